"""The calibration of each truck that `omnimate umbmark` writes, and what speaks against using it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.calib.errors import CalibrationError
from omnimate.calib.scale import scaled_truck
from omnimate.calib.umbmark.assessment import assess
from omnimate.cli.console import warn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.umbmark.assessment import Assessment
    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.printed import Method
    from omnimate.cli.umbmark.sources import Case
    from omnimate.vehicle.parameters import Truck


@dataclass(frozen=True, slots=True)
class Result:
    """One truck's calibration.

    Attributes:
        case: The truck and its experiment.
        assessment: The calibrations by every method, and the advice.
        chosen: The calibration by the method that was asked for.
        truck: The calibrated truck, scaled by E_s where a tape measured it.
    """

    case: Case
    assessment: Assessment
    chosen: Calibration
    truck: Truck


def result_of(case: Case, method: Method, e_s: float) -> Result:
    """Return what an experiment says, by every method and by the one asked for.

    Raises:
        MethodError: The data do not allow the method.
        CalibrationError: The errors are beyond what a method can explain.
    """
    assessment = assess(case.experiment, case.recordings, case.truck)
    chosen = assessment.by(method)
    return Result(case, assessment, chosen, scaled_truck(chosen.truck, e_s))


def heed_advice(results: Sequence[Result], *, force: bool) -> None:
    """Print what looks wrong.

    Raises:
        CalibrationError: A result is not to be used, and `force` does not say to use it nevertheless.
    """
    errors = []
    for result in results:
        source = result.case.experiment.source
        for advice in result.assessment.advice:
            if advice.severity == "error" and not force:
                errors.append(str(advice).removeprefix(f"{source}: "))
            else:
                warn(f"{result.case.label}: {advice}")
    if errors:
        sentences = "; ".join(dict.fromkeys(errors))
        raise CalibrationError(
            results[0].case.experiment.source, f"{sentences} (--force uses the result nevertheless)"
        )
