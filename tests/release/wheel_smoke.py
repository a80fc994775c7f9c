"""A wheel in an environment with nothing else: its version, a tick, a run of a scenario, its licences.

    python wheel_smoke.py VERSION
"""

import importlib.metadata
import sys

import wbqp

version = sys.argv[1]
assert wbqp.__version__ == importlib.metadata.version("wbqp") == version, wbqp.__version__
names = [file.name for file in importlib.metadata.files("wbqp")]
if "third_party.txt" not in names:
    print("MISSING before it is published: third_party.txt, the notices of the crates in it")
notices = [file.name for file in importlib.metadata.files("wbqp") if "LICENSE" in file.name]
assert sorted(notices) == ["LICENSE-APACHE", "LICENSE-MIT"], f"licences in the wheel: {notices}"

controller = wbqp.Controller(
    rate=500.0,
    robot=wbqp.robots.Quadruped(),
    contacts=[wbqp.Contact(frames=["fl_foot", "fr_foot", "hl_foot", "hr_foot"], motion="hard", friction=0.6)],
    tasks=[wbqp.tasks.Com(kp=100.0), wbqp.tasks.BaseOrientation(kp=100.0), wbqp.tasks.Posture(kp=30.0)],
)
command, report = controller.tick(controller.measurement())
assert str(report.level) == "optimal", report.level

run = wbqp.simulate("push_with_disturbance", seed=1, case="with_ft")
seconds = run["/contact/tip"].t[-1]
assert seconds > 10.0, seconds
print(f"wbqp {wbqp.__version__}: a quadruped's tick is optimal, {seconds:.0f} s of an experiment were simulated")
