"""Logs that were not made here, with what is known of them: 28 robots of another simulator, and a car.

The car's signals are those of the public opendbc file toyota_2017_ref_pt.dbc; the 16 bits of each are
big-endian. Trailing bytes that its log lost do not matter to them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.frames import Frames
from omnimate.vehicle.file import load_vehicle
from studies.listen.devices import ROOT, Bus, FieldTruth, Pdo

DATA = ROOT.parent / "shared" / "data"
MINUTE = 60.0
# Message, first bit as DBC files count, width, signed.
CAR = (
    (0x0AA, 7, 16, False), (0x0AA, 23, 16, False), (0x0AA, 39, 16, False), (0x0AA, 55, 16, False),
    (0x024, 1, 10, False), (0x024, 17, 10, False), (0x024, 33, 10, False),
    (0x025, 3, 12, True), (0x025, 35, 12, True), (0x0B4, 47, 16, False),
)  # fmt: skip


def robots() -> Iterator[Bus]:
    """Yield the first minute of each robot's log."""
    for path in sorted(DATA.glob("concealed*/*/1")):
        vehicle = load_vehicle(path / "vehicle.toml")
        pdos: dict[int, Pdo] = {}
        for each in vehicle.encoders:
            pdo = pdos.setdefault(
                each.cob_id, Pdo(each.cob_id, each.node, 0, is_receive=False, cause="unknown")
            )
            truth = FieldTruth(
                each.start_bit, each.bits, each.signed, "number", f"position {each.channel}", each.sign,
                abs(1.0 / each.scale), (0x6004, 0),
            )  # fmt: skip
            pdo.fields.append(truth)
        yield Bus(_minute(path / "can.log"), pdos)


def car() -> Bus:
    """Return the car's log, of the 10 signals that its public description names for motion."""
    pdos: dict[int, Pdo] = {}
    for can_id, start, bits, signed in CAR:
        pdo = pdos.setdefault(can_id, Pdo(can_id, 0, 0, is_receive=False, cause="unknown", bytes=8))
        # The highest bit's place in the number that the bytes in the other order make.
        highest = 8 * (7 - start // 8) + start % 8
        truth = FieldTruth(highest - bits + 1, bits, signed, "number", "", 1, 0.0, (0, 0), is_big_endian=True)
        pdo.fields.append(truth)
    path = DATA / "real" / "comma2k19_rav4" / "can_bus0.candump.log.gz"
    return Bus(_minute(path), pdos)


def _minute(path: Path) -> Frames:
    frames = read_log(path).frames
    return frames.select(frames.time < frames.time[0] + MINUTE)
