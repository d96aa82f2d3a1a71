"""The world of injections: real recordings as they are, and with an effect put into their counts or stamps.

A case is some runs of one OptiOdom set by a robot that is calibrated by least squares on that set. Beside
every injected case is its twin, the same runs untouched; it counts as a healthy robot, as no black box
predicts these sets better than three numbers do. Runs follow each other on one clock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.files.recordings.folder import save_recording
from omnimate.vehicle.parameters import Channel
from omnimate.vehicle.recording import Recording
from studies.datasets.optiodom.drives import each_recording
from studies.mismatch.engines.rivals import draw
from studies.mismatch.engines.strength import Drive, Poses, Ruler
from studies.mismatch.run import Report
from studies.mismatch.worlds.optiodom import in_sequence, optiodom_sets
from studies.mismatch.worlds.world import Label, Request, write_all

MOST_RUNS = 6  # of a case
_WHEELS: tuple[Channel, Channel] = ("a.left", "a.right")
QUICK, WHOLE = 3, 500  # injected cases, where no number is asked for


def write_injections(
    data: Path, folder: Path, request: Request, jobs: int, report: Report
) -> Mapping[str, Label]:
    """Write injected cases and their twins; `data` is the folder of the real recordings."""
    sets = optiodom_sets(data, "injections are")
    count = request.cases or (QUICK if request.quick else WHOLE)
    wanted = {f"injected-{number:04d}": (sets, request.seed, number) for number in range(count)}
    pairs = write_all(write_pair, wanted, folder, jobs, report)
    labels = {name: label for pair in pairs.values() for name, label in pair.items()}
    return {name: label for name, label in labels.items() if not request.healthy or label["kind"] == "null"}


def write_pair(folder: Path, sets: Sequence[Path], seed: int, number: int) -> dict[str, Label]:
    """Write one injected case and its twin, drawn by seed and number; return the labels of both."""
    chance = np.random.default_rng([seed, number])
    while True:
        place = sets[int(chance.integers(len(sets)))]
        every = calibrated_runs(place)
        count = min(len(every), int(chance.integers(2, MOST_RUNS + 1)))
        picked = sorted(chance.choice(len(every), count, replace=False).tolist())
        untouched = in_sequence([every[index] for index in picked])
        drives = [drive_of(recording) for recording in untouched]
        injected = draw(drives, Ruler.of(drives), chance)
        if injected is not None:
            break
    altered = [with_drive(*pair) for pair in zip(untouched, injected.injection.into(drives), strict=True)]
    twin = f"{folder.name}-twin"
    names = [str(index) for index in range(1, count + 1)]
    for name, before, after in zip(names, untouched, altered, strict=True):
        save_recording(before, folder.with_name(twin) / name, compress=True)
        save_recording(after, folder / name, compress=True)
    common = {"recordings": names, "set": f"{place.parent.name}/{place.name}", "runs": picked}
    return {
        folder.name: {
            "kind": "injected",
            "effects": [injected.label()],
            "twin": twin,
            "strength": injected.strength,
            **common,
        },
        twin: {"kind": "null", "effects": [], **common},
    }


@cache
def calibrated_runs(place: Path) -> list[Recording]:
    """Return all runs of a set, by the robot that least squares on these runs gives.

    OptiOdomError: the set is damaged; CalibrationError: it cannot tell wheelbase and diameters.
    """
    recordings = [recording for _, recording in each_recording(place)]
    truck = calibrate_truck(recordings).truck
    return [replace(recording, vehicle=recording.vehicle.with_truck("a", truck)) for recording in recordings]


def drive_of(recording: Recording) -> Drive:
    """Return what injections see of a recording of a single truck with poses."""
    assert recording.poses is not None  # sets without poses are no source of injections
    poses, vehicle = recording.poses.of("a"), recording.vehicle
    known = poses.select(np.isfinite(poses.pose).all(axis=1))
    pose = known.pose.copy()
    pose[:, 2] = np.unwrap(pose[:, 2])
    counts = np.stack([recording.channel_counts(side) for side in _WHEELS], axis=1)
    scale = np.array([vehicle.metres_per_count(side) for side in _WHEELS])
    return Drive(
        np.array(recording.time),
        counts * scale,
        np.abs(scale),
        np.array([0.5 * vehicle.wheel_diameter(side) for side in _WHEELS]),
        np.array([vehicle.trucks["a"].wheelbase]),
        np.zeros((len(recording), 0)),
        0.0,
        {0: Poses(known.time, pose)},
    )


def with_drive(recording: Recording, drive: Drive) -> Recording:
    """Return a recording with the ways, rounded to whole counts, and the stamps of an altered drive.

    Poses whose stamps lie beyond the recording's end are left out.
    """
    assert recording.poses is not None  # as above
    vehicle, poses = recording.vehicle, recording.poses.of("a")
    counts = recording.counts.copy()
    for wheel, side in enumerate(_WHEELS):
        column = vehicle.channels.index(side)
        counts[:, column] = np.rint(drive.way[:, wheel] / vehicle.metres_per_count(side)).astype(np.int64)
    known = poses.select(np.isfinite(poses.pose).all(axis=1))
    stamped = replace(known, time=drive.poses[0].time)
    measured = stamped.select(stamped.time <= recording.time[-1])
    return replace(recording, counts=counts, poses=measured)
