#!/usr/bin/env bash
# A Slurm cluster of this machine alone, for tests: `slurm_here.sh start DIR` and `slurm_here.sh stop DIR`. Wants
# Debian's slurm-wlm and munge, and root. Everything it writes is in DIR; set SLURM_CONF=DIR/slurm.conf to talk to it.
set -euo pipefail
command=$1
directory=$(realpath -m "$2")

start() {
    mkdir -p "$directory"/{state,spool,munge}
    # Munge wants folders that nobody else can write to, and says so.
    chmod 755 "$directory/munge"
    dd if=/dev/urandom of="$directory/munge/key" bs=128 count=1 status=none
    chmod 400 "$directory/munge/key"
    munged --force --key-file="$directory/munge/key" --socket="$directory/munge/socket" \
        --pid-file="$directory/munge/pid" --log-file="$directory/munge/log" --seed-file="$directory/munge/seed"
    local name cores memory
    name=$(hostname -s)
    cores=$(nproc)
    memory=$(awk '/MemTotal/ { print int($2 / 1024 * 0.8) }' /proc/meminfo)
    cat >"$directory/slurm.conf" <<CONF
ClusterName=here
SlurmctldHost=$name(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$directory/munge/socket
CredType=cred/munge
StateSaveLocation=$directory/state
SlurmdSpoolDir=$directory/spool
SlurmctldPidFile=$directory/slurmctld.pid
SlurmdPidFile=$directory/slurmd.pid
SlurmctldLogFile=$directory/slurmctld.log
SlurmdLogFile=$directory/slurmd.log
SlurmctldPort=${SLURM_HERE_PORT:-16817}
SlurmdPort=$((${SLURM_HERE_PORT:-16817} + 1))
# Containers have no cgroups to give away.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerType=sched/backfill
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
JobRequeue=1
NodeName=$name NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$memory State=UNKNOWN
PartitionName=here Nodes=$name Default=YES MaxTime=INFINITE State=UP
CONF
    export SLURM_CONF="$directory/slurm.conf"
    slurmctld -c
    slurmd
    for _ in $(seq 60); do
        if sinfo --noheader --format=%t 2>/dev/null | grep -q idle; then
            return
        fi
        sleep 0.5
    done
    echo "the node is not idle after 30 s:" >&2
    tail -n 20 "$directory/slurmctld.log" "$directory/slurmd.log" >&2
    return 1
}

stop() {
    for pid in slurmd.pid slurmctld.pid munge/pid; do
        if test -s "$directory/$pid"; then
            kill "$(cat "$directory/$pid")" 2>/dev/null || true
        fi
    done
}

case $command in
start) start ;;
stop) stop ;;
*)
    echo "usage: $0 start|stop DIR" >&2
    exit 2
    ;;
esac
