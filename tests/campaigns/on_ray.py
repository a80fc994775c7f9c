"""Runs a campaign on a Ray cluster of this machine, and kills a worker in the middle: ``on_ray.py PLAN RUNS OUT``."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

from wbqp import campaign

killed = threading.Event()


def kill_a_worker() -> None:
    """As soon as there is one at work."""
    while not killed.is_set():
        # The workers' processes have the names of their tasks.
        found = subprocess.run(["pgrep", "-f", "^ray::part"], capture_output=True, text=True, check=False)
        workers = [int(word) for word in found.stdout.split()]
        if workers:
            time.sleep(1.0)
            try:
                os.kill(workers[0], signal.SIGKILL)
            except ProcessLookupError:
                continue
            killed.set()
        time.sleep(0.1)


def main() -> int:
    plan, runs, out = sys.argv[1:]
    threading.Thread(target=kill_a_worker, daemon=True).start()
    table = campaign.run(plan, address="local", shards=4, limit=int(runs), out=out)
    print(f"{table.num_rows} runs, a worker killed: {killed.is_set()}")
    return 0 if killed.is_set() and table.num_rows == int(runs) else 1


if __name__ == "__main__":
    sys.exit(main())
