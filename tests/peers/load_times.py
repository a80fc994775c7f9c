"""Times `wbqp check` on files, one program beside another in the same run; see load_times.sh.

Seconds are those on the clock or those of the processors, whichever are fewer: what others do on the machine makes the
clock run longer, and cases that are checked side by side are together longer on the processors.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import time

BEGIN = "<!-- load times: written by tests/peers/load_times.sh -->"
END = "<!-- end of load times -->"
# The first two files have to be read this many times faster.
FASTER = 7.0


def measure(program, file, most):
    """Seconds, MiB and exit status of one check; seconds are infinite if it was ended."""
    start = time.perf_counter()
    process = subprocess.Popen(
        [program, "check", file.name], cwd=file.parent, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    deadline = start + most
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            took = min(time.perf_counter() - start, usage.ru_utime + usage.ru_stime)
            process.returncode = os.waitstatus_to_exitcode(status)
            return took, usage.ru_maxrss / 1024, process.returncode
        if time.perf_counter() > deadline:
            process.kill()
            _, _, usage = os.wait4(process.pid, 0)
            process.returncode = -9
            return float("inf"), usage.ru_maxrss / 1024, None
        time.sleep(0.001)


def best(program, file, rounds, most):
    results = []
    for _ in range(rounds):
        results.append(measure(program, file, most))
        if results[-1][0] > 2.0:
            break
    return min(results)


def seconds(took, most):
    return f"> {most:.0f}" if took == float("inf") else f"{took:.2f}"


def main():
    parser = argparse.ArgumentParser()
    for name in ["before", "after", "files", "list", "page"]:
        parser.add_argument("--" + name, type=pathlib.Path, required=True)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--most", type=float, default=60.0)
    arguments = parser.parse_args()
    promised = {}
    for line in arguments.list.read_text().splitlines():
        name, limit, _ = line.split("\t")
        promised[name] = float(limit)
    names = list(promised) + sorted(set(os.listdir(arguments.files)) - set(promised))
    rows, failed, ratios = [], [], []
    for name in names:
        file = arguments.files / name
        size = file.stat().st_size
        old, new = (
            best(program.resolve(), file, arguments.rounds, arguments.most)
            for program in [arguments.before, arguments.after]
        )
        limit = promised.get(name)
        ratios.append(old[0] / new[0])
        if limit is not None and new[0] > limit:
            failed.append(f"{name}: {new[0]:.2f} s, promised {limit} s")
        end = {0: "loads", 1: "refused", None: "ended"}.get(new[2], f"status {new[2]}")
        # What has nothing to do with the file is in it: about 15 MiB.
        rows.append(
            f"| `{name}` | {size / 1024:.0f} KiB | {seconds(old[0], arguments.most)} s, {old[1]:.0f} MiB "
            f"| **{seconds(new[0], arguments.most)} s**, {new[1]:.0f} MiB | {limit or '–'} s | {end} |"
        )
        print(rows[-1], flush=True)
    for name, ratio in list(zip(names, ratios))[:2]:
        print(f"{name}: {ratio:.0f} times faster")
        if ratio < FASTER:
            failed.append(f"{name}: only {ratio:.1f} times faster, promised {FASTER}")
    table = "\n".join(["| file | size | before | now | promised | |", "|---|---|---|---|---|---|", *rows])
    page = arguments.page.read_text()
    head, rest = page.split(BEGIN, 1)
    tail = rest.split(END, 1)[1]
    arguments.page.write_text(f"{head}{BEGIN}\n{table}\n{END}{tail}")
    for line in failed:
        print("NOT as promised:", line, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
