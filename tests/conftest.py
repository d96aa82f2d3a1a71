"""What several rooms' tests need."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# No test depends on the speed of the machine: the first example may have to compile what it calls.
# The examples of a test may share its fixtures, which they do not change.
settings.register_profile(
    "project",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("project")

# pytest-xdist tells its processes the size of the terminal, which the command line would then keep to.
for size in ("COLUMNS", "LINES"):
    os.environ.pop(size, None)

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings beside the project; tests that need it are skipped without it."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the real recordings (../shared/data) are not here")
    return folder


@pytest.fixture
def robot_toml() -> str:
    """The text of a whole two-truck robot's `vehicle.toml`."""
    head = """
name = "omnimate-7"
[truck.a]
wheelbase = 0.340
wheel_diameter_left = 0.150
wheel_diameter_right = 0.151
[truck.b]
wheelbase = 0.341
wheel_diameter_left = 0.150
wheel_diameter_right = 0.150
[linkage]
length = 1.000
[bus]
bitrate = 500000
sync_period = 0.015
"""
    units = ["counts_per_turn = 40000"] * 4 + ["counts_per_turn = 16384"] * 2 + ["counts_per_metre = 10000"]
    channels = ["a.left", "a.right", "b.left", "b.right", "joint_a", "joint_b", "link"]
    encoders = [
        f'[[encoder]]\nchannel = "{channel}"\nnode = {node}\ncob_id = {0x180 + node}\n'
        f"start_bit = 0\nbits = 32\nsigned = true\nsign = 1\n{unit}\n"
        for node, (channel, unit) in enumerate(zip(channels, units, strict=True), start=1)
    ]
    return head + "\n".join(encoders)
