"""Campaigns give the same results however they are run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import wbqp
from wbqp import campaign

PLAN = """
name = "push"
scenario = "SCENARIO"
design = { type = "DESIGN", base = 4 }
change.plant.tolerance = 1e-6

[[variant]]
name = "away"
cases = ["free"]

[[factor]]
name = "mass"
path = "change.plant.mismatch.mass_scale"
scale = { uniform = [0.95, 1.05] }

[[factor]]
name = "servo"
path = "change.plant.servo.time_constant"
scale = { uniform = [0.5, 1.5] }

[[measure]]
name = "farthest"
signals = { x = "/plant.base.position.x" }
reduce = "max_abs"
unit = "m"
at_most = 10.0
"""


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    scenario = wbqp.scenarios()["push_away"]
    text = PLAN.replace("SCENARIO", scenario.as_posix()).replace("DESIGN", "saltelli")
    file = tmp_path / "plan.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_plan_says_what_it_has(plan: Path) -> None:
    about = campaign.describe(plan)
    assert (about["name"], about["runs"], about["variants"]) == ("push", 16, ["away"])
    assert about["measures"] == [{"name": "farthest", "unit": "m", "tolerance": "≤ 10 m", "counts": True}]


def test_a_refused_run_neither_holds_nor_fails(plan: Path) -> None:
    text = plan.read_text(encoding="utf-8").replace('type = "saltelli", base = 4', 'type = "grid"')
    text = text.replace("scale = { uniform = [0.95, 1.05] }", "value = { values = [1.0, -1.0] }")
    plan.write_text(text.replace("scale = { uniform = [0.5, 1.5] }", "scale = { values = [1.0] }"), encoding="utf-8")
    with pytest.warns(UserWarning, match="factor `mass`: with the value -1"):
        found = campaign.outcomes(plan)
    assert found["status"] == ["completed", "refused"]
    np.testing.assert_array_equal(found["holds"], [1.0, np.nan])


def test_outcomes_are_arrays_and_other_values_change_them(plan: Path) -> None:
    found = campaign.outcomes(plan, limit=4)
    assert found["status"] == ["completed"] * 4 and found["holds"].all()
    assert found["factors"]["mass"].shape == (4,)
    assert np.isfinite(found["measures"]["farthest"]).all()
    same = campaign.outcomes(plan, limit=4, jobs=1)
    assert (same["measures"]["farthest"] == found["measures"]["farthest"]).all()
    other = campaign.outcomes(plan, change={"plant": {"mismatch": {"thrust_scale": 0.95}}}, limit=4)
    assert (other["measures"]["farthest"] != found["measures"]["farthest"]).any()


def test_what_is_wrong_with_a_plan_is_said(plan: Path) -> None:
    plan.write_text(plan.read_text(encoding="utf-8").replace("at_most", "at_mots"), encoding="utf-8")
    with pytest.raises(wbqp.ConfigError, match="plan.toml:.*at_mots"):
        campaign.describe(plan)
    with pytest.raises(OSError, match="nowhere.toml"):
        campaign.describe(plan.with_name("nowhere.toml"))


def test_tables_do_not_depend_on_shards_and_have_indices(plan: Path, tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    one = campaign.run(plan, out=tmp_path / "one")
    three = campaign.run(plan, out=tmp_path / "three", shards=3)
    assert one.equals(three)
    files = [tmp_path / name / "campaign.parquet" for name in ("one", "three")]
    assert files[0].read_bytes() == files[1].read_bytes()
    assert one["run"].to_pylist() == list(range(16))
    about = json.loads(one.schema.metadata[b"wbqp.campaign"])
    assert [factor["name"] for factor in about["factors"]] == ["mass", "servo"]
    pytest.importorskip("SALib")
    indices = campaign.first_order_indices(one, "farthest")
    assert set(indices) == {"mass", "servo"}
    file = campaign.write_indices(one, tmp_path / "indices.json")
    assert json.loads(file.read_text(encoding="utf-8")) == {"farthest": {k: list(v) for k, v in indices.items()}}
    # Without variance there are no indices, and JSON has no word for what is none.
    still = one.set_column(
        one.schema.get_field_index("measure.farthest"), "measure.farthest", pa.array([1.0] * one.num_rows)
    )
    assert json.loads(campaign.write_indices(still, file).read_text(encoding="utf-8")) == {}
    with pytest.raises(ValueError, match="whole groups"):
        campaign.first_order_indices(one.slice(0, 5), "farthest")


TUNED = """
name = "tuned"
scenario = "SCENARIO"
design = { type = "random", points = 2 }
change.plant.tolerance = 1e-6

[[variant]]
name = "away"
cases = ["free"]

[[factor]]
name = "mass"
path = "change.plant.mismatch.mass_scale"
scale = { uniform = [0.95, 1.05] }

[[measure]]
name = "error"
signals = { dx = "/task/base_position.rows.x.error" }
reduce = "rms"
unit = "m"
"""


def test_a_gain_that_was_spoilt_is_found_again(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    from wbqp.tuning import FAILED, Objective, Parameter, tune

    file = tmp_path / "plan.toml"
    scenario = wbqp.scenarios()["push_away"]
    file.write_text(TUNED.replace("SCENARIO", scenario.as_posix()), encoding="utf-8")
    path = "set.task.base_position.kp"
    objective = Objective("error", over="worst")
    tuned = tune(file, [Parameter(path, 0.1, 40.0, log=True, start=0.2)], objective, trials=8, seed=3)
    assert tuned.best[path] > 0.2 and len(tuned.history) == 8
    assert objective.value(tuned.after) == min(tuned.history) < tuned.history[0] < FAILED
    assert tuned.patch == f"{path} = {tuned.best[path]!r}\n"
    page = tuned.write(tmp_path / "out").read_text(encoding="utf-8")
    assert "before and after" in page and "<svg" in page
    # What misses its share is worse than anything that has it.
    half = {**tuned.after, "holds": np.array([1.0, 0.0])}
    assert objective.value(half) > FAILED
    # What is not simulated does not make the others' share look whole.
    assert objective.value({**tuned.after, "holds": np.array([1.0, np.nan])}) > FAILED
    with pytest.raises(KeyError, match="'error'"):
        Objective("eror").value(tuned.after)
    with pytest.raises(ValueError, match="empty"):
        Parameter(path, 2.0, 1.0)


def test_steps_against_the_gradient_go_on_from_the_best_trial(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    from wbqp.tuning import Descent, Objective, Parameter

    file = tmp_path / "plan.toml"
    scenario = wbqp.scenarios()["push_away"]
    file.write_text(TUNED.replace("SCENARIO", scenario.as_posix()), encoding="utf-8")
    kp, weight = "set.task.base_position.kp", "set.task.posture.weight"
    parameters = [Parameter(kp, 0.1, 40.0, log=True, start=2.0), Parameter(weight, 1e-3, 1.0, log=True, start=0.05)]
    objective = Objective("error", over="worst")
    descent = Descent("base_position", steps=3, rows=(0,))
    slopes = descent.slopes(file, {kp: 2.0, weight: 0.05, "change.plant.tolerance": 1e-6})
    assert slopes[kp] < -0.1 and abs(slopes[weight]) < abs(slopes[kp]) and slopes["change.plant.tolerance"] == 0.0
    tuned = wbqp.tune(file, parameters, objective, trials=1, descent=descent)
    assert tuned.history[0] > tuned.history[1] > tuned.history[2], "a step of the gradient is a step down"
    assert tuned.best[kp] > 3.0 and objective.value(tuned.after) == min(tuned.history)
    with pytest.raises(wbqp.ConfigError, match="no such task"):
        Descent("base").slopes(file, {kp: 2.0})


def test_any_parameter_names_where_it_is() -> None:
    from wbqp.tuning import Parameter

    with pytest.raises(ValueError, match="`set.` or `change.`"):
        Parameter("task.com.kp", 1.0, 2.0)
