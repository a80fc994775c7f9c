"""Many controllers at once."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

import wbqp

CONFIG = wbqp.scenarios()["push_with_disturbance"].with_name("push_with_disturbance.controller.toml")


AT_THE_WALL = [-0.9, 0.0, 1.26]


def scatter(batch: wbqp.Batch, seed: int) -> None:
    random = np.random.default_rng(seed)
    batch.position[:] = AT_THE_WALL + 0.001 * random.normal(size=batch.position.shape)
    batch.q += 0.001 * random.normal(size=batch.q.shape)
    batch.v += 0.001 * random.normal(size=batch.v.shape)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_a_batch_computes_the_bits_of_single_controllers(threads: int) -> None:
    n = 20
    batch = wbqp.Batch(CONFIG, n, threads=threads)
    assert len(batch) == n and batch.threads == threads
    singles = [wbqp.Controller(CONFIG) for _ in range(n)]
    m = singles[0].measurement()
    batch.position[:] = AT_THE_WALL
    batch.follow("base_position", wbqp.references.MinJerk(to=[0.1, 0.0, 1.3], duration=0.5), of=[3, -1])
    for i in (3, n - 1):
        singles[i].follow("base_position", wbqp.references.MinJerk(to=[0.1, 0.0, 1.3], duration=0.5))
    batch.set("posture", of=5, kp=4.0)
    singles[5].set("posture", kp=4.0)
    batch.reweight("base_position", 33.0, of=7)
    singles[7].reweight("base_position", 33.0)
    for k in range(30):
        batch.time[:] = 0.004 * k
        scatter(batch, k)
        batch.tick()
        for i, single in enumerate(singles):
            m.time = batch.time[i]
            m.position, m.quaternion, m.q, m.v = batch.position[i], batch.quaternion[i], batch.q[i], batch.v[i]
            command, report = single.tick(m)
            assert batch.effort[i].tolist() == command.effort.tolist(), (k, i)
            assert batch.joint_velocity[i].tolist() == command.joint_velocity.tolist()
            assert batch.vdot[i].tolist() == report.vdot.tolist()
            assert ("optimal", "relaxed", "extrapolated", "safe")[int(batch.level[i])] == report.level
            assert batch.solution[i, 0].tolist() == report.contacts[batch.contacts[0]].solution.tolist()
    errors = batch.error("posture")
    assert errors.shape == (n, 3)
    assert errors[2].tolist() == singles[2].report.tasks["posture"].error.tolist()
    assert not np.array_equal(batch.effort[5], batch.effort[6])


def test_one_bad_measurement_is_one_controllers_fault() -> None:
    batch = wbqp.Batch(CONFIG, 4)
    batch.position[:] = AT_THE_WALL
    batch.tick()
    batch.time += 0.004
    batch.q[2, 0] = np.nan
    batch.tick()
    assert batch.level.tolist() == [0, 0, 2, 0]
    assert "not finite" in (batch.explain(2) or "") and batch.explain(0) is None
    assert np.isfinite(batch.effort).all()


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="n is 0"):
        wbqp.Batch(CONFIG, 0)
    with pytest.raises(ValueError, match="threads is 0"):
        wbqp.Batch(CONFIG, 2, threads=0)
    with pytest.raises(wbqp.ConfigError, match="robot"):
        wbqp.Batch({"controller": {"rate": 100.0}}, 2)
    batch = wbqp.Batch(CONFIG, 2)
    with pytest.raises(IndexError, match="there is no controller 2: there are 2"):
        batch.activate("posture", of=2)
    with pytest.raises(KeyError, match="there is no entry `leg`"):
        batch.activate("leg")
    with pytest.raises(KeyError, match="no task `leg`"):
        batch.error("leg")
    with pytest.raises(ValueError, match="broadcast"):
        batch.q = np.zeros((3, 3))
    with pytest.raises(ValueError, match="read-only"):
        batch.effort[0, 0] = 1.0


def test_a_view_outlives_its_batch() -> None:
    batch = wbqp.Batch(CONFIG, 8)
    batch.tick()
    effort = batch.effort
    expected = effort.copy()
    del batch
    noise = np.random.rand(10000)
    assert np.array_equal(effort, expected) and noise.size


def test_two_threads_on_one_batch() -> None:
    batch = wbqp.Batch(CONFIG, 256, threads=1)
    outcomes: list[str] = []
    start = threading.Barrier(2)

    def tick() -> None:
        start.wait()
        for _ in range(50):
            try:
                batch.tick()
                outcomes.append("done")
            except RuntimeError as error:
                assert "in use by another thread" in str(error)
                outcomes.append("refused")

    threads = [threading.Thread(target=tick) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert outcomes.count("done") >= 50 and outcomes.count("refused") >= 1


def test_a_mask_is_no_list_of_numbers() -> None:
    batch = wbqp.Batch(CONFIG, 3)
    with pytest.raises(TypeError, match="flatnonzero"):
        batch.reweight("posture", 2.0, of=[True, False, False])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is nothing to fork")
def test_a_batch_of_another_process_says_so() -> None:
    batch = wbqp.Batch(CONFIG, 4, threads=2)
    child = os.fork()
    if child == 0:
        try:
            batch.tick()
        except RuntimeError as error:
            os._exit(0 if "after the fork" in str(error) else 2)
        os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
