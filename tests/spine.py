#!/usr/bin/env python3
"""The spine: the files and lines of code that an optimal tick runs through, from `Controller::tick` to the command.

    python3 tests/spine.py

Runs `spine` (tests/src/bin/spine.rs: three controllers that ship) without optimisation below callgrind (Debian's
package `valgrind`), collects the functions that run below `Controller::tick`, and counts the lines of the files of
`framework/src` that they are in, without comments, blank lines and tests; what is derived (`==`) is nowhere to be
read. Beside it the lines that ran: a file also has what is done before the first tick. Dynamics, solver, logs and
plug-ins are crates of their own.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCE = ROOT / "framework" / "src"


def build():
    target = ROOT / "target" / "spine"
    flags = ["--config", "profile.dev.opt-level=0", "--config", "profile.dev.debug='line-tables-only'"]
    command = ["cargo", "build", "--locked", "-p", "wbqp-tests", "--bin", "spine", "--target-dir", target, *flags]
    subprocess.run(command, cwd=ROOT, check=True)
    return target / "debug" / "spine"


def functions(program):
    """Files and functions below the tick, and the lines of the files that ran."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "callgrind.out"
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--dump-instr=no",
                   "--toggle-collect=*Controller*::tick*", program]
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
        if done.returncode != 0:
            sys.exit(done.stderr)
        text = out.read_text()
    files, names, found, ran = {}, {}, set(), set()
    file, at, line, is_call = None, None, 0, False
    for text_line in text.splitlines():
        if match := re.match(r"(fl|fi|fe)=\((\d+)\)(?: (.*))?", text_line):
            if match[3]:
                files[match[2]] = match[3]
            at = files[match[2]]
            if match[1] == "fl":
                file = at
        elif match := re.match(r"fn=\((\d+)\)(?: (.*))?", text_line):
            if match[2]:
                names[match[1]] = match[2]
            function = names[match[1]]
        elif match := re.match(r"c(?:fi|fl|ob)=\((\d+)\)(?: (.*))?", text_line):
            if match[2]:
                files[match[1]] = match[2]
        elif match := re.match(r"cfn=\((\d+)\)(?: (.*))?", text_line):
            if match[2]:
                names[match[1]] = match[2]
        elif text_line.startswith("calls="):
            is_call = True
        elif (match := re.match(r"([+\-]?\d+|\*) ", text_line)) and file:
            step = match[1]
            line = line if step == "*" else int(step) + (line if step[0] in "+-" else 0)
            found.add((file, function))
            if not is_call:
                ran.add((at, line))
            is_call = False
    derived = re.compile(r"as core::(cmp|clone|default|fmt)::")
    return {pair for pair in found if not derived.search(pair[1])}, ran


def lines_of_code(path):
    text = path.read_text().split("\n#[cfg(test)]\nmod tests")[0]
    lines = (line.strip() for line in text.splitlines())
    return sum(1 for line in lines if line and not line.startswith("//"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", help="a `spine` that is there, built without optimisation")
    arguments = parser.parse_args()
    program = arguments.program or build()
    found, ran = functions(program)
    reached = {}
    for file, function in found:
        match = re.search(r"framework/src/(.*\.rs)$", file)
        if match:
            reached.setdefault(match[1], set()).add(function)
    total, total_ran = 0, 0
    for file in sorted(reached):
        count = lines_of_code(SOURCE / file)
        lines = sum(1 for at, line in ran if line and at.endswith(f"framework/src/{file}"))
        total += count
        total_ran += lines
        print(f"{count:6} lines, {lines:4} ran, {len(reached[file]):3} functions  {file}")
    print(f"{total:6} lines of code in {len(reached)} files, of which {total_ran} ran")


if __name__ == "__main__":
    main()
