"""Where the PyPI package example-robot-data has its URDFs."""

from importlib.metadata import distribution
from pathlib import Path


def urdf(name: str) -> Path:
    """The file of that name; ``pip install './python[examples]'`` brings them."""
    package = distribution("example-robot-data")
    found = [file for file in package.files or [] if file.name == name]
    if not found:
        raise SystemExit(f"example-robot-data has no {name}")
    return Path(str(package.locate_file(found[0])))
