#!/usr/bin/env python3
"""What changed in the interfaces of the crates since a tag, by cargo-semver-checks.

    python3 tests/release/interfaces.py TAG

A crate that the tag does not have is new, and has no interface to keep. Ends with 1 if the version does not say what
changed.
"""

import subprocess
import sys
from pathlib import Path

from workspace import ROOT, is_published, members, metadata


def is_in(tag: str, package: dict) -> bool:
    manifest = Path(package["manifest_path"]).relative_to(ROOT)
    return subprocess.run(["git", "cat-file", "-e", f"{tag}:{manifest}"], cwd=ROOT, capture_output=True).returncode == 0


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    tag = sys.argv[1]
    packages = {name: package for name, package in members(metadata("--no-deps")).items() if is_published(package)}
    new = sorted(name for name, package in packages.items() if not is_in(tag, package))
    if new:
        print(f"new since {tag}: {', '.join(new)}")
    command = ["cargo", "semver-checks", "--workspace", "--baseline-rev", tag]
    command += [word for name in new for word in ("--exclude", name)]
    sys.exit(subprocess.run(command, cwd=ROOT).returncode != 0)


if __name__ == "__main__":
    main()
