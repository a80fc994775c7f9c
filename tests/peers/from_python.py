#!/usr/bin/env python3
"""wbqp from Python beside PlaCo, tsid and mink: the same jobs in the same closed loop, in one run.

    bash tests/peers/from_python.sh       installs and runs everything; writes the page's tables
    python from_python.py --work target/peers-python --python PYTHON from_python.py's options

Every library is a process with the code that its user writes (users/). All begin in the same state; what a controller
commands moves its robot, by the same integrator, and gives the state of its next step. They take turns, a block of
steps each, so that what else the machine does disturbs all alike; several rounds, which all go the same way.

Of the steps the times count, and of the results the error, what was at its limit and whether the torques move the robot
as they say, all by Pinocchio and from what the loop has recorded. This program runs in tsid's environment.
"""

import argparse
import ast
import json
import os
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import SimpleNamespace

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

import robots  # noqa: E402
from judge import Judge  # noqa: E402
from robots import Peer, machine, table, write_page  # noqa: E402
from states import read_problem, rotation_of  # noqa: E402
from users.job import path, read_job  # noqa: E402

HERE = Path(__file__).parent
# Steps in a turn.
BLOCK = 250
DT = 0.001
# How near to a limit counts as at it: eiquadprog leaves its own by a third of that.
AT_LIMIT = 1e-4
# File in example-robot-data, frame of the tool, home, torque limits of the dynamics, speed limits of the kinematics.
ARMS = {
    "UR5": {
        "urdf": "ur_description/urdf/ur5_robot.urdf", "frame": "tool0",
        "path": {"semi_axes": [0.15, 0.15], "turns": 3.0},
        "home": {"shoulder_lift_joint": -1.2, "elbow_joint": 1.6, "wrist_1_joint": -2.0, "wrist_2_joint": -1.57},
        "effort": {"shoulder_lift_joint": 39.0}, "velocity": {"elbow_joint": 2.1},
    },
    "Panda": {
        "urdf": "panda_description/urdf/panda.urdf", "frame": "panda_hand_tcp",
        "path": {"semi_axes": [0.1, 0.1], "turns": 2.0},
        "home": {"panda_joint2": -0.6, "panda_joint4": -2.2, "panda_joint6": 1.7, "panda_joint7": 0.8},
        "effort": {"panda_joint4": 24.5}, "velocity": {"panda_joint4": 1.3},
    },
}
DYNAMICS = {
    "wbqp": ("with_wbqp", "Arm"),
    "wbqp, its own `ellipse`": ("with_wbqp", "ArmByItself"),
    "tsid": ("with_tsid", "Arm"),
    "PlaCo, `DynamicsSolver`": ("with_placo", "Arm"),
}
KINEMATICS = {
    "wbqp (inverse dynamics)": ("with_wbqp", "Arm"),
    "mink": ("with_mink", "Kinematics"),
    "PlaCo, `KinematicsSolver`": ("with_placo", "Kinematics"),
}
STAND = {
    "wbqp": ("with_wbqp", "Stand"),
    "wbqp, its own `ellipse`": ("with_wbqp", "StandByItself"),
    "tsid": ("with_tsid", "Stand"),
    "PlaCo, `DynamicsSolver`": ("with_placo", "Stand"),
}


def plain(source, target):
    """The robot as all of them read it: without shapes, and without fingers that move; MuJoCo keeps its fixed links."""
    robots.without_meshes(source, target)
    tree = ElementTree.parse(target)
    for joint in tree.getroot().iter("joint"):
        if "finger" in joint.get("name", "") and joint.get("type") == "prismatic":
            joint.set("type", "fixed")
            for tag in ("axis", "limit", "mimic", "dynamics"):
                for element in joint.findall(tag):
                    joint.remove(element)
    mujoco = ElementTree.SubElement(tree.getroot(), "mujoco")
    ElementTree.SubElement(mujoco, "compiler", fusestatic="false")
    tree.write(target)


def arm(robot, work, kinematics):
    about, urdf = ARMS[robot], work / f"{robot}.urdf"
    plain(robots.folder() / about["urdf"], urdf)
    model = pin.buildModelFromUrdf(str(urdf))
    data, joints = model.createData(), list(model.names)[1:]
    home = {joint: about["home"].get(joint, 0.0) for joint in joints}
    pin.framesForwardKinematics(model, data, np.array(list(home.values())))
    tool = data.oMf[model.getFrameId(about["frame"])]
    of_urdf = dict(zip(joints, zip(map(float, model.effortLimit), map(float, model.velocityLimit))))
    return model, {
        "kind": "arm", "robot": robot, "urdf": str(urdf), "joints": joints, "home": home, "dt": DT, "steps": 6500,
        "position": [0.0, 0.0, 0.0], "frame": about["frame"], "rotation": tool.rotation.tolist(),
        "tool": {"kp": 400.0, "kd": 40.0, "weight": [100.0] * 3 + [10.0] * 3},
        "posture": {"kp": 20.0, "kd": 9.0, "weight": 0.01}, "acceleration": about.get("acceleration", 40.0),
        "effort": {j: e for j, (e, _) in of_urdf.items()} | ({} if kinematics else about["effort"]),
        "velocity": {j: v for j, (_, v) in of_urdf.items()} | (about["velocity"] if kinematics else {}),
        "path": {
            "start": tool.translation.tolist(), "axes": [1, 2], "phase": -np.pi / 2, "duration": 6.0, **about["path"],
        },
    }


def stand(robot, work, path):
    """The problem of the comparison in C++ (robots/), with the centre of mass on a circle."""
    controller = tomllib.loads((HERE / "robots" / f"{robot}.controller.toml").read_text())
    scenario = tomllib.loads((HERE / "robots" / f"{robot}.toml").read_text())
    urdf = work / f"{robot}.urdf"
    plain(robots.urdf_of(robot), urdf)
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    text = robots.problem_of(controller, model, 1)
    (work / f"{robot}.problem.txt").write_text(text)
    problem = read_problem(work / f"{robot}.problem.txt")
    joints, home = list(model.names)[2:], controller["robot"]["options"]["home"]
    position = scenario["initial"]["position"]
    q = np.concatenate([position, [0, 0, 0, 1], [home.get(joint, 0.0) for joint in joints]])
    com = pin.centerOfMass(model, model.createData(), q)
    number = lambda name: float(problem[name][0])  # noqa: E731
    gains = lambda name: {key: number(f"{name}.{key}") for key in ("weight", "kp", "kd")}  # noqa: E731
    contacts = []
    for c in controller["contact"]:
        key = f"contact.{c['name']}."
        weights = [float(w) for w in problem[f"{key}weight"]]
        lengths = {n: number(key + n) for n in ("half_length_x", "half_length_y") if key + n in problem}
        numbers = {n: number(key + n) for n in ("friction", "force_min", "force_max", "damping")}
        full = c["kind"] == "full"
        contacts.append({"name": c["name"], "frame": c["frame"], "kind": c["kind"],
                         "weight": weights if full else weights[0], **numbers, **lengths})
    return model, {
        "kind": "stand", "robot": robot, "urdf": str(urdf), "joints": joints, "home": home, "dt": DT, "steps": 6500,
        "position": position, "com": gains("com"), "base": gains("base") | {"frame": problem["base.frame"][0]},
        "posture": gains("posture"), "contacts": contacts,
        "effort": {joint: number(f"effort.{joint}") for joint in joints},
        "path": {"start": com.tolist(), **path},
    }


def lines_of(module, name):
    """Lines that a user writes: of the class's `__init__`, `step` and what `step` needs of the module, without comments
    and descriptions."""
    source = (HERE / "users" / f"{module}.py").read_text()
    lines, classes = source.splitlines(), {c.name: c for c in ast.parse(source).body if isinstance(c, ast.ClassDef)}
    methods = {}
    for base in [b.id for b in classes[name].bases] + [name]:
        methods |= {m.name: m for m in classes[base].body if isinstance(m, ast.FunctionDef)}
    counted = [methods[m] for m in ("__init__", "step", "reference") if m in methods]
    counted += [classes["Given"]] if "Given" in ast.unparse(methods["step"]) else []
    return sum(1 for node in counted for line in lines[node.lineno - 1 : node.end_lineno]
               if line.strip() and not line.strip().startswith(("#", '"""')))


def split(job, states):
    n = len(job.joints)
    return np.split(states, np.cumsum([3, 4, n, 3, 3])[:5], axis=1)


def judge_arm(model, job, answer):
    """Largest and mean square error of the tool over the steps; limits; how far torques are from the motion's."""
    data, frame = model.createData(), model.getFrameId(job.frame)
    _, _, q, _, _, qd = split(job, answer["states"])
    kinematics = bool(np.isnan(answer["torques"]).all())
    wanted = path(job, np.arange(job.steps) * job.dt)[0]
    turned = np.array(job.rotation)
    error, turn, defect = np.zeros(job.steps), np.zeros(job.steps), np.zeros(job.steps)
    for k in range(job.steps):
        pin.framesForwardKinematics(model, data, q[k])
        error[k] = np.linalg.norm(data.oMf[frame].translation - wanted[k])
        turn[k] = np.linalg.norm(pin.log3(turned.T @ data.oMf[frame].rotation))
        if not kinematics:
            defect[k] = np.abs(pin.rnea(model, data, q[k], qd[k], answer["motions"][k]) - answer["torques"][k]).max()
    effort, speed = (np.array([of[joint] for joint in job.joints]) for of in (job.effort, job.velocity))
    after = answer["motions"] if kinematics else qd + job.dt * answer["motions"]
    at_limit = {"speed": np.abs(after) - speed, "range": np.maximum(
        model.lowerPositionLimit - q, q - model.upperPositionLimit)}
    if not kinematics:
        at_limit["torque"] = np.abs(answer["torques"]) - effort
        at_limit["acceleration"] = np.abs(answer["motions"]) - job.acceleration
    return {"error": error, "turn": turn, "defect": None if kinematics else float(defect.max()),
            "at_limit": {key: int((value > -AT_LIMIT).any(axis=1).sum()) for key, value in at_limit.items()},
            "violation": float(max(max(value.max() for value in at_limit.values()), 0.0))}


def judge_stand(model, job, answer, problem):
    """As for arms, by the judge of the comparison in C++."""
    position, quaternion, q, linear, angular, qd = split(job, answer["states"])
    wanted = path(job, np.arange(job.steps) * job.dt)
    contacts = [c.name for c in job.contacts]
    zero, ticks = np.zeros(3), []
    for k in range(job.steps):
        ticks.append(SimpleNamespace(
            position=position[k], quaternion=quaternion[k], rotation=rotation_of(quaternion[k]), q=q[k],
            linear=linear[k], angular=angular[k], qd=qd[k], com=tuple(w[k] for w in wanted),
            base=(np.eye(3), zero, zero), on=[True] * len(contacts),
            swing=[None] * len(contacts)))
    posture = np.array([job.home.get(joint, 0.0) for joint in job.joints])
    states = SimpleNamespace(joints=job.joints, contacts=contacts, posture=posture, ticks=ticks)
    verdict = Judge(model, problem, states).judge(np.hstack([answer["motions"], answer["torques"]]))
    data, error = model.createData(), np.zeros(job.steps)
    frames = [model.getFrameId(c.frame) for c in job.contacts]
    turn, feet = np.zeros(job.steps), []
    for k in range(job.steps):
        full = np.concatenate([position[k], quaternion[k], q[k]])
        error[k] = np.linalg.norm(pin.centerOfMass(model, data, full) - wanted[0][k])
        turn[k] = np.linalg.norm(pin.log3(ticks[k].rotation))
        pin.framesForwardKinematics(model, data, full)
        feet.append([data.oMf[frame].translation.copy() for frame in frames])
    slipped = np.linalg.norm(np.array(feet) - np.array(feet[0]), axis=2).max()
    limit = np.array([job.effort[joint] for joint in job.joints])
    return {"error": error, "turn": turn, "defect": float(verdict["dynamics"].max()), "slipped": float(slipped),
            "at_limit": {"torque": int((np.abs(answer["torques"]) > limit - AT_LIMIT).any(axis=1).sum()),
                         "contact": int((verdict["margin"] > -AT_LIMIT).sum())},
            "violation": float(max(verdict[key].max() for key in ("wrench", "torque", "motion")))}


def run(name, model, job, peers, args, judge):
    """All rounds of one job; the summary of each library."""
    work = args.work / name.lower().replace(",", "").replace(" ", "_")
    work.mkdir(parents=True, exist_ok=True)
    file = work / "job.json"
    file.write_text(json.dumps(job, indent=1))
    job = read_job(file)
    running = []
    for label, (module, which) in peers.items():
        python = args.tsid if module == "with_tsid" else args.python
        running.append(Peer(label, [python, HERE / "users" / "worker.py", file.resolve(), module, which]))
    for turn in range(args.rounds):
        for peer in running:
            peer.ask("start")
        for block, first in enumerate(range(0, job.steps, BLOCK)):
            # Each goes first as often as the others.
            at = block % len(running)
            for peer in running[at:] + running[:at]:
                peer.ask(f"run {first} {first + BLOCK}")
        print(f"{name}: round {turn + 1} of {args.rounds}", flush=True)
    rows = {}
    for i, peer in enumerate(running):
        answers = work / f"{i}.npz"
        peer.ask(f"write {answers.resolve()}")
        peer.process.stdin.close()
        peer.process.wait()
        answer = np.load(answers)
        verdict = judge(model, job, answer)
        times = answer["times"] * 1e-3
        least = times.min(axis=0)
        rows[peer.name] = {
            "p50": np.percentile(times, 50), "p99": np.percentile(times, 99),
            "least_p50": np.percentile(least, 50), "least_p99": np.percentile(least, 99),
            "error": float(verdict["error"].max()), "rms": float(np.sqrt((verdict["error"] ** 2).mean())),
            "turn": float(verdict["turn"].max()), "defect": verdict["defect"], "violation": verdict["violation"],
            "at_limit": verdict["at_limit"], "slipped": verdict.get("slipped"),
            "not_optimal": int((~answer["optimal"]).sum()), "lines": lines_of(*peers[peer.name]),
        }
    return rows


def us(time):
    return f"{time:.1f}" if time < 100 else f"{time:.0f}"


def markdown(rows):
    own = next(iter(rows.values()))
    stands = own["slipped"] is not None
    times, results = [], []
    for name, r in rows.items():
        times.append([name, us(r["p50"]), us(r["p99"]), us(r["least_p50"]), us(r["least_p99"]),
                      f"{r['least_p50'] / own['least_p50']:.2f}", f"{r['least_p99'] / own['least_p99']:.2f}",
                      str(r["lines"])])
        limits = ", ".join(f"{key} {n}" for key, n in r["at_limit"].items() if n) or "none"
        results.append([name, *(f"{1e3 * r[key]:.3g}" for key in ("rms", "error", "turn")), limits,
                        f"{r['violation']:.0e}", "no torques" if r["defect"] is None else f"{r['defect']:.0e}",
                        str(r["not_optimal"]), *([f"{1e3 * r['slipped']:.2g}"] if stands else [])])
    return (table(["step, µs", "p50", "p99", "least p50", "least p99", "p50 ÷ wbqp's", "p99 ÷", "lines"], times) + "\n\n"
            + table(["result", "error, mm, rms", "max", "turned, mrad", "steps at a limit", "beyond it", "torques off",
                     "not optimal", *(["feet moved, mm"] if stands else [])], results))


def ratios(sections):
    """What a step takes as a multiple of wbqp's, p50 and p99 of each step's least time."""
    rows = []
    for job, libraries in sections.items():
        own, row = next(iter(libraries.values())), {}
        for name, r in libraries.items():
            parts = [r[key] / own[key] for key in ("least_p50", "least_p99")]
            p50, p99 = (f"**{part:.2f}**" if part < 1.0 else f"{part:.2f}" for part in parts)
            row[name.split(",")[0]] = f"{p50} ({p99})"
        rows.append([job, *(row.get(name, "") for name in ("tsid", "PlaCo", "mink"))])
    return table(["peer ÷ wbqp: p50 (p99)", "tsid", "PlaCo", "mink"], rows)


def page(sections, rounds):
    parts = [f"{machine()} {rounds} rounds.", ratios(sections)]
    for job, libraries in sections.items():
        parts += [f"**{job}**", markdown(libraries)]
    return "\n\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--python", required=True, help="the Python of the environment with wbqp, PlaCo and mink")
    parser.add_argument("--tsid", required=True, help="the Python of tsid's environment")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--page", type=Path)
    parser.add_argument("jobs", nargs="*")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    jobs = {}
    for robot in ARMS:
        jobs[f"{robot}, inverse dynamics"] = (*arm(robot, args.work, False), DYNAMICS, judge_arm)
        jobs[f"{robot}, differential inverse kinematics"] = (*arm(robot, args.work, True), KINEMATICS,
                                                             judge_arm)
    circle = {"axes": [0, 1], "phase": 0.0, "duration": 6.0}
    for robot, how in (("solo12", {"semi_axes": [0.04, 0.04], "turns": 4.0}),
                       ("talos", {"semi_axes": [0.04, 0.04], "turns": 2.0})):
        model, job = stand(robot, args.work, circle | how)
        problem = read_problem(args.work / f"{robot}.problem.txt")
        jobs[robots.ROBOTS[robot][0]] = (
            model, job, STAND, lambda *given, problem=problem: judge_stand(*given, problem))
    sections = {}
    for name, (model, job, peers, judge) in jobs.items():
        if not args.jobs or any(asked in name for asked in args.jobs):
            sections[name] = run(name, model, job, peers, args, judge)
            print(f"**{name}**\n\n{markdown(sections[name])}\n", flush=True)
    if args.json:
        args.json.write_text(json.dumps(sections, indent=1) + "\n")
    if args.page:
        write_page(args.page, "from_python", page(sections, args.rounds))


if __name__ == "__main__":
    main()
