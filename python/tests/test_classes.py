"""Classes that are made from the registry."""

from __future__ import annotations

import copy
import inspect
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import wbqp

PYTHON = Path(__file__).parent.parent


def test_constructors_make_the_same_controller_as_a_file() -> None:
    text = """
        [controller]
        rate = 500.0
        [robot]
        type = "quadruped"
        [[contact]]
        frames = ["FL_foot", "FR_foot", "RL_foot", "RR_foot"]
        motion = "hard"
        friction = 0.6
        [[task]]
        type = "com"
        kp = 100.0
        [[task]]
        type = "base_orientation"
        kp = 100.0
        reference = { type = "min_jerk", to = [0.0, 0.1, 0.0], duration = 2.0 }
        [[task]]
        type = "posture"
        kp = 30.0
        weight = 0.5
    """
    robot = wbqp.Robot(wbqp.robots.Quadruped())
    feet = [name for name in robot.frames if name.endswith("foot")]
    assert len(feet) == 4
    in_code = wbqp.Controller(
        rate=500.0,
        robot=wbqp.robots.Quadruped(),
        contacts=[wbqp.Contact(frames=feet, motion="hard", friction=0.6)],
        tasks=[
            wbqp.tasks.Com(kp=100.0),
            wbqp.tasks.BaseOrientation(
                kp=100.0, reference=wbqp.references.MinJerk(to=[0.0, 0.1, 0.0], duration=2.0)
            ),
            wbqp.tasks.Posture(kp=30.0, weight=0.5),
        ],
    )
    from_text = wbqp.Controller.from_text(text.replace('"FL_foot", "FR_foot", "RL_foot", "RR_foot"', str(feet)[1:-1]))
    m = in_code.measurement()
    for k in range(50):
        m.time = 0.002 * k
        expected, report = from_text.tick(m)
        command, _ = in_code.tick(m)
        assert report.level == "optimal"
        assert command.effort.tolist() == expected.effort.tolist()


def test_defaults_signature_and_documentation_come_from_the_schema() -> None:
    com = wbqp.tasks.Com
    parameters = inspect.signature(com).parameters
    assert parameters["kp"].default is inspect.Parameter.empty
    assert parameters["active"].default is True
    assert "Parameters\n----------\n" in (com.__doc__ or "")
    assert com(kp=3.0).active is True and com(kp=3.0).kp == 3.0
    assert com(kp=3.0) == com(kp=3.0) != com(kp=4.0)


def test_unknown_and_missing_keys_are_refused_at_once() -> None:
    with pytest.raises(TypeError, match="Com has no key 'kq'; did you mean 'kp'"):
        wbqp.tasks.Com(kq=1.0)
    with pytest.raises(TypeError, match="Com needs 'kp'"):
        wbqp.tasks.Com()
    with pytest.raises(wbqp.ConfigError, match="kp"):
        wbqp.Controller(rate=250.0, robot="othex", tasks=[wbqp.tasks.Com(kp="stiff")])


def test_every_plug_in_has_a_class() -> None:
    assert {"Com", "Posture", "FramePose"} <= set(wbqp.tasks.__all__)
    assert {"ActuatorLimits", "FrictionPyramid"} <= set(wbqp.constraints.__all__)
    assert {"Hold", "MinJerk"} <= set(wbqp.references.__all__)
    assert {"Othex", "Urdf"} <= set(wbqp.robots.__all__)
    assert "ActiveSet" in wbqp.solvers.__all__ and wbqp.fallbacks.__all__


def test_stubs_are_those_of_the_registry() -> None:
    script = str(PYTHON / "generate_stubs.py")
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_and_its_use_are_typed(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    use = tmp_path / "use.py"
    use.write_text(
        "import numpy as np\n"
        "import wbqp\n"
        "controller = wbqp.Controller(rate=250.0, robot='othex', tasks=[wbqp.tasks.Posture(kp=1.0)])\n"
        "m = controller.measurement()\n"
        "m.q['arm_pitch1'] = 0.1\n"
        "command, report = controller.tick(m)\n"
        "level: str = report.level\n"
        "effort: np.ndarray = command.effort\n"
        "solution = wbqp.solve_qp(np.eye(2), np.zeros(2))\n"
        "number: float = solution.objective\n"
    )
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import wbqp\nwbqp.tasks.Posture(kp='stiff')\nwbqp.solve_qp(1)\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--python-executable", sys.executable]
    cache = ["--cache-dir", str(tmp_path / "cache")]
    good = subprocess.run([*command, *cache, str(use)], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert good.returncode == 0, good.stdout + good.stderr
    bad = subprocess.run([*command, *cache, str(wrong)], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert bad.returncode == 1 and bad.stdout.count("error:") == 2, bad.stdout + bad.stderr


def test_stubs_of_the_extension_module_are_what_it_has(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy.stubtest", "wbqp._wbqp", "--ignore-disjoint-bases"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_assigned_keys_are_those_of_the_configuration() -> None:
    com = wbqp.tasks.Com(kp=1.0)
    com.kp = 50.0
    assert com == wbqp.tasks.Com(kp=50.0)
    with pytest.raises(AttributeError, match="did you mean 'kp'"):
        com.kpp = 3.0
    pose = wbqp.tasks.FramePose(frame="tool", kp=1.0)
    pose.weight.append(7.0)
    assert 7.0 not in wbqp.tasks.FramePose(frame="tool", kp=1.0).weight
    assert wbqp.tasks.Posture(kp=np.ones(3)) == wbqp.tasks.Posture(kp=np.ones(3))
    assert wbqp.tasks.Posture(kp=np.ones(3)) != wbqp.tasks.Posture(kp=np.zeros(3))


def test_copies_of_named_arrays_have_names() -> None:
    controller = wbqp.Controller(rate=250.0, robot=wbqp.robots.Othex())
    effort = controller.command.effort
    name = effort.names[0]
    for other in (effort.copy(), copy.deepcopy(effort), pickle.loads(pickle.dumps(effort))):
        assert other[name] == effort[0] and other is not effort
    q = controller.measurement().q
    q += 0.25
    assert q[q.names[0]] == q[0]
    assert type(q + 1.0) is np.ndarray
