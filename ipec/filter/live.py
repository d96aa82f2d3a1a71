"""The filter as a step function for live use."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.disturbed_wheels import STEP_LENGTH
from omnimate.ipec.filter.findings import SlowParameters, slow_parameters
from omnimate.ipec.filter.fixes import Fix, apply_fix, fix_sigma
from omnimate.ipec.filter.hypotheses import HYPOTHESES, LATE, log_prior_probabilities
from omnimate.ipec.filter.poses import fill_pose
from omnimate.ipec.filter.prior import (
    CALIBRATED,
    OPEN_SIGMAS,
    SUSPECT_SIZES,
    FilterNoise,
    Prior,
    suspect_directions,
    suspect_values,
)
from omnimate.ipec.filter.records import (
    FAST,
    HYPOTHESIS_COUNT,
    LINK,
    STATES,
    FilterSettings,
    FilterState,
    OpenFilter,
    X,
    Y,
)
from omnimate.ipec.filter.step import finish_step, predict
from omnimate.ipec.readings import columns_of, read_sample, scales_of
from omnimate.vehicle.compiled import Array, Record, layout, record
from omnimate.vehicle.parameters import CHANNELS

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.sample import Sample


NO_MOVES = np.empty((0, STATES + 2))  # nothing of the mixture is stored


@dataclass(frozen=True, slots=True)
class FilteredState:
    """The estimate after a sample. It is never changed: each step returns another one."""

    record: Record  # one read-only record `(1,)` of `omnimate.ipec.filter.records.FilterState`
    filters: Record  # read-only records `(H,)` of `OpenFilter`, shared by states of the same step

    def pose(self, truck: TruckName = "a") -> Array:
        """Return the pose x, y, heading of a truck [m, m, rad], shape `(3,)`.

        The pose of truck b is nan until the linkage has been read.
        """
        return self._pose_and_sigma(truck)[0]

    def sigma(self, truck: TruckName = "a") -> Array:
        """Return the standard deviations of a truck's pose [m, m, rad], shape `(3,)`."""
        return self._pose_and_sigma(truck)[1]

    def _pose_and_sigma(self, truck: TruckName) -> tuple[Array, Array]:
        pose, sigma = np.empty(3), np.empty(3)
        state = self.record[0]
        fill_pose(state["mean"], state["covariance"], 0 if truck == "a" else 1, pose, sigma)
        if truck == "b" and not state["is_linked"]:
            pose[:], sigma[:] = np.nan, np.nan
        return pose, sigma

    @property
    def _likely(self) -> np.void:
        """The open filter of the most probable hypothesis."""
        likely: np.void = self.filters[self.record["weight"][0].argmax()]
        return likely

    @property
    def nis(self) -> float:
        """Normalised innovation squared of the last sample, 3 degrees of freedom; nan without one."""
        return float(self._likely["nis"]) if self.record["predicted"][0] else math.nan

    @property
    def disturbed(self) -> tuple[bool, ...]:
        """Whether each wheel is distrusted, in the order of `WHEELS`."""
        return tuple((self._likely["alert"][:4] > 0.0).tolist())

    @property
    def lost(self) -> tuple[float, ...]:
        """Travel that each distrusted wheel lost in the last sample [m], in the order of `WHEELS`."""
        return tuple(self._likely["lost"].tolist()) if self.record["predicted"][0] else (0.0,) * 4

    @property
    def slow(self) -> SlowParameters:
        """The estimated systematic errors of the encoders and their standard deviations."""
        return slow_parameters(self.record["mean"][0], self.record["covariance"][0])


class Filter:
    """The filter for one robot with two trucks.

    `noise` is the scatter of floor and encoders, `FilterNoise()` where it is None; `prior` says how well the
    `vehicle` is known, `CALIBRATED` where it is None.

    Raises:
        NoLinkageError: The robot has a single truck.
    """

    def __init__(
        self, vehicle: VehicleParameters, noise: FilterNoise | None = None, prior: Prior | None = None
    ) -> None:
        self.noise, self.prior = noise or FilterNoise(), prior or CALIBRATED
        self.settings = filter_settings(vehicle, self.noise, self.prior)
        self._columns = columns_of(vehicle, CHANNELS)

    def start(self, pose_a: ArrayLike = ORIGIN, sigma: ArrayLike = (0.0, 0.0, 0.0)) -> FilteredState:
        """Return the state before the first sample, at a pose of truck a and its sigma [m, m, rad]."""
        period = self.settings["period"][0]
        states, filters = record(FilterState), np.zeros(HYPOTHESIS_COUNT, layout(OpenFilter))
        state = states[0]
        state["mean"][[X, Y, LINK]] = pose_a
        state["covariance"][[X, Y, LINK], [X, Y, LINK]] = np.square(sigma)
        filters["covariance"] = state["covariance"]
        filters["covariance"][:, FAST:, FAST:] = np.diag(self.settings["open_variance"][0])
        filters["number"], filters["is_active"], filters["nis"] = np.arange(HYPOTHESIS_COUNT), 1, np.nan
        filters["reading"] = [hypothesis.reading for hypothesis in HYPOTHESES]
        filters["form"] = [hypothesis.form for hypothesis in HYPOTHESES]
        sizes = [hypothesis.sizes for hypothesis in HYPOTHESES]
        units = [(period, 1.0) if hypothesis.form == LATE else (1.0, 1.0) for hypothesis in HYPOTHESES]
        filters["variance"] = np.square(np.multiply(sizes, units))
        filters["correlation_length"] = [
            hypothesis.correlation_length * self.settings["length"][0] for hypothesis in HYPOTHESES
        ]
        state["covariance"][FAST:, FAST:] = self.prior.covariance
        state["reading_variance"] = self.settings["half_count"][0] ** 2 / 3.0
        state["origin"] = state["mean"][[X, Y]]
        states["weight"] = np.exp(self.settings["log_prior"])
        return _frozen(states, filters)

    def step(self, state: FilteredState, sample: Sample) -> FilteredState:
        """Return the state after a sample; `state` is not changed."""
        following, filters = _copy(state.record), state.filters
        if predict(self.settings, following, *read_sample(sample, self._columns)):
            filters = _copy(filters)  # only when changed: they are large
            finish_step(self.settings, following, filters, NO_MOVES)
        return _frozen(following, filters)

    def fix(
        self, state: FilteredState, pose: ArrayLike, sigma: ArrayLike, truck: TruckName = "a"
    ) -> FilteredState:
        """Return the state after an absolute pose of a truck, measured at the time of the sample of `state`.

        Only fixes separate the joints' biases from the robot's heading. The pose and its standard deviations
        [m, m, rad] have the shape `(3,)`; nan is a coordinate that was not measured, or a standard deviation
        that none stated.
        """
        following, filters = _copy(state.record), _copy(state.filters)
        fix = record(Fix)[0]
        fix["truck"], fix["pose"], fix["sigma"] = "ab".index(truck), pose, fix_sigma(sigma)
        apply_fix(self.settings, following, filters, fix, NO_MOVES)
        return _frozen(following, filters)


def filter_settings(vehicle: VehicleParameters, noise: FilterNoise, prior: Prior) -> Record:
    """Return the constants of the compiled functions as one record `(1,)` of `FilterSettings`.

    Raises:
        NoLinkageError: The robot has a single truck.
    """
    records = scales_of(vehicle, FilterSettings)
    settings = records[0]
    steps = np.abs(settings["scale"])
    settings["period"] = vehicle.bus.sync_period
    settings["noise"] = np.square([noise.roughness, noise.roughness, noise.sideways, noise.slack])
    settings["trust"], settings["memory"] = noise.trust, noise.memory
    settings["resolution"] = steps[:4] ** 2 / 6.0  # two readings, each off by up to a count
    settings["half_count"] = 0.5 * steps[4:]
    settings["log_prior"] = log_prior_probabilities(prior.wrong)
    settings["drift"], settings["gate"] = noise.drift**2, noise.gate**2
    settings["hold"], settings["distrust"] = noise.hold, noise.distrust
    directions, information = suspect_directions(), np.linalg.inv(prior.covariance)
    settings["open_variance"], settings["nominal_information"] = np.square(OPEN_SIGMAS), information
    settings["suspect_information"] = directions @ information
    settings["suspect_precision"] = directions @ information @ directions.T
    settings["suspect_value"] = suspect_values()
    settings["size"], settings["odds"] = SUSPECT_SIZES, prior.odds
    settings["independent_share"] = STEP_LENGTH / noise.correlated
    return records


def _copy(records: Record) -> Record:
    return np.ndarray(records.shape, records.dtype, records.view(np.uint8).copy())


def _frozen(record: Record, filters: Record) -> FilteredState:
    record.flags.writeable = filters.flags.writeable = False
    return FilteredState(record, filters)
