"""The independent engine: shares no code with what it proves, and drives as its numbers say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.linkage import linkage_of
from omnimate.vehicle.odometry import dead_reckon
from studies.mismatch.engines.engine import Floor
from studies.mismatch.engines.faults import ConcealedFault, TruckStep, WheelStep, moved, travelled
from studies.mismatch.engines.scene import Case, make, scene
from studies.mismatch.engines.vocabulary import set_bump_times
from tests.test_architecture import modules_named

ROOT = Path(__file__).resolve().parents[4] / "studies" / "mismatch" / "engines"


def test_the_engine_imports_nothing_of_the_project_but_itself():
    named = [name for path in ROOT.rglob("*.py") for name in modules_named(path)]
    of_the_project = [name for name in named if name.split(".")[0] in {"omnimate", "studies"}]
    assert of_the_project
    assert [name for name in of_the_project if not name.startswith("studies.mismatch.engines.")] == []


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_true_motion_of_the_wheels_integrates_to_the_poses(seed):
    setting = scene(Case("single", (("wheel_diameter", "a.left"),), "eights", "none"), seed)
    smooth = replace(setting, floor=Floor(0.0, 0.0))
    driven = smooth.driven(setting.faults)
    robot, ratio = setting.robot, setting.faults[0]["ratio"]
    turned = [np.diff(robot.devices[wheel].reading(driven.counts[:, wheel])) for wheel in (0, 1)]
    left, right = turned[0] * robot.radius[0] * ratio, turned[1] * robot.radius[1]
    heading = np.cumsum(np.concatenate([[0.0], (right - left) / robot.wheelbase[0]]))
    step = 0.5 * (left + right) * np.exp(0.5j * (heading[:-1] + heading[1:]))
    ends = np.cumsum(step)
    off = np.hypot(ends.real - driven.poses[1:, 0, 0], ends.imag - driven.poses[1:, 0, 1])
    assert np.abs(heading - driven.poses[:, 0, 2]).max() < 5e-3
    assert off.max() < 5e-3


@pytest.fixture(scope="module")
def healthy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("null")
    make(folder, Case("null", (), "eights", "mocap", note="smooth floor"), 7)
    return load_recording(folder / "1")


def test_a_healthy_robots_odometry_leads_where_it_was_seen(healthy):
    own = healthy.poses.of("a")
    start = own.pose[0]
    driven = dead_reckon(healthy, "a", start)
    off = [np.interp(own.time, healthy.time, driven[:, axis]) - own.pose[:, axis] for axis in range(2)]
    assert np.hypot(*off).max() < 0.05


def test_a_healthy_robots_linkage_reads_what_lies_between_its_trucks(healthy):
    a, b = healthy.poses.of("a"), healthy.poses.of("b")
    joint_a, joint_b, length = linkage_of(a.pose, b.pose)
    shown = [np.interp(a.time, healthy.time, healthy.joint_angle(name)) for name in ("joint_a", "joint_b")]
    assert np.abs(np.angle(np.exp(1j * (shown[0] - joint_a)))).max() < 0.02
    assert np.abs(np.angle(np.exp(1j * (shown[1] - joint_b)))).max() < 0.02
    assert np.abs(np.interp(a.time, healthy.time, healthy.link_length()) - length).max() < 0.01


STILL = TruckStep(0.35, (0.0, 0.0), 0.0, 0.0, 0.0025)


def rolls(rolled, now=0.0, place=(0.0, 0.1)):
    """Return a step of 10 ms of wheel a.left."""
    return WheelStep(rolled, (0.0, 0.0), rolled / 0.01, 0.0, now, 0.01, "a.left", place)


def test_a_tyre_is_as_warm_as_it_rolled_of_late():
    fault = ConcealedFault("unknown", "a.left", {"kind": "warmth", "size": 0.01, "pitch": 20.0, "start": 0.0})
    gained = [travelled(fault, rolls(0.03, 0.1 * step)) - 0.03 for step in range(2000)]
    assert gained[-1] == pytest.approx(0.03 * 0.01, rel=0.02)
    for step in range(2000, 4000):
        travelled(fault, rolls(0.0, 0.1 * step))
    assert travelled(fault, rolls(0.03, 400.0)) - 0.03 < 0.05 * gained[-1]


def test_tyres_that_a_turn_wound_up_unwind_by_the_next_turn_the_other_way():
    fault = ConcealedFault("unknown", "a", {"kind": "wind-up", "size": 0.02, "pitch": 0.0})

    def turned(by):
        at = TruckStep(0.3, (0.0, 0.0), 0.0, 0.0, 0.01)
        return sum(moved(fault, (0.0, 0.0, by), at)[2] for _ in range(500))

    assert turned(0.01) == pytest.approx(5.0 - 0.02, abs=1e-4)
    assert turned(-0.01) == pytest.approx(-5.0 + 0.04, abs=1e-4)


def test_a_bump_takes_what_its_label_says():
    fault = ConcealedFault("bump", "a.left", {"times": [0.0], "lost": [2e-3], "radius": 0.075})
    way = sum(travelled(fault, rolls(1e-3, 0.01 * step)) for step in range(1, 400))
    assert way == pytest.approx(0.399 - 2e-3, abs=1e-6)


def test_a_play_takes_its_width_once_for_each_reversal():
    fault = ConcealedFault("gear_backlash", "a.left", {"width": 3e-3})
    there = sum(travelled(fault, rolls(1e-3)) for _ in range(50))
    back = sum(travelled(fault, rolls(-1e-3)) for _ in range(50))
    assert there == pytest.approx(0.05)
    assert back == pytest.approx(-0.05 + 3e-3)


def test_slabs_are_of_the_floor_and_take_as_much_on_the_way_back():
    fault = ConcealedFault("unknown", "left", {"kind": "slabs", "size": 5e-4, "pitch": 0.6, "start": 0.0})
    there = np.arange(0.0, 2.0, 0.01)
    ways = [
        sum(travelled(fault, rolls(rolled, place=(x, 0.1))) for x in path)
        for rolled, path in ((0.01, there), (-0.01, there[::-1]))
    ]
    assert ways == pytest.approx([2.0 - 3 * 5e-4, -2.0 + 3 * 5e-4])


def test_a_wheel_on_a_joint_meets_it_once():
    fault = ConcealedFault("unknown", "left", {"kind": "slabs", "size": 5e-4, "pitch": 0.6, "start": 0.0})
    joint = 0.6 * 0.63
    xs = joint + 1e-3 * np.sin(np.arange(500.0))
    ways = [travelled(fault, rolls(0.01, place=(x, 0.1))) for x in xs]
    assert sum(ways) == pytest.approx(5.0)


@pytest.mark.slow
def test_a_bump_is_labelled_with_the_moment_at_which_the_wheel_comes_to_it(tmp_path):
    label = make(tmp_path / "bumps", Case("single", (("bump", "a.left"),), "squares", "none"), 28)
    recording = load_recording(tmp_path / "bumps" / "1")
    way = np.abs(np.diff(recording.wheel_angle("a.left")))
    for onset in label["effects"][0]["parameters"]["times"]["value"]:
        assert way[np.searchsorted(recording.time, onset + 0.05)] > 0.0


def test_a_moment_between_two_samples_is_labelled_as_it_is_while_the_wheel_rolls():
    time = np.arange(0.0, 1.0, 0.02)
    counts = np.cumsum(np.where(time > 0.5, 10, 0))
    label = {"parameters": {"times": {"value": [0.2, 0.733]}}}
    set_bump_times(label, time, counts)
    assert label["parameters"]["times"]["value"] == pytest.approx([0.5, 0.733])


def test_castors_kick_where_the_robot_turns_round_and_not_in_a_spin_on_rough_ground():
    fault = ConcealedFault("castor_kick", "a", {"yaw": 0.02, "radius": 0.05, "start": 0.0})
    chance = np.random.default_rng(3)
    kicked = [moved(fault, (1e-5 * chance.normal(), 0.0, 1e-3), STILL)[2] for _ in range(400)]
    assert max(kicked) == pytest.approx(1e-3)
    there = [moved(fault, (5e-4, 0.0, 0.0), STILL)[2] for _ in range(200)]
    back = [moved(fault, (-5e-4, 0.0, 0.0), STILL)[2] for _ in range(200)]
    assert sum(there) == 0.0
    assert sum(back) == pytest.approx(0.02)
