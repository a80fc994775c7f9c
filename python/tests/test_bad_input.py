"""Bad input: a clear exception or a reported fault, never a crash or a hang."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest

import wbqp


def hover() -> wbqp.Controller:
    return wbqp.Controller(
        rate=250.0,
        robot="othex",
        contacts=[
            wbqp.Contact(
                name="tip",
                frame="tool",
                kind="point",
                active=False,
                surface={"normal": [-1.0, 0.0, 0.0], "x_axis": [0.0, 1.0, 0.0]},
            )
        ],
        tasks=[wbqp.tasks.BasePosition(kp=10.0), wbqp.tasks.BaseOrientation(kp=20.0), wbqp.tasks.Posture(kp=25.0)],
        constraints=[wbqp.constraints.ActuatorLimits()],
    )


def test_wrong_shapes_and_types_are_refused_where_they_are_written() -> None:
    m = hover().measurement()
    before = m.q.copy(), m.wrench.copy()
    for wrong in ([1.0, 2.0], np.zeros((2, 3)), np.zeros(4)):
        with pytest.raises(ValueError):
            m.q = wrong
    # What NumPy would repeat.
    with pytest.raises(ValueError, match=r"measurement\.q: has shape \(1,\), must have \(3,\)"):
        m.q = [0.6]
    with pytest.raises(ValueError, match="measurement.position"):
        m.position = [1.0]
    m.v = 0.0
    m.wrench = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    m.wrench = np.zeros(6)
    with pytest.raises(ValueError):
        m.q[:] = ["a", "b", "c"]
    with pytest.raises(TypeError):
        m.time = "now"  # type: ignore[assignment]
    with pytest.raises((TypeError, ValueError)):
        m.wrench["tip"] = {"force": 3}
    with pytest.raises(KeyError, match="'top' is none of tip"):
        m.wrench["top"] = 0.0
    with pytest.raises(AttributeError):
        m.positions = [0.0, 0.0, 0.0]  # type: ignore[attr-defined]
    assert np.array_equal(m.q, before[0]) and np.array_equal(m.wrench, before[1])


@pytest.mark.parametrize("what", [None, 5, "home", {"q": [0.0]}, np.zeros(9)])
def test_a_tick_takes_measurements_only(what: Any) -> None:
    controller = hover()
    with pytest.raises(TypeError, match="Measurement"):
        controller.tick(what)


def test_numbers_that_are_none_are_reported() -> None:
    controller = hover()
    m = controller.measurement()
    controller.tick(m)
    for field in ("position", "quaternion", "q", "v", "wrench"):
        bad = m.copy()
        bad.time = m.time = m.time + 0.004
        getattr(bad, field).reshape(-1)[0] = np.nan
        command, report = controller.tick(bad)
        assert report.level == "extrapolated", field
        assert "not finite" in (report.fault or "") and np.isfinite(command.effort).all()
        m.time += 0.004
        assert controller.tick(m)[1].level == "optimal"
    m.time = float("inf")
    assert "time" in (controller.tick(m)[1].fault or "")


def test_a_quaternion_that_is_none_is_reported() -> None:
    controller = hover()
    m = controller.measurement()
    m.quaternion = [0.0, 0.0, 0.0, 0.0]
    _, report = controller.tick(m)
    assert "unit quaternion" in (report.fault or "")


def test_measurements_of_other_controllers_are_refused() -> None:
    feet = {"frames": ["fl_foot", "fr_foot", "hl_foot", "hr_foot"], "motion": "hard"}
    tasks = [wbqp.tasks.Posture(kp=1.0)]
    m = wbqp.Controller(rate=500.0, robot="quadruped", tasks=tasks, constraints=[], contacts=[feet]).measurement()
    controller = hover()
    with pytest.raises(ValueError, match=r"12 joints.*make it with controller.measurement\(\)"):
        controller.tick(m)
    with pytest.raises(ValueError, match="make it with"):
        controller.reset(m)


def test_a_freed_controller_leaves_its_views() -> None:
    def make() -> tuple[Any, ...]:
        controller = hover()
        m = controller.measurement()
        command, report = controller.tick(m)
        return m.q, command.effort, report.vdot, report.tasks["posture"].error, report.contacts["tip"].solution

    kept = [make() for _ in range(50)]
    assert all(np.array_equal(a, b) for one in kept for a, b in zip(one, kept[0]))


def test_requests_name_what_is_wrong() -> None:
    controller = hover()
    with pytest.raises(KeyError, match="did you mean `posture`"):
        controller.activate("postur")
    with pytest.raises(KeyError, match="no contact `tipp`"):
        controller.activate_contact("tipp")
    with pytest.raises(ValueError, match="weight"):
        controller.reweight("posture", -1.0)
    with pytest.raises(ValueError, match="weight"):
        controller.reweight("posture", [1.0, 2.0])
    with pytest.raises((TypeError, ValueError)):
        controller.reweight("posture", "heavy")
    with pytest.raises(ValueError, match="`posture`: .*kq"):
        controller.set("posture", kq=1.0)
    with pytest.raises(ValueError, match="`posture`: .*kp"):
        controller.set("posture", kp=-1.0)
    with pytest.raises(ValueError, match="replaced by `follow`"):
        controller.set("posture", reference={"type": "hold"})
    with pytest.raises(TypeError, match="a configuration cannot hold a set"):
        controller.set("posture", kp={1.0})
    with pytest.raises(wbqp.ConfigError, match="unknown reference type `holt`"):
        controller.follow("posture", {"type": "holt"})
    with pytest.raises(wbqp.ConfigError, match="reference: "):
        controller.follow("posture", {"type": "min_jerk", "to": "there", "duration": 1.0})
    with pytest.raises(ValueError, match="to"):
        controller.follow("posture", wbqp.references.MinJerk(to=[0.0], duration=1.0))
    with pytest.raises(ValueError, match="rotation matrix"):
        controller.move_surface("tip", [0.0, 0.0, 0.0], np.zeros((3, 3)))
    with pytest.raises(ValueError, match="not finite"):
        controller.move_surface("tip", [np.nan, 0.0, 0.0])
    assert controller.tick(controller.measurement())[1].level == "optimal"


def test_keys_are_changed_by_name_and_hold_from_the_next_tick_on() -> None:
    controller = hover()
    m = controller.measurement()
    controller.tick(m)
    m.time, m.q[1] = 0.004, m.q[1] + 0.01
    soft = controller.tick(m)[1].vdot["arm_pitch1"]
    controller.set("posture", kp=50.0)
    m.time = 0.008
    assert controller.tick(m)[1].vdot["arm_pitch1"] == pytest.approx(2.0 * soft, rel=0.05)


@pytest.mark.parametrize(
    "config",
    [
        {},
        {"controller": {"rate": 250.0}},
        {"controller": {"rate": float("nan")}, "robot": {"type": "othex"}},
        {"controller": {"rate": 250.0}, "robot": {"type": "othex"}, "tasks": []},
        {"controller": 5, "robot": []},
        {"controller": {"rate": 250.0}, "robot": {"file": "/nowhere/robot.urdf"}},
    ],
)
def test_configurations_that_cannot_be_are_config_errors(config: dict[str, Any]) -> None:
    with pytest.raises(wbqp.ConfigError) as refused:
        wbqp.Controller(config)
    assert refused.value.errors and str(refused.value)


def test_what_no_configuration_can_hold_is_named() -> None:
    with pytest.raises(TypeError, match=r"task\[0\].kp: a configuration cannot hold a object"):
        wbqp.Controller({"task": [{"kp": object()}]})
    with pytest.raises(ValueError, match="controller.rate: the integer does not fit"):
        wbqp.Controller({"controller": {"rate": 2**70}})
    with pytest.raises(TypeError, match="the key 5 is not a text"):
        wbqp.Controller({5: 3})  # type: ignore[dict-item]
    loop: dict[str, Any] = {}
    loop["loop"] = loop
    with pytest.raises(ValueError, match="nested too deeply"):
        wbqp.Controller(loop)
    with pytest.raises(TypeError, match="not both"):
        wbqp.Controller("file.toml", rate=3.0)
    with pytest.raises(TypeError, match="give a file"):
        wbqp.Controller()
    with pytest.raises(TypeError, match="a path or a dict"):
        wbqp.Controller(5)  # type: ignore[arg-type]
    with pytest.raises(wbqp.ConfigError, match="absent.toml: cannot be read"):
        wbqp.Controller("absent.toml")


def test_two_threads_on_one_controller() -> None:
    controller = hover()
    m = controller.measurement()
    outcomes: list[str] = []
    lock = threading.Lock()
    times = iter(np.arange(1, 4001) * 0.004)

    def tick() -> None:
        own = m.copy()
        for _ in range(1000):
            try:
                with lock:
                    own.time = float(next(times))
                controller.tick(own)
                outcomes.append("done")
            except RuntimeError as error:
                outcomes.append(str(error))

    threads = [threading.Thread(target=tick) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60.0)
        assert not thread.is_alive()
    assert len(outcomes) == 4000
    assert {outcome for outcome in outcomes if outcome != "done"} <= {
        "the controller is in use by another thread, or by the tick that this plug-in is part of"
    }
    assert np.isfinite(controller.command.effort).all()
