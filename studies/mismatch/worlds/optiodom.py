"""The world of OptiOdom: real recordings, half of a set diagnosed, and the other half predicted.

The robot is that of the data's own description. Beside the effects found stands plain least squares of three
numbers, fitted to the same half; labels hold what these numbers change by five of their standard deviations.
What they change by three of them when fitted to both halves is true as well: to name it is right, to miss it
no mistake.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.effects.ageing import AgedSamples
from omnimate.effects.block import Block
from omnimate.effects.effect import Effect
from omnimate.effects.reference_offset import truck_poses
from omnimate.effects.stages import replay
from omnimate.files.recordings.folder import save_recording
from omnimate.mismatch import diagnose
from omnimate.vehicle.arcs import integrate_twists
from omnimate.vehicle.parameters import Channel
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array, between
from studies.datasets.optiodom import drives as optiodom
from studies.mismatch.engines.strength import rates
from studies.mismatch.engines.vocabulary import label
from studies.mismatch.run import Answer, Question, Report, answer_of, recordings_of
from studies.mismatch.worlds.world import AbsentError, Label, Request

START, PAUSE = 1_593_000_000.0, 60.0  # [s] the clock of the first run, and from one run to the next


def optiodom_sets(data: Path, missing: str) -> list[Path]:
    """Return the differential robot's sets; without any, AbsentError: `missing` says what is left out."""
    root = data / "real" / "optiodom"
    if not root.is_dir():
        raise AbsentError(f"{root} is not there: {missing} left out")
    return sorted(optiodom.differential_sets(root)[0])


def in_sequence(recordings: Sequence[Recording]) -> list[Recording]:
    """Return recordings one after the other on one clock, as a robot records that stays switched on."""
    moved, start = [], START
    for recording in recordings:
        by = start - float(recording.time[0])
        moved.append(_shifted(recording, by))
        start = float(moved[-1].time[-1]) + PAUSE
    return moved


def _shifted(recording: Recording, by: float) -> Recording:
    poses, driven = recording.poses, recording.run
    if driven is not None:
        laps = (replace(lap, start=lap.start + by, end=lap.end + by) for lap in driven.laps)
        driven = replace(driven, laps=tuple(laps))
    gaps = (replace(gap, start=gap.start + by, end=gap.end + by) for gap in recording.gaps)
    return replace(
        recording,
        time=recording.time + by,
        poses=None if poses is None else replace(poses, time=poses.time + by),
        run=driven,
        gaps=tuple(gaps),
    )


def halves(recordings: Sequence[Recording]) -> tuple[list[Recording], list[Recording]]:
    """Return every other recording, and the rest; a recording that stands alone is cut in the middle.

    Every other one, because the first runs of a set may be cw and the last ones ccw.
    """
    if len(recordings) > 1:
        return list(recordings[::2]), list(recordings[1::2])
    (whole,) = recordings
    middle = len(whole) // 2
    return [_part(whole, slice(None, middle))], [_part(whole, slice(middle, None))]


def _part(recording: Recording, rows: slice) -> Recording:
    """Return some samples of a recording, with the poses and laps that lie in them."""
    time, poses, driven = recording.time[rows], recording.poses, recording.run
    start, end = float(time[0]), float(time[-1])
    if poses is not None:
        poses = poses.select((poses.time >= start) & (poses.time <= end))
    if driven is not None:
        laps = (
            replace(lap, start=max(lap.start, start), end=min(lap.end, end))
            for lap in driven.laps
            if lap.start < end and lap.end > start
        )
        driven = replace(driven, laps=tuple(laps))
    return replace(
        recording,
        time=time,
        counts=recording.counts[rows],
        present=recording.present[rows],
        poses=poses,
        run=driven,
        gaps=tuple(gap for gap in recording.gaps if gap.start >= start and gap.end <= end),
        commands=None if recording.commands is None else recording.commands[rows],
    )


STRETCH = 10.0  # [s] that is driven open loop
_WHEELS: tuple[Channel, Channel] = ("a.left", "a.right")


def position_error(recordings: Sequence[Recording], effects: Sequence[Effect] = ()) -> float:
    """Return the position error of truck a after 10 s of open loop, root mean square [m].

    Recordings have dense poses of truck a; effects are physics that their description leaves out.
    """
    return float(
        np.sqrt(np.mean(np.concatenate([_errors(recording, effects) for recording in recordings]) ** 2))
    )


def _errors(recording: Recording, effects: Sequence[Effect]) -> Array:
    """Return the position error at the end of each stretch of one recording [m], shape `(S,)`."""
    time, measured = recording.time, _measured(recording, effects)
    twist = replay(block_of(recording), effects).twist[:, 0]
    heading = np.concatenate(([0.0], np.cumsum(twist[:, 2])))
    path = integrate_twists(twist, heading, np.zeros(3))
    edges = np.linspace(0, len(time) - 1, max(1, round(float(time[-1] - time[0]) / STRETCH)) + 1).astype(int)
    begin, end = edges[:-1], edges[1:]
    off = between(path[begin], path[end]) - between(measured[begin], measured[end])
    return np.asarray(np.hypot(off[:, 0], off[:, 1]))


def _measured(recording: Recording, effects: Sequence[Effect]) -> Array:
    """Return truck a's pose at every sample `(N, 3)`: stamps and the reference's place put right."""
    assert recording.poses is not None  # the caller chose recordings with poses
    poses = recording.poses.of("a")
    known = np.isfinite(poses.pose).all(axis=1)
    time, pose = poses.time[known], poses.pose[known].copy()
    for effect in effects:
        if isinstance(effect, AgedSamples) and effect.acts_at() == "poses":
            time = time - effect.age(time, float(recording.time[0]))
    pose = truck_poses(effects, "a", pose)
    pose[:, 2] = np.unwrap(pose[:, 2])
    return np.stack([np.interp(recording.time, time, axis) for axis in pose.T], axis=1)


def block_of(recording: Recording) -> Block:
    """Return the steps of a recording of a single truck, as its nominal robot would have driven them."""
    vehicle, time = recording.vehicle, np.asarray(recording.time)
    angle = np.stack([recording.wheel_angle(wheel) for wheel in _WHEELS], axis=1)
    radius = np.array([0.5 * vehicle.wheel_diameter(wheel) for wheel in _WHEELS])
    turned = np.diff(angle, axis=0)
    smooth = [rates(way, time) for way in (radius * angle).T]
    pose = _measured(recording, ()) if recording.poses is not None else np.zeros((len(time), 3))
    middle = 0.5 * (pose[1:] + pose[:-1])
    return Block(
        time=time[1:],
        period=np.diff(time),
        angle=angle[1:],
        turned=turned,
        speed=np.stack([speed for speed, _ in smooth], axis=1),
        acceleration=np.stack([acceleration for _, acceleration in smooth], axis=1),
        wheelbase=np.array([vehicle.trucks["a"].wheelbase]),
        heading=middle[:, None, 2],
        place=middle[:, None, :2],
        travel=radius * turned,
        twist=np.zeros((len(turned), 1, 3)),
        reading=np.zeros((len(turned), 0)),
    ).rolled()


CERTAIN = 5.0  # standard deviations from which a calibrated number must be asserted
LIKELY = 3.0  # standard deviations from which a number that all recordings of a set give is another one
QUICK = 2  # cases, where a small part is enough
_EFFECTS = {
    "wheelbase": ("wheelbase", "a"),
    "left wheel diameter": ("wheel_diameter", "a.left"),
    "right wheel diameter": ("wheel_diameter", "a.right"),
}  # by the name of the calibrated quantity


def write_optiodom(
    data: Path, folder: Path, request: Request, _jobs: int, report: Report
) -> Mapping[str, Label]:
    """Write each half of each differential set as a case; `data` is the folder of the real recordings."""
    sets = optiodom_sets(data, "optiodom is")
    most = request.cases or (QUICK if request.quick else 2 * len(sets))
    labels = {}
    for place in sets[: -(-most // 2)]:
        name = f"{place.parent.name}-{place.name}"
        both = halves(in_sequence([recording for _, recording in optiodom.each_recording(place)]))
        for half, (seen, held_out) in enumerate((both, both[::-1]), start=1):
            labels[f"{name}-{half}"] = {
                **_write(folder / f"{name}-{half}", seen, held_out),
                "set": f"{place.parent.name}/{place.name}",
            }
        report(len(labels), most)
    return labels


def _write(folder: Path, seen: Sequence[Recording], held_out: Sequence[Recording]) -> dict[str, Any]:
    names: dict[str, list[str]] = {"recordings": [], "held_out": []}
    for kind, recordings in zip(names, (seen, held_out), strict=True):
        for number, recording in enumerate(recordings, start=1):
            names[kind].append(f"{kind}-{number}")
            save_recording(recording, folder / names[kind][-1], compress=True)
    secondary = _changed([*seen, *held_out], LIKELY)
    return {"kind": "calibration", "effects": _changed(seen, CERTAIN), "secondary": secondary, **names}


def _changed(recordings: Sequence[Recording], sigmas: float) -> list[dict[str, Any]]:
    """Return the labels of numbers that least squares changes by so many standard deviations."""
    return [
        label(*_EFFECTS[quantity.name], {"ratio": quantity.value / quantity.nominal})
        for quantity in calibrate_truck(recordings).quantities
        if quantity.sigma > 0.0 and abs(quantity.value - quantity.nominal) >= sigmas * quantity.sigma
    ]


def diagnosed_and_driven(question: Question) -> Answer:
    """Return the tool's answer, and beside it the position errors on the recordings that it has not seen.

    They are those after 10 s of open loop, rms [m]: of the robot as described, by plain least squares, and
    with the effects that were found.
    """

    def ask() -> Answer:
        folder, wanted = question
        seen, held_out = recordings_of(question), recordings_of((folder, {"recordings": wanted["held_out"]}))
        diagnosis = diagnose(seen)
        truck = calibrate_truck(seen).truck
        calibrated = [
            replace(recording, vehicle=recording.vehicle.with_truck("a", truck)) for recording in held_out
        ]
        errors = {
            "nominal": position_error(held_out),
            "least squares": position_error(calibrated),
            "found": position_error(held_out, diagnosis.effects),
        }
        return {**diagnosis.as_json(), "open_loop": errors}

    return answer_of(ask)
