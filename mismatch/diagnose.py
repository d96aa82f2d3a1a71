"""`diagnose`: from recordings of one robot to what its simulation leaves out, and how sure that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.mismatch.answer import answer
from omnimate.mismatch.diagnosis import Diagnosis
from omnimate.mismatch.far_off import far_off
from omnimate.mismatch.first_look import first_look
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.investigate import STEPS, investigate
from omnimate.mismatch.noise import DEFAULT_LEVELS, WHITE_FLOOR
from omnimate.mismatch.parts import WHOLE
from omnimate.mismatch.refine import TURNS, contend, refine
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.validate import check, too_little
from omnimate.mismatch.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.investigate import Progress
    from omnimate.mismatch.parts import Parts
    from omnimate.vehicle.recording import Recording


def diagnose(
    recordings: Sequence[Recording],
    *,
    without: Iterable[str] = (),
    parts: Parts = WHOLE,
    progress: Progress = lambda _done, _all, _doing: None,
) -> Diagnosis:
    """Return where a simulation of the robot and recordings of it differ, and which physics that is.

    Args:
        recordings: of one robot, all with the same `vehicle.toml`.
        without: effects to leave out of the library.
        parts: of the method that are at work.
        progress: is told how much is done, of how much, and what is being done.

    Raises:
        RecordingError: recordings of two robots, a clock that jumps, a channel or poses that do not fit.
    """
    check(recordings)
    names = tuple(one.source for one in recordings)
    robot = recordings[0].vehicle.name
    reason = too_little(recordings)
    if reason:
        return Diagnosis("insufficient", reason, robot=robot, recordings=names, drive_next=(reason,))
    progress(0, STEPS, "a first look")
    look = first_look(recordings)
    if look is not None:
        return far_off(recordings, look)
    windows = [windows_of(signals_of(one, foreseen=parts.foreseen)) for one in recordings]
    left_out = without if parts.unknown else [*without, "unknown"]
    noise = DEFAULT_LEVELS if parts.waves else WHITE_FLOOR
    found = investigate(windows, folds_of(windows), without=left_out, noise=noise, progress=progress)
    progress(STEPS - 1, STEPS, "fitting what was found")
    if parts.refinement:
        contend(found)
    turns = TURNS if parts.refinement else 0
    diagnosis = answer(found, refine(found, turns), turns)
    progress(STEPS, STEPS, "done")
    return diagnosis
