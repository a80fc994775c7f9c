#!/usr/bin/env python3
"""Writes what Pinocchio says of every URDF of the PyPI package example-robot-data, floating and fixed.

    python3 -m venv target/oracles-venv
    target/oracles-venv/bin/pip install -r tests/oracles/requirements.txt
    target/oracles-venv/bin/python tests/oracles/robot_collection.py target/oracles/robot_collection

The tests `tests/robots/collection.rs` read that folder. Nothing of it is committed: the robots are other people's.

`tree.py` says how quantities are computed and in which conventions.

The folder
----------
`index.json`: versions, and per robot `file` (relative to the package's folder of robots), `path` (where it is here) and
`models`: per base, `floating` and `fixed`, the name of a file beside the index; null if there is no link or nothing
moves.

Such a file has `joints`, the degrees of freedom in Pinocchio's order, which is that of every vector and matrix over
velocities, after the six of the base if there is one; `mimics`, the joints that follow others; `mimic`, what Pinocchio
makes of them (`none`, `coupled`, or why it refuses them); `total_mass`; and `states`.

A state is random and has `base` (p, quaternion_wxyz; null if fixed), `q` by joint, `v`, `mass_matrix`, `h`, `com`,
`momentum` (`linear`, `angular` about `com`) and `frames`: `name` of the link, `p`, `R`, `jacobian` (6 x nv, world axes,
of the link's origin), `bias` (Jdot v: classical acceleration of the origin and angular acceleration when vdot = 0).
Matrices are lists of rows.
"""

import json
import platform
import shutil
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import distribution, version
from pathlib import Path

import numpy as np
import pinocchio as pin

from tree import Tree, plain, state_entry

SEED = 69
STATES = 3
FRAMES = 12


def urdfs():
    """Path here by name; names are relative to the package's folder of robots."""
    package = distribution("example-robot-data")
    files = [file for file in package.files if file.suffix == ".urdf"]
    return {str(file).split("/robots/", 1)[1]: Path(package.locate_file(file)) for file in sorted(files)}


def describe(index, path, floating):
    text = path.read_text()
    if "<link" not in text:
        return None  # urdfdom, which reads for Pinocchio, refuses it
    tree = Tree(text, floating, FRAMES)
    if not floating and not tree.joints:
        return None  # Pinocchio crashes on a robot without a degree of freedom
    rng = np.random.default_rng([SEED, index, floating])
    states = []
    for _ in range(STATES):
        s = tree.random_state(rng)
        values = tree.quantities(s)
        tree.verify(s, values)
        states.append(state_entry(tree, s) | values)
    mimic = "none" if not tree.has_mimics else "coupled" if tree.coupled else tree.refusal
    return dict(
        joints=tree.joints,
        mimics=[name for name in tree.relations if name not in tree.joints],
        mimic=mimic,
        total_mass=tree.free.total_mass(),
        states=states,
    )


def write(job):
    folder, index, name, path = job
    models, mimics = {}, []
    for base in ["floating", "fixed"]:
        model = describe(index, path, base == "floating")
        if model is None:
            models[base] = None
            continue
        models[base] = f"{index:02}_{base}.json"
        (folder / models[base]).write_text(json.dumps(plain(model)))
        mimics.append(model["mimic"])
    return dict(file=name, path=str(path), models=models), mimics


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} FOLDER")
    folder = Path(sys.argv[1])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    jobs = [(folder, index, name, path) for index, (name, path) in enumerate(urdfs().items())]
    with ProcessPoolExecutor() as pool:
        robots, mimics = zip(*pool.map(write, jobs))
    versions = dict(python=platform.python_version(), pinocchio=pin.__version__, numpy=np.__version__)
    versions["example-robot-data"] = version("example-robot-data")
    # The index comes last: a folder without one is of a run that did not come to its end.
    (folder / "index.json").write_text(json.dumps(dict(versions=versions, robots=robots), indent=1))
    for mimic, count in Counter(mimic for both in mimics for mimic in both).items():
        print(f"{count} models, mimic joints: {mimic}")


if __name__ == "__main__":
    main()
