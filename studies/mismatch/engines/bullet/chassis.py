"""Robots as PyBullet loads them: their URDF, and what of it rolls, measures and grips.

The Husky, R2D2 and the racecar are those of `pybullet_data`; the tug and the pair are written here. The tread
of every wheel is a sphere of the wheel's radius, so that it meets the floor in one point: a cylinder of the
original width rests on its inner and its outer edge in turn, and the wheelbase jumps by that width.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from numpy.random import Generator

from studies.mismatch.engines.bullet.urdf import (
    Place,
    bare,
    joint,
    link,
    sphere,
    with_inertia,
    with_links,
    with_soft,
    with_tread,
)

# Slip [m/s] at which tyres have 0.7 of their grip where a robot steers by skidding: about what its bends drag
# them aside, so that it turns on one wheelbase.
CREEP = (0.1, 0.2)
CASTOR_RADIUS, SLIDES = 0.03, 0.02
# Inertia [kg m^2] of a wheel with its motor's, seen through the gear. It is large against what creeping tyres
# take or give in a step, which would ring on the bare wheels.
GEARED = 0.05
FRONT = 2000.0, 60.0  # [N/m], [N s/m] of the racecar's front tyres: on stiff ones a rear wheel would lift


@dataclass(frozen=True, slots=True)
class Wheel:
    """Wheels that one encoder counts: one, or those of one side of a robot that steers by skidding."""

    joints: tuple[str, ...]  # joints of the wheels; the encoder sits on the first
    links: tuple[str, ...]  # links of the wheels
    radius: float  # radius of the treads [m]
    axis: int  # axis of the joints in the wheels' frame: 1 for y, 2 for z


@dataclass(frozen=True, slots=True)
class Chassis:
    name: str  # name of the robot
    urdf: str  # text of its URDF
    wheels: Mapping[str, Wheel]  # driven wheels, by channel
    tracks: tuple[float, ...]  # distance between the wheels of each truck [m]
    height: float  # height of the base's frame above the floor [m]
    force: float  # most torque of a motor [N m]
    aside: Place = (0.0, 1.0, 0.0)  # direction to the left in the frame of the base
    rolls: float = 1.0  # +1 or -1, the sense in which the wheels turn when they roll ahead
    # friction of links that slide on the floor without a drive
    feet: Mapping[str, float] = field(default_factory=dict)
    grip: float = 0.9  # friction of its tyres
    # slip at which its tyres have 0.7 of their grip [m/s]; None for tyres that hold
    creep: float | None = None
    free: tuple[str, ...] = ()  # joints that nothing holds
    link: float = 0.0  # length of the linkage at rest [m]; 0 without one

    @property
    def skids(self) -> bool:
        """Whether it steers by skidding."""
        return any(len(wheel.joints) > 1 for wheel in self.wheels.values())

    @property
    def trucks(self) -> int:
        return len(self.tracks)


def husky(chance: Generator) -> Chassis:
    """Return the Husky of `pybullet_data`: four wheels, one encoder for each side."""
    sides = {side: tuple(f"{end}_{side}_wheel" for end in ("rear", "front")) for side in ("left", "right")}
    wheels = {
        f"a.{side}": Wheel(joints, tuple(f"{name}_link" for name in joints), 0.17775, 1)
        for side, joints in sides.items()
    }
    urdf = _round("husky/husky.urdf", wheels)
    for name in (name for wheel in wheels.values() for name in wheel.links):
        urdf = with_inertia(urdf, name, 10.0 * GEARED)
    creep = float(chance.uniform(*CREEP))
    return Chassis("husky", urdf, wheels, (0.5708,), 0.0, 300.0, creep=creep)


def r2d2(chance: Generator) -> Chassis:
    """Return R2D2 of `pybullet_data`: four small wheels under two legs, y is ahead."""
    wheels = {
        f"a.{side}": Wheel(
            tuple(f"{side}_{end}_wheel_joint" for end in ("back", "front")),
            tuple(f"{side}_{end}_wheel" for end in ("back", "front")),
            0.035,
            2,
        )
        for side in ("left", "right")
    }
    creep = float(chance.uniform(*CREEP))
    urdf = _round("r2d2.urdf", wheels)
    return Chassis("r2d2", urdf, wheels, (0.44,), 0.47, 100.0, (-1.0, 0.0, 0.0), -1.0, creep=creep)


def racecar(_chance: Generator) -> Chassis:
    """Return the racecar of `pybullet_data`, its rear wheels driven one by one, its front wheels sliding."""
    rear = {f"a.{side}": f"{side}_rear_wheel" for side in ("left", "right")}
    wheels = {channel: Wheel((f"{name}_joint",), (name,), 0.05, 2) for channel, name in rear.items()}
    front = {
        f"{side}_front_wheel": Wheel((), (f"{side}_front_wheel",), 0.05, 2) for side in ("left", "right")
    }
    urdf = _round("racecar/racecar.urdf", wheels | front)
    for name in front:
        urdf = with_soft(urdf, name, *FRONT)
    return Chassis("racecar", urdf, wheels, (0.245,), 0.0, 20.0, feet=dict.fromkeys(front, SLIDES))


def _round(file: str, wheels: Mapping[str, Wheel]) -> str:
    """Return a URDF of `pybullet_data` with round treads on its wheels."""
    import pybullet_data  # prints a line when it is imported

    text = (Path(pybullet_data.getDataPath()) / file).read_text(encoding="utf-8")
    text = bare(text, [name for wheel in wheels.values() for name in wheel.links])
    for wheel in wheels.values():
        for name in wheel.links:
            text = with_tread(text, name, wheel.radius)
    return text


def tug(chance: Generator) -> Chassis:
    """Return a robot with two wheels and a castor that slides."""
    radius, track = float(chance.uniform(0.05, 0.1)), float(chance.uniform(0.25, 0.5))
    behind = -float(chance.uniform(0.4, 0.6)) * track
    urdf, wheels = _truck("a", radius, track, behind, float(chance.uniform(10.0, 40.0)))
    text = with_links('<robot name="tug"></robot>', urdf)
    return Chassis("tug", text, wheels, (track,), radius, 50.0, feet={"a.castor": SLIDES})


def pair(chance: Generator) -> Chassis:
    """Return two trucks with a linkage of two joints and a slider between them."""
    radius, length = float(chance.uniform(0.06, 0.09)), float(chance.uniform(0.8, 1.2))
    tracks = tuple(float(chance.uniform(0.28, 0.42)) for _ in "ab")
    mass = float(chance.uniform(15.0, 30.0))
    ahead, wheels_ahead = _truck("a", radius, tracks[0], 0.5 * tracks[0], mass)
    behind, wheels_behind = _truck("b", radius, tracks[1], -0.5 * tracks[1], mass)
    pitch, roll, damping = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), float(chance.uniform(10.0, 30.0))
    half = (-0.3, 0.0, 0.0)
    linkage = [
        link("bar.yaw", 0.1, 1e-3),
        joint("joint_a", "continuous", ("a", "bar.yaw"), damping=0.02),
        link("bar", 0.5, 0.01, at=half),
        joint("pitch_a", "continuous", ("bar.yaw", "bar"), axis=pitch, damping=0.02),
        link("slider", 0.5, 0.01, at=(0.3, 0.0, 0.0)),
        joint("link", "prismatic", ("bar", "slider"), (-length, 0.0, 0.0), (-1.0, 0.0, 0.0), damping),
        link("pivot.pitch", 0.1, 1e-3),
        joint("pitch_b", "continuous", ("slider", "pivot.pitch"), axis=pitch, damping=0.02),
        link("pivot", 0.1, 1e-3),
        joint("roll_b", "continuous", ("pivot.pitch", "pivot"), axis=roll, damping=0.02),
        joint("joint_b", "continuous", ("pivot", "b"), damping=0.02),
    ]
    return Chassis(
        "pair",
        with_links('<robot name="pair"></robot>', ahead, behind, *linkage),
        wheels_ahead | wheels_behind,
        tracks,
        radius,
        50.0,
        feet={"a.castor": SLIDES, "b.castor": SLIDES},
        free=("joint_a", "pitch_a", "link", "pitch_b", "roll_b", "joint_b"),
        link=length,
    )


def _truck(
    name: str, radius: float, track: float, castor: float, mass: float
) -> tuple[str, dict[str, Wheel]]:
    """Return a truck as XML, its axle's middle in the origin and its castor ahead of it, and its wheels."""
    size = sphere(CASTOR_RADIUS)
    parts = [
        link(name, mass, mass * track**2 / 6.0, at=(0.35 * castor, 0.0, 0.0)),
        link(f"{name}.castor", 0.2, 1e-3, size),
        joint(f"{name}.castor", "fixed", (name, f"{name}.castor"), (castor, 0.0, CASTOR_RADIUS - radius)),
    ]
    wheels = {}
    for side, y in (("left", 0.5 * track), ("right", -0.5 * track)):
        channel = f"{name}.{side}"
        wheels[channel] = Wheel((channel,), (channel,), radius, 1)
        parts += [
            link(channel, 1.0, GEARED, sphere(radius)),
            joint(channel, "continuous", (name, channel), (0.0, y, 0.0), (0.0, 1.0, 0.0)),
        ]
    return "".join(parts), wheels


ROBOTS: dict[str, Callable[[Generator], Chassis]] = {
    "husky": husky,
    "tug": tug,
    "pair": pair,
    "racecar": racecar,
    "r2d2": r2d2,
}
