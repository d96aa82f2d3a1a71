"""Faults of robots in PyBullet, and their sizes as the true motion shows them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.mismatch.engines.bullet.chassis import Chassis
from studies.mismatch.engines.bullet.drive import Box, Hook, Scene
from studies.mismatch.engines.bullet.urdf import (
    Place,
    joint,
    link,
    middle,
    sphere,
    with_links,
    with_moved,
    with_tread,
)
from studies.mismatch.engines.true_motion import (
    Draws,
    Drive,
    before_and_after,
    crossings,
    lost,
    path_of,
    rolling_radius,
    travel_angle,
    turning_base,
    wave,
)
from studies.mismatch.engines.vocabulary import WHEELS

Parameters = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Setting(Draws):
    """What a fault is built into; the healthy robot drives the course on a plane."""

    chassis: Chassis  # the healthy robot


def _unchanged(chassis: Chassis) -> Chassis:
    return chassis


@dataclass(frozen=True, slots=True)
class Fault:
    effect: str  # its name in the vocabulary, or "unknown"
    component: str  # component on which it acts
    # function that returns its parameters, as a drive with the fault on a plane shows them
    measure: Callable[[Drive], Parameters]
    build: Callable[[Chassis], Chassis] = _unchanged  # function that builds it into a robot
    boxes: tuple[Box, ...] = ()  # boxes that it lays on the floor
    hooks: tuple[Hook, ...] = ()  # functions that change the world during the drive
    sensed: Parameters | None = None  # parameters of a fault of an encoder; None where it acts on the motion
    # function that returns the intervals in which it acts [s], of the drive that is recorded
    intervals: Callable[[Drive], list[list[float]]] | None = None


def with_treads(
    chassis: Chassis,
    channel: str,
    radius: float,
    off_axle: Place = (0.0, 0.0, 0.0),
    links: Sequence[str] = (),
) -> Chassis:
    """Return a robot with other treads on the wheels of a channel, or on some links of them."""
    urdf = chassis.urdf
    for name in links or chassis.wheels[channel].links:
        urdf = with_tread(urdf, name, radius, off_axle)
    return replace(chassis, urdf=urdf)


OILY = (0.02, 0.05)  # share of its grip that a tyre keeps on oil
LOADED = (0.5, 1.0)  # mass of a payload over that of the Husky's body, 33 kg; R2D2's is about the same
BOXES, HEIGHTS = 4, (0.05, 0.09)  # on the floor; their heights over the radius of the wheel


def wheel_diameter(at: Setting) -> Fault:
    """Return a larger or smaller tread on the wheels of one encoder."""
    return _diameter(at, (0.003, 0.01), one=False)


def one_tyre(at: Setting) -> Fault:
    """Return a larger or smaller tread on one of the two wheels of a side."""
    return _diameter(at, (0.01, 0.03), one=True)


def _diameter(at: Setting, bounds: tuple[float, float], *, one: bool) -> Fault:
    wheel = at.wheel()
    described = at.chassis.wheels[wheel]
    radius = described.radius * (1.0 + at.sign() * at.chance.uniform(*bounds))
    links = [str(at.chance.choice(described.links))] if one else described.links
    return Fault(
        "wheel_diameter",
        wheel,
        _over_healthy(at, lambda drive: rolling_radius(drive, at.nominal, wheel)),
        lambda chassis: with_treads(chassis, wheel, radius, links=links),
    )


def _over_healthy(at: Setting, size_of: Callable[[Drive], float]) -> Callable[[Drive], Parameters]:
    """Return the function that measures a size of a drive over that of the healthy robot's."""
    return lambda drive: {"ratio": size_of(drive) / size_of(at.healthy)}


def wheel_eccentricity(at: Setting) -> Fault:
    """Return a tread that is mounted off its axle, on the wheel with the encoder."""
    wheel, bearing = at.wheel(), at.chance.uniform(-np.pi, np.pi)
    described, amplitude = at.chassis.wheels[wheel], at.chance.uniform(0.005, 0.015)
    x, y = amplitude * described.radius * np.array([np.cos(bearing), np.sin(bearing)])
    off_axle = (x, 0.0, y) if described.axis == 1 else (x, y, 0.0)

    def measure(drive: Drive) -> dict[str, Any]:
        return dict(zip(("amplitude", "phase"), wave(drive, at.nominal, wheel), strict=True))

    return Fault(
        "wheel_eccentricity",
        wheel,
        measure,
        lambda chassis: with_treads(chassis, wheel, described.radius, off_axle, described.links[:1]),
    )


def wheelbase(at: Setting) -> Fault:
    """Return a truck whose wheels sit farther out, or farther in."""
    truck, ratio = at.truck(), 1.0 + at.sign() * at.chance.uniform(0.008, 0.03)
    number = "ab".index(truck)
    out = 0.5 * at.chassis.tracks[number] * (ratio - 1.0)

    def build(chassis: Chassis) -> Chassis:
        urdf = chassis.urdf
        for side, way in (("left", out), ("right", -out)):
            x, y, z = chassis.aside
            for name in chassis.wheels[f"{truck}.{side}"].joints:
                urdf = with_moved(urdf, name, (way * x, way * y, way * z))
        return replace(chassis, urdf=urdf)

    measure = _over_healthy(at, lambda drive: turning_base(drive, at.nominal, number))
    return Fault("wheelbase", truck, measure, build)


def wheel_misalignment(at: Setting) -> Fault:
    """Return a truck whose axle is turned in it."""
    truck, angle = at.truck(), at.sign() * at.chance.uniform(0.005, 0.02)

    def build(chassis: Chassis) -> Chassis:
        urdf = chassis.urdf
        for side in ("left", "right"):
            for name in chassis.wheels[f"{truck}.{side}"].joints:
                urdf = with_moved(urdf, name, (0.0, 0.0, 0.0), angle)
        return replace(chassis, urdf=urdf)

    def measure(drive: Drive) -> dict[str, Any]:
        angle, healthy = (travel_angle(driven, "ab".index(truck)) for driven in (drive, at.healthy))
        return {"angle": angle - healthy}

    return Fault("wheel_misalignment", truck, measure, build)


def tyre_loses_air(at: Setting) -> Fault:
    """Return a wheel that rolls on a smaller tread from one moment on."""
    wheel, time = at.wheel(), at.moment(0.35, 0.65)
    described, ratio = at.chassis.wheels[wheel], 1.0 - at.chance.uniform(0.004, 0.012)

    def build(chassis: Chassis) -> Chassis:
        flat = with_treads(chassis, wheel, described.radius * ratio)
        parts = []
        for name in described.links:
            parts.append(link(f"{name}.air", 1e-3, 1e-6, sphere(described.radius)))
            parts.append(joint(f"{name}.air", "fixed", (name, f"{name}.air"), middle(flat.urdf, name)))
        links = (*described.links, *(f"{name}.air" for name in described.links))
        wheels = {**flat.wheels, wheel: replace(described, links=links)}
        return replace(flat, urdf=with_links(flat.urdf, *parts), wheels=wheels)

    def hook(scene: Scene, now: float) -> None:
        if now >= time:
            for name in described.links:
                scene.let_through(f"{name}.air")

    def measure(drive: Drive) -> dict[str, Any]:
        first, last = (
            rolling_radius(drive, at.nominal, wheel, rows)
            / rolling_radius(at.healthy, at.nominal, wheel, rows)
            for rows in before_and_after(time, drive)
        )
        return {"ratio": last / first, "time": time + at.start}

    until = [time + at.start, float(at.healthy.time[-1]) + at.start]
    return Fault("radius_step", wheel, measure, build, hooks=(hook,), intervals=lambda _: [until])


def bump(at: Setting) -> Fault:
    """Return boxes on the path of a wheel."""
    wheel = at.wheel()
    height = at.chance.uniform(*HEIGHTS) * at.chassis.wheels[wheel].radius
    boxes = tuple(
        Box(wheel, (x, y), heading, (at.chance.uniform(0.01, 0.04), 0.12, height))
        for x, y, heading in _places(at, wheel, BOXES)
    )

    def measure(drive: Drive) -> dict[str, Any]:
        spans, lost = crossings(drive, at.nominal, wheel, at.start)
        return {"times": [first for first, _ in spans], "lost": lost}

    return Fault(
        "bump",
        wheel,
        measure,
        boxes=boxes,
        intervals=lambda drive: crossings(drive, at.nominal, wheel, at.start)[0],
    )


def _places(at: Setting, wheel: str, count: int) -> list[tuple[float, float, float]]:
    """Return places on a wheel's path where it rolls steadily [m], and its direction there [rad]."""
    path, heading = (
        path_of(at.healthy, at.nominal.tracks, wheel),
        at.healthy.poses[:, WHEELS.index(wheel) // 2, 2],
    )
    period = float(at.healthy.time[1])
    speed = np.abs(np.diff(at.healthy.wheels[:, WHEELS.index(wheel)])) * at.nominal.radii[0] / period
    turning = np.abs(np.diff(heading)) / period
    fast = np.flatnonzero(speed > 0.6 * speed.max())
    straight = fast[turning[fast] < 0.5 * turning.max() + 1e-6]
    steady = straight if len(straight) > count else fast
    rows = steady[np.linspace(0, len(steady) - 1, count + 2).astype(int)[1:-1]]
    return [(float(path[row, 0]), float(path[row, 1]), float(heading[row])) for row in rows]


def slippery(at: Setting) -> Fault:
    """Return oil on a part of the floor, which one wheel runs through."""
    wheel = at.wheel()
    described, radius = at.chassis.wheels[wheel], at.chance.uniform(0.4, 0.9)
    keeps = at.chassis.grip * at.chance.uniform(*OILY)
    x, y, _ = _places(at, wheel, 1)[0]

    def hook(scene: Scene, _now: float) -> None:
        for name in described.links:
            place = scene.place(name)
            inside = np.hypot(place[0] - x, place[1] - y) < radius
            scene.grip(name, keeps if inside else at.chassis.grip)

    def inside(drive: Drive) -> NDArray[np.bool_]:
        tracks = np.array(at.chassis.tracks)
        return np.asarray(np.hypot(*(path_of(drive, tracks, wheel) - (x, y)).T) < radius)

    def measure(drive: Drive) -> dict[str, Any]:
        faulty, healthy = (lost(driven, at.nominal, wheel, inside(drive)) for driven in (drive, at.healthy))
        return {"fraction": faulty - healthy}

    return Fault(
        "slip_patch",
        wheel,
        measure,
        hooks=(hook,),
        intervals=lambda drive: _spans(drive, inside(drive), at.start),
    )


def _spans(drive: Drive, inside: NDArray[np.bool_], start: float) -> list[list[float]]:
    """Return the intervals [s] of the rows in which something is so."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside, [False])).astype(int)))
    last = len(drive.time) - 1
    return [
        [float(drive.time[first]) + start, float(drive.time[min(end, last)]) + start]
        for first, end in edges.reshape(-1, 2)
    ]


def payload_moves(at: Setting) -> Fault:
    """Return a payload that moves to one end of the robot, where the wheels then grip more."""
    time, mass, way = at.moment(0.35, 0.6), 33.0 * at.chance.uniform(*LOADED), at.sign() * 0.2
    x, y, _ = at.chassis.aside
    across = bool(at.chance.random() < 0.5)
    axis = at.chassis.aside if across else (y, -x, 0.0)
    body = "base_link"  # of the Husky and of R2D2

    def build(chassis: Chassis) -> Chassis:
        parts = (
            link("load", mass, 0.1),
            joint("load", "prismatic", (body, "load"), (0.0, 0.0, 0.3 * (chassis.height == 0.0)), axis),
        )
        return replace(chassis, urdf=with_links(chassis.urdf, *parts))

    def hook(scene: Scene, now: float) -> None:
        scene.move("load", float(np.clip((now - time) / 1.0, 0.0, 1.0)) * way)

    until = [time + at.start, float(at.healthy.time[-1]) + at.start]
    return Fault("unknown", "a", lambda _: {}, build, hooks=(hook,), intervals=lambda _: [until])


def dragging(at: Setting) -> Fault:
    """Return a castor that does not slide any more: it drags."""
    friction = at.chance.uniform(0.1, 0.25)

    def build(chassis: Chassis) -> Chassis:
        return replace(chassis, feet=dict.fromkeys(chassis.feet, friction))

    return Fault("unknown", "a", lambda _: {}, build)


def joint_bias(at: Setting) -> Fault:
    """Return a joint encoder that is mounted at an angle."""
    return _sensed("joint_bias", at.joint(), bias=at.sign() * at.chance.uniform(0.003, 0.01))


def joint_eccentricity(at: Setting) -> Fault:
    """Return a joint encoder whose disc is off the joint's centre."""
    amplitude, phase = at.chance.uniform(0.004, 0.015), at.chance.uniform(-np.pi, np.pi)
    return _sensed("joint_eccentricity", at.joint(), amplitude=amplitude, phase=phase)


def joint_backlash(at: Setting) -> Fault:
    """Return a joint encoder with play."""
    return _sensed("joint_backlash", at.joint(), width=at.chance.uniform(0.01, 0.03))


def link_bias(at: Setting) -> Fault:
    """Return a linear encoder that is not mounted where `vehicle.toml` says."""
    return _sensed("link_bias", "link", bias=at.sign() * at.chance.uniform(0.003, 0.01))


def count_loss(at: Setting) -> Fault:
    """Return a wheel whose counts are lost above a speed."""
    wheel = at.wheel()
    column = WHEELS.index(wheel)
    speed = np.abs(np.gradient(at.healthy.wheels[:, column], at.healthy.time)) * at.nominal.radii[column]
    above = float(at.chance.uniform(0.4, 0.8) * np.quantile(speed, 0.95))
    return _sensed("count_loss", wheel, fraction=at.chance.uniform(0.004, 0.015), above=above)


def latency(at: Setting) -> Fault:
    """Return an encoder whose samples are old."""
    channels = [*at.chassis.wheels, *(("joint_a", "joint_b") if at.chassis.link else ())]
    return _sensed("latency", str(at.chance.choice(channels)), delay=at.chance.uniform(0.03, 0.09))


def _sensed(effect: str, component: str, **parameters: float) -> Fault:
    return Fault(effect, component, lambda _: dict(parameters), sensed=parameters)
