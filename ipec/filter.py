"""An error-state Kalman filter with all seven encoders, for live use: better than IPEC where it can be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipec.corrector import ORIGIN
from ipec.filter_records import (
    JOINT_BIAS,
    LENGTH_BIAS,
    LINK,
    WHEEL,
    WHEELBASE,
    FilterSettings,
    FilterState,
    X,
    Y,
)
from ipec.filtering import advance_filter, look, take_fix
from ipec.readings import SampleReader, scales_of
from vehicle.compiled import Array, Record, record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.sample import Sample


@dataclass(frozen=True, slots=True)
class Noise:
    """How much the floor and the encoders scatter.

    Attributes:
        roughness: standard deviation of a wheel's travel after one metre [m/sqrt(m)]; concrete 5.6e-4.
        sideways: likewise of a truck's sideways slip.
        joint: standard deviation of a joint's reading beside its resolution [rad].
        link: of the link's reading likewise [m].
        drift: by which a wheel's or wheelbase's factor changes in one metre [1/sqrt(m)].
        gate: standard deviations from which on an innovation counts as a disturbed wheel.
        hold: way for which a disturbed wheel stays distrusted [m].
        distrust: standard deviation of its travel then, as part of what it rolled.
    """

    roughness: float = 5.6e-4
    sideways: float = 5e-5
    joint: float = 0.0
    link: float = 0.0
    drift: float = 1e-5
    gate: float = 3.0
    hold: float = 0.1
    distrust: float = 0.3


@dataclass(frozen=True, slots=True)
class Prior:
    """How well `vehicle.toml` is known, as standard deviations: what a calibration leaves.

    What the linkage cannot tell (the mean of all diameters, and the joints' biases as long as the
    trucks drive straight) stays held by these.

    Attributes:
        scale: mean of a truck's wheel diameters, relative, U (2.4) E_s.
        ratio: right over left diameter of a truck, U (2.3) E_d.
        wheelbase: of each truck, relative, U (2.4) E_b.
        joint: bias of each joint [rad].
        link: bias of the link [m].
    """

    scale: float = 1e-3
    ratio: float = 3e-4
    wheelbase: float = 1.5e-3
    joint: float = math.radians(0.02)
    link: float = 3e-4

    @property
    def covariance(self) -> Array:
        """The covariance `(9, 9)` of wheels, wheelbases, joint biases and link bias."""
        out = np.diag(np.square([0.0] * 4 + [self.wheelbase] * 2 + [self.joint] * 2 + [self.link]))
        together, apart = self.scale**2, 0.25 * self.ratio**2
        truck = [[together + apart, together - apart], [together - apart, together + apart]]
        out[:2, :2] = out[2:4, 2:4] = truck
        return out


CALIBRATED = Prior()
NOMINAL = Prior(5e-3, 5e-3, 2e-2, math.radians(0.5), 3e-3)
"""What a data sheet leaves."""


@dataclass(frozen=True, slots=True)
class FilteredState:
    """The estimate after a sample; never changed, each step returns another.

    Attributes:
        record: read-only, one `ipec.filter_records.FilterState`.
    """

    record: Record

    def pose(self, truck: TruckName = "a") -> Array:
        """Return the pose `(3,)` of a truck; truck b is nan until the linkage has been read."""
        return self._look(truck)[0]

    def sigma(self, truck: TruckName = "a") -> Array:
        """Return the standard deviations `(3,)` of a truck's pose."""
        return self._look(truck)[1]

    def _look(self, truck: TruckName) -> tuple[Array, Array]:
        pose, sigma = np.empty(3), np.empty(3)
        own = self.record[0]
        look(own["mean"], own["covariance"], 0 if truck == "a" else 1, pose, sigma)
        if truck == "b" and not own["placed"]:
            pose[:], sigma[:] = np.nan, np.nan
        return pose, sigma

    @property
    def nis(self) -> float:
        """Normalised innovation squared of the last sample, 3 degrees of freedom; nan without one."""
        return float(self.record["nis"][0])

    @property
    def disturbed(self) -> tuple[bool, ...]:
        """Which wheels are distrusted, in the order of `WHEELS`."""
        return tuple((self.record["alert"][0] > 0.0).tolist())

    @property
    def lost(self) -> tuple[float, ...]:
        """What the distrusted wheels lost in the last sample [m], in the order of `WHEELS`."""
        return tuple(self.record["lost"][0].tolist())

    @property
    def slow(self) -> SlowParameters:
        """The slow parameters and their standard deviations."""
        own = self.record[0]
        return slow_parameters(own["mean"], np.sqrt(np.diag(own["covariance"])))


@dataclass(frozen=True, slots=True)
class SlowParameters:
    """What makes the encoders err, as estimated, with standard deviations `sigma` in the same order.

    Attributes:
        wheel: (4,) true over nominal diameter of each wheel, minus 1.
        wheelbase: (2,) likewise of each wheelbase.
        joint_bias: (2,) what joint_a and joint_b read too much [rad].
        link_bias: what the link reads too much [m].
        sigma: (9,) of wheels, wheelbases, joint biases, link bias.
    """

    wheel: Array
    wheelbase: Array
    joint_bias: Array
    link_bias: float
    sigma: Array


def slow_parameters(mean: Array, sigma: Array) -> SlowParameters:
    """Return the slow parameters of a mean `(15,)` and its standard deviations `(15,)`."""
    return SlowParameters(
        np.array(mean[WHEEL:WHEELBASE]),
        np.array(mean[WHEELBASE:JOINT_BIAS]),
        np.array(mean[JOINT_BIAS:LENGTH_BIAS]),
        float(mean[LENGTH_BIAS]),
        np.array(sigma[WHEEL:]),
    )


class Filter:
    """The filter for one robot.

    Args:
        vehicle: the robot.
        noise: of floor and encoders.
        prior: of what its file says.

    Raises:
        NoLinkageError: the robot has a single truck.
    """

    def __init__(
        self, vehicle: VehicleParameters, noise: Noise | None = None, prior: Prior | None = None
    ) -> None:
        self.noise, self.prior = noise or Noise(), prior or CALIBRATED
        self.settings = filter_settings(vehicle, self.noise)
        self._reader = SampleReader(vehicle)

    def start(self, pose_a: ArrayLike = ORIGIN, sigma: ArrayLike = (0.0, 0.0, 0.0)) -> FilteredState:
        """Return the state before the first sample, truck a at a pose `(3,)`, known to `sigma` `(3,)`."""
        state = record(FilterState)
        own = state[0]
        own["mean"][[X, Y, LINK]] = pose_a
        own["covariance"][[X, Y, LINK], [X, Y, LINK]] = np.square(sigma)
        own["covariance"][WHEEL:, WHEEL:] = self.prior.covariance
        state["nis"] = np.nan
        return _frozen(state)

    def step(self, state: FilteredState, sample: Sample) -> FilteredState:
        """Return the state after a sample."""
        counts, present = self._reader.read(sample)
        following = state.record.copy()
        advance_filter(self.settings, following, counts, present)
        return _frozen(following)

    def fix(
        self, state: FilteredState, pose: ArrayLike, sigma: ArrayLike, truck: TruckName = "a"
    ) -> FilteredState:
        """Return the state after an absolute pose `(3,)` of a truck with standard deviations `(3,)`.

        nan stands for what is unknown. Fixes are what tells the joints' biases from the robot's turning.
        """
        following = state.record.copy()
        fix, own = np.asarray(pose, np.float64), np.asarray(sigma, np.float64)
        take_fix(following, 0 if truck == "a" else 1, fix, own)
        return _frozen(following)


def filter_settings(vehicle: VehicleParameters, noise: Noise) -> Record:
    """Return the settings record `(1,)`.

    Raises:
        NoLinkageError: the robot has a single truck.
    """
    scales = scales_of(vehicle)
    settings = record(FilterSettings)
    own = settings[0]
    for name in scales.dtype.names or ():
        own[name] = scales[name][0]
    steps = np.abs(own["scale"])
    own["roughness"], own["sideways"] = noise.roughness**2, noise.sideways**2
    own["resolution"] = steps[:4] ** 2 / 6.0  # two readings, each off by up to a count
    own["half"] = 0.5 * steps[4:]
    own["blur"] = np.square([noise.joint, noise.joint, noise.link]) + (0.1 * steps[4:]) ** 2
    own["drift"], own["gate"] = noise.drift**2, noise.gate**2
    own["hold"], own["distrust"] = noise.hold, noise.distrust
    return settings


def _frozen(state: Record) -> FilteredState:
    state.flags.writeable = False
    return FilteredState(state)
