"""Classification of frames by COB-ID: the predefined connection set of CiA 301 and the vehicle's PDOs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from omnimate.files.logs.canopen_words import SYNC_ID, TIME_ID
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames
    from omnimate.vehicle.parameters import VehicleParameters

FrameClass = Literal[
    "SYNC",
    "PDO",
    "unknown PDO",
    "heartbeat",
    "EMCY",
    "SDO",
    "NMT",
    "TIME",
    "LSS",
    "remote",
    "error",
    "foreign",
]
CLASSES: tuple[FrameClass, ...] = get_args(FrameClass)

_RANGES: dict[FrameClass, tuple[range, ...]] = {
    "NMT": (range(0x001),),
    "SYNC": (range(SYNC_ID, SYNC_ID + 1),),
    "EMCY": (range(0x081, 0x100),),
    "TIME": (range(TIME_ID, TIME_ID + 1),),
    "unknown PDO": tuple(range(base + 1, base + 0x80) for base in range(0x180, 0x580, 0x80)),
    "SDO": (range(0x581, 0x600), range(0x601, 0x680)),
    "heartbeat": (range(0x701, 0x780),),
    "LSS": (range(0x7E4, 0x7E6),),
}


def classify(frames: Frames, vehicle: VehicleParameters | None = None) -> NDArray[np.uint8]:
    """Return for each frame the index of its class in `CLASSES`, `(N,)`; with no vehicle no PDO is known."""
    table = np.full(0x800, CLASSES.index("foreign"), np.uint8)
    for name, ranges in _RANGES.items():
        for identifiers in ranges:
            table[identifiers.start : identifiers.stop] = CLASSES.index(name)
    if vehicle is not None:
        cob_ids = [encoder.cob_id for encoder in vehicle.encoders] + [
            drive.cob_id for drive in vehicle.drives
        ]
        table[cob_ids] = CLASSES.index("PDO")
    classes: NDArray[np.uint8] = table[frames.can_id & 0x7FF]
    classes[(classes == CLASSES.index("SYNC")) & (frames.length > 1)] = CLASSES.index("foreign")
    classes[frames.flags & REMOTE > 0] = CLASSES.index("remote")
    classes[frames.flags & (EXTENDED | FD) > 0] = CLASSES.index("foreign")
    classes[frames.flags & ERROR > 0] = CLASSES.index("error")
    return classes


def count_classes(frames: Frames, vehicle: VehicleParameters) -> dict[FrameClass, int]:
    """Return how many frames of each class there are, in the order of `CLASSES`."""
    counts = np.bincount(classify(frames, vehicle), minlength=len(CLASSES))
    return dict(zip(CLASSES, counts.tolist(), strict=True))


def is_class(classes: NDArray[np.uint8], name: FrameClass) -> NDArray[np.bool_]:
    """Return where the result of `classify` is one class, `(N,)`."""
    return np.asarray(classes == CLASSES.index(name), np.bool_)
