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
from pathlib import Path

from omnimate.driver.canopen.mapped_signals import mapped_signals
from omnimate.files.logs.seen_mapping import seen_objects
from omnimate.listen.learning import learn_bus
from studies.benchmark import options
from studies.listen.buses import make_bus
from studies.listen.devices import Bus, described, eds_files
from studies.listen.recorded import car, robots
from studies.listen.scoring import Score, score_bus, score_meanings

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
    return 0 if all(each.right >= RIGHT and each.sure_and_wrong <= SURE_AND_WRONG for each in wanted) else 1


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
