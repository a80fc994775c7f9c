"""What `cargo metadata` says of this workspace, for the checks of a release."""

import json
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def metadata(*options: str) -> dict:
    """The answer of `cargo metadata`, by the lock file."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", *options]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)


def members(answer: dict) -> dict[str, dict]:
    """The packages of this workspace, by name."""
    inside = set(answer["workspace_members"])
    return {package["name"]: package for package in answer["packages"] if package["id"] in inside}


def is_published(package: dict) -> bool:
    """Whether the package may go to a registry: `publish = false` is an empty list."""
    return package["publish"] is None


def own_dependencies(package: dict, packages: dict[str, dict]) -> list[dict]:
    """The dependencies of a package on others of this workspace, those of its tests included."""
    return [d for d in package["dependencies"] if d["name"] in packages and d["name"] != package["name"]]
