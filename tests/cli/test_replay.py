"""`omnimate replay`: what a recording holds, and real logs of strangers, frame by frame."""

import re

import numpy as np
import pytest

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.errors import NoSync
from omnimate.driver.robot.passive import PassiveReader
from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.recordings.folder import load_recording, save_recording
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.odometry import dead_reckon
from tests.samples import CANOPEN_TRACES, CAR_LOG, OTHER_ROBOT, OTHER_ROBOT_ASC, cases

STRANGERS_LOGS = cases(OTHER_ROBOT, OTHER_ROBOT_ASC, *CANOPEN_TRACES, CAR_LOG)


def test_the_trajectories_are_those_of_dead_reckoning(accepted, small_drive, tmp_path):
    table, figure = tmp_path / "paths.csv", tmp_path / "plan.svg"
    result = accepted("replay", small_drive, "--csv", table, "--plot", figure)
    recording = load_recording(small_drive)
    written = np.genfromtxt(table, delimiter=",", skip_header=1, usecols=(0, 2, 3, 4))
    first = recording.poses.of("a").pose[0]
    assert np.allclose(written[: len(recording), 1:], dead_reckon(recording, "a", first), atol=1e-6)
    assert len(written) == 2 * len(recording)
    assert figure.read_text().startswith("<?xml")
    assert "fix minus odometry" in result.out


def test_a_figure_of_unknown_format_is_refused_before_the_log_is_read(refused, small_drive, tmp_path):
    assert "unknown format '.jpg'" in refused("replay", small_drive, "--plot", tmp_path / "plan.jpg", out="")


def test_a_calibrated_vehicle_changes_the_trajectory_and_not_the_recording(omnimate, small_drive, tmp_path):
    before = omnimate("replay", small_drive).out
    other = tmp_path / "other.toml"
    other.write_text(
        (small_drive / "vehicle.toml").read_text().replace("wheelbase = 0.34", "wheelbase = 0.33")
    )
    assert omnimate("replay", small_drive, "--vehicle", other).out != before
    assert omnimate("replay", small_drive).out == before


def test_a_vehicle_with_other_encoders_reads_the_log_anew(refused, small_drive, tmp_path):
    other = tmp_path / "other.toml"
    text = (small_drive / "vehicle.toml").read_text()
    other.write_text(text.replace("node = 2\ncob_id = 386", "node = 9\ncob_id = 999"))
    assert "a.left and a.right are never there in the same sample" in refused(
        "replay", small_drive, "--vehicle", other
    )


def test_an_eds_that_is_not_there_is_named(omnimate, small_drive, tmp_path):
    other = tmp_path / "other.toml"
    text = (small_drive / "vehicle.toml").read_text()
    other.write_text(text.replace('channel = "a.left"', 'channel = "a.left"\neds = "gone.eds"', 1))
    result = omnimate("replay", small_drive, "--vehicle", other)
    assert f"{tmp_path / 'gone.eds'}: not there" in result.err


def test_a_log_of_another_robot_without_its_vehicle_says_to_give_it(omnimate, tmp_path):
    recording = simulate(reference_single(), Truth(reference_single(), seed=1), umbmark(0.5, 1))
    save_recording(recording, tmp_path)
    asked = omnimate("replay", tmp_path / "can.log")
    assert asked.code == 1
    assert "give --vehicle" in asked.err.splitlines()[-1]
    given = omnimate("replay", tmp_path / "can.log", "--vehicle", tmp_path / "vehicle.toml")
    assert (given.code, given.err) == (0, "")


def test_frames_go_onto_a_bus_unchanged_and_in_order(omnimate, small_drive):
    frames = read_log(small_drive / "can.log").frames
    with open_bus("virtual://replayed") as bus:
        assert omnimate("replay", small_drive, "--bus", "virtual://replayed", "--pace", 0).code == 0
        heard = [bus.recv(0.0) for _ in range(len(frames))]
        assert bus.recv(0.0) is None
    sent = [(frame.can_id, frame.data) for frame in frames]
    assert [(message.arbitration_id, bytes(message.data)) for message in heard] == sent


@pytest.mark.parametrize("path", STRANGERS_LOGS)
def test_every_frame_of_a_strangers_log_is_called_something(omnimate, path):
    result = omnimate("replay", path)
    total, classes = re.search(r"(\d+) frames: (.*)", result.out).groups()
    numbers = [int(number) for number in re.findall(r" (\d+)(?:,|$)", classes)]
    assert sum(numbers) == int(total) == len(read_log(path).frames)
    assert result.code == 1
    assert "error: " in result.err


@pytest.mark.parametrize("path", STRANGERS_LOGS)
def test_a_strangers_log_on_the_bus_is_heard_without_an_unhandled_frame(path):
    """Frame by frame through the live reader: nothing raises, and no frame enters a sample."""
    frames = read_log(path).frames
    url = "virtual://strangers"
    with open_bus(url) as sender, PassiveReader(reference_vehicle(), url) as ear:
        for frame in frames:
            sender.send(message_of_frame(frame))
        try:
            samples = list(ear.samples(idle=0.0, patience=0.2))
        except NoSync:
            samples = []
        report = ear.report()
    assert not any(any(sample.present) for sample in samples)
    assert sum(node.received for node in report.nodes) == 0
    assert report.unknown_frames
