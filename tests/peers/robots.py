#!/usr/bin/env python3
"""wbqp beside TSID and PlaCo: the same robots, contacts, tasks, gains and limits, at the same states, in one run.

    bash tests/peers/robots.sh            installs, builds and runs everything; writes the page's table
    python robots.py --work target/peers-robots --wbqp … --tsid … --placo PYTHON robots.py's options

For each robot a scenario runs in wbqp's closed loop, with noise, pushes and limits that become active. What every tick
was given is recorded, and then all libraries get it: every one solves at the same state for the same references. They run
by turns, a block of ticks each, so that what else the machine does disturbs all alike; several rounds.

Answers are judged by a program that none of them has a part in: with Pinocchio's dynamics, each answer's cost in the common
problem and its largest violation of the limits.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from judge import Judge  # noqa: E402
from states import States, read_problem  # noqa: E402

HERE = Path(__file__).parent
ROBOTS = {
    "solo12": ("Solo12", "solo_description/robots/solo12.urdf"),
    "talos": ("Talos", "talos_data/robots/talos_reduced.urdf"),
}
BLOCK = 250
LIBRARIES = ["wbqp", "TSID", "PlaCo"]


def urdf_of(robot):
    folder = Path(pin.__file__).parents[4].parent / "cmeel.prefix/share/example-robot-data/robots"
    for path in [Path(p) for p in sys.path if p]:
        candidate = path / "cmeel.prefix/share/example-robot-data/robots"
        if candidate.is_dir():
            folder = candidate
    return folder / ROBOTS[robot][1]


def without_meshes(source, target):
    """The same robot, without what PlaCo would load and place: shapes have no part in the dynamics."""
    tree = ElementTree.parse(source)
    for link in tree.getroot().iter("link"):
        for tag in ("visual", "collision"):
            for element in link.findall(tag):
                link.remove(element)
    tree.write(target)


def problem_of(controller, model):
    """What the other libraries need of the controller's file: name and values per line."""
    lines = {}
    tasks = {task["name"]: task for task in controller["task"]}
    constraints = {c["contact"]: {} for c in controller["constraint"] if "contact" in c}
    for constraint in controller["constraint"]:
        if "contact" in constraint:
            constraints[constraint["contact"]].update(constraint)
    for name in ("com", "base", "posture"):
        for key in ("weight", "kp", "kd"):
            lines[f"{name}.{key}"] = tasks[name][key]
    lines["base.frame"] = "base_link"
    effort = controller["robot"].get("options", {}).get("effort", {})
    for joint in list(model.names)[2:]:
        lines[f"effort.{joint}"] = effort.get(joint, float(model.effortLimit[model.joints[model.getJointId(joint)].idx_v]))
    for contact in controller["contact"]:
        name, brought = contact["name"], constraints[contact["name"]]
        weight = tasks[f"force_{name}"]["weight"]
        lines[f"contact.{name}.frame"] = contact["frame"]
        lines[f"contact.{name}.kind"] = contact["kind"]
        for key in ("friction", "force_min", "force_max"):
            lines[f"contact.{name}.{key}"] = contact[key]
        for key in ("damping", "half_length_x", "half_length_y"):
            if key in brought:
                lines[f"contact.{name}.{key}"] = brought[key]
        lines[f"contact.{name}.weight"] = " ".join(map(str, weight if isinstance(weight, list) else [weight] * 6))
        if f"swing_{name}" in tasks:
            for key in ("weight", "kp", "kd"):
                lines[f"swing.{name}.{key}"] = tasks[f"swing_{name}"][key]
    return "".join(f"{name} {value}\n" for name, value in lines.items())


def level(states, model, problem):
    """Turns soles level and straight ahead, by the least change of base and joints; gives the largest change.

    TSID and PlaCo know a sole's wrench in the sole's axes, wbqp in the ground's; where the ground gives way or the
    estimate is noisy, they differ. Points have no axes of their own.
    """
    frames = [model.getFrameId(problem[f"contact.{name}.frame"][0]) for name in states.contacts
              if problem[f"contact.{name}.kind"][0] == "full"]
    if not frames:
        return 0.0
    data = model.createData()
    index = [model.joints[model.getJointId(joint)].idx_q for joint in states.joints]
    largest = 0.0
    for tick in states.ticks:
        q = np.zeros(model.nq)
        q[:3], q[3:7], q[index] = tick.position, tick.quaternion, tick.q
        before = q.copy()
        for _ in range(6):
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            error = np.concatenate([pin.log3(data.oMf[f].rotation) for f in frames])
            if np.abs(error).max() < 1e-14:
                break
            J = np.vstack([pin.getFrameJacobian(model, data, f, pin.LOCAL_WORLD_ALIGNED)[3:] for f in frames])
            q = pin.integrate(model, q, -np.linalg.lstsq(J, error, rcond=None)[0])
        largest = max(largest, np.abs(pin.difference(model, before, q)).max())
        joints = len(states.joints)
        tick.numbers[1:4], tick.numbers[4:8], tick.numbers[8 : 8 + joints] = q[:3], q[3:7], q[index]
    return largest


class Peer:
    """A program that ticks when it is told to."""

    def __init__(self, name, command):
        self.name, self.size = name, None
        self.process = subprocess.Popen(list(map(str, command)), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        while not (answer := self.process.stdout.readline()).startswith("done"):
            if not answer:
                sys.exit(f"{self.name} has ended with {self.process.wait()} at `{line}`")
        self.size = tuple(map(int, answer.split()[1:]))

    def answers(self, file):
        self.ask(f"write {file}")
        self.process.stdin.close()
        self.process.wait()
        rows, times, notes = [], [], []
        with open(file) as lines:
            for line in lines:
                numbers, spent, *rest = line.split("|")
                rows.append(np.array(numbers.split(), dtype=float))
                times.append(np.array(spent.split(), dtype=float) * 1e-3)
                notes.append(list(map(int, rest[0].split())) if rest else [])
        rows = np.array(rows)
        return rows[:, 0] != 0, rows[:, 1:], np.array(times), np.array(notes)


def quantiles(times):
    """Over all ticks of all rounds; and of each tick's least time, which is what it takes when nothing disturbs it."""
    everything, least = times.ravel(), times.min(axis=1)
    of = lambda t: {"p50": np.percentile(t, 50), "p99": np.percentile(t, 99), "max": t.max()}  # noqa: E731
    return {"all": of(everything), "least": of(least), "ticks": len(least), "rounds": times.shape[1]}


def compare(robot, args):
    work = args.work / robot
    work.mkdir(parents=True, exist_ok=True)
    for file in (f"{robot}.toml", f"{robot}.controller.toml"):
        shutil.copy(HERE / "robots" / file, work / file)
    source, urdf = urdf_of(robot), work / f"{robot}.urdf"
    without_meshes(source, urdf)
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    problem_file = work / "problem.txt"
    problem_file.write_text(problem_of(tomllib.loads((work / f"{robot}.controller.toml").read_text()), model))
    problem = read_problem(problem_file)
    scenario, recorded = work / f"{robot}.toml", work / "recorded.txt"
    subprocess.run([args.wbqp, "record", scenario, recorded], check=True)
    states = States(recorded)
    if args.ticks:
        states.ticks = states.ticks[: args.ticks]
    turned = level(states, model, problem)
    given = work / "states.txt"
    states.write(given)

    peers = [
        Peer("wbqp", [args.wbqp, "serve", scenario, given]),
        Peer("TSID", [args.tsid, urdf, problem_file, given]),
        Peer("PlaCo", [args.placo, HERE / "placo_peer.py", urdf, problem_file, given]),
    ]
    ticks = len(states.ticks)
    for turn in range(args.rounds):
        for peer in peers:
            peer.ask("start")
        for block, first in enumerate(range(0, ticks, BLOCK)):
            # Each goes first as often as the others.
            for peer in peers[block % 3 :] + peers[: block % 3]:
                peer.ask(f"run {first} {first + BLOCK}")
        print(f"{robot}: round {turn + 1} of {args.rounds}", file=sys.stderr)
    results = {peer.name: peer.answers(work / f"{peer.name.lower()}.txt") for peer in peers}

    judge = Judge(model, problem, states)
    verdicts = {name: judge.judge(result[1]) for name, result in results.items()}
    reference = results["wbqp"]
    limited = reference[3][:, :2] > 0
    summary = {
        "robot": ROBOTS[robot][0], "urdf": ROBOTS[robot][1], "ticks": ticks, "turned": turned,
        "torque_limited": int(limited[:, 0].sum()), "contact_limited": int(limited[:, 1].sum()),
        "lifted": int(sum(not all(tick.on for tick in states.ticks[i : i + 1]) for i in range(ticks) for tick in [states.ticks[i]])),
        "libraries": {},
    }
    nv = model.nv
    for peer in peers:
        optimal, answers, times, _ = results[peer.name]
        row = {"times": quantiles(times), "size": peer.size, "not_optimal": int((~optimal).sum())}
        good = optimal & reference[0]
        difference = np.abs(answers - reference[1])
        parts = {"base": difference[:, :6], "joints": difference[:, 6:nv], "torques": difference[:, nv:]}
        free = good & ~limited.any(axis=1)
        for part, values in parts.items():
            worst = values.max(axis=1)
            row[part] = {
                "largest": float(worst[good].max(initial=0.0)),
                "largest_free": float(worst[free].max(initial=0.0)),
                "median": float(np.median(worst[good])),
            }
        verdict = verdicts[peer.name]
        excess = (verdict["cost"] - verdicts["wbqp"]["cost"]) / (1 + np.abs(verdicts["wbqp"]["cost"]))
        row["excess"] = [float(excess[good].min()), float(excess[good].max())]
        row["violation"] = {key: float(verdict[key][good].max()) for key in verdict if key != "cost"}
        summary["libraries"][peer.name] = row
    np.savez_compressed(
        work / "answers.npz", limited=limited,
        **{f"{name}_{what}": value for name, result in results.items()
           for what, value in zip(("optimal", "answers", "times"), result[:3])},
        **{f"{name}_{key}": value for name, verdict in verdicts.items() for key, value in verdict.items()},
    )
    return summary


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--wbqp", type=Path, required=True)
    parser.add_argument("--tsid", type=Path, required=True)
    parser.add_argument("--placo", required=True, help="the Python of PlaCo's environment")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--ticks", type=int, help="only so many")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--page", type=Path)
    parser.add_argument("robots", nargs="*", default=list(ROBOTS))
    args = parser.parse_args()
    summaries = [compare(robot, args) for robot in args.robots or ROBOTS]
    text = json.dumps(summaries, indent=1)
    if args.json:
        args.json.write_text(text + "\n")
    print(text)


if __name__ == "__main__":
    main()
