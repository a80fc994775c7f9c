#!/usr/bin/env python3
"""Licences of everything that is compiled in or on the page, and the Rust that it needs.

    python3 tests/release/licences.py

Crates by `cargo metadata`, npm packages by the lock file of the page. Prints how many there are of each licence, and
ends with 1 for a licence that is not in `.ci/about.toml`, and for a crate that wants a newer Rust than this workspace
declares.
"""

import json
import subprocess
import sys
import tomllib
from collections import Counter

from license_expression import Licensing

from workspace import ROOT, members, metadata

LICENSING = Licensing()
ALLOWED = set(tomllib.loads((ROOT / ".ci/about.toml").read_text())["accepted"])


def is_allowed(expression: str) -> bool:
    """Whether an SPDX expression leaves a choice that is allowed; `/` is an old way to write OR."""

    def holds(part) -> bool:
        if isinstance(part, LICENSING.OR):
            return any(map(holds, part.args))
        if isinstance(part, LICENSING.AND):
            return all(map(holds, part.args))
        return str(part) in ALLOWED

    return holds(LICENSING.parse(expression.replace("/", " OR ")))


def check_the_reader() -> None:
    """A reader that allows everything would say nothing."""
    assert is_allowed("MIT OR GPL-3.0-only") and is_allowed("(MIT OR GPL-3.0-only) AND Unicode-3.0")
    assert is_allowed("Unlicense/MIT") and is_allowed("Apache-2.0 WITH LLVM-exception")
    assert not is_allowed("GPL-3.0-only") and not is_allowed("MIT AND GPL-3.0-only")
    assert not is_allowed("GPL-2.0 WITH Classpath-exception-2.0") and not is_allowed("MPL-2.0 OR (MIT AND LGPL-3.0)")


def crates(answer: dict) -> dict[str, str | None]:
    own = members(answer)
    others = [package for package in answer["packages"] if package["name"] not in own]
    return {f"{package['name']} {package['version']}": package["license"] for package in others}


def npm_packages() -> dict[str, str | None]:
    """What is on the page: not what builds and tests it."""
    lock = json.loads((ROOT / "web/package-lock.json").read_text())["packages"]
    found = {path.rpartition("node_modules/")[2]: package for path, package in lock.items()
             if path and not package.get("dev")}
    return {f"{name} {package['version']} (npm)": package.get("license") for name, package in found.items()}


def number(version: str) -> tuple[int, ...]:
    parts = [int(part) for part in version.split("-")[0].split(".")]
    return tuple(parts + [0] * (3 - len(parts)))


def faults_of_rust(answer: dict) -> list[str]:
    declared = {package["rust_version"] for package in members(answer).values() if package["rust_version"]}
    if len(declared) != 1:
        return [f"crates declare several versions of Rust: {', '.join(sorted(declared))}"]
    declared = declared.pop()
    wanted = [(number(package["rust_version"]), package["name"]) for package in answer["packages"]
              if package["rust_version"] and package["name"] not in members(answer)]
    newest, name = max(wanted)
    asked = subprocess.run(["rustc", "--version"], cwd=ROOT, check=True, capture_output=True, text=True)
    here = asked.stdout.split()[1]
    print(f"Rust: declared {declared}; of {len(wanted)} dependencies that declare one, `{name}` wants the newest,",
          ".".join(map(str, newest)))
    if number(here)[:2] == number(declared)[:2]:
        print(f"Rust: {here} is used here, so what is tested is tested with what is declared")
    else:
        print(f"NOT CHECKED with the declared Rust {declared}: {here} is used here")
    newer = [(version, name) for version, name in wanted if version > number(declared)]
    return [f"{name} wants Rust {'.'.join(map(str, version))}" for version, name in newer]


def main() -> None:
    check_the_reader()
    answer = metadata()
    licences = crates(answer) | npm_packages()
    for licence, count in Counter(licences.values()).most_common():
        print(f"{count:4}  {licence}")
    faults = [f"{name}: licence {licence}" for name, licence in licences.items()
              if licence is None or not is_allowed(licence)]
    faults += faults_of_rust(answer)
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
