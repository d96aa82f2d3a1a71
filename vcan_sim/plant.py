"""The plant: the robot's mechanics, from commanded wheel speeds to the counts of its encoders."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vcan_sim.altered_path import AlteredPath
from omnimate.vcan_sim.biases import split_biases
from omnimate.vcan_sim.noise import SONAR, STREAMS, normal_pair
from omnimate.vcan_sim.records import Constants, Obstacle, State
from omnimate.vcan_sim.signal_path import advance, begin_lap, couple, read_linkage, read_wheels
from omnimate.vehicle.compiled import Record, layout, record
from omnimate.vehicle.parameters import CHANNELS, WHEELS
from omnimate.vehicle.se2 import Array, compose

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.vcan_sim.floor import Bump
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import Encoder, TruckName, VehicleParameters

Pose = tuple[float, float, float]


class Plant:
    """The mechanics of one robot on one floor; it advances one step per SYNC.

    Args:
        truth: True robot.
        vehicle: Nominal robot, whose encoders give the counts.
        start: True pose of truck a [m, m, rad]; truck b is straight behind it, at the link's length at rest.
        start_time: Time at the start, for effects that depend on time [s].
        clock: Clock to which this time is set after a pause without SYNC [s]; none by default.
    """

    def __init__(
        self,
        truth: Truth,
        vehicle: VehicleParameters,
        start: Pose = (0.0, 0.0, 0.0),
        start_time: float = 0.0,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self.truth = truth
        self.vehicle = vehicle
        self.constants = constants_of(truth, vehicle)
        self.obstacles = obstacles_of(truth.floor.bumps, truth.vehicle)
        self.state = record(State)
        self._set_start(start)
        self._altered: AlteredPath | None = None
        _, effects = split_biases(truth.effects)  # the biases are in the constants
        if effects:
            self._altered = AlteredPath(vehicle, self.constants, effects, start_time, clock)
            self._altered.apply_to_first_readings(self.state, vehicle.bus.sync_period)
        self._counters = [_counter(encoder) for encoder in vehicle.encoders]
        self._command = np.zeros(4)
        self._wheels = len(vehicle.wheels)
        self._fixes = 0

    def _set_start(self, start: Pose) -> None:
        robot = self.state[0]
        robot["lap"] = -1
        robot["pose"][0] = start
        if self.truth.vehicle.linkage is not None:
            robot["pose"][1] = compose(start, (-self.truth.vehicle.linkage.length, 0.0, 0.0))
        read_wheels(self.constants[0], robot)
        couple(self.constants[0], robot)
        read_linkage(self.constants[0], robot)

    def step(self, wheel_speeds: Sequence[float], dt: float) -> None:
        """Advance by `dt` [s] with commanded wheel speeds [rad/s] in the order of `vehicle.wheels`.

        Raises ValueError for a speed that is not finite, or for too few or too many.
        """
        if len(wheel_speeds) != self._wheels or not all(map(math.isfinite, wheel_speeds)):
            raise ValueError(f"wheel speeds {wheel_speeds}; expected {self._wheels} finite numbers [rad/s]")
        self._command[: self._wheels] = wheel_speeds
        self.advance(self._command, dt)

    def advance(self, command: Array, dt: float) -> None:
        """Advance like `step`, without checks, with commands `(4,)` [rad/s]."""
        if self._altered is None:
            advance(self.constants, self.state, self.obstacles, command, dt)
        else:
            self._altered.advance(self.state, self.obstacles, command, dt)

    def raw_counts(self) -> tuple[int, ...]:
        """Return the counts as the encoders send them, wrapped, in the order of `vehicle.channels`."""
        counts = self.state["counts"][0].tolist()
        return tuple((counts[column] + half) % span - half for column, half, span in self._counters)

    def pose(self, truck: TruckName) -> Array:
        """Return the true pose of a truck [m, m, rad], `(3,)`, with unwrapped heading."""
        return np.array(self.state["pose"][0][_index(truck)])

    def fix(self, truck: TruckName) -> tuple[Array, Array]:
        """Return a truck's pose `(3,)` by sonar, and its sigma `(3,)` [m, m, rad]; nan if no wall is in view.

        With effects of latency or clock drift it is the pose of an earlier time.
        """
        stream = _index(truck) * STREAMS + SONAR
        first = normal_pair(self.truth.seed, stream, 2 * self._fixes)
        second = normal_pair(self.truth.seed, stream, 2 * self._fixes + 1)
        self._fixes += 1
        pose = self.pose(truck) if self._altered is None else self._altered.pose(_index(truck))
        return self.truth.sonar.fix(pose, np.array([*first, second[0]]))

    def begin_lap(self, lap: int | None) -> None:
        """Set the number of the current lap, for bumps of a lap; None between laps."""
        begin_lap(self.state, -1 if lap is None else lap)

    @property
    def has_effects(self) -> bool:
        """Whether effects act between the compiled stages."""
        return self._altered is not None

    @property
    def link_length(self) -> float:
        """True length of the link [m]."""
        return float(self.state["length"][0])

    @property
    def at_end_stop(self) -> bool:
        """Whether the slider has been at its end stop."""
        return bool(self.state["end_stop"][0])


def _index(truck: TruckName) -> int:
    return 0 if truck == "a" else 1


def _counter(encoder: Encoder) -> tuple[int, int, int]:
    """Return (column in the state, half, range) of an encoder: it counts from -half to range - half - 1."""
    span = encoder.wrap_range
    return CHANNELS.index(encoder.channel), span // 2 if encoder.signed else 0, span


def constants_of(truth: Truth, vehicle: VehicleParameters) -> Record:
    """Return the constants record `(1,)` of a true robot whose encoders are those of `vehicle`."""
    constants = record(Constants)
    robot = constants[0]
    (*joint_biases, link_bias), _ = split_biases(truth.effects)
    robot["trucks"], robot["seed"], robot["roughness"] = (
        len(truth.vehicle.trucks),
        truth.seed,
        truth.floor.roughness,
    )
    robot["wheelbase"] = truth.vehicle.trucks["a"].wheelbase
    if truth.vehicle.linkage is not None and vehicle.linkage is not None:
        robot["wheelbase"][1] = truth.vehicle.trucks["b"].wheelbase
        robot["link_zero"] = vehicle.linkage.length - link_bias
        robot["shortest"] = truth.vehicle.linkage.length - truth.stroke
        robot["longest"] = truth.vehicle.linkage.length + truth.stroke
    robot["joint_bias"] = joint_biases
    for number, wheel in enumerate(truth.vehicle.wheels):
        robot["radius"][number] = 0.5 * truth.vehicle.wheel_diameter(wheel)
        robot["servo"][number] = truth.servo / robot["radius"][number]
    generator = np.random.default_rng(truth.seed)
    for number, channel in enumerate(vehicle.expected_channels):
        encoder = vehicle.encoder(channel)
        robot["scale"][number] = 1.0 / encoder.scale
        robot["offset"][number] = _first_count(encoder, generator)
    return constants


def _first_count(encoder: Encoder, generator: np.random.Generator) -> float:
    """Return the counts at angle 0: random for a wheel, whose encoder has no zero; else its `zero`."""
    if encoder.channel in WHEELS:
        span = min(encoder.wrap_range, 2**32)
        return float(generator.uniform(-0.5, 0.5) * span) + (0.0 if encoder.signed else 0.5 * span)
    return float(encoder.zero)


def obstacles_of(bumps: tuple[Bump, ...], vehicle: VehicleParameters) -> Record:
    """Return the `Obstacle` records `(K,)`: one for each bump and each wheel that may cross it."""
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
            crossing = bump.crossing(radius)
            obstacle["lost"], obstacle["span"] = crossing.lost, crossing.rolled
            obstacles.append(obstacle)
    return np.array(obstacles, layout(Obstacle))
