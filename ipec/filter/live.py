"""The filter sample by sample, for live use."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.disturbed_wheels import STEP
from omnimate.ipec.filter.fixes import take_fix
from omnimate.ipec.filter.hypotheses import HYPOTHESES, chances_before
from omnimate.ipec.filter.noise import FilterNoise
from omnimate.ipec.filter.prior import CALIBRATED, OPEN, SIZES, Prior, directions
from omnimate.ipec.filter.records import FAST, LINK, FilterSettings, FilterState, X, Y
from omnimate.ipec.filter.state import FilteredState
from omnimate.ipec.filter.step import advance_filter
from omnimate.ipec.readings import SampleReader, scales_of
from omnimate.vehicle.compiled import Record, record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.sample import Sample


class Filter:
    """The filter for one robot with two trucks.

    Args:
        vehicle: The robot as `vehicle.toml` describes it.
        noise: Scatter of floor and encoders; `FilterNoise()` where it is None.
        prior: How well `vehicle` is known; `CALIBRATED` where it is None.

    Raises:
        NoLinkageError: The robot has a single truck.
    """

    def __init__(
        self, vehicle: VehicleParameters, noise: FilterNoise | None = None, prior: Prior | None = None
    ) -> None:
        self.noise, self.prior = noise or FilterNoise(), prior or CALIBRATED
        self.settings = filter_settings(vehicle, self.noise, self.prior)
        self._reader = SampleReader(vehicle)

    def start(self, pose_a: ArrayLike = ORIGIN, sigma: ArrayLike = (0.0, 0.0, 0.0)) -> FilteredState:
        """Return the state before the first sample.

        Args:
            pose_a: Pose of truck a [m, m, rad], shape `(3,)`.
            sigma: Standard deviations of that pose [m, m, rad], shape `(3,)`.
        """
        states = record(FilterState)
        state = states[0]
        state["mean"][[X, Y, LINK]] = pose_a
        state["known"][[X, Y, LINK], [X, Y, LINK]] = np.square(sigma)
        state["covariance"][:] = state["known"]
        state["covariance"][:, FAST:, FAST:] = np.diag(self.settings["open"][0])
        state["known"][FAST:, FAST:] = self.prior.covariance
        state["blur"] = self.settings["half"][0] ** 2 / 3.0
        state["origin"] = state["mean"][[X, Y]]
        states["nis"] = np.nan
        states["weight"] = np.exp(self.settings["credit"])
        states["followed"] = 1
        return _frozen(states)

    def step(self, state: FilteredState, sample: Sample) -> FilteredState:
        """Return the state after a sample; `state` stays as it is."""
        counts, present = self._reader.read(sample)
        following = state.record.view(np.uint8).copy().view(state.record.dtype)
        advance_filter(self.settings, following, counts, present)
        return _frozen(following)

    def fix(
        self, state: FilteredState, pose: ArrayLike, sigma: ArrayLike, truck: TruckName = "a"
    ) -> FilteredState:
        """Return the state after an absolute pose of a truck.

        Only fixes can separate the joints' biases from a turn of the robot.

        Args:
            state: State after the sample in which the pose was measured.
            pose: Measured pose [m, m, rad], shape `(3,)`; nan for a coordinate that was not measured.
            sigma: Standard deviations of the measured pose [m, m, rad], shape `(3,)`.
            truck: Truck whose pose was measured.
        """
        following = state.record.view(np.uint8).copy().view(state.record.dtype)
        measured, sigmas = np.asarray(pose, np.float64), np.asarray(sigma, np.float64)
        take_fix(self.settings, following, 0 if truck == "a" else 1, measured, sigmas)
        return _frozen(following)


def filter_settings(vehicle: VehicleParameters, noise: FilterNoise, prior: Prior) -> Record:
    """Return the settings of the compiled functions as one record `(1,)` of `FilterSettings`.

    Raises:
        NoLinkageError: The robot has a single truck.
    """
    scales = scales_of(vehicle)
    records = record(FilterSettings)
    settings = records[0]
    for name in scales.dtype.names or ():
        settings[name] = scales[name][0]
    steps = np.abs(settings["scale"])
    settings["period"] = vehicle.bus.sync_period
    settings["noise"] = np.square([noise.roughness, noise.roughness, noise.sideways, noise.slack])
    settings["trust"], settings["memory"] = noise.trust, noise.memory
    settings["resolution"] = steps[:4] ** 2 / 6.0  # two readings, each off by up to a count
    settings["half"] = 0.5 * steps[4:]
    for number, hypothesis in enumerate(HYPOTHESES):
        settings["reading"][number], settings["wander"][number] = hypothesis.reading, hypothesis.wander**2
    settings["alike"] = [hypothesis.alike * settings["length"] for hypothesis in HYPOTHESES]
    settings["credit"] = chances_before(prior.wrong)
    settings["drift"], settings["gate"] = noise.drift**2, noise.gate**2
    settings["hold"], settings["distrust"] = noise.hold, noise.distrust
    settings["open"], settings["usual"] = np.square(OPEN), np.linalg.inv(prior.covariance)
    settings["suspect"], settings["size"], settings["odds"] = directions(), SIZES, prior.odds
    settings["independent"] = STEP / noise.correlated
    return records


def _frozen(record: Record) -> FilteredState:
    record.flags.writeable = False
    return FilteredState(record)
