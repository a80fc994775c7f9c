"""Model and dynamics: identities between what the methods return."""

from __future__ import annotations

import numpy as np
import pytest

import wbqp


@pytest.fixture(params=["othex", "quadruped", "humanoid"])
def dynamics(request: pytest.FixtureRequest) -> tuple[wbqp.Robot, wbqp.Dynamics]:
    robot = wbqp.Robot({"type": request.param})
    dynamics = wbqp.Dynamics(robot)
    random = np.random.default_rng(5)
    q = [random.uniform(max(a, -1.0), min(b, 1.0)) for a, b in robot.joint_range]
    v = random.normal(size=robot.nv)
    dynamics.update(q, v, position=[0.1, 0.2, 1.0], quaternion=random.normal(size=4))
    return robot, dynamics


def test_inverse_dynamics_is_mass_matrix_and_bias(dynamics: tuple[wbqp.Robot, wbqp.Dynamics]) -> None:
    robot, d = dynamics
    vdot = np.random.default_rng(6).normal(size=robot.nv)
    M, h = d.mass_matrix(), d.bias()
    np.testing.assert_allclose(M, M.T, atol=1e-12)
    np.testing.assert_allclose(d.inverse(vdot), M @ vdot + h, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(d.solve_mass(M @ vdot), vdot, atol=1e-7)


def test_forward_dynamics_undoes_inverse_dynamics_with_forces(dynamics: tuple[wbqp.Robot, wbqp.Dynamics]) -> None:
    robot, d = dynamics
    random = np.random.default_rng(7)
    effort = random.normal(size=robot.nu)
    forces = {robot.frames[-1]: random.normal(size=6)}
    vdot = d.forward(effort, forces)
    J = d.frame(robot.frames[-1]).J
    np.testing.assert_allclose(d.inverse(vdot, forces), d.actuation() @ effort, rtol=1e-8, atol=1e-8)
    wrench = forces[robot.frames[-1]]
    np.testing.assert_allclose(d.inverse(vdot, forces), d.inverse(vdot) - J.T @ wrench, rtol=1e-8, atol=1e-8)


def test_velocities_are_jacobians_times_v(dynamics: tuple[wbqp.Robot, wbqp.Dynamics]) -> None:
    robot, d = dynamics
    v = np.random.default_rng(8).normal(size=robot.nv)
    d.update(v=v)
    np.testing.assert_allclose(d.center_of_mass_velocity(), d.center_of_mass_jacobian() @ v, atol=1e-12)
    np.testing.assert_allclose(d.momentum()[:3], robot.mass * d.center_of_mass_velocity(), rtol=1e-9, atol=1e-9)
    for name in robot.frames:
        frame = d.frame(name)
        np.testing.assert_allclose(frame.velocity, frame.J @ v, atol=1e-10)
        np.testing.assert_allclose(frame.rotation @ frame.rotation.T, np.eye(3), atol=1e-12)
    assert d.energy()[0] == pytest.approx(0.5 * v @ d.mass_matrix() @ v)


def test_statics_hold_the_othex() -> None:
    robot = wbqp.Robot({"type": "othex"})
    d = wbqp.Dynamics(robot)
    effort, residual = d.statics()
    np.testing.assert_allclose(residual, 0.0, atol=1e-6)
    np.testing.assert_allclose(d.forward(effort), 0.0, atol=1e-5)
    limits = np.array(robot.effort_limits)
    assert (effort >= limits[:, 0]).all() and (effort <= limits[:, 1]).all()


def test_wrong_shapes_and_names_are_refused() -> None:
    d = wbqp.Dynamics(wbqp.Robot({"type": "othex"}))
    with pytest.raises(ValueError, match="q: has 2 numbers, must have 3"):
        d.update(q=[0.0, 0.0])
    with pytest.raises(ValueError, match="not finite"):
        d.update(q=[0.0, np.nan, 0.0])
    with pytest.raises(TypeError, match="v: must be real numbers"):
        d.update(v=np.zeros(9, dtype=complex))
    with pytest.raises(ValueError, match="quaternion: is zero"):
        d.update(quaternion=[0, 0, 0, 0])
    with pytest.raises(KeyError, match="no frame `tol`; did you mean"):
        d.frame("tol")
    # What was refused changed nothing.
    np.testing.assert_array_equal(d.bias()[2], pytest.approx(2.919 * 9.81, rel=1e-3))


def test_python_that_runs_within_a_call_may_use_the_model() -> None:
    robot = wbqp.Robot(wbqp.robots.Quadruped())
    d = wbqp.Dynamics(robot)

    class Wrench:
        def __array__(self, *_: object, **__: object) -> np.ndarray:
            return d.momentum()

    expected = d.inverse(np.zeros(robot.nv), forces={"fl_foot": d.momentum()})
    np.testing.assert_array_equal(d.inverse(np.zeros(robot.nv), forces={"fl_foot": Wrench()}), expected)
    d.forward(np.zeros(robot.nu), forces={"fl_foot": Wrench()})
    d.statics(forces={"fl_foot": Wrench()})
