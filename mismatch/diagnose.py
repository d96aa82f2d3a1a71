"""`diagnose`: from recordings of one robot to what its simulation leaves out, and how sure that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from threadpoolctl import threadpool_limits

from omnimate.mismatch.answer.answer import answer
from omnimate.mismatch.description.far_off import far_off
from omnimate.mismatch.description.first_look import first_look
from omnimate.mismatch.diagnosis import Diagnosis
from omnimate.mismatch.investigate import PROGRESS_STEPS, investigate
from omnimate.mismatch.recording.validate import check, too_little

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.investigate import Progress
    from omnimate.vehicle.recording import Recording


def diagnose(
    recordings: Sequence[Recording],
    *,
    without: Iterable[str] = (),
    progress: Progress = lambda _done, _all, _doing: None,
    budget: float | None = None,
) -> Diagnosis:
    """Return where a simulation of the robot and recordings of it differ, and which physics that is.

    Args:
        recordings: of one robot, all with the same `vehicle.toml`.
        without: effects to leave out of the library.
        progress: called with steps done, total steps, and a description.
        budget: processor time [s] after which the search begins no other round, and the answer says so; 20 s
            for 20,000 samples where none is given.

    Raises:
        RecordingError: no recordings, or of two robots; a clock that jumps; a channel or poses that do not
            fit.
    """
    check(recordings)
    names = tuple(recording.source for recording in recordings)
    robot = recordings[0].vehicle.name
    reason = too_little(recordings)
    if reason:
        return Diagnosis("insufficient", reason, robot=robot, recordings=names, drive_next=(reason,))
    progress(0, PROGRESS_STEPS, "a first look")
    look = first_look(recordings)
    if look is not None:
        return far_off(recordings, look)
    # matrices are so small that a second thread takes longer, and budgets count the time of all threads
    with threadpool_limits(1, user_api="blas"):
        investigation = investigate(recordings, without, progress, budget)
        diagnosis = answer(investigation)
    progress(PROGRESS_STEPS, PROGRESS_STEPS, "done")
    return diagnosis
