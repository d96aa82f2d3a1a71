"""The MuJoCo robot: what a healthy one, a cable, a larger and an eccentric wheel do, and the folders."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed: the extra `mujoco`")

from omnimate.files.recordings.folder import load_recording
from studies.mismatch.engines.mujoco import cases
from studies.mismatch.engines.mujoco.cases import make, nominal_by_geometry
from studies.mismatch.engines.mujoco.control import Pace, eight, rounded, shuttle, square
from studies.mismatch.engines.mujoco.drive import Floor, drive
from studies.mismatch.engines.mujoco.faults import nodding
from studies.mismatch.engines.mujoco.model import Cable, random_robot
from studies.mismatch.engines.true_motion import calibrate, crossings, residuals, rolling_radius, wave

PACE = Pace(0.015, 0.3)
FLAT = Floor(np.random.default_rng(0), 0.0)


@pytest.fixture(scope="module")
def robot():
    return random_robot(np.random.default_rng(3))


def run(robot, program, nominal=None, slope=0.0):
    floor = Floor(np.random.default_rng(5), slope)
    return drive(robot, floor, program, nominal or nominal_by_geometry(robot))


def straight(way):
    return shuttle(PACE, way, 1).first(1)


def test_the_programs_close():
    for program in (square(PACE, 1.5, (1, -1)), rounded(PACE, 1.8, (1,)), eight(PACE, 7.0, 2)):
        theta = np.cumsum(program.w) * PACE.dt
        middle = theta - program.w * PACE.dt / 2
        end = np.sum(program.v * np.exp(1j * middle)) * PACE.dt
        assert abs(end) < 2e-3
        assert np.cos(theta[-1]) == pytest.approx(1.0, abs=1e-9)


def test_a_healthy_robot_drives_a_square_and_its_dead_reckoning_agrees(robot):
    result = run(robot, square(PACE, 1.0, (1,)))
    nominal = calibrate(result, robot.link)
    ruler = nominal_by_geometry(robot)
    assert nominal.radii == pytest.approx(ruler.radii, rel=3e-4)
    assert nominal.tracks == pytest.approx(ruler.tracks, rel=3e-4)
    assert np.abs(residuals(result, nominal, 1).cumsum(axis=0)[:, :6]).max() < 5e-4
    assert np.abs(residuals(result, nominal)[:, 6:]).max() < 1e-5
    assert np.hypot(*(result.poses[-1, 0, :2] - result.poses[0, 0, :2])) < 0.01


def test_a_cable_takes_the_way_that_geometry_says(robot):
    height, track = 0.006, robot.trucks["a"].track
    cable = Cable("a.right", 1.0, -track / 2, np.pi / 2, height, 0.3)
    slow = Pace(0.015, 0.15)
    program, nominal = shuttle(slow, 1.6, 1), nominal_by_geometry(robot)
    program = replace(program, v=np.abs(program.v[:900]), w=program.w[:900], leader=np.full(900, "a"))
    result = drive(replace(robot, cables=(cable,)), FLAT, program, nominal)
    _, lost = crossings(result, nominal, "a.right", 0.0)
    radius = robot.tyres["a.right"].radius
    q = np.arccos((radius - height / 2) / (radius + height / 2))
    assert lost == pytest.approx([2 * (radius + height / 2) * (q - np.sin(q))], rel=0.1)
    assert result.poses[-1, 0, 2] < result.poses[0, 0, 2] - 0.5 * lost[0] / track


def test_a_larger_wheel_rolls_farther_per_turn(robot):
    tyre = robot.tyres["b.left"]
    larger = replace(robot, tyres=robot.tyres | {"b.left": replace(tyre, radius=tyre.radius * 1.01)})
    driven = run(larger, rounded(PACE, 1.0, (1,)))
    rolled = rolling_radius(driven, nominal_by_geometry(robot), "b.left")
    assert rolled / tyre.radius == pytest.approx(1.01, abs=5e-4)


def test_an_eccentric_wheel_rolls_its_radius_plus_a_cosine_turned_by_the_nodding_of_its_truck(robot):
    tyre = replace(robot.tyres["a.left"], eccentricity=1e-3, phase=0.7)
    result = run(replace(robot, tyres=robot.tyres | {"a.left": tyre}), straight(1.5))
    amplitude, phase = wave(result, nominal_by_geometry(robot), "a.left")
    expected = 1e-3 * np.exp(0.7j) * nodding(robot, "a.left")
    assert amplitude * np.exp(1j * phase) == pytest.approx(expected, rel=0.03)


def test_recordings_load_and_their_labels_say_what_was_done(tmp_path):
    entry = make(tmp_path, 1, 7)
    recording = load_recording(tmp_path / "1")
    assert entry["engine"] == "mujoco"
    assert entry["effects"][0]["effect"] == "joint_bias"
    assert len(recording.run.laps) >= 4
    assert len(recording.time) * 0.015 == pytest.approx(entry["seconds_of_driving"], abs=0.1)


def test_a_drive_with_unstable_contacts_is_drawn_once_more(monkeypatch, tmp_path):
    drawn = []

    def unstable_first(folder, rng, name, poses):
        drawn.append(rng.random())
        if len(drawn) == 1:
            raise FloatingPointError("unstable")
        return {"fault": name}

    monkeypatch.setattr(cases, "_made", unstable_first)
    assert make(tmp_path, 1, 0, fault="healthy") == {"fault": "healthy"}
    assert drawn[0] != drawn[1]


def test_a_case_depends_on_the_seed_and_its_number_alone(written_twice):
    written_twice(make, 2, 0, faultless=True)
