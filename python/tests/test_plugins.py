"""Plug-ins written in Python."""

from __future__ import annotations

import dataclasses
import threading
import traceback
import time
from typing import Any

import numpy as np
import pytest

import wbqp


@wbqp.task("test.level_head")
@dataclasses.dataclass
class LevelHead:
    """Keeps a frame's z axis upright."""

    frame: str
    kp: float = dataclasses.field(default=40.0, metadata={"unit": "1/s²", "description": "Stiffness."})

    def bind(self, setup: wbqp.Setup) -> wbqp.Layout:
        self.head = setup.frame(self.frame)
        return wbqp.Layout([("about x", "rad/s²"), ("about y", "rad/s²")], error_unit="rad")

    def update(self, tick: wbqp.Tick, rows: wbqp.Rows) -> None:
        frame = tick.frame(self.head)
        tilt = np.cross([0.0, 0.0, 1.0], frame.rotation[:, 2])
        for k in range(2):
            rate = frame.velocity[3 + k]
            rows.motion(k, error=tilt[k], rate=rate, kp=self.kp, J=frame.J[3 + k], bias=frame.Jdot_v[3 + k])


@wbqp.constraint("test.speed_limit")
class SpeedLimit:
    """Keeps a joint slower than a speed, by its acceleration."""

    joint: str
    most: float = 1.0

    def bind(self, setup: wbqp.Setup) -> wbqp.Layout:
        self.index = setup.velocity(self.joint)
        self.period = setup.period
        return wbqp.Layout([(self.joint, "rad/s²")])

    def update(self, tick: wbqp.Tick, rows: wbqp.Rows) -> None:
        rows.vdot[0, self.index] = 1.0
        rows.lower[0] = (-self.most - tick.v[self.index]) / self.period
        rows.upper[0] = (self.most - tick.v[self.index]) / self.period


@wbqp.reference("test.swing")
class Swing:
    """A sine around where it begins."""

    amplitude: float
    frequency: float = 1.0

    def start(self, time: float, value: np.ndarray, rate: np.ndarray) -> None:
        self.begin, self.center = time, value

    def sample(self, time: float) -> Any:
        w = 2 * np.pi * self.frequency
        phase = w * (time - self.begin)
        one = np.ones_like(self.center)
        return (
            self.center + self.amplitude * np.sin(phase) * one,
            self.amplitude * w * np.cos(phase) * one,
            -self.amplitude * w * w * np.sin(phase) * one,
        )


@wbqp.task("test.naughty")
class Naughty:
    """Does what it is told."""

    what: str = "nothing"

    def bind(self, setup: wbqp.Setup) -> Any:
        if self.what == "bind":
            raise ValueError("no, thanks")
        if self.what == "layout":
            return {"rows": 1}
        return wbqp.Layout([("x", "m/s²")])

    def update(self, tick: wbqp.Tick, rows: wbqp.Rows) -> Any:
        rows.vdot[0, 0] = 1.0
        rows.target[0] = 0.0
        if self.what == "raise":
            raise RuntimeError("out of order")
        if self.what == "garbage":
            rows.target = ["x", "y"]
        if self.what == "nan":
            rows.vdot[0, 0] = np.nan
        if self.what == "return":
            return 5
        if self.what == "shape":
            rows.vdot = np.zeros((3, 3))
        if self.what == "sleep":
            time.sleep(0.3)
        if self.what == "interrupt":
            raise KeyboardInterrupt
        if self.what == "unwritten":
            rows.target[0] = np.nan
        return None


def hover(*tasks: Any, **more: Any) -> wbqp.Controller:
    tables: dict[str, Any] = {
        "rate": 250.0,
        "robot": "othex",
        "tasks": [
            wbqp.tasks.BasePosition(kp=10.0),
            wbqp.tasks.BaseOrientation(kp=20.0, weight=0.01),
            wbqp.tasks.Posture(kp=25.0),
            *tasks,
        ],
        "constraints": [wbqp.constraints.ActuatorLimits()],
    }
    tables.update(more)
    return wbqp.Controller(**tables)


def test_a_task_in_python_does_what_one_in_rust_does() -> None:
    frame = wbqp.Robot({"type": "othex"}).frames[0]
    head = wbqp.entry(LevelHead(frame=frame, kp=30.0), name="head", weight=10.0)
    controller = hover(head)
    m = controller.measurement()
    # 0.1 rad about x.
    m.quaternion[:] = [np.cos(0.05), np.sin(0.05), 0.0, 0.0]
    controller.tick(m)
    m.time = 0.004
    _, report = controller.tick(m)
    assert report.level == "optimal" and report.traceback is None
    assert report.tasks["head"].error["about x"] == pytest.approx(-np.sin(0.1) * -1.0)
    assert report.vdot["base roll"] == pytest.approx(-30.0 * np.sin(0.1), rel=0.05)
    controller.set("head", kp=60.0)
    m.time = 0.008
    assert controller.tick(m)[1].vdot["base roll"] == pytest.approx(-60.0 * np.sin(0.1), rel=0.05)


def test_the_kit_accepts_what_is_right_and_finds_what_is_wrong() -> None:
    wbqp.testing.check(LevelHead(frame="tool"), semantics="motion", states=2)
    wbqp.testing.check(wbqp.tasks.Posture(kp=3.0, kd=3.5), states=2)

    @wbqp.task("test.wrong_sign")
    class WrongSign(LevelHead):
        """Pushes in the direction of its error."""

        def update(self, tick: wbqp.Tick, rows: wbqp.Rows) -> None:
            super().update(tick, rows)
            frame = tick.frame(self.head)
            for k in range(2):
                rows.target[k] = 30.0 * frame.velocity[3 + k]

    with pytest.raises(AssertionError, match="Feedback|feedback"):
        wbqp.testing.check(WrongSign(frame="tool"), semantics="motion", states=2)


def test_a_constraint_limits() -> None:
    limits = [wbqp.constraints.ActuatorLimits(), {"type": "test.speed_limit", "joint": "arm_pitch1", "most": 0.2}]
    controller = hover(wbqp.tasks.Com(kp=1.0), constraints=limits)
    m = controller.measurement()
    controller.tick(m)
    controller.follow("posture", {"type": "test.swing", "amplitude": 1.0})
    fastest = 0.0
    for k in range(1, 60):
        m.time = 0.004 * k
        command, report = controller.tick(m)
        speed = m.v[7] + 0.004 * report.vdot["arm_pitch1"]
        assert abs(speed) <= 0.2 + 1e-6
        fastest = max(fastest, speed)
        m.q[1] += 0.004 * speed
        m.v[7] = speed
    assert fastest == pytest.approx(0.2, abs=1e-6)


def test_a_reference_is_followed_also_from_a_file() -> None:
    text = """
        [controller]
        rate = 250.0
        [robot]
        type = "othex"
        [[task]]
        type = "base_position"
        kp = 10.0
        [[task]]
        type = "posture"
        kp = 25.0
        reference = { type = "test.swing", amplitude = 0.1 }
    """
    controller = wbqp.Controller.from_text(text)
    m = controller.measurement()
    controller.tick(m)
    m.time = 0.1
    _, report = controller.tick(m)
    expected = -0.1 * np.sin(2 * np.pi * 0.1)
    np.testing.assert_allclose(report.tasks["posture"].error, expected, atol=1e-9)


def test_parameters_are_checked_with_their_places() -> None:
    head = '[controller]\nrate = 250.0\n[robot]\ntype = "othex"\n'
    text = head + '[[task]]\ntype = "test.level_head"\nweight = 1.0\nkpp = 3.0\n'
    with pytest.raises(wbqp.ConfigError) as refused:
        wbqp.Controller.from_text(text, name="file.toml")
    messages = str(refused.value)
    assert "file.toml:8:1: task[0]" in messages and "unknown key `kpp`; did you mean `kp`" in messages
    assert "key `frame` is missing" in messages
    with pytest.raises(wbqp.ConfigError, match="`kp` must be a number, is 'stiff'"):
        hover({"type": "test.level_head", "frame": "tool", "kp": "stiff", "weight": 1.0})
    with pytest.raises(wbqp.ConfigError, match="frame `tol` does not exist; did you mean `tool`"):
        hover({"type": "test.level_head", "frame": "tol", "weight": 1.0})


def test_a_tag_is_registered_once_and_keys_of_the_framework_are_refused() -> None:
    with pytest.raises(ValueError, match="task type `test.level_head` is there already, from "):
        wbqp.task("test.level_head")(Naughty)
    with pytest.raises(ValueError, match="there already"):
        wbqp.task("com")(LevelHead)

    class Weighty:
        weight: float = 1.0
        bind = update = lambda self, *_: None

    with pytest.raises(ValueError, match="`weight`, which belongs to the framework"):
        wbqp.task("test.weighty")(Weighty)
    with pytest.raises(TypeError, match="needs a method `bind`"):
        wbqp.task("test.empty")(type("Empty", (), {}))


CELL = """
@wbqp.{kind}("{tag}")
class Again:
    "As a cell of a notebook defines it."

    gain: float = 1.0
    {keys}
    def bind(self, setup):
        return wbqp.Layout([("x", "m/s²")])

    def update(self, tick, rows):
        rows.vdot[0, 0] = 1.0
        rows.{write} = self.gain * {number}
"""


def run_cell(**words: Any) -> None:
    exec(CELL.format_map({"kind": "task", "tag": "test.again", "keys": "", "write": "target[0]", **words}), globals())


def wanted(controller: wbqp.Controller, **keys: float) -> float:
    """The acceleration along x that the entry wants, from its residual without an acceleration."""
    m = controller.measurement()
    controller.reset(m)
    if keys:
        controller.set("again", **keys)
    m.time = controller.report.time + 0.004
    return float(controller.tick(m)[1].vdot["base x"])


def again(**keys: Any) -> wbqp.Controller:
    return hover({"type": "test.again", "name": "again", "weight": 1e6, **keys})


def test_a_cell_that_runs_again_defines_its_plug_in_anew() -> None:
    run_cell(number=0.1)
    first = again()
    run_cell(number=0.2, keys="more: float = 0.0")
    second = again(more=1.0)
    assert wanted(first) == pytest.approx(0.1, rel=1e-3)
    assert wanted(second) == pytest.approx(0.2, rel=1e-3)
    # The earlier controller keeps its class, with its keys.
    assert wanted(first, gain=2.0) == pytest.approx(0.2, rel=1e-3)
    assert wanted(second, gain=2.0) == pytest.approx(0.4, rel=1e-3)
    with pytest.raises(ValueError, match=r"unknown key `more` \(known: gain\)"):
        first.set("again", more=1.0)
    second.set("again", more=2.0)
    # What is no longer there is refused, as a key that never was.
    run_cell(number=0.3)
    with pytest.raises(wbqp.ConfigError, match="unknown key `more`"):
        again(more=1.0)
    # A class with another name is another plug-in.
    with pytest.raises(ValueError, match="task type `test.again` is there already"):
        cell = CELL.format(kind="task", tag="test.again", keys="", write="target[0]", number=0.0)
        exec(cell.replace("Again", "Other"))
    assert wanted(again()) == pytest.approx(0.3, rel=1e-3)


def test_a_constraint_is_defined_anew_as_well() -> None:
    limit = {"type": "test.again_limit", "name": "again"}
    words = {"kind": "constraint", "tag": "test.again_limit", "write": "lower[0] = rows.upper[0]"}
    run_cell(**words, number=0.1)
    first = hover(constraints=[limit])
    run_cell(**words, number=0.2)
    assert wanted(first) == pytest.approx(0.1, rel=1e-6)
    assert wanted(hover(constraints=[limit])) == pytest.approx(0.2, rel=1e-6)
    assert wanted(first, gain=3.0) == pytest.approx(0.3, rel=1e-6)


def naughty(what: str) -> wbqp.Controller:
    return hover({"type": "test.naughty", "what": what, "name": "naughty", "weight": 1.0})


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("raise", "RuntimeError: out of order"),
        ("garbage", "ValueError: could not convert"),
        ("return", "TypeError: update returned a int"),
        ("shape", "ValueError: could not broadcast"),
    ],
)
def test_what_an_update_raises_is_a_fault_and_the_command_still_comes(what: str, says: str) -> None:
    controller = naughty(what)
    good = hover().tick(hover().measurement())[0].effort
    m = controller.measurement()
    command, report = controller.tick(m)
    assert report.level in ("extrapolated", "safe")
    assert "not finite" in (report.fault or "")
    assert says in (report.traceback or "") and "plug-in `test.naughty`" in (report.traceback or "")
    if what == "raise":
        assert f'File "{__file__}"' in (report.traceback or "") and "in update" in (report.traceback or "")
    np.testing.assert_allclose(command.effort, good, atol=2.0)
    # The next tick is well again once the plug-in is.
    controller.set("naughty", what="nothing")
    m.time = 0.004
    assert controller.tick(m)[1].level == "optimal" and report.traceback is None


@pytest.mark.parametrize("what", ["nan", "unwritten"])
def test_numbers_that_are_none_are_a_fault(what: str) -> None:
    controller = naughty(what)
    command, report = controller.tick(controller.measurement())
    assert report.level in ("extrapolated", "safe") and "not finite" in (report.fault or "")
    assert np.isfinite(command.effort).all() and report.traceback is None


@pytest.mark.parametrize(
    ("what", "says"), [("bind", "ValueError: no, thanks"), ("layout", "must return a wbqp.Layout")]
)
def test_what_bind_raises_is_a_config_error(what: str, says: str) -> None:
    with pytest.raises(wbqp.ConfigError, match=says) as refused:
        naughty(what)
    cause = refused.value.__cause__
    assert cause is not None and f"{type(cause).__name__}: {cause}" in str(refused.value)
    if what == "bind":
        assert cause.__traceback__ is not None
        assert "bind" in [entry.name for entry in traceback.extract_tb(cause.__traceback__)]
    # It was that controller's.
    with pytest.raises(wbqp.ConfigError) as other:
        hover({"type": "test.naughtty"})
    assert other.value.__cause__ is None


def test_a_plug_in_that_sleeps_leaves_the_controller_in_use() -> None:
    controller = naughty("sleep")
    m = controller.measurement()
    done: list[str] = []
    thread = threading.Thread(target=lambda: done.append(controller.tick(m)[1].level))
    thread.start()
    time.sleep(0.1)
    asked = [lambda: controller.tick(m), lambda: controller.report, lambda: controller.command, controller.explain]
    for ask in asked:
        with pytest.raises(RuntimeError, match="in use by another thread"):
            ask()
    thread.join()
    assert done == ["optimal"] and controller.report.level == "optimal"


def test_ctrl_c_in_an_update_ends_the_tick() -> None:
    controller = naughty("interrupt")
    with pytest.raises(KeyboardInterrupt):
        controller.tick(controller.measurement())
    # The controller is as usable as after any fault.
    controller.set("naughty", what="nothing")
    m = controller.measurement()
    m.time = 0.004
    assert controller.tick(m)[1].level == "optimal"


def test_each_controller_has_an_object_of_its_own() -> None:
    parameters = LevelHead(frame=wbqp.Robot({"type": "othex"}).frames[0])
    first, second = (hover(wbqp.entry(parameters, name="head", weight=1.0)) for _ in range(2))
    first.set("head", kp=0.0)
    m = first.measurement()
    m.quaternion[:] = [np.cos(0.05), np.sin(0.05), 0.0, 0.0]
    accelerations = []
    for controller in (first, second):
        for k in range(2):
            m.time = 0.004 * k
            accelerations.append(controller.tick(m)[1].vdot["base roll"])
    assert accelerations[1] != accelerations[3] and not hasattr(parameters, "head")


@pytest.fixture
def naughty_scenario(tmp_path: Any) -> Any:
    """Half a second of experiment B's controller, with a task that raises."""
    shipped = wbqp.scenarios()["push_with_disturbance"]
    text = (shipped.parent / "push_with_disturbance.controller.toml").read_text(encoding="utf-8")
    more = '\n[[task]]\nname = "naughty"\ntype = "test.naughty"\nwhat = "raise"\nweight = 1.0\n'
    (tmp_path / "push_with_disturbance.controller.toml").write_text(text + more, encoding="utf-8")
    scenario = tmp_path / "push.toml"
    text = shipped.read_text(encoding="utf-8")
    for old, new in (("duration = 25.0", "duration = 0.5"), ("from = 12.0\nuntil = 17.0", "from = 0.2\nuntil = 0.3"),
                     ("at = 1.0", "at = 0.1")):
        assert old in text
        text = text.replace(old, new)
    scenario.write_text(text, encoding="utf-8")
    return scenario


def test_a_simulation_says_what_a_plug_in_raised(naughty_scenario: Any) -> None:
    run = wbqp.simulate(naughty_scenario, case="with_ft", progress=False)
    assert run.summary["held"] > 0
    said = run.summary["traceback"]
    assert "plug-in `test.naughty`" in said and "RuntimeError: out of order" in said
    assert "in update" in said and __file__ in said
    with pytest.raises(wbqp.ConfigError, match="no, thanks") as refused:
        wbqp.simulate(naughty_scenario, case="with_ft", set={"task": {"naughty": {"what": "bind"}}}, progress=False)
    assert isinstance(refused.value.__cause__, ValueError)
    # It was that run's: neither the next one's nor that of a tick.
    well_behaved = {"task": {"naughty": {"what": "nothing"}}}
    well = wbqp.simulate(naughty_scenario, case="with_ft", set=well_behaved, progress=False)
    assert well.summary["traceback"] is None
    controller = hover()
    assert controller.tick(controller.measurement())[1].traceback is None


def test_a_case_in_another_engine_says_what_a_plug_in_raised(naughty_scenario: Any, tmp_path: Any) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra `mujoco`")
    from wbqp.mujoco import run_case

    summary = run_case(naughty_scenario, "with_ft", tmp_path / "run.mcap")
    assert "RuntimeError: out of order" in summary["traceback"]
    with pytest.raises(KeyboardInterrupt):
        run_case(naughty_scenario, "with_ft", tmp_path / "run.mcap", variation='set.task.naughty.what = "interrupt"')


@wbqp.task("test.maybe")
@dataclasses.dataclass
class Maybe:
    """Has a number, or none."""

    size: float | None = 3.0

    def bind(self, setup: wbqp.Setup) -> wbqp.Layout:
        return wbqp.Layout([("z", "m/s²")])

    def update(self, tick: wbqp.Tick, rows: wbqp.Rows) -> None:
        rows.target[0] = 0.0


def test_what_a_configuration_cannot_say_is_refused() -> None:
    class Other(Maybe):
        """Is not registered itself."""

    with pytest.raises(TypeError, match=r'Other is not registered.*@wbqp.task\("tag"\)'):
        wbqp.entry(Other(), weight=1.0)
    with pytest.raises(TypeError, match="`size` is None"):
        wbqp.entry(Maybe(size=None), weight=1.0)


def test_tracebacks_belong_to_the_tick_in_which_they_were_raised() -> None:
    inner = wbqp.Controller(rate=500.0, robot=wbqp.robots.Othex(), tasks=[wbqp.tasks.Posture(kp=30.0)])

    @wbqp.task("test.nested")
    class Nested:
        """Raises, then ticks another controller."""

        def bind(self, setup: wbqp.Setup) -> wbqp.Layout:
            return wbqp.Layout([("z", "m/s²")])

        def update(self, tick: wbqp.Tick, rows: wbqp.Rows) -> None:
            _, report = inner.tick(inner.measurement())
            assert report.traceback is None
            raise ValueError("its own")

    outer = wbqp.Controller(
        rate=500.0, robot=wbqp.robots.Othex(), tasks=[wbqp.tasks.Posture(kp=30.0), wbqp.entry(Nested(), weight=1.0)]
    )
    _, report = outer.tick(outer.measurement())
    assert report.traceback is not None and "its own" in report.traceback
    _, report = inner.tick(inner.measurement())
    assert report.traceback is None
