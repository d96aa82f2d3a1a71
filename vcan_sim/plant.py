"""The plant: the robot's mechanics, from commanded wheel speeds to what its encoders count."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from motion.compiled import Record, layout, record
from vcan_sim.noise import SONAR, STREAMS, normal_pair
from vcan_sim.signal_path import (
    Constants,
    Obstacle,
    State,
    advance,
    begin_lap,
    couple,
    read_linkage,
    read_wheels,
)
from vehicle.parameters import CHANNELS, Encoder
from vehicle.se2 import Array, compose

if TYPE_CHECKING:
    from vcan_sim.bumps import Bump
    from vcan_sim.truth import Truth
    from vehicle.parameters import TruckName, VehicleParameters

Pose = tuple[float, float, float]


def constants_of(truth: "Truth", vehicle: "VehicleParameters") -> Record:
    """Return the constants record `(1,)` of a true robot whose encoders are those of `vehicle`."""
    constants = record(Constants)
    own = constants[0]
    own["trucks"], own["seed"], own["roughness"] = (
        len(truth.vehicle.trucks),
        truth.seed,
        truth.floor.roughness,
    )
    own["wheelbase"] = truth.vehicle.trucks["a"].wheelbase
    if truth.vehicle.linkage is not None and vehicle.linkage is not None:
        own["wheelbase"][1] = truth.vehicle.trucks["b"].wheelbase
        own["link_zero"] = vehicle.linkage.length - truth.link_bias
        own["shortest"] = truth.vehicle.linkage.length - truth.stroke
        own["longest"] = truth.vehicle.linkage.length + truth.stroke
    own["joint_bias"] = truth.joint_bias
    for number, wheel in enumerate(truth.vehicle.wheels):
        own["radius"][number] = 0.5 * truth.vehicle.wheel_diameter(wheel)
        own["servo"][number] = truth.servo / own["radius"][number]
    chance = np.random.default_rng(truth.seed)
    for number, channel in enumerate(vehicle.expected_channels):
        encoder = vehicle.encoder(channel)
        own["scale"][number] = 1.0 / encoder.scale
        own["offset"][number] = _first_count(encoder, chance)
    return constants


def _first_count(encoder: Encoder, chance: np.random.Generator) -> float:
    """Return the counts at angle 0: anywhere for a wheel, which knows no zero."""
    if encoder.channel in CHANNELS[:4]:
        span = min(encoder.wrap_range, 2**32)
        return float(chance.uniform(-0.5, 0.5) * span) + (0.0 if encoder.signed else 0.5 * span)
    return float(encoder.zero)


def obstacles_of(bumps: "tuple[Bump, ...]", vehicle: "VehicleParameters") -> Record:
    """Return one record per bump and wheel that may meet it, `(K,)`."""
    obstacles = []
    for bump in bumps:
        wheels = vehicle.wheels if bump.wheel is None else (bump.wheel,)
        for wheel in wheels:
            radius = 0.5 * vehicle.wheel_diameter(wheel)
            obstacle = np.zeros((), layout(Obstacle))
            obstacle["wheel"], obstacle["scheduled"] = vehicle.wheels.index(wheel), bump.wheel is not None
            obstacle["lap"] = -1 if bump.lap is None else bump.lap
            obstacle["after"], obstacle["size"] = bump.after, bump.size
            obstacle["x"], obstacle["y"] = bump.x, bump.y
            obstacle["lost"], obstacle["span"] = bump.lost(radius), bump.span(radius)
            obstacles.append(obstacle)
    return np.array(obstacles, layout(Obstacle))


def to_raw(count: int, encoder: Encoder) -> int:
    """Return what a device sends for an unwrapped count: wrapped at its range, signed if it is."""
    half = encoder.wrap_range // 2 if encoder.signed else 0
    return (count + half) % encoder.wrap_range - half


class Plant:
    """One robot on one floor; advances one step per SYNC.

    Args:
        truth: the robot as it is.
        vehicle: the robot as its owner believes it to be, whose encoders count.
        start: true pose of truck a; truck b stands behind it in line, at the link's length at rest.
    """

    def __init__(self, truth: "Truth", vehicle: "VehicleParameters", start: Pose = (0.0, 0.0, 0.0)) -> None:
        self.truth = truth
        self.vehicle = vehicle
        self.constants = constants_of(truth, vehicle)
        self.obstacles = obstacles_of(truth.floor.bumps, truth.vehicle)
        self.state = record(State)
        self._place(start)
        self._columns = [(CHANNELS.index(one.channel), one) for one in vehicle.encoders]
        self._command = np.zeros(4)
        self._fixes = 0

    def _place(self, start: Pose) -> None:
        own = self.state[0]
        own["lap"] = -1
        own["pose"][0] = start
        if self.truth.vehicle.linkage is not None:
            own["pose"][1] = compose(start, (-self.truth.vehicle.linkage.length, 0.0, 0.0))
        read_wheels(self.constants[0], own)
        couple(self.constants[0], own)
        read_linkage(self.constants[0], own)

    def step(self, wheel_speeds: Sequence[float], dt: float) -> None:
        """Advance by a time [s] with the commanded speeds of the wheels [rad/s], as `vehicle.wheels`.

        Raises:
            ValueError: a speed that is not a finite number, or too few of them.
        """
        if len(wheel_speeds) != len(self.vehicle.wheels) or not all(map(math.isfinite, wheel_speeds)):
            raise ValueError(
                f"wheel speeds {wheel_speeds}; expected {len(self.vehicle.wheels)} finite numbers"
            )
        self._command[: len(wheel_speeds)] = wheel_speeds
        advance(self.constants, self.state, self.obstacles, self._command, dt)

    def raw_counts(self) -> tuple[int, ...]:
        """Return what the encoders send, in the order of `vehicle.channels`, wrapped as each of them does."""
        counts = self.state["counts"][0].tolist()
        return tuple(to_raw(counts[column], encoder) for column, encoder in self._columns)

    def pose(self, truck: "TruckName") -> Array:
        """Return the true pose of a truck, `(3,)`, heading unwrapped."""
        return np.array(self.state["pose"][0][_index(truck)])

    def fix(self, truck: "TruckName") -> tuple[Array, Array]:
        """Measure a truck by sonar: pose `(3,)` and sigma `(3,)`, nan where no wall is in view."""
        stream = _index(truck) * STREAMS + SONAR
        first = normal_pair(self.truth.seed, stream, 2 * self._fixes)
        second = normal_pair(self.truth.seed, stream, 2 * self._fixes + 1)
        self._fixes += 1
        return self.truth.sonar.fix(self.pose(truck), np.array([*first, second[0]]))

    def begin_lap(self, lap: int | None) -> None:
        """Note which lap begins, for the bumps that are put there; None when one has ended."""
        begin_lap(self.state, -1 if lap is None else lap)

    @property
    def at_end_stop(self) -> bool:
        """Whether the slider has been at its end stop."""
        return bool(self.state["end_stop"][0])


def _index(truck: "TruckName") -> int:
    return 0 if truck == "a" else 1
