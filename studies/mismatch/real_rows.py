"""What the tool finds in recordings of real robots, about whose physics the truth is not known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.mismatch import diagnose
from omnimate.mismatch.description.first_look import first_look
from studies.datasets import husky, labyrinth

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.mismatch import Diagnosis
    from omnimate.vehicle.recording import Recording


@dataclass(frozen=True, slots=True)
class RobotRow:
    """One robot that is described wrongly: as it is described, and as the first look corrects it.

    Attributes:
        name: Name of the data.
        recordings: The recordings with the robot as described.
        corrected: The recordings with the robot as the first look corrects it.
        first: Diagnosis of the robot as described.
        second: Diagnosis of the corrected robot.
    """

    name: str
    recordings: Sequence[Recording]
    corrected: Sequence[Recording]
    first: Diagnosis
    second: Diagnosis


def robot_row(folder: Path, every: int = 1) -> RobotRow:
    """Return the answers to labyrinth_tuc or drive_ugv, as described and as corrected by the first look.

    Args:
        folder: Folder of the data, whose name says which of the two they are.
        every: One in so many of the corrected recordings is searched.

    Raises:
        SourceError: The data are damaged.
    """
    source = labyrinth if folder.name == "labyrinth_tuc" else husky
    recordings = source.recordings_of(folder)
    look = first_look(recordings)
    corrected = recordings if look is None else [look.corrected(recording) for recording in recordings]
    return RobotRow(folder.name, recordings, corrected, diagnose(recordings), diagnose(corrected[::every]))
