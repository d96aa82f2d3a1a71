"""How much of an unknown bus `omnimate listen` learns right, and how often it is sure and wrong.

Robots drive about for a minute with devices of all EDS files (those of `../shared/data/eds` and of the
simulated vehicle) beside real logs whose layout is known. A signal counts as right when its boundaries, byte
order and kind are those of the device, and its sign is, or no value that was seen tells the sign. It is sure
and wrong when one of these is said with P of at least 0.99, and is not so. Signals that never changed
are left out: there is nothing to learn from them. Where nothing tells the sign of a counter, `cannot tell` is
right, and counted once more: unwrapped, it is the same number either way.

The failures of all EDS files were looked at while the method was made, with seeds below SEED. Seeds from
there on are fresh; --eds takes the EDS files of a folder instead, such as files that are not here.

Peer: READ (Marchetti and Stabili, IEEE Trans. on Information Forensics and Security 14, 2019), which puts
boundaries where the rate of flips of a bit falls by an order of magnitude; it is told the byte order.

Usage: python -m studies.listen.accuracy [buses per EDS file] [first seed] [--eds FOLDER]
"""

from __future__ import annotations

import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

from omnimate.driver.canopen.mapped_signals import mapped_signals
from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.frames import Frames
from omnimate.files.logs.seen_mapping import seen_objects
from omnimate.listen.learning import learn_bus
from omnimate.vehicle.file import load_vehicle
from studies.benchmark import options
from studies.listen.buses import make_bus
from studies.listen.devices import ROOT, Bus, FieldTruth, Pdo, described, eds_files
from studies.listen.scoring import Score, score_bus, score_meanings

DATA = ROOT.parent / "shared" / "data"
MINUTE = 60.0
# Of a car: message, first bit as DBC files count, width, signed; from the public opendbc file
# toyota_2017_ref_pt.dbc, big-endian. Trailing bytes that its log lost do not matter to them.
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
        for device in vehicle.encoders:
            pdo = pdos.setdefault(
                device.cob_id, Pdo(device.cob_id, device.node, 0, is_receive=False, cause="unknown")
            )
            truth = FieldTruth(
                device.start_bit, device.bits, device.signed, "number", f"position {device.channel}",
                device.sign, abs(1.0 / device.scale), (0x6004, 0),
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


BUSES, SEED = 4, 90_000
RIGHT, SURE_AND_WRONG = 0.95, 0.01


def main() -> int:
    """Print the tables; 1 where a figure is worse than what is wanted."""
    asked = options(__doc__, {"count": BUSES, "seed": SEED}, eds=None)
    count, seed = asked.count, asked.seed
    files = eds_files() if asked.eds is None else eds_files((Path(asked.eds),))
    groups: dict[str, Score] = defaultdict(Score)
    made: Counter[str] = Counter()
    given: Counter[str] = Counter()
    for name, path in files.items():
        if not described(path)[0]:
            print(f"{name}: no object that can be mapped")
            continue
        print(f"{name} ...", file=sys.stderr, flush=True)
        for number in range(seed, seed + count):
            bus = make_bus(name, number, path)
            boot = "boot-up seen" if bus.boots else "boot-up not seen"
            ask(bus, groups, (name, "all simulated", boot), made)
    for log in robots():
        ask(log, groups, ("28 given robots",), given)
    log = car()
    groups["a car (RAV4)"].add(score_bus(log, learn_bus(log.frames), foreign=True))
    print(f"{'':26} {Score.HEAD}")
    for group, score in groups.items():
        print(f"{group:26} {score.row()}")
    print(f"\n{'what moves':44} simulated   given")
    for name in sorted({*made, *given}):
        print(f"{name:44} {made[name]:9} {given[name]:7}")
    wanted = [groups[name] for name in ("all simulated", "28 given robots")]
    return 0 if all(row.right >= RIGHT and row.sure_and_wrong <= SURE_AND_WRONG for row in wanted) else 1


def ask(bus: Bus, groups: dict[str, Score], names: tuple[str, ...], meanings: Counter[str]) -> None:
    """Learn a bus, and add what is right to its groups."""
    seen = seen_objects(bus.frames)
    findings = learn_bus(bus.frames, mapped_signals(seen, {}) if seen else {})
    for name in names:
        groups[name].add(score_bus(bus, findings))
    groups["not CANopen"].add(score_bus(bus, findings, foreign=True))
    meanings.update(score_meanings(bus, findings))


if __name__ == "__main__":
    sys.exit(main())
