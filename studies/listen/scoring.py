"""Findings held against the truth of a simulated bus."""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from omnimate.listen.learning import Findings
from omnimate.listen.signals import SURE_PROBABILITY, LearnedSignal
from studies.listen.devices import Bus, FieldTruth

Words = NDArray[np.uint64]

SAME_KIND = {
    "bytes": {"number", "bits", "float", "cannot tell", "time", "counter"},
    "time": {"time", "number"},
    "counter": {"counter", "number"},
    "noise": {"number", "bits", "cannot tell"},
}
FOREIGN = (0, 0)  # the object of what no object dictionary has


@dataclass
class Score:
    """Counts of signals."""

    HEAD = " signals   right  not sure  sure, wrong  bounds    kind  no sign  bounds by READ"
    counts: Counter[str] = field(default_factory=Counter)  # by what was said of them

    def add(self, other: Score) -> None:
        self.counts.update(other.counts)

    @property
    def signals(self) -> int:
        """Number of signals that changed."""
        return self.counts["signals"]

    @property
    def right(self) -> float:
        """Share of signals with everything right."""
        return self.counts["right"] / max(self.signals, 1)

    @property
    def sure_and_wrong(self) -> float:
        """Share of signals of which something wrong was said as certain."""
        return self.counts["sure and wrong"] / max(self.signals, 1)

    def row(self) -> str:
        shares = [
            self.counts[name] / max(self.signals, 1)
            for name in ("not sure", "bounds", "kind", "counter without sign", "bounds by READ")
        ]
        return (
            f"{self.signals:8} {self.right:7.1%} {shares[0]:9.1%} {self.sure_and_wrong:12.2%} "
            f"{shares[1]:7.1%} {shares[2]:7.1%} {shares[3]:8.1%} {shares[4]:15.1%}"
        )


def score_bus(bus: Bus, findings: Findings, *, foreign: bool = False) -> Score:
    """Return how many signals of a bus are right, of nodes or of others."""
    score = Score()
    learned = {signal.message.can_id: signal for signal in findings.messages}
    for cob_id, pdo in bus.pdos.items():
        rows = bus.frames.can_id == cob_id
        if np.count_nonzero(rows) < 2 or not pdo.fields or foreign != (pdo.node == 0):
            continue
        frames = bus.frames.select(rows)
        words = frames.words()
        if pdo.is_big_endian:
            words = frames.data.view(">u8").reshape(-1).astype(np.uint64) >> np.uint64(64 - 8 * pdo.length)
        peer = read_boundaries(words, pdo.length)
        signals = learned[cob_id].signals if cob_id in learned else ()
        for truth in pdo.fields:
            column = words >> np.uint64(truth.start) & np.uint64((1 << truth.bits) - 1)
            if np.all(column == column[0]):
                continue
            score.counts.update(judged(truth, column, signals))
            score.counts["bounds by READ"] += (truth.start, truth.bits) in peer
    return score


def read_boundaries(words: Words, length: int) -> set[tuple[int, int]]:
    """Return the fields that READ finds in little-endian data, as first bits and widths."""
    flips = words[1:] ^ words[:-1]
    rates = [float(np.mean(flips >> np.uint64(bit) & np.uint64(1))) for bit in range(8 * length)]
    sizes = [math.ceil(math.log10(rate)) if rate else -math.inf for rate in rates]
    starts = [0] + [bit for bit in range(1, 8 * length) if sizes[bit] > sizes[bit - 1]] + [8 * length]
    return {(start, end - start) for start, end in itertools.pairwise(starts)}


def judged(truth: FieldTruth, column: Words, signals: Sequence[LearnedSignal]) -> Iterator[str]:
    """Return what was said of a signal, as the counts that it adds to."""
    yield "signals"
    signals = [s for s in signals if s.is_big_endian == truth.is_big_endian or s.bits <= 8]
    hit = next((s for s in signals if (s.start, s.bits) == (truth.start, truth.bits)), None)
    if hit is None and truth.object == FOREIGN:  # spare bits above a signal belong to nothing
        hit = next((s for s in signals if s.start == truth.start and reads_the_same(s, column)), None)
    if hit is None:
        touching = [
            s
            for s in signals
            if s.kind != "constant" and s.start < truth.start + truth.bits and truth.start < s.start + s.bits
        ]
        yield (
            "sure and wrong"
            if any(s.boundaries_probability >= SURE_PROBABILITY for s in touching)
            else "not sure"
        )
        return
    yield "bounds"
    is_right_kind = hit.kind in SAME_KIND.get(truth.kind, {truth.kind})
    if is_right_kind:
        yield "kind"
    # Both signs read the same numbers where the highest bit was never set; a counter's differences always.
    is_alike = not np.any(column >> np.uint64(truth.bits - 1)) or bool(hit.counter_range)
    has_sign = hit.kind in {"number", "counter", "time"} and not is_alike
    counts = truth.role.startswith("position") or bool({hit.kind, truth.kind} & {"counter", "time"})
    if has_sign and hit.signed is None and counts:
        yield "counter without sign"
        has_sign = False
    is_wrong_sign = has_sign and hit.signed is not None and hit.signed != truth.signed
    is_wrong_kind = not is_right_kind and hit.is_sure
    if is_wrong_sign or is_wrong_kind:
        yield "sure and wrong"
    elif not is_right_kind or (has_sign and hit.signed is None):
        yield "not sure"
    else:
        yield "right"


def reads_the_same(signal: LearnedSignal, column: Words) -> bool:
    """Return whether a signal has the values of a column of frames."""
    return len(signal.raw) == len(column) and bool(np.all(signal.raw == column))


def score_meanings(bus: Bus, findings: Findings) -> Iterator[str]:
    """Yield what was said of the wheels, trucks, joints and speeds of a robot."""
    truth = {(pdo.cob_id, field.start): field for pdo in bus.pdos.values() for field in pdo.fields}

    def of(signal: LearnedSignal) -> FieldTruth | None:
        return truth.get((signal.can_id, signal.start))

    wheels = findings.kinematics.wheels
    measured = {
        field.role for field in truth.values() if field.role.startswith("position") and "." in field.role
    }
    names = []
    for wheel in wheels:
        field_ = of(wheel.shaft.position.signal)
        role = field_.role if field_ is not None else "nothing"
        names.append(role)
        if field_ is None or role not in measured:
            yield "wheels: wrong"
        else:
            yield "wheels: right"
            yield f"wheels: direction {_said(bool(wheel.forward), wheel.forward == field_.sign)}"
    not_stated = "wheels: not stated" + (" (robot with no wheel stated)" if not wheels else "")
    yield from [not_stated] * len(measured - set(names))
    if len(wheels) == 4 and measured.issuperset(names):
        trucks = _grouped((wheel.truck, name[9]) for wheel, name in zip(wheels, names, strict=True))
        sides = _grouped((wheel.side, name[11]) for wheel, name in zip(wheels, names, strict=True))
        front = findings.kinematics.front
        yield f"trucks: {_said(None not in trucks, [*map(len, trucks.values())] == [1, 1])}"
        if None not in trucks:
            yield f"sides: {_said(None not in sides, [*map(len, sides.values())] == [1, 1])}"
            yield f"truck in front: {_said(front is not None, trucks.get(front) == {'a'})}"
    first = of(wheels[0].shaft.position.signal) if wheels else None
    for wheel, name in zip(wheels, names, strict=True):
        field_ = of(wheel.shaft.position.signal)
        if first and field_ and name in measured and wheel is not wheels[0] and names[0] in measured:
            exact = field_.sign * field_.scale / first.sign / first.scale
            off = abs(wheel.ratio / exact - 1)
            word = "told" if wheel.has_exact_ratio else "about"
            yield f"ratios {word}: within 2 %" if off < 0.02 else f"ratios {word}: wrong by more"
    for other in findings.kinematics.others:
        field_ = of(other.shaft.position.signal)
        role = "" if field_ is None else field_.role
        kind = (
            "joint" if role.startswith("position joint") else "slider" if role == "position link" else "other"
        )
        yield f"{kind}: {_said(other.role != 'cannot tell', other.role.startswith(kind))}"
    yield from _score_speeds(findings, of)
    yield from _score_sending(bus, findings)


def _said(is_stated: bool, is_right: bool) -> str:
    return ("right" if is_right else "wrong") if is_stated else "not stated"


def _grouped(pairs: Iterable[tuple[int | None, str]]) -> dict[int | None, set[str]]:
    """Return the true letters of wheels by the number that is said of them, None where none is."""
    groups: dict[int | None, set[str]] = defaultdict(set)
    for number, letter in pairs:
        groups[number].add(letter)
    return groups


def _score_speeds(findings: Findings, of: Callable[[LearnedSignal], FieldTruth | None]) -> Iterator[str]:
    for shaft in findings.shafts:
        field_ = of(shaft.position.signal)
        for signal, factor, _ in shaft.rates:
            rate = of(signal)
            if rate is None or field_ is None:
                continue
            of_same = rate.role.partition(" ")[2] == field_.role.partition(" ")[2]
            if rate.role.startswith("speed") and of_same:
                exact = (
                    rate.sign * rate.scale / field_.sign / field_.scale
                    if field_.role.startswith("position")
                    else 0
                )
                yield "speeds: right" if exact and abs(factor / exact - 1) < 0.05 else "speeds: wrong ratio"
            elif rate.role.startswith("error") and of_same:
                yield "speeds: following error in proportion"
            else:
                yield "speeds: wrong"


def _score_sending(bus: Bus, findings: Findings) -> Iterator[str]:
    for signal in findings.messages:
        pdo = bus.pdos.get(signal.message.can_id)
        if pdo is not None and pdo.cause != "unknown" and signal.sending.cause != "cannot tell":
            cause = signal.sending.cause.lower() == pdo.cause
            right = cause and (pdo.cause != "sync" or signal.sending.every == pdo.every)
            sure = "sure and " if signal.sending.probability >= SURE_PROBABILITY and not right else ""
            yield f"sending: {sure}{'right' if right else 'wrong'}"
