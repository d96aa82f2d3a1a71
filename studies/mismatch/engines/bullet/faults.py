"""Faults of geometry and friction, and of encoders."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.bullet import measured
from studies.mismatch.engines.bullet.floor import Box
from studies.mismatch.engines.bullet.setting import Fault, with_treads
from studies.mismatch.engines.bullet.urdf import joint, link, middle, sphere, with_links, with_moved
from studies.mismatch.engines.robots import WHEELS
from studies.mismatch.engines.true_motion import crossings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from studies.mismatch.engines.bullet.chassis import Chassis
    from studies.mismatch.engines.bullet.drive import Scene
    from studies.mismatch.engines.bullet.setting import Setting
    from studies.mismatch.engines.true_motion import Drive

    Array = NDArray[np.float64]

OILY = (0.02, 0.05)  # share of its grip that a tyre keeps on oil
LOADED = (0.5, 1.0)  # mass of a payload over that of the Husky's body, 33 kg; R2D2's is about the same
BOXES, HEIGHTS = 4, (0.05, 0.09)  # on the floor; their heights over the radius of the wheel


def wheel_diameter(at: Setting) -> Fault:
    """Return a larger or smaller tread on the wheels of one encoder."""
    wheel = at.wheel()
    radius = at.chassis.wheels[wheel].radius * (1.0 + at.sign() * at.chance.uniform(0.003, 0.01))
    return Fault(
        "wheel_diameter",
        wheel,
        partial(_diameter, at, wheel),
        lambda chassis: with_treads(chassis, wheel, radius),
    )


def one_tyre(at: Setting) -> Fault:
    """Return a larger or smaller tread on one of the two wheels of a side."""
    wheel = at.wheel()
    own = at.chassis.wheels[wheel]
    radius, tyre = (
        own.radius * (1.0 + at.sign() * at.chance.uniform(0.01, 0.03)),
        str(at.chance.choice(own.links)),
    )
    return Fault(
        "wheel_diameter",
        wheel,
        partial(_diameter, at, wheel),
        lambda chassis: with_treads(chassis, wheel, radius, links=[tyre]),
    )


def _diameter(at: Setting, wheel: str, drive: Drive) -> dict[str, Any]:
    own, healthy = (measured.rolling_radius(each, at.nominal, wheel) for each in (drive, at.healthy))
    return {"ratio": own / healthy}


def wheel_eccentricity(at: Setting) -> Fault:
    """Return a tread that is mounted off its axle, on the wheel with the encoder."""
    wheel, bearing = at.wheel(), at.chance.uniform(-np.pi, np.pi)
    own, amplitude = at.chassis.wheels[wheel], at.chance.uniform(0.005, 0.015)
    x, y = amplitude * own.radius * np.array([np.cos(bearing), np.sin(bearing)])
    off_axle = (x, 0.0, y) if own.axis == 1 else (x, y, 0.0)

    def measure(drive: Drive) -> dict[str, Any]:
        return dict(zip(("amplitude", "phase"), measured.wave(drive, at.nominal, wheel), strict=True))

    return Fault(
        "wheel_eccentricity",
        wheel,
        measure,
        lambda chassis: with_treads(chassis, wheel, own.radius, off_axle, own.links[:1]),
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

    def measure(drive: Drive) -> dict[str, Any]:
        own, healthy = (measured.turning_base(each, at.nominal, number) for each in (drive, at.healthy))
        return {"ratio": own / healthy}

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
        own, healthy = (measured.travel_angle(each, "ab".index(truck)) for each in (drive, at.healthy))
        return {"angle": own - healthy}

    return Fault("wheel_misalignment", truck, measure, build)


def tyre_loses_air(at: Setting) -> Fault:
    """Return a wheel that rolls on a smaller tread from one moment on."""
    wheel, time = at.wheel(), at.moment(0.35, 0.65)
    own, ratio = at.chassis.wheels[wheel], 1.0 - at.chance.uniform(0.004, 0.012)

    def build(chassis: Chassis) -> Chassis:
        flat = with_treads(chassis, wheel, own.radius * ratio)
        parts = []
        for name in own.links:
            parts.append(link(f"{name}.air", 1e-3, 1e-6, sphere(own.radius)))
            parts.append(joint(f"{name}.air", "fixed", (name, f"{name}.air"), middle(flat.urdf, name)))
        links = (*own.links, *(f"{name}.air" for name in own.links))
        wheels = {**flat.wheels, wheel: replace(own, links=links)}
        return replace(flat, urdf=with_links(flat.urdf, *parts), wheels=wheels)

    def hook(scene: Scene, now: float) -> None:
        if now >= time:
            for name in own.links:
                scene.let_through(f"{name}.air")

    def measure(drive: Drive) -> dict[str, Any]:
        first, last = (
            measured.rolling_radius(drive, at.nominal, wheel, rows)
            / measured.rolling_radius(at.healthy, at.nominal, wheel, rows)
            for rows in measured.before_and_after(time, drive)
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
    path, heading = _path(at.healthy, at.nominal.tracks, wheel), at.healthy.poses[:, _truck(wheel), 2]
    period = float(at.healthy.time[1])
    speed = np.abs(np.diff(at.healthy.wheels[:, WHEELS.index(wheel)])) * at.nominal.radii[0] / period
    turning = np.abs(np.diff(heading)) / period
    fast = np.flatnonzero(speed > 0.6 * speed.max())
    straight = fast[turning[fast] < 0.5 * turning.max() + 1e-6]
    steady = straight if len(straight) > count else fast
    rows = steady[np.linspace(0, len(steady) - 1, count + 2).astype(int)[1:-1]]
    return [(float(path[row, 0]), float(path[row, 1]), float(heading[row])) for row in rows]


def _truck(wheel: str) -> int:
    return "ab".index(wheel[0])


def _path(drive: Drive, tracks: Array, wheel: str) -> Array:
    """Return where a wheel is on the floor [m], shape `(N, 2)`."""
    x, y, heading = drive.poses[:, _truck(wheel)].T
    half = 0.5 * tracks[_truck(wheel)] * (1.0 if wheel.endswith("left") else -1.0)
    return np.stack([x - half * np.sin(heading), y + half * np.cos(heading)], axis=1)


def slippery(at: Setting) -> Fault:
    """Return oil on a part of the floor, which one wheel runs through."""
    wheel = at.wheel()
    own, radius = at.chassis.wheels[wheel], at.chance.uniform(0.4, 0.9)
    keeps = at.chassis.grip * at.chance.uniform(*OILY)
    x, y, _ = _places(at, wheel, 1)[0]

    def hook(scene: Scene, _now: float) -> None:
        for name in own.links:
            place = scene.place(name)
            inside = np.hypot(place[0] - x, place[1] - y) < radius
            scene.grip(name, keeps if inside else at.chassis.grip)

    def inside(drive: Drive) -> NDArray[np.bool_]:
        tracks = np.array(at.chassis.tracks)
        return np.asarray(np.hypot(*(_path(drive, tracks, wheel) - (x, y)).T) < radius)

    def measure(drive: Drive) -> dict[str, Any]:
        own, healthy = (measured.lost(each, at.nominal, wheel, inside(drive)) for each in (drive, at.healthy))
        return {"fraction": own - healthy}

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
