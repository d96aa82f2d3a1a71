"""`omnimate track`: a recording or a robot in, poses, rows and words out."""

import csv
import json
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from omnimate.cli.track.live import follow_robot, open_rows
from omnimate.effects.crossing import crossing_of
from omnimate.files.recordings.folder import save_recording
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.tracker import Tracker
from omnimate.motion.paths import out_and_back, rounded_rectangle
from omnimate.motion.paths import umbmark as squares
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.file import load_vehicle
from tests.recordings import frozen, samples


@pytest.fixture
def call(accepted):
    return partial(accepted, "track")


LOST = 1e3 * crossing_of("cable", 0.075, 0.010).lost  # [mm] that a wheel of 150 mm loses on a cable of 10 mm
ROUGH = 1.0  # [mm] that the floor's roughness may add to it while it is crossed: three standard deviations


def ways_lost(printed):
    """Return the ways [mm] that are printed to be lost by wheel a.right."""
    return [float(way) for way in re.findall(r"a\.right lost ([0-9.]+) mm", printed)]


@pytest.fixture(scope="module")
def drive():
    robot = reference_vehicle()
    truth = Truth(robot, floor=Floor(bumps=bumps_under("a.right", 2, 1.0, 5.0)), seed=1)
    return simulate(robot, truth, rounded_rectangle(3.0, 2.0, ["cw"]))


@pytest.fixture(scope="module")
def folder(drive, tmp_path_factory):
    place = tmp_path_factory.mktemp("track") / "drive"
    save_recording(drive, place)
    return place


def test_a_recording_shows_the_poses_and_each_bump_with_its_wheel(call, folder):
    result = call(folder)
    for word in ("plain", "IPEC", "filter", "joint_a bias"):
        assert word in result.out
    assert result.err.count("a.right lost") == 2
    assert ways_lost(result.err) == pytest.approx([LOST] * 2, abs=ROUGH)


def test_what_the_drive_has_not_told_and_what_to_drive_is_printed(call, tmp_path):
    """A way straight out and back turns no joint by an angle that tells a wheelbase."""
    robot = reference_vehicle()
    save_recording(simulate(robot, Truth(robot), out_and_back(2.0, 1, link_length=1.0)), tmp_path / "drive")
    said = call(tmp_path / "drive").out
    assert "encoders alone cannot tell the mean diameter of all wheels" in said
    assert "does not tell whether these are wrong" in said
    assert "drive rounded corners" in said


def test_json_lines_on_standard_output_are_nothing_but_json(call, folder):
    result = call(folder, "--jsonl", "-", "--every", 1.0)
    rows = [json.loads(line) for line in result.out.splitlines()]
    assert len(rows) > 30
    assert {"t", "plain_x", "ipec_theta", "filter_y", "sigma_theta", "lost_a_right"} <= set(rows[0])
    assert sum(row["lost_a_right"] for row in rows) == pytest.approx(0.0068, abs=0.0015)
    assert "filter" in result.err


def test_the_table_states_its_units_on_standard_error_too(call, folder):
    result = call(folder, "--jsonl", "-", "--every", 1.0)
    assert re.search(r"x \[m\] +y \[m\] +heading \[degrees\]", result.err)


def test_csv_holds_a_row_for_every_sample_if_asked(call, folder, drive, tmp_path):
    call(folder, "--csv", tmp_path / "rows.csv", "--every", 0)
    with (tmp_path / "rows.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(drive)
    assert float(rows[-1]["t"]) == pytest.approx(drive.time[-1])


def test_a_live_stream_gives_the_rows_of_the_recording_until_the_time_is_up(drive, tmp_path, capsys):
    path = tmp_path / "rows.jsonl"
    with open_rows(None, str(path)) as writer:
        follow_robot(samples(drive), Tracker(drive.vehicle), writer, seconds=20.0, every=0.1)
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    assert rows[-1]["t"] - rows[0]["t"] == pytest.approx(20.0, abs=0.11)
    assert np.diff([row["t"] for row in rows]).min() >= 0.1 - 1e-9
    assert ways_lost(capsys.readouterr().err) == pytest.approx([LOST], abs=ROUGH)


def test_a_joint_that_freezes_live_is_told_once_with_its_node(drive, capsys):
    broken = frozen(drive, "joint_a", 500)
    with open_rows(None, None) as writer:
        follow_robot(samples(broken), Tracker(broken.vehicle), writer, seconds=None, every=1.0)
    told = capsys.readouterr().err
    assert told.count("joint_a (node 5) stands still") == 1
    assert "check its coupling" in told


def last_row(path):
    return list(csv.DictReader(path.read_text().splitlines()))[-1]


def test_a_single_truck_is_tracked_by_its_wheels_and_by_fixes_where_it_has_them(call, refused, tmp_path):
    single = reference_single()
    recording = simulate(single, Truth(single, floor=Floor(), seed=1), squares(1.0, 1))
    save_recording(recording, tmp_path / "single")
    alone = call(tmp_path / "single")
    assert ("IPEC" in alone.out, "learned" in alone.out) == (False, False)
    call(tmp_path / "single", "--fixes", "--csv", tmp_path / "rows.csv")
    last = last_row(tmp_path / "rows.csv")
    assert last["ipec_x"] == ""
    assert float(last["filter_x"]) == pytest.approx(recording.poses.pose[-1, 0], abs=0.02)
    out = ("--out", tmp_path / "vehicle.toml")
    assert "of one, `omnimate calibrate` learns" in refused("track", tmp_path / "single", *out)
    save_recording(replace(recording, poses=None), tmp_path / "bare")
    assert "no fix of truck a has x, y and heading" in refused("track", tmp_path / "bare", "--fixes")
    assert "a bus has none" in refused("track", "--bus", "virtual://x", "--fixes")


def test_fixes_keep_two_trucks_where_they_are(call, drive, folder, tmp_path):
    call(folder, "--fixes", "--csv", tmp_path / "rows.csv")
    last = last_row(tmp_path / "rows.csv")
    assert float(last["filter_x"]) == pytest.approx(drive.poses.of("a").pose[-1, 0], abs=0.01)
    assert float(last["filter_y"]) == pytest.approx(drive.poses.of("a").pose[-1, 1], abs=0.01)


def test_what_was_learned_is_written_and_then_nothing_is_left_to_learn(call, tmp_path):
    """A joint that reads half a degree too much: its zero is moved, to within half a count."""
    robot = reference_vehicle()
    truth = Truth(robot, effects=linkage_biases(joint_a=np.radians(0.5)), floor=Floor(), seed=2)
    recording = simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["ccw", "cw"]))
    save_recording(recording, tmp_path / "drive")
    result = call(tmp_path / "drive", "--out", tmp_path / "learned.toml")
    assert "an axle that is turned" in result.out
    learned = load_vehicle(tmp_path / "learned.toml")
    count = learned.encoder("joint_a").scale
    moved = (learned.encoder("joint_a").zero - robot.encoder("joint_a").zero) * count
    assert moved == pytest.approx(np.radians(0.5), abs=0.75 * abs(count))
    again = estimate(replace(recording, vehicle=learned))
    assert not any(name == "bias of joint_a" for name, _ in again.findings.suspects)
