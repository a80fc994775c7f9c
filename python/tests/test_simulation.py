"""Scenarios and logs."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import wbqp


def test_scenarios_come_with_the_package() -> None:
    shipped = wbqp.scenarios()
    assert {"push_with_disturbance", "push_and_slide", "push_away", "under_actuated", "switching"} <= set(shipped)
    assert "with_ft" in wbqp.cases("push_with_disturbance.toml")
    with pytest.raises(FileNotFoundError, match="with the package come"):
        wbqp.simulate("push_with_disturbances")


@pytest.fixture(scope="module")
def stand(tmp_path_factory: pytest.TempPathFactory) -> tuple[wbqp.Recording, wbqp.Recording]:
    """A simulation in memory, and the same from its file."""
    path = tmp_path_factory.mktemp("log") / "stand.mcap"
    heard: list[float] = []
    in_memory = wbqp.simulate("quadruped_short", seed=3, progress=heard.append)
    assert heard[0] == 0.0 and heard[-1] == 1.0 and heard == sorted(heard)
    wbqp.simulate("quadruped_short", seed=3, log=path)
    return in_memory, wbqp.read_log(path)


def test_a_log_in_a_file_is_what_was_simulated(stand: tuple[wbqp.Recording, wbqp.Recording]) -> None:
    in_memory, from_file = stand
    assert in_memory.summary["diverged"] is None and in_memory.summary["ticks"] > 100
    assert set(in_memory) == set(from_file)
    for name, topic in in_memory.items():
        assert list(topic) == list(from_file[name])
        if "timing" in name or "solver" in name:
            continue
        np.testing.assert_array_equal(topic.t, from_file[name].t)
    plant = in_memory["/plant"]
    np.testing.assert_array_equal(plant["base/position/z"], from_file["/plant"]["base/position/z"])


def test_numbers_below_a_name_are_side_by_side(stand: tuple[wbqp.Recording, wbqp.Recording]) -> None:
    plant = stand[0]["/plant"]
    position = plant["base/position"]
    assert position.shape == (len(plant.t), 3) and plant.columns("base/position") == ["x", "y", "z"]
    np.testing.assert_array_equal(position[:, 2], plant["base/position/z"])
    assert stand[0].unit("/plant", "base/position/z") == "m"
    with pytest.raises(KeyError, match="/plant has no 'base/height'"):
        plant["base/height"]
    with pytest.raises(KeyError):
        stand[0]["/nothing"]


def test_a_topic_has_what_any_of_its_messages_has() -> None:
    push = wbqp.simulate("push_with_disturbance", case="with_ft", change={"duration": 10.0})
    tip = push["/contact/tip"]
    # The contact is off at first: it has no set point then.
    reference = tip["reference/z"]
    assert reference.shape == tip.t.shape
    assert np.isnan(reference[0]) and np.isfinite(reference[-1]), reference
    level = push["/qp"]["level"]
    assert level.shape == push["/qp"].t.shape and set(level) <= {"optimal", "relaxed", "extrapolated", "safe"}


def test_what_can_hardly_be_meant_is_warned_of() -> None:
    short = {"duration": 0.01}
    with pytest.warns(UserWarning, match="quadruped_short stand: contact `fl_foot` is on from the start"):
        high = wbqp.simulate("quadruped_short", change={**short, "initial": {"position": [0.0, 0.0, 2.0]}})
    assert len(high.summary["warnings"]) == 4, high.summary
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert wbqp.simulate("quadruped_short", change=short).summary["warnings"] == []


def test_values_are_replaced_and_mistakes_are_config_errors() -> None:
    lighter = wbqp.simulate("quadruped_short", change={"duration": 0.1})
    assert len(lighter["/plant"].t) < 200
    with pytest.raises(wbqp.ConfigError, match="durations"):
        wbqp.simulate("quadruped_short", change={"durations": 0.1})
    with pytest.raises(wbqp.ConfigError, match="no case"):
        wbqp.simulate("quadruped_short", case="upside_down")


def test_ctrl_c_ends_a_simulation() -> None:
    # What runs in the background of a shell ignores it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def press() -> None:
        time.sleep(0.7)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press, daemon=True).start()
    start = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            for _ in range(100):
                wbqp.simulate("push_and_slide", progress=False)
    finally:
        signal.signal(signal.SIGINT, before)
    # A hundred runs take longer.
    assert time.monotonic() - start < 60.0


def test_what_progress_raises_ends_a_simulation() -> None:
    def enough(fraction: float) -> None:
        if fraction > 0.1:
            raise ValueError("enough")

    with pytest.raises(ValueError, match="enough"):
        wbqp.simulate("quadruped_short", progress=enough)


def test_a_file_that_is_no_log_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bad.mcap"
    path.write_bytes(b"nothing")
    with pytest.raises(ValueError, match="bad.mcap: not a complete MCAP file"):
        wbqp.read_log(path)
    with pytest.raises(OSError):
        wbqp.read_log(tmp_path / "absent.mcap")


def test_the_rows_of_an_experiment_are_met() -> None:
    runs = {case: wbqp.simulate("push_away", case=case) for case in wbqp.experiment_cases()["push_away"]}
    rows = wbqp.rows("push_away", runs)
    assert len(rows) > 3
    assert [row for row in rows if row["promised"] and not row["pass"]] == []
    with pytest.raises(KeyError, match="known: "):
        wbqp.rows("push_aside", runs)
