"""Commands from Python are those from Rust, to the last bit, in the scenarios that ship."""

from __future__ import annotations

import json

import numpy as np
import pytest

import wbqp
from wbqp import _wbqp

CASES = [(name, case) for name in wbqp.scenarios() for case in wbqp.cases(name)]


def ask(controller: wbqp.Controller, requests: str) -> None:
    for request in json.loads(requests):
        for key in ("tare", "deactivate_contact", "activate_contact", "deactivate", "activate"):
            for name in request.get(key, []):
                getattr(controller, key)(name)
        for name, weight in request.get("weight", {}).items():
            controller.reweight(name, weight)
        for name, reference in request.get("follow", {}).items():
            controller.follow(name, reference)


@pytest.mark.parametrize(("name", "case"), CASES)
def test_commands_are_the_bits_of_rust(name: str, case: str) -> None:
    run = _wbqp._record(wbqp.scenarios()[name], case, 1)
    controller = wbqp.Controller(run["file"], set=json.loads(run["set"]))
    m = controller.measurement()
    q, v, n = m.q.size, m.v.size, m.wrench.shape[0]
    effort, velocity = [], []
    for inputs, requests in zip(run["inputs"], run["requests"]):
        ask(controller, requests)
        m.time = inputs[0]
        m.position, m.quaternion, m.q = inputs[1:4], inputs[4:8], inputs[8 : 8 + q]
        m.v, m.wrench = inputs[8 + q : 8 + q + v], inputs[8 + q + v :].reshape(n, 6)
        command, _ = controller.tick(m)
        effort.append(np.array(command.effort))
        velocity.append(np.array(command.joint_velocity))
    # As bits: a zero has a sign, and what is no number is not equal to itself.
    for got, expected in ((effort, run["effort"]), (velocity, run["joint_velocity"])):
        assert np.array_equal(np.array(got).view(np.uint64), expected.view(np.uint64))
    assert len(effort) > 100
