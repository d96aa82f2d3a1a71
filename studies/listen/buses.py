"""A bus of devices of EDS files on a robot that drives about: its frames, and what is true of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.random import Generator

from omnimate.files.logs.frames import Frame, Frames, frames_of
from omnimate.vehicle.se2 import Array
from studies.listen.devices import Bus, Pdo, described, eds_files, foreign_messages, pdos_of
from studies.listen.objects import Shaft

STEP = 0.005  # [s]


def drive(random: Generator, seconds: float, trucks: int) -> tuple[Array, dict[str, Array]]:
    """Return a drive of straights, arcs, turns on the spot and stops.

    It is the times [s], shape `(N,)`, and by channel over them the angles of wheels, forward positive, and of
    joints [rad], and the length of the link [m].
    """
    time = np.arange(0.0, seconds, STEP)
    top = math.exp(random.uniform(math.log(0.15), math.log(2.0)))
    wheelbase = random.uniform(0.25, 0.9)
    speed, turn = commands(random, len(time), top, wheelbase, spot=trucks == 1)
    base = {"a": wheelbase, "b": wheelbase * (1.0 if random.random() < 0.7 else random.uniform(0.9, 1.1))}
    diameter = random.uniform(0.08, 0.4)
    angles = _wheels(speed, turn, "a", base["a"], diameter, random)
    if trucks == 2:
        speed, turn, joint_a, joint_b, link = _follow(random, speed, turn)
        angles |= _wheels(speed, turn, "b", base["b"], diameter, random)
        angles |= {"joint_a": joint_a, "joint_b": joint_b, "link": link}
    return time, angles


def commands(random: Generator, count: int, top: float, wheelbase: float, *, spot: bool) -> Iterator[Array]:
    """Return speed [m/s] and rate of turn [rad/s], each limited in its change."""
    speed, turn = np.zeros(count), np.zeros(count)
    at = 0 if random.random() < 0.5 else int(random.uniform(0.5, 8.0) / STEP)
    kinds = ["straight", "arc", "stop", "back"] + (["spot"] * 2 if spot else [])
    shares = random.dirichlet(np.ones(len(kinds))) + 0.08
    shares[0] += 0.3
    shares /= shares.sum()
    while at < count:
        end = at + int(random.uniform(1.0, 8.0) / STEP)
        kind = random.choice(kinds, p=shares)
        going = top * random.uniform(0.3, 1.0)
        if kind == "straight":
            speed[at:end] = going
        elif kind == "back":
            speed[at:end] = -0.5 * going
        elif kind == "arc":
            speed[at:end] = going
            turn[at:end] = going / random.uniform(1.5, 8.0) / wheelbase / 2 * random.choice([-1, 1])
        elif kind == "spot":
            turn[at:end] = 2 * going / wheelbase * random.uniform(0.3, 0.8) * random.choice([-1, 1])
        at = end
    rise = random.uniform(0.1, 0.8)  # [s]
    width = max(int(rise / STEP), 3)
    window = np.hanning(width + 2)[1:-1]
    window /= window.sum()
    limit = min(1.2, 1.6 * top / wheelbase)
    turn = np.clip(turn, -limit, limit)
    return (np.convolve(series, window)[:count] for series in (speed, turn))


def _wheels(
    speed: Array, turn: Array, truck: str, base: float, diameter: float, random: Generator
) -> dict[str, Array]:
    radius = {side: diameter / 2 * random.normal(1.0, 0.003) for side in ("left", "right")}
    wobble = np.convolve(random.normal(0, 1, len(speed)), np.ones(40) / 40, "same")
    speed = speed * (1 + 0.01 * wobble)
    rate = {
        "left": (speed - turn * base / 2) / radius["left"],
        "right": (speed + turn * base / 2) / radius["right"],
    }
    return {f"{truck}.{side}": np.cumsum(wheel_rate) * STEP for side, wheel_rate in rate.items()}


def _follow(random: Generator, speed: Array, turn: Array) -> Array:
    """Return speed and rate of turn of the truck behind, both joints, and the link's length."""
    count = len(speed)
    rest = random.uniform(0.5, 1.6)
    gain, pull = random.uniform(0.8, 2.5), random.uniform(0.8, 3.0)
    out = np.zeros((5, count))
    ax, ay, ah, bx, by, bh = rest, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        dx, dy = ax - bx, ay - by
        length, direction = math.hypot(dx, dy), math.atan2(dy, dx)
        joint_a = math.remainder(ah - direction, 2 * math.pi)
        joint_b = math.remainder(bh - direction, 2 * math.pi)
        v = speed[n] * math.cos(joint_a) + pull * (length - rest)
        w = -gain * joint_b + speed[n] * math.sin(joint_a) / rest * 0.5
        out[:, n] = v, w, joint_a, joint_b, length
        ah += turn[n] * STEP
        ax += speed[n] * math.cos(ah) * STEP
        ay += speed[n] * math.sin(ah) * STEP
        bh += w * STEP
        bx += v * math.cos(bh) * STEP
        by += v * math.sin(bh) * STEP
    return out


SECONDS = 60.0
FOREIGN = 0.3  # share of buses on which others than CANopen devices send, too
DRIVES = {"drive_cia402", "elmo_gold", "maxon_epos2_347717", "pilz_prbt_0_1", "faulhaber_605.3150.71-A"}
ENCODERS = {
    "encoder_cia406",
    "encoder_single_turn_cia406",
    "encoder_linear_cia406",
    "cia406_profile_kacanopen",
}


def make_bus(eds: str, seed: int, path: Path) -> Bus:
    """Return a bus of a robot whose wheels have devices of an EDS file, with other devices next to them."""
    files = eds_files() | {eds: path}
    random = np.random.default_rng([seed, *eds.encode()])
    trucks = 1 if random.random() < 0.55 else 2
    time, angles = drive(random, SECONDS + 2, trucks)
    wheels = [name for name in angles if "." in name]
    boots = bool(random.random() < 0.4)
    session = float(random.uniform(2.5, 5.0)) if boots else None
    shafts = {name: Shaft(random, time, angle, name) for name, angle in angles.items()}
    for wheel in wheels:  # the wheels of a robot are alike, seldom mirrored or of another resolution
        if random.random() < 0.85:
            shafts[wheel].scale = shafts["a.left"].scale
    mirrored = random.random() < 0.6
    for wheel in wheels:
        if random.random() < 0.9:
            shafts[wheel].sign = -1 if mirrored and wheel.endswith("left") else 1
    ids = iter(random.permutation(np.arange(1, 100)).tolist())
    nodes: list[int] = []
    pdos: dict[int, Pdo] = {}

    def add(name: str, carried: Sequence[Shaft]) -> None:
        node = next(ids)
        nodes.append(node)
        for pdo in pdos_of(random, files[name], node, carried, session):
            pdos[pdo.cob_id] = pdo

    measures = eds in DRIVES | ENCODERS or {0x6064, 0x6004} & {index for index, _ in described(files[eds])[0]}
    moving = eds if measures else str(random.choice(["drive_cia402", "encoder_cia406"]))
    double = moving == "encoder_cia406" and random.random() < 0.4
    for truck in "ab"[:trucks]:
        pair = [shafts[f"{truck}.left"], shafts[f"{truck}.right"]]
        for carried in [pair] if double else [[shaft] for shaft in pair]:
            add(moving, carried)
    if trucks == 2:
        for name in ("joint_a", "joint_b"):
            add("encoder_single_turn_cia406", [shafts[name]])
        add("encoder_linear_cia406", [shafts["link"]])
    if not measures:
        add(eds, [])
    _schedule(random, pdos, sync := float(random.choice([0.005, 0.01, 0.01, 0.02, 0.02, 0.025, 0.05])))
    if random.random() < FOREIGN:
        pdos |= {message.cob_id: message for message in foreign_messages(random)}
    has_sync = any(pdo.cause == "sync" for pdo in pdos.values())
    return Bus(_frames(random, pdos, nodes, sync if has_sync else None, boots), pdos, boots)


def _schedule(random: Generator, pdos: dict[int, Pdo], sync: float) -> None:
    synchronous = random.random() < 0.8
    for pdo in pdos.values():
        if synchronous and random.random() < 0.8:
            pdo.cause, pdo.every = "sync", int(random.choice([1, 1, 1, 1, 2, 5]))
        elif random.random() < 0.7:
            pdo.cause, pdo.every = "timer", float(random.choice([0.01, 0.02, 0.05, 0.1, 0.2]))
        else:
            pdo.cause, pdo.every = "change", float(random.choice([0.005, 0.01, 0.03]))
        if sync * pdo.every > 0.25 and pdo.cause == "sync":
            pdo.every = 1


def _frames(
    random: Generator, pdos: dict[int, Pdo], nodes: list[int], sync: float | None, boots: bool
) -> Frames:
    rows: list[Frame] = []
    started = 1.8 if boots else 0.0
    syncs = np.arange(0.001, SECONDS, sync) if sync else np.empty(0)
    if sync:
        syncs = syncs + random.normal(0, 0.00003, len(syncs))
        counter = random.random() < 0.15
        rows += [Frame(float(t), 0x80, bytes([n % 240 + 1]) if counter else b"") for n, t in enumerate(syncs)]
    lost = 0.001 if random.random() < 0.2 else 0.0
    for rank, pdo in enumerate(sorted(pdos.values(), key=lambda pdo: pdo.cob_id)):
        times, sampled = _times(random, pdo, syncs, rank, started)
        columns = [entry.values(sampled) for entry in pdo.fields if entry.values is not None]
        words = [
            sum(int(column[n]) << entry.start for column, entry in zip(columns, pdo.fields, strict=True))
            for n in range(len(times))
        ]
        last = None
        keep = random.random(len(times)) >= lost
        for n, (time, word) in enumerate(zip(times.tolist(), words, strict=True)):
            if pdo.cause == "change" and word == last:
                continue
            last = word
            if keep[n]:
                data = word.to_bytes(pdo.length, "big" if pdo.is_big_endian else "little")
                rows.append(Frame(time, pdo.cob_id, data))
    for node in nodes:
        period = float(random.choice([0.1, 0.5, 1.0]))
        begin = random.uniform(0.05, 0.6)
        if boots:
            rows.append(Frame(begin, 0x700 + node, b"\0"))
        for time in np.arange(begin + period, SECONDS, period) + random.normal(0, 0.0005):
            state = 0x7F if boots and time < started else 5
            rows.append(Frame(float(time), 0x700 + node, bytes([state])))
        if random.random() < 0.15:
            rows.append(Frame(random.uniform(10, 50), 0x80 + node, bytes.fromhex("1081010000000000")))
        if boots:
            _configure(random, rows, node, pdos, begin)
    if boots:
        rows += [Frame(started, 0, b"\x01\x00")]
    if random.random() < 0.2:
        rows += [Frame(float(t), 0x100, bytes(6)) for t in np.arange(0.3, SECONDS, 1.0)]
    rows.sort(key=lambda row: row.time)
    return frames_of(Frame(1.7e9 + row.time, *row[1:]) for row in rows)


def _times(random: Generator, pdo: Pdo, syncs: Array, rank: int, started: float) -> tuple[Array, Array]:
    """Return when the PDO is sent and when its values are taken [s]."""
    if pdo.cause == "sync":
        every = int(pdo.every)
        at = syncs[int(random.integers(0, every)) :: every]
        at = at[at >= started]
        return at + 0.0003 + 0.00013 * rank + np.abs(random.normal(0, 0.00004, len(at))), at
    step = pdo.every * random.normal(1, 0.002)
    at = np.arange(started + random.uniform(0, pdo.every), SECONDS, step)
    at = at + np.abs(random.normal(0, 0.0001, len(at)))
    return at, at


def _configure(random: Generator, rows: list[Frame], node: int, pdos: dict[int, Pdo], begin: float) -> None:
    """Write the mappings of a node's PDOs as CiA 301 (7.5.2.38) asks for, or read them."""
    time = begin + 0.05
    if random.random() < 0.25:  # this node is not configured
        return
    writes = random.random() < 0.7

    def transfer(index: int, subindex: int, value: int, size: int) -> None:
        nonlocal time
        head = index.to_bytes(2, "little") + bytes([subindex])
        code = {1: 0x0F, 2: 0x0B, 4: 0x03}[size]
        body = value.to_bytes(size, "little").ljust(4, b"\0")
        asks = bytes([0x20 | code]) + head + body if writes else b"\x40" + head + bytes(4)
        answers = b"\x60" + head + bytes(4) if writes else bytes([0x40 | code]) + head + body
        rows.append(Frame(time, 0x600 + node, asks))
        rows.append(Frame(time + 0.0008, 0x580 + node, answers))
        time += 0.003

    if not writes:
        transfer(0x1000, 0, 0x00020192, 4)
    for pdo in pdos.values():
        if pdo.node != node or (pdo.is_receive and random.random() < 0.5):
            continue
        base = 0x1400 if pdo.is_receive else 0x1800
        transfer(base + pdo.number, 1, pdo.cob_id | 0x80000000 if writes else pdo.cob_id, 4)
        transfer(base + pdo.number, 2, int(pdo.every) if pdo.cause == "sync" else 255, 1)
        if writes:
            transfer(base + 0x200 + pdo.number, 0, 0, 1)
        for number, entry in enumerate(pdo.fields, start=1):
            transfer(
                base + 0x200 + pdo.number,
                number,
                entry.object[0] << 16 | entry.object[1] << 8 | entry.bits,
                4,
            )
        transfer(base + 0x200 + pdo.number, 0, len(pdo.fields), 1)
        if writes:
            transfer(base + pdo.number, 1, pdo.cob_id, 4)
