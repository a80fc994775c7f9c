#!/usr/bin/env python3
"""wbqp beside TSID and PlaCo: the same robots, contacts, tasks, gains and limits, at the same states, in one run.

    bash tests/peers/robots.sh            installs, builds and runs everything; writes the page's table
    python robots.py --work target/peers-robots --wbqp … --tsid … --placo PYTHON robots.py's options

For each robot a scenario runs in wbqp's closed loop, with noise, pushes and limits that become active. What every
tick was given is recorded, and then all libraries get it: every one solves at the same state for the same references.
They run by turns, a block of ticks each, so that what else the machine does disturbs all alike; several rounds.

Answers are judged by a program that none of them has a part in: with Pinocchio's dynamics, each answer's cost in the
common problem and its largest violation of the limits.
"""

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import textwrap
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
# Ticks in a turn.
BLOCK = 250
# How much more all costs are in the pass that shows what the libraries' own regularisation does.
SCALE = 100
VIOLATIONS = ("dynamics", "motion", "wrench", "torque")


def folder():
    """Where example-robot-data has its robots."""
    folder = Path(pin.__file__).parents[4].parent / "cmeel.prefix/share/example-robot-data/robots"
    for path in [Path(p) for p in sys.path if p]:
        candidate = path / "cmeel.prefix/share/example-robot-data/robots"
        if candidate.is_dir():
            folder = candidate
    return folder


def urdf_of(robot):
    return folder() / ROBOTS[robot][1]


def without_meshes(source, target):
    """The same robot, without what PlaCo would load and place: shapes have no part in the dynamics."""
    tree = ElementTree.parse(source)
    for link in tree.getroot().iter("link"):
        for tag in ("visual", "collision"):
            for element in link.findall(tag):
                link.remove(element)
    tree.write(target)


def problem_of(controller, model, scale):
    """What the other libraries need of the controller's file: name and values per line.

    All weights times `scale`, which changes no optimum but makes what both add to the Hessian's diagonal, 1e-8,
    smaller.
    """
    lines = {}
    tasks = {task["name"]: task for task in controller["task"]}
    constraints = {c["contact"]: {} for c in controller["constraint"] if "contact" in c}
    for constraint in controller["constraint"]:
        if "contact" in constraint:
            constraints[constraint["contact"]].update(constraint)
    for name in ("com", "base", "posture"):
        for key in ("weight", "kp", "kd"):
            lines[f"{name}.{key}"] = tasks[name][key] * (scale if key == "weight" else 1)
    lines["base.frame"] = "base_link"
    effort = controller["robot"].get("options", {}).get("effort", {})
    for joint in list(model.names)[2:]:
        of_urdf = model.effortLimit[model.joints[model.getJointId(joint)].idx_v]
        lines[f"effort.{joint}"] = effort.get(joint, float(of_urdf))
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
        lines[f"contact.{name}.weight"] = " ".join(
            str(scale * w) for w in (weight if isinstance(weight, list) else [weight] * 6))
        if f"swing_{name}" in tasks:
            for key in ("weight", "kp", "kd"):
                lines[f"swing.{name}.{key}"] = tasks[f"swing_{name}"][key] * (scale if key == "weight" else 1)
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
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(list(map(str, command)), stdin=pipe, stdout=pipe, text=True)

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


def largest(good, difference, nv):
    """Of the differences, per part, in the ticks that count."""
    parts = {"base": difference[:, :6], "joints": difference[:, 6:nv], "torques": difference[:, nv:]}
    return {part: float(values[good].max(initial=0.0)) for part, values in parts.items()}


def compare(robot, args):
    work = args.work / robot
    work.mkdir(parents=True, exist_ok=True)
    for file in (f"{robot}.toml", f"{robot}.controller.toml"):
        shutil.copy(HERE / "robots" / file, work / file)
    source, urdf = urdf_of(robot), work / f"{robot}.urdf"
    without_meshes(source, urdf)
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    controller = tomllib.loads((work / f"{robot}.controller.toml").read_text())
    problem_file = work / "problem.txt"
    problem_file.write_text(problem_of(controller, model, 1))
    problem = read_problem(problem_file)
    scenario, recorded = work / f"{robot}.toml", work / "recorded.txt"
    subprocess.run([args.wbqp, "record", scenario, recorded], check=True)
    states = States(recorded)
    if args.ticks:
        states.ticks = states.ticks[: args.ticks]
    turned = level(states, model, problem)
    given = work / "states.txt"
    states.write(given)
    states = States(given)

    commands = {
        "TSID": lambda problem: [args.tsid, urdf, problem, given],
        "PlaCo": lambda problem: [args.placo, HERE / "placo_peer.py", urdf, problem, given],
    }
    peers = [Peer("wbqp", [args.wbqp, "serve", scenario, given])]
    peers += [Peer(name, command(problem_file)) for name, command in commands.items()]
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
    reference, cost = results["wbqp"], verdicts["wbqp"]["cost"]
    limited = reference[3][:, :2] > 0
    # The optimum of the common problem is that of TSID's as well where its narrower limit holds.
    same = verdicts["wbqp"]["corners"] < 1e-6
    summary = {
        "robot": ROBOTS[robot][0], "urdf": ROBOTS[robot][1], "ticks": ticks, "turned": turned,
        "torque_limited": int(limited[:, 0].sum()), "contact_limited": int(limited[:, 1].sum()),
        "lifted": sum(not all(tick.on) for tick in states.ticks), "corners_bear": int(same.sum()),
        "soles": any(problem[f"contact.{name}.kind"][0] == "full" for name in states.contacts),
        "libraries": {},
    }
    for peer in peers:
        optimal, answers, times, _ = results[peer.name]
        good = optimal & reference[0]
        difference = np.abs(answers - reference[1])
        verdict = verdicts[peer.name]
        excess = ((verdict["cost"] - cost) / (1 + np.abs(cost)))[good]
        summary["libraries"][peer.name] = {
            "times": quantiles(times), "size": peer.size, "not_optimal": int((~optimal).sum()),
            "differences": largest(good, difference, model.nv),
            "differences_same": largest(good & same, difference, model.nv),
            "excess": [float(excess.min()), float(excess.max())],
            "violation": {key: float(verdict[key][good].max()) for key in VIOLATIONS},
        }
    np.savez_compressed(
        work / "answers.npz", limited=limited,
        **{f"{name}_{what}": value for name, result in results.items()
           for what, value in zip(("optimal", "answers", "times"), result[:3])},
        **{f"{name}_{key}": value for name, verdict in verdicts.items() for key, value in verdict.items()},
    )

    # What is left comes from what they add to the Hessian's diagonal if it gets smaller as costs get larger. Violations
    # that eiquadprog accepts grow with the costs: where there are any, an answer says nothing about that.
    scaled = work / "problem_scaled.txt"
    scaled.write_text(problem_of(controller, model, SCALE))
    for name, command in commands.items():
        peer = Peer(name, command(scaled))
        peer.ask("start")
        peer.ask(f"run 0 {ticks}")
        optimal, answers, *_ = peer.answers(work / f"{name.lower()}_scaled.txt")
        verdict = judge.judge(answers)
        violation = np.max([verdict[key] for key in VIOLATIONS], axis=0)
        good = optimal & reference[0] & same
        row = summary["libraries"][name]
        row["differences_same_scaled"] = largest(good & (violation < 1e-9), np.abs(answers - reference[1]), model.nv)
        row["loose_scaled"] = int((violation >= 1e-9).sum())
        row["violation_scaled"] = float(violation[optimal].max())
        row["not_optimal_scaled"] = int((~optimal).sum())
    return summary


def table(header, rows):
    marks = ["---"] + ["---:"] * (len(header) - 1)
    return "\n".join("| " + " | ".join(row) + " |" for row in [header, marks, *rows])


def markdown(summary):
    us = lambda t: f"{t:.1f}" if t < 100 else f"{t:.0f}"  # noqa: E731
    three = lambda parts: " / ".join(f"{parts[part]:.0e}" for part in ("base", "joints", "torques"))  # noqa: E731
    libraries, own = summary["libraries"], summary["libraries"]["wbqp"]["times"]["least"]
    rounds = libraries["wbqp"]["times"]["rounds"]
    times, answers = [], []
    for name, row in libraries.items():
        all_, least = row["times"]["all"], row["times"]["least"]
        which = ("p50", "p99", "max")
        times.append([name, *(us(all_[q]) for q in which), *(us(least[q]) for q in which),
                      *(f"{least[q] / own[q]:.1f}" for q in which), " / ".join(map(str, row["size"]))])
        if name == "wbqp":
            answers.append([name, str(row["not_optimal"]), "", "", "", ""])
        else:
            loose = f" (without {row['loose_scaled']} ticks)" if row["loose_scaled"] else ""
            answers.append([name, str(row["not_optimal"]), three(row["differences"]), three(row["differences_same"]),
                            three(row["differences_same_scaled"]) + loose,
                            f"{row['excess'][0]:.0e} … {row['excess'][1]:.0e}"])
        answers[-1].append(f"{max(row['violation'].values()):.0e}")
    text = f"**{summary['robot']}** (`{summary['urdf']}`), {summary['ticks']} ticks: in {summary['torque_limited']}"
    text += f" a torque is at its limit, in {summary['contact_limited']} a contact at one of its own"
    if summary["lifted"]:
        text += f", in {summary['lifted']} a foot is in the air"
    if summary["soles"]:
        bear = "all" if summary["corners_bear"] == summary["ticks"] else summary["corners_bear"]
        text += f"; in {bear} the corners of the soles bear the optimum's wrenches"
    times = table([f"µs, {rounds} rounds", "p50", "p99", "max", "least p50", "least p99", "least max",
                   "p50 ÷ wbqp's", "p99 ÷", "max ÷", "variables / equalities / inequalities"], times)
    answers = table(["", "not optimal", "differences", "where the limits are the same", f"costs × {SCALE}", "cost",
                     "violation"], answers)
    text = textwrap.fill(f"{text}.", width=120, break_long_words=False, break_on_hyphens=False)
    return f"{text}\n\n{times}\n\n{answers}"


def machine():
    processor = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                      if "model name" in line), platform.processor())
    return (f"{processor}, {os.cpu_count()} logical cores, {platform.system()}; "
            f"load over the last 15 minutes {os.getloadavg()[2]:.1f}.")


def write_page(page, place, content):
    """Puts the content between the marks of that name."""
    text = page.read_text()
    pattern = re.compile(rf"(<!-- begin {place} -->\n).*?(<!-- end {place} -->)", re.DOTALL)
    if not pattern.search(text):
        sys.exit(f"{page}: there is no place for {place}")
    page.write_text(pattern.sub(lambda m: f"{m[1]}\n{content}\n\n{m[2]}", text))


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
    if args.page:
        write_page(args.page, "robots", "\n\n".join([machine(), *map(markdown, summaries)]))
    print(text)


if __name__ == "__main__":
    main()
