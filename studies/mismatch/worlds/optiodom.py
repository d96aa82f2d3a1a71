"""The world of OptiOdom: real recordings, half of a set diagnosed, and the other half predicted.

The robot is that of the data's own description. Beside the effects found stands plain least squares of three
numbers, fitted to the same half; labels hold what these numbers change by five of their standard deviations.
What they change by three of them when fitted to both halves is true as well: to name it is right, to miss it
no mistake.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.files.recordings.folder import save_recording
from omnimate.mismatch import diagnose
from studies.datasets.optiodom import recordings as optiodom
from studies.mismatch.engines.labels import label
from studies.mismatch.open_loop import position_error
from studies.mismatch.questions import Answer, Question, answer_of, recordings_of
from studies.mismatch.worlds.sequence import halves, in_sequence
from studies.mismatch.worlds.world import AbsentError, Label, Request

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from omnimate.vehicle.recording import Recording
    from studies.mismatch.progress import Report

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
    root = data / "real" / "optiodom"
    if not root.is_dir():
        raise AbsentError(f"{root} is not there: optiodom is left out")
    sets = sorted(optiodom.differential_sets(root)[0])
    most = request.cases or (QUICK if request.quick else 2 * len(sets))
    labels = {}
    for place in sets[: -(-most // 2)]:
        name = f"{place.parent.name}-{place.name}"
        both = halves(in_sequence(optiodom.recordings_of(place)))
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
    return answer_of(lambda: _diagnosed_and_driven(question))


def _diagnosed_and_driven(question: Question) -> Answer:
    folder, wanted = question
    seen, held_out = recordings_of(question), recordings_of((folder, {"recordings": wanted["held_out"]}))
    diagnosis = diagnose(seen)
    truck = calibrate_truck(seen).truck
    calibrated = [replace(each, vehicle=each.vehicle.with_truck("a", truck)) for each in held_out]
    errors = {
        "nominal": position_error(held_out),
        "least squares": position_error(calibrated),
        "found": position_error(held_out, diagnosis.effects),
    }
    return {**diagnosis.as_json(), "open_loop": errors}
