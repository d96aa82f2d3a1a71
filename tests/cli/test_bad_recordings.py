"""Recordings that cannot calibrate anything: every verb says what is wrong and what to do."""

import shutil
from dataclasses import replace

import pytest

from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from tests.recordings import frozen

TWO_ROBOTS = "is of the robot 'twin', but {first} of 'omnimate'; give recordings of one robot at a time"


def drive(name="omnimate", runs=2):
    robot = replace(reference_vehicle(), name=name)
    return simulate(robot, Truth(robot, seed=1), umbmark(1.5, runs, speed=0.4, link_length=1.0))


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Recordings that are sound, of another robot, of one run or one direction, and with frozen channels."""
    sound, root = drive(), tmp_path_factory.mktemp("bad")
    laps = [lap for lap in sound.run.laps if lap.direction == "cw"]
    made = {"sound": sound, "twin": drive("twin"), "single": drive(runs=1)}
    made["cw"] = replace(sound, run=replace(sound.run, laps=tuple(laps)))
    for channel in ("a.left", "joint_a", "joint_b", "link"):
        made[channel] = frozen(sound, channel)
    for name, recording in made.items():
        save_recording(recording, root / name)
    return {name: root / name for name in made}


def test_one_direction_says_why_both_are_needed(said, folders):
    sentence = said("umbmark", folders["cw"])
    assert "no ccw run" in sentence
    assert "drive the square in both" in sentence


def test_a_single_run_each_way_is_refused_once_for_both_trucks_and_may_be_forced(
    omnimate, said, folders, tmp_path
):
    call = ("umbmark", folders["single"], "--out", tmp_path / "out.toml")
    sentence = said(*call)
    assert not (tmp_path / "out.toml").exists()
    assert sentence.count("n = 1") == 1
    assert "drive the square five times in each direction" in sentence
    forced = omnimate(*call, "--force")
    assert (tmp_path / "out.toml").exists()
    assert forced.code == 0
    assert "n = 1" in forced.err


@pytest.mark.parametrize("verb", ["umbmark", "calibrate", "drift"])
def test_two_robots_are_not_pooled_though_their_sizes_are_the_same(said, folders, verb):
    sentence = said(verb, folders["sound"], folders["twin"])
    assert TWO_ROBOTS.format(first=folders["sound"]) in sentence


@pytest.mark.parametrize("verb", ["umbmark", "calibrate", "drift"])
def test_a_pose_that_is_no_number_names_its_line_and_column(said, folders, tmp_path, verb):
    folder = shutil.copytree(folders["sound"], tmp_path / "nan")
    rows = (folder / "poses.csv").read_text().splitlines()
    cells = rows[3].split(",")
    rows[3] = ",".join([*cells[:2], "nan", *cells[3:]])
    (folder / "poses.csv").write_text("\n".join(rows))
    sentence = said(verb, folder)
    assert "poses.csv:4: x 'nan' is not finite; leave the cell empty where it is unknown" in sentence


@pytest.mark.parametrize("channel", ["joint_a", "joint_b", "link"])
@pytest.mark.parametrize("verb", ["umbmark", "drift", "track"])
def test_a_frozen_channel_of_the_linkage_is_named_with_what_to_do(said, folders, verb, channel):
    sentence = said(verb, folders[channel])
    assert f"{channel} is frozen" in sentence
    assert "check its encoder" in sentence


def test_calibrate_does_without_a_frozen_link_and_says_so_but_not_with_linkage(accepted, said, folders):
    result = accepted("calibrate", folders["link"])
    assert "link is frozen" in result.err
    assert "the trucks are calibrated without it" in result.err
    assert "link is frozen" in said("calibrate", folders["link"], "--linkage")


@pytest.mark.parametrize("verb", ["umbmark", "calibrate", "drift", "track"])
def test_a_frozen_wheel_is_named_and_not_the_joint_that_follows_from_it(said, folders, verb):
    sentence = said(verb, folders["a.left"])
    assert "left" in sentence
    assert "joint" not in sentence
    assert "check its encoder" in sentence
