"""Times `wbqp check` on files, one program beside another in the same run; see load_times.sh.

Seconds are those on the clock or those of the processors, whichever are fewer: what others do on the machine makes the
clock run longer, and cases that are checked side by side are together longer on the processors.

Memory is the largest resident size less that of the same program on the smallest file that loads. It may be
TIMES the file's size and IN_ANY_CASE, and what the program says that the bound problem needs before it makes it: once
for every processor, if a scenario's cases are checked side by side.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

BEGIN = "<!-- load times: written by tests/peers/load_times.sh -->"
END = "<!-- end of load times -->"
# The first two files have to be read this many times faster.
FASTER = 7.0
# What a file may take, beside what the bound problem needs: so many times its size, and so many MiB in any case.
TIMES = 20.0
IN_ANY_CASE = 8.0
# Files of scenarios begin with this.
SCENARIOS = ("cases_", "set_cases_")
SMALLEST = "stand.controller.toml"
NEEDS = re.compile(r" needs about ([0-9.]+) (bytes|KiB|MiB|GiB)")
UNITS = {"bytes": 2.0**-20, "KiB": 2.0**-10, "MiB": 1.0, "GiB": 2.0**10}


def measure(program, file, most):
    """Seconds, MiB, exit status and MiB that the bound problem is said to need of one check; infinite seconds if it was
    ended."""
    with tempfile.TemporaryFile("w+") as said:
        start = time.perf_counter()
        process = subprocess.Popen(
            [program, "check", file.name], cwd=file.parent, stdout=said, stderr=subprocess.DEVNULL
        )
        deadline = start + most
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                took = min(time.perf_counter() - start, usage.ru_utime + usage.ru_stime)
                process.returncode = os.waitstatus_to_exitcode(status)
                break
            if time.perf_counter() > deadline:
                process.kill()
                _, _, usage = os.wait4(process.pid, 0)
                took, process.returncode = float("inf"), -9
                break
            time.sleep(0.001)
        said.seek(0)
        # A line per controller that takes more than those before; there are no others like it.
        needs = [float(amount) * UNITS[unit] for amount, unit in NEEDS.findall(said.read())]
    code = None if took == float("inf") else process.returncode
    return took, usage.ru_maxrss / 1024, code, max(needs, default=0.0)


def best(program, file, rounds, most):
    results = []
    for _ in range(rounds):
        results.append(measure(program, file, most))
        if results[-1][0] > 2.0:
            break
    # The first is enough of memory: a program takes what it takes.
    return min(results, key=lambda result: result[0])


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
    programs = [arguments.before.resolve(), arguments.after.resolve()]
    trivial = [best(program, arguments.files / SMALLEST, 3, arguments.most)[1] for program in programs]
    for name in names:
        file = arguments.files / name
        size = file.stat().st_size
        old, new = (best(program, file, arguments.rounds, arguments.most) for program in programs)
        limit = promised.get(name)
        ratios.append(old[0] / new[0])
        if limit is not None and new[0] > limit:
            failed.append(f"{name}: {new[0]:.2f} s, promised {limit} s")
        before, now = (max(result[1] - own, 0.0) for result, own in zip([old, new], trivial))
        # Cases are checked side by side.
        is_scenario = name.startswith(SCENARIOS)
        needs = new[3] * (os.cpu_count() if is_scenario else 1)
        may = TIMES * size / 2**20 + IN_ANY_CASE + needs
        if now > may:
            failed.append(f"{name}: {now:.1f} MiB, promised {may:.1f} MiB, {needs:.1f} of them for the bound problem")
        end = {0: "loads", 1: "refused", None: "ended"}.get(new[2], f"status {new[2]}")
        rows.append(
            f"| `{name}` | {size / 1024:.0f} KiB | {seconds(old[0], arguments.most)} s, {before:.0f} MiB "
            f"| **{seconds(new[0], arguments.most)} s**, **{now:.1f} MiB** | {limit or '–'} s "
            f"| {may:.1f} MiB | {needs:.1f} MiB | {end} |"
        )
        print(rows[-1], flush=True)
    for name, ratio in list(zip(names, ratios))[:2]:
        print(f"{name}: {ratio:.0f} times faster")
        if ratio < FASTER:
            failed.append(f"{name}: only {ratio:.1f} times faster, promised {FASTER}")
    table = "\n".join([
        "| file | size | before | now | time promised | memory promised | of it said before it is taken | |",
        "|---|---|---|---|---|---|---|---|",
        *rows,
    ])
    page = arguments.page.read_text()
    head, rest = page.split(BEGIN, 1)
    tail = rest.split(END, 1)[1]
    arguments.page.write_text(f"{head}{BEGIN}\n{table}\n{END}{tail}")
    for line in failed:
        print("NOT as promised:", line, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
