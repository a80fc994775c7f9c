"""A controller from Python: configurations, measurement, tick, command and report."""

from __future__ import annotations

import gc
import math
from pathlib import Path

import numpy as np
import pytest

import wbqp

HOVER = {
    "controller": {"rate": 250.0},
    "robot": {"type": "othex"},
    "task": [
        {"type": "base_position", "kp": 10.0, "weight": 10.0},
        {"type": "base_orientation", "kp": 20.0, "weight": 10.0},
        {"type": "posture", "kp": 25.0, "weight": 1.0},
    ],
    "constraint": [{"type": "actuator_limits"}],
}


@pytest.fixture
def hover() -> wbqp.Controller:
    return wbqp.Controller(HOVER)


def test_a_tick_at_home_carries_the_robot(hover: wbqp.Controller) -> None:
    m = hover.measurement()
    command, report = hover.tick(m)
    assert report.level == "optimal" and report.fault is None
    weight = hover.robot.mass * 9.81
    assert sum(command.effort[name] for name in hover.robot.rotors) * math.cos(math.radians(35)) > 0.5 * weight
    assert np.abs(report.vdot).max() < 1e-3
    assert hover.explain() is None


def test_an_observer_finds_what_the_model_does_not_have(hover: wbqp.Controller) -> None:
    observer = {"velocity": 3.0, "wrench": 0.5, "max_force": 5.0, "max_moment": 1.0}
    controller = wbqp.Controller(HOVER | {"controller": {"rate": 250.0, "observer": observer}})
    m = controller.measurement()
    for tick in range(2000):
        m.time = 0.004 * tick
        # At rest, which is what its thrusts are for.
        _, report = controller.tick(m)
    assert report.disturbance.shape == (6,)
    assert np.abs(report.disturbance).max() < 0.05
    assert np.all(hover.tick(hover.measurement())[1].disturbance == 0.0)
    # Something holds it back: it stays at rest with thrusts that lift by 1.2 N more than the weight.
    controller.follow("base_position", wbqp.references.Hold(value=[0.0, 0.0, 0.04]))
    for tick in range(2000, 6000):
        m.time = 0.004 * tick
        _, report = controller.tick(m)
    assert report.disturbance[2] < -0.9


def test_a_report_says_by_name_what_is_wrong_and_so_does_its_copy(hover: wbqp.Controller) -> None:
    m = hover.measurement()
    hover.tick(m)
    m.time += 0.004
    m.q["arm_pitch2"] += 50.0
    _, report = hover.tick(m)
    kept = report.copy()
    assert "arm_pitch2" in (report.fault or "") and "arm_pitch2" in repr(report)
    said = hover.explain()
    assert said is not None and said == report.explain()
    # Later ticks do not change what is kept.
    m.time += 0.004
    m.q["arm_pitch2"] -= 50.0
    hover.tick(m)
    assert kept.explain() == said and report.explain() != said


def test_names_and_arrays_see_the_same_numbers(hover: wbqp.Controller) -> None:
    m = hover.measurement()
    m.q["arm_pitch1"] = 0.3
    assert m.q[1] == 0.3
    m.q[:] = [0.0, 0.1, 0.2]
    assert m.q["arm_pitch2"] == 0.2
    command, report = hover.tick(m)
    for i, name in enumerate(hover.robot.actuators):
        assert command.effort[name] == command.effort[i]
    assert report.tasks["posture"].error["arm_pitch1"] == report.tasks["posture"].error[1]
    with pytest.raises(KeyError, match="is none of"):
        command.effort["rotor_7"]


def test_arrays_are_views_that_the_next_tick_writes(hover: wbqp.Controller) -> None:
    m = hover.measurement()
    command, report = hover.tick(m)
    effort, vdot = command.effort, report.vdot
    before, kept = np.array(effort), (command.copy(), report.copy())
    m.time += 0.004
    m.position[2] -= 0.02
    again, report_again = hover.tick(m)
    assert again is command and report_again is report
    assert effort is command.effort
    assert not np.array_equal(effort, before)
    assert np.array_equal(kept[0].effort, before)
    assert kept[1].time == 0.0 and report.time == 0.004
    assert not np.array_equal(kept[1].vdot, vdot)


def test_commands_cannot_be_written(hover: wbqp.Controller) -> None:
    command, report = hover.tick(hover.measurement())
    for array in (command.effort, report.vdot, report.tasks["posture"].error):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
        with pytest.raises(ValueError):
            array.setflags(write=True)
        with pytest.raises(ValueError):
            array.base.resize((1000,), refcheck=False)


def test_a_view_outlives_its_controller() -> None:
    controller = wbqp.Controller(HOVER)
    m = controller.measurement()
    command, report = controller.tick(m)
    effort, error, q = command.effort, report.tasks["posture"].error, m.q
    expected = effort.tolist(), error.tolist()
    q[:] = 0.25
    del controller, m, command, report
    gc.collect()
    noise = [np.random.rand(64) for _ in range(100)]
    assert (effort.tolist(), error.tolist()) == expected
    assert q.tolist() == [0.25] * 3 and len(noise) == 100


def test_text_and_dict_and_keywords_and_file_are_the_same(hover: wbqp.Controller, tmp_path: Path) -> None:
    text = """
        [controller]
        rate = 250.0
        [robot]
        type = "othex"
        [[task]]
        type = "base_position"
        kp = 10.0
        weight = 10.0
        [[task]]
        type = "base_orientation"
        kp = 20.0
        weight = 10.0
        [[task]]
        type = "posture"
        kp = 25.0
        weight = 1.0
        [[constraint]]
        type = "actuator_limits"
    """
    path = tmp_path / "hover.toml"
    path.write_text(text)
    keywords = wbqp.Controller(rate=250.0, robot="othex", tasks=HOVER["task"], constraints=HOVER["constraint"])
    ways = [wbqp.Controller.from_text(text), wbqp.Controller(path), wbqp.Controller(str(path)), keywords]
    m = hover.measurement()
    m.position[:] = [0.01, -0.02, 0.03]
    expected = hover.tick(m)[0].effort.tolist()
    for controller in ways:
        assert controller.tick(m)[0].effort.tolist() == expected


def test_all_mistakes_are_reported_with_their_places() -> None:
    text = '[controller]\nrate = 250.0\n[robot]\ntype = "othx"\n[[task]]\ntype = "posture"\nkp = "stiff"\nkq = 1\n'
    with pytest.raises(wbqp.ConfigError) as refused:
        wbqp.Controller.from_text(text, name="bad.toml")
    errors = refused.value.errors
    assert len(errors) == 3
    assert (errors[0].file, errors[0].line) == ("bad.toml", 4)
    assert "othex" in errors[0].message
    assert str(refused.value) == "\n".join(str(error) for error in errors)
    assert str(errors[0]).startswith("bad.toml:4:")


def test_a_robot_can_be_given_as_an_object(hover: wbqp.Controller) -> None:
    robot = wbqp.Robot({"type": "othex"})
    assert robot.base == "floating" and robot.nu == 9
    controller = wbqp.Controller({**HOVER, "robot": robot})
    m = hover.measurement()
    assert controller.tick(m)[0].effort.tolist() == hover.tick(m)[0].effort.tolist()


def test_values_of_a_file_are_replaced_by_set() -> None:
    stiff = wbqp.Controller(HOVER, set={"task": {"base_position": {"kp": 40.0}}})
    soft = wbqp.Controller(HOVER)
    m = soft.measurement()
    for controller in (stiff, soft):
        controller.tick(m)
    m.time, m.position[2] = 0.004, -0.05
    assert stiff.tick(m)[1].vdot["base z"] > soft.tick(m)[1].vdot["base z"]


def test_derivatives_of_a_tick_have_names_and_units(hover: wbqp.Controller) -> None:
    def ticked(z: float, kp: float = 10.0) -> wbqp.Controller:
        controller = wbqp.Controller(HOVER)
        m = controller.measurement()
        controller.tick(m)
        controller.set("base_position", kp=kp)
        m.time = 0.004
        m.position[2] += z
        controller.tick(m)
        return controller

    s = ticked(0.02).sensitivity()
    assert s.derivatives.shape == (len(s.outputs), len(s.parameters))
    assert len(s.kinds) == len(s.units) == len(s.values) == len(s.parameters)
    assert s.vdot.shape[0] + s.effort.shape[0] + s.force.shape[0] == len(s.outputs)
    for name, unit, h, at in [
        ("base_position.kp", "1/s²", 1e-3, lambda h: ticked(0.02, 10.0 + h)),
        ("state.position z", "m", 1e-5, lambda h: ticked(0.02 + h)),
    ]:
        numbers = [np.concatenate([c.report.vdot, c.command.effort]) for c in (at(-h), at(h))]
        slope = (numbers[1] - numbers[0]) / (2 * h)
        assert np.abs(s[name] - slope).max() < 1e-6 * np.abs(slope).max() + 1e-9
        assert s.units[s.parameters.index(name)] == unit
        assert f" {name} " in s.table()
    assert [entry for entry, _ in s.ranking[:1]][0] in hover.tasks
    assert s.ranking[0][0] in repr(s)
    assert s.mismatch < 1e-8 and s.notes is not None
    with pytest.raises(KeyError, match="did you mean `base_position.k"):
        s["base_position.kq"]


def test_there_are_no_derivatives_before_the_first_tick_and_without_an_optimum(hover: wbqp.Controller) -> None:
    with pytest.raises(RuntimeError, match="no tick"):
        hover.sensitivity()
    m = hover.measurement()
    hover.tick(m)
    hover.sensitivity()
    m.time = 0.004
    m.position[0] = math.nan
    hover.tick(m)
    with pytest.raises(RuntimeError, match="`extrapolated`"):
        hover.sensitivity()
