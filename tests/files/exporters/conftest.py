"""Drives that are exported."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.exporters.drive import drive_of
from omnimate.files.logs.blocks import LogStream
from omnimate.files.logs.frames import ERROR, Frame, concatenate, frames_of
from omnimate.files.logs.recording_to_frames import frames_of_recording
from omnimate.vehicle.file import parse_vehicle
from omnimate.vehicle.recording import Gap, Lap, Poses, Recording, Run
from tests.files.logs.any_frames import write_log

SAMPLES, START = 120, 1763670000.0


def silent(_done, _total):
    """Take no notice of progress."""


def written_log(path, rows):
    """Write frames as a log of candump, and return what reads it."""
    write_log(rows, path, ".log")
    return LogStream(path)


@pytest.fixture
def recording(robot_toml):
    """Two trucks in a bend: a sample lacks a.left, a pose of b its heading; a lap and commands."""
    vehicle = parse_vehicle(robot_toml)
    index = np.arange(SAMPLES)
    counts = np.outer(index, [370, 390, -350, -360, 4, -3, 2]).astype(np.int64)
    present = np.ones(counts.shape, bool)
    present[50, 0], counts[50, 0] = False, counts[49, 0]
    time = START + np.round(index * vehicle.bus.sync_period, 6)
    poses = Poses(
        time[[5, 5, 90]],
        np.array(["a", "b", "a"]),
        np.array([[1.0, 2.0, 0.3], [0.1, 1.9, np.nan], [1.4, 2.2, 0.4]]),
        np.array([[0.01, 0.02, 0.03], [0.01, np.nan, np.nan], [np.nan] * 3]),
    )
    return Recording(
        vehicle,
        time,
        counts,
        present,
        poses,
        Run("free", None, (Lap("none", float(time[0]), float(time[-1])),)),
        (Gap("a.left", float(time[49]), float(time[51]), "missing"),),
        np.full((SAMPLES, 4), 1.5),
    )


@pytest.fixture
def drive(recording):
    """The same, with an EMCY and an error frame on its bus."""
    special = [
        Frame(START + 0.5, 0x081, bytes.fromhex("1023050000000000")),
        Frame(START + 0.6, 0x004, bytes(8), ERROR),
    ]
    return drive_of(recording, concatenate([frames_of_recording(recording), frames_of(special)]))


@pytest.fixture
def single(recording):
    """A drive of one truck only."""
    vehicle = recording.vehicle
    alone = replace(vehicle, trucks={"a": vehicle.trucks["a"]}, linkage=None, encoders=vehicle.encoders[:2])
    counts, present = recording.counts[:, :2].copy(), recording.present[:, :2].copy()
    changes = {"vehicle": alone, "counts": counts, "present": present, "poses": None, "commands": None}
    recording = replace(recording, **changes)
    return drive_of(recording, frames_of_recording(recording))
