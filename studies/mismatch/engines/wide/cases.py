"""The cases of the wide world: what is concealed, how strong it is, and what looks like it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from studies.mismatch.engines.engine import Floor
from studies.mismatch.engines.faults import FARTHER
from studies.mismatch.engines.laws import altered
from studies.mismatch.engines.programmes import PROGRAMMES, wide_programme
from studies.mismatch.engines.rivals import alike, measured_label
from studies.mismatch.engines.scene import SEEDS, START, Scene, drawn_parameters
from studies.mismatch.engines.strength import Drive, Noise, Ruler, left_of, rates, residual
from studies.mismatch.engines.vocabulary import (
    CLEAR,
    JOINTS,
    LINKAGE,
    VOCABULARY,
    WHEELS,
    Array,
    case_label,
    set_bump_times,
)
from studies.mismatch.engines.wide.robots import secondary, wide_measuring, wide_robot, within
from studies.mismatch.engines.writing import Log, Measuring, Robot, seen, write

ROUGHNESS, WAVES = (5e-5, 2e-3), (0.05, 0.5)  # [m/sqrt(m)], [m]
STRETCH = (0.4, 2.5)  # factor on the usual size of a fault
WEAK, ATTEMPTS = 0.1, 6  # share of faults of any strength; draws for a clear one of the others
KINDS = {"null": 0.4, "single": 0.35, "multi": 0.1, "unknown": 0.15}  # shares of the cases
DROPPED = (0.0, 0.0, 0.002, 0.02)  # share of frames that are lost
BEYOND = 0.3  # share of an unnamed fault's strength that every curve in one quantity must leave, if possible
FINE = 4096  # counts in one of the robot's, where a change is measured
BENT = 1.2  # [rad] of a joint beyond which a drive is drawn again
UNNAMED = {
    "warmth": WHEELS,
    "load transfer": ("a", "b"),
    "field": ("a", "b"),
    "wind-up": ("a", "b"),
    "swing": LINKAGE,
}


Fault = tuple[str, str, dict[str, Any]]  # effect, component, parameters


@dataclass(frozen=True, slots=True)
class _Hidden:
    """A fault to conceal, and the whitened change `(K,)` of what is read."""

    fault: Fault
    change: Array

    @property
    def strength(self) -> float:
        return float(np.linalg.norm(self.change))


@dataclass(frozen=True, slots=True)
class _Healthy:
    drive: Drive  # the drive as recorded, with the poses as they are
    ruler: Ruler  # the ruler of it, with the noise of the poses
    # its residual on a smooth floor; empty where none of the faults is without a law
    smooth: Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class _Setting:
    """What is drawn before anything is concealed."""

    scene: Scene
    measuring: Measuring | None
    kind: str

    @property
    def robot(self) -> Robot:
        return self.scene.robot

    @property
    def length(self) -> float:
        legs = [leg for _, lap in self.scene.laps for leg in lap]
        return sum(duration for _, _, duration in legs) + 2.4 * len(self.scene.laps)


def make(
    folder: Path,
    seed: int,
    number: int,
    measuring: Measuring | None = None,
    *,
    faultless: bool = False,
    kinds: Mapping[str, float] = KINDS,
) -> dict[str, Any]:
    """Write the recording of a case into a folder, and return its label; `kinds` are the kinds' shares."""
    chance = np.random.default_rng([seed, number, 5])
    kind = "null" if faultless else str(chance.choice(list(kinds), p=list(kinds.values())))
    while True:
        setting = _setting(chance, seed, number, dense=kind == "unknown")
        driven = setting.scene.driven([])
        if not _is_driveable(setting.robot, driven):
            continue
        healthy = _healthy(setting, driven, chance, kind)
        hidden = _clear(chance, setting, kind, healthy)
        faults = [setting.scene.fault(*fault.fault) for fault in hidden if fault.fault[1] != "poses"]
        driven = setting.scene.driven(faults)
        if _is_driveable(setting.robot, driven):
            break
    measuring = measuring or _aged(setting.measuring, [fault.fault for fault in hidden])
    labels = [_label(fault, setting, driven, healthy) for fault in hidden]
    write(folder / "1", setting.robot, driven, measuring, float(chance.choice(DROPPED)), chance)
    return {
        **case_label(kind, labels, weak=any(fault.strength < CLEAR for fault in hidden)),
        "poses": "none" if measuring is None else f"{measuring.period:g} s", "drive": setting.kind,
        "trucks": setting.robot.trucks, "period": setting.robot.period, "secondary": secondary(measuring),
        "roughness": setting.scene.floor.roughness,
    }  # fmt: skip


def make_nameless(folder: Path, seed: int, number: int, *, faultless: bool = False) -> dict[str, Any]:
    """Write the recording of a case of physics without a name into a folder, and return its label."""
    return make(folder, seed, number, faultless=faultless, kinds={"unknown": 1.0})


def _healthy(setting: _Setting, driven: Log, chance: Generator, kind: str) -> _Healthy:
    noisy, drive = (seen(setting.robot, driven, setting.measuring, source) for source in (chance, None))
    ruler = Ruler(Noise.of([residual(noisy)]), (residual(drive),))
    return _Healthy(drive, ruler, _smooth(setting, []) if kind == "unknown" else {})


def _clear(chance: Generator, setting: _Setting, kind: str, healthy: _Healthy) -> list[_Hidden]:
    """Return what to conceal: in most cases what this drive shows clearly, and no curve can follow."""
    hidden: list[_Hidden] = []
    for _ in range(1 if chance.random() < WEAK else ATTEMPTS):
        hidden = [
            _Hidden(fault, _change(fault, setting, healthy)) for fault in _faults(chance, setting, kind)
        ]
        if all(one.strength >= CLEAR and _is_beyond(one, healthy) for one in hidden):
            break
    return hidden


def _is_beyond(hidden: _Hidden, healthy: _Healthy) -> bool:
    """Say whether a fault has a name, or is no curve in one quantity."""
    return hidden.fault[0] != "unknown" or outside(hidden.change, healthy.drive, healthy.ruler) >= BEYOND


def _setting(chance: Generator, seed: int, number: int, *, dense: bool) -> _Setting:
    trucks = 1 if chance.random() < 0.35 else 2
    robot, kind = wide_robot(chance, trucks), str(chance.choice(list(PROGRAMMES)))
    laps = wide_programme(chance, kind, trucks, robot.period)
    floor = Floor(within(chance, ROUGHNESS), 0.0 if chance.random() < 0.5 else within(chance, WAVES))
    start = START + 1000.0 * ((10_000 * seed + number) % SEEDS)
    return _Setting(
        Scene(robot, laps, (), (), floor, start, np.random.default_rng([seed, number, 6])),
        wide_measuring(chance, trucks, dense=dense and trucks == 1),
        kind,
    )


def _faults(chance: Generator, setting: _Setting, kind: str) -> list[Fault]:
    """Return faults, drawn at random."""
    count = {"null": 0, "multi": 2}.get(kind, 1)
    hidden: dict[str, Fault] = {}
    while len(hidden) < count:
        effect, note = (str(chance.choice(list(VOCABULARY))), "")
        if kind == "unknown":
            effect, note = "unknown", str(chance.choice(FARTHER))
        places = _places(effect, note, setting)
        if not places or effect in hidden:
            continue
        component = str(chance.choice(places))
        start, length = setting.scene.start, setting.length
        drawn = drawn_parameters(chance, effect, start, length, note, within(chance, STRETCH))
        if effect == "count_loss":
            fastest = max(abs(leg[0]) for _, lap in setting.scene.laps for leg in lap)
            drawn["above"] = float(chance.uniform(0.3, 0.8)) * fastest
        if component not in {place for _, place, _ in hidden.values()}:
            hidden[effect] = effect, component, drawn
    return list(hidden.values())


def _places(effect: str, note: str, setting: _Setting) -> list[str]:
    """Return the components on which an effect can act and be seen."""
    robot, measuring = setting.robot, setting.measuring
    dense = measuring is not None and measuring.period > 0.0
    if effect == "floor_slope" and not dense:
        return []
    places = list(UNNAMED[note] if effect == "unknown" else VOCABULARY[effect].components)
    if effect in {"latency", "clock_drift"}:
        places = [*JOINTS, "link", *WHEELS] + (["poses"] if dense else [])
    components = {*robot.channels, *"ab"[: robot.trucks], "poses"}
    return [place for place in places if place in components]


def _aged(measuring: Measuring | None, hidden: list[Fault]) -> Measuring | None:
    """Return the measuring with the faults of the poses in it."""
    for effect, component, parameters in hidden:
        if component == "poses" and measuring is not None:
            if effect == "latency":
                measuring = replace(measuring, delay=parameters["delay"])
            else:
                measuring = replace(measuring, fast=parameters["rate"])
    return measuring


def _is_driveable(robot: Robot, driven: Log) -> bool:
    """Say whether the trucks stayed in line, and no link was torn."""
    if robot.trucks == 1:
        return True
    gap = driven.poses[:, 0, :2] - driven.poses[:, 1, :2]
    along = np.arctan2(gap[:, 1], gap[:, 0])
    joints = np.abs(np.angle(np.exp(1j * (driven.poses[:, :, 2] - along[:, None]))))
    return bool(joints.max() < BENT and np.abs(np.hypot(*gap.T) - robot.length).max() < 0.3 * robot.length)


def _smooth(setting: _Setting, faults: Sequence[Fault]) -> Mapping[str, Array]:
    """Return the residual of a drive with faults on a smooth floor, with sensors that do not scatter.

    Their counts are so fine that a change holds no rounding, which no curve could follow.
    """
    fine = tuple(replace(device, resolution=FINE * device.resolution) for device in setting.robot.devices)
    robot = replace(setting.robot, jitter=0.0, devices=fine)
    scene = replace(setting.scene, robot=robot, floor=Floor(0.0, 0.0))
    driven = scene.driven([scene.fault(*fault) for fault in faults])
    return residual(seen(robot, driven, setting.measuring, None))


def _change(fault: Fault, setting: _Setting, healthy: _Healthy) -> Array:
    """Return the whitened change by a fault: by its law, or by drives on a smooth floor where it has none."""
    if fault[0] != "unknown":
        return healthy.ruler.change([altered(healthy.drive, *fault)])
    with_it, without = _smooth(setting, [fault]), healthy.smooth
    return healthy.ruler.noise.whitened([{part: with_it[part] - without[part] for part in without}])


def _label(hidden: _Hidden, setting: _Setting, driven: Log, healthy: _Healthy) -> dict[str, Any]:
    """Return the label of a fault, with its strength and what this drive cannot tell from it."""
    effect, component, parameters = hidden.fault
    others = alike(hidden.change, effect, component, parameters, [healthy.drive], healthy.ruler)
    labelled = measured_label(effect, component, parameters, hidden.strength, others)
    if effect == "unknown":
        labelled["kind"] = parameters["kind"]
        labelled["outside"] = round(outside(hidden.change, healthy.drive, healthy.ruler), 3)
    if effect == "bump":
        set_bump_times(labelled, driven.time, driven.counts[:, setting.robot.channels.index(component)])
    return labelled


KNOTS = 7  # of a curve, evenly spaced in the quantity's quantiles


def outside(change: Array, drive: Drive, ruler: Ruler) -> float:
    """Return the share of a change `(K,)` that the best curve in one quantity leaves, 0 to 1.

    A curve may scale the way of a wheel, move a truck to the left or turn it per way, or be added to a
    reading of the linkage.
    """
    whole = float(np.linalg.norm(change))
    curves = _curves(drive) if whole > 0.0 else ()
    lefts = (left_of(change, [ruler.change([term]) for term in curve]) / whole for curve in curves)
    return min(lefts, default=0.0)


def _curves(drive: Drive) -> Iterator[list[Drive]]:
    """Yield, for each curve, the drives with one of its knots raised by a little."""
    for quantity in _quantities(drive):
        knots = _knots(quantity)
        for wheel in range(2 * drive.trucks):
            yield [_scaled(drive, wheel, knot) for knot in knots]
        for truck in range(drive.trucks):
            for axis in (1, 2):
                yield [_moved(drive, truck, axis, knot) for knot in knots]
        for channel in range(drive.reading.shape[1]):
            yield [_shown(drive, channel, knot) for knot in knots]


def _quantities(drive: Drive) -> Iterator[Array]:
    """Yield what a curve may depend on, at each step, `(N - 1,)`."""
    yield drive.time[1:]
    for truck in range(drive.trucks):
        way = drive.way[:, 2 * truck : 2 * truck + 2].mean(axis=1)
        speed, acceleration = rates(way, drive.time)
        path = drive.path(truck)[1:]
        yield from (speed, np.abs(speed), acceleration, way[1:])
        yield from (rates(drive.path(truck)[:, 2], drive.time)[0], *path.T)
        yield np.mod(path[:, 2], 2.0 * np.pi)
    for wheel in range(len(WHEELS[: 2 * drive.trucks])):
        yield np.mod(drive.way[1:, wheel] / drive.radius[wheel], 2.0 * np.pi)
    yield from drive.reading[1:].T


def _knots(quantity: Array) -> list[Array]:
    """Return hats `(N - 1,)` over the range of a quantity, which sum to one."""
    places = np.unique(np.quantile(quantity, np.linspace(0.0, 1.0, KNOTS)))
    if len(places) < 2:
        return [np.ones_like(quantity)]
    return [np.interp(quantity, places, row) for row in np.eye(len(places))]


def _scaled(drive: Drive, wheel: int, knot: Array) -> Drive:
    way = drive.way[:, wheel]
    return drive.with_way(wheel, way + np.concatenate(([0.0], np.cumsum(1e-3 * knot * np.diff(way)))))


def _moved(drive: Drive, truck: int, axis: int, knot: Array) -> Drive:
    more = np.zeros((len(knot), 3))
    more[:, axis] = 1e-3 * knot * np.abs(drive.twist(truck)[:, 0])
    return drive.with_more(truck, more)


def _shown(drive: Drive, channel: int, knot: Array) -> Drive:
    return drive.with_reading(channel, drive.reading[:, channel] + 1e-3 * np.concatenate((knot[:1], knot)))
