#!/usr/bin/env python3
"""What would be published of the crates: checks their metadata, packages them, looks into the packages, prints a table.

    python3 tests/release/crates.py            packages without compiling; uncommitted changes are allowed
    python3 tests/release/crates.py --verify   compiles every package as a registry's user would, and wants the address
                                               of the repository

Publishes nothing. Ends with 1 if something is missing or does not belong there.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tarfile
from pathlib import Path

from workspace import ROOT, is_published, members, metadata, own_dependencies

# A larger file of a crate is test data that got in by mistake.
LARGEST_FILE = 1_000_000
TARGET = ROOT / "target/release-check"
WANTED = ["description", "license", "rust_version", "readme", "keywords", "categories"]
INSIDE = ["README.md", "LICENSE-MIT", "LICENSE-APACHE", "Cargo.toml"]


def in_order(packages: dict[str, dict]) -> list[str]:
    """Names of the packages that are published, each after those that it depends on."""
    left = {name: package for name, package in packages.items() if is_published(package)}
    order = []
    while left:
        waits = {name: {d["name"] for d in own_dependencies(package, packages)} & left.keys()
                 for name, package in left.items()}
        ready = sorted(name for name, others in waits.items() if not others)
        if not ready:
            sys.exit(f"these depend on one another in a circle: {', '.join(sorted(left))}")
        order += ready
        for name in ready:
            del left[name]
    return order


def faults_of_metadata(package: dict, packages: dict[str, dict]) -> list[str]:
    """What a registry, or its reader, would miss."""
    faults = [f"no `{key.replace('_', '-')}`" for key in WANTED if not package[key]]
    if len(package["keywords"]) > 5 or any(len(word) > 20 for word in package["keywords"]):
        faults.append("crates.io takes five keywords of at most twenty letters")
    for dependency in own_dependencies(package, packages):
        name = dependency["name"]
        if not is_published(packages[name]):
            faults.append(f"depends on `{name}`, which is not published")
        if dependency["req"] == "*":
            faults.append(f"depends on `{name}` without a version")
    return faults


def faults_of_versions(packages: dict[str, dict]) -> list[str]:
    """What has another version than the crates."""
    versions = {package["version"] for package in packages.values()}
    if len(versions) > 1:
        return [f"several versions in one workspace: {', '.join(sorted(versions))}"]
    version = versions.pop()
    faults = []
    if json.loads((ROOT / "web/package.json").read_text())["version"] != version:
        faults.append(f"web/package.json does not have version {version}")
    if f"\n## [{version}]" not in (ROOT / "CHANGELOG.md").read_text():
        faults.append(f"CHANGELOG.md has no section [{version}]")
    if not re.search(rf'^version: "?{re.escape(version)}"?$', (ROOT / "CITATION.cff").read_text(), re.M):
        faults.append(f"CITATION.cff does not have version {version}")
    for name, package in packages.items():
        for dependency in own_dependencies(package, packages):
            if dependency["req"] not in ("*", f"^{version}"):
                faults.append(f"{name}: depends on `{dependency['name']}` {dependency['req']}, which is {version} here")
    return faults


def package_all(order: list[str], is_verifying: bool) -> None:
    command = ["cargo", "package", "--locked", *(word for name in order for word in ("-p", name))]
    if not is_verifying:
        command += ["--no-verify", "--allow-dirty"]
    environment = os.environ | {"CARGO_TARGET_DIR": str(TARGET)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=not is_verifying, text=True)
    if done.returncode != 0:
        sys.exit((done.stderr or "") + f"\n`{' '.join(command)}` failed")


def files_of(crate: Path) -> dict[str, int]:
    """Sizes of the files in a package, by path."""
    with tarfile.open(crate) as archive:
        return {str(Path(*Path(entry.name).parts[1:])): entry.size for entry in archive if entry.isfile()}


def faults_of_files(files: dict[str, int]) -> list[str]:
    missing = [f"no {name} in the package" for name in INSIDE if name not in files]
    large = [f"{name} has {size} bytes" for name, size in files.items() if size > LARGEST_FILE]
    return missing + large


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--verify", action="store_true", help="compile the packages; takes minutes")
    is_verifying = parser.parse_args().verify
    packages = members(metadata("--no-deps"))
    order = in_order(packages)
    faults = faults_of_versions(packages)
    faults += [f"{name}: {fault}" for name in order for fault in faults_of_metadata(packages[name], packages)]
    package_all(order, is_verifying)

    print(f"{'crate':16} {'version':8} {'bytes':>8} {'files':>6}  largest file")
    for name in order:
        version = packages[name]["version"]
        crate = TARGET / f"package/{name}-{version}.crate"
        files = files_of(crate)
        largest = max(files, key=files.get)
        print(f"{name:16} {version:8} {crate.stat().st_size:8} {len(files):6}  {largest}, {files[largest]} bytes")
        faults += [f"{name}: {fault}" for fault in faults_of_files(files)]
    print("not published: " + ", ".join(sorted(packages.keys() - set(order))))

    without_address = [name for name in order if not packages[name]["repository"]]
    if without_address:
        fault = "no `repository`: the address is a line of [workspace.package], and one of each crate above"
        print(f"MISSING before anything is published: {fault}")
        faults += [fault] if is_verifying else []
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
