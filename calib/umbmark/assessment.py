"""Calibration of an experiment by all applicable methods, with advice on its data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.calib.advice import Advice
from omnimate.calib.errors import CalibrationError, MethodError
from omnimate.calib.recordings import frozen_linkage
from omnimate.calib.scale import scale_from_straights
from omnimate.calib.umbmark.experiment import calibrate, usable_methods
from omnimate.calib.umbmark.guards import advise, without_outliers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.experiment import Calibration, Experiment
    from omnimate.calib.umbmark.printed import Method
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording


@dataclass(frozen=True, slots=True)
class Assessment:
    """Calibrations of a truck from an experiment, with advice."""

    experiment: Experiment  # the experiment, without runs that do not fit the others
    calibrations: tuple[Calibration, ...]  # its calibration by each method that its data allow
    advice: tuple[Advice, ...]  # problems of its recordings, then of its return errors

    @property
    def is_usable(self) -> bool:
        """Whether the result may be used: no advice is an error."""
        return all(advice.severity != "error" for advice in self.advice)

    def by(self, method: Method) -> Calibration:
        """Return the calibration by one method.

        Raises:
            MethodError: The data do not allow the method.
        """
        for calibration in self.calibrations:
            if calibration.correction.method == method:
                return calibration
        raise MethodError(self.experiment.source, method)


def assess(experiment: Experiment, recordings: Sequence[Recording], truck: TruckName) -> Assessment:
    """Return the calibrations and the advice of an experiment.

    `recordings` are those that it comes from; there are none where it comes from a table.

    Raises:
        CalibrationError: The errors are beyond what a method can explain.
    """
    experiment, left_out = without_outliers(experiment)
    methods = usable_methods(experiment.errors)
    calibrations = tuple(calibrate(experiment, method) for method in methods)
    recorded = advise_on_recordings(recordings, truck)
    return Assessment(experiment, calibrations, (*recorded, *left_out, *advise(experiment)))


def advise_on_recordings(recordings: Sequence[Recording], truck: TruckName) -> tuple[Advice, ...]:
    """Return advice on frozen channels, and on straights between fixes that show an uncorrected E_s."""
    frozen = [advice for recording in recordings for advice in frozen_linkage(recording)]
    try:
        scale = scale_from_straights(recordings, truck)
    except CalibrationError:
        return tuple(frozen)
    if not scale.is_significant:
        return tuple(frozen)
    what = f"{scale.straights} straights between fixes are {scale.e_s:.4f} times as long as calculated"
    do = f"E_s is left in; add --tape {10.0 * scale.e_s:.4f} 10, which scales wheels and wheelbase"
    return (*frozen, Advice("warning", what, do))
