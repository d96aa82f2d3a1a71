"""What `omnimate umbmark` finds about each truck, and what speaks against using it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from calib.channel_guards import advise_about
from calib.errors import CalibrationError
from calib.experiment import Calibration, calibrate, usable_methods
from calib.guards import advise
from calib.scale import scaled_truck
from cli.console import warn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calib.guards import Advice
    from calib.umbmark import Method
    from cli.umbmark_sources import Case
    from vehicle.parameters import Truck


@dataclass(frozen=True, slots=True)
class Result:
    """One truck's calibration.

    Attributes:
        case: what was measured.
        calibrations: by every method that the data allow.
        chosen: the one that is written.
        truck: by it, with E_s where a tape told it.
    """

    case: Case
    calibrations: tuple[Calibration, ...]
    chosen: Calibration
    truck: Truck


def result_of(case: Case, method: Method, e_s: float) -> Result:
    """Return what an experiment says, by every method and by the one asked for.

    Raises:
        CalibrationError: the data do not allow the method.
    """
    found = tuple(calibrate(case.experiment, one) for one in usable_methods(case.experiment.errors))
    chosen = [one for one in found if one.correction.method == method]
    if not chosen:
        raise CalibrationError(
            case.experiment.source,
            f"--method {method} needs the heading of every run, and more than one run in a direction",
        )
    return Result(case, found, chosen[0], scaled_truck(chosen[0].truck, e_s))


def advice_on(case: Case) -> tuple[Advice, ...]:
    """Return what looks wrong with an experiment and with the recordings that it comes from."""
    recorded = advise_about(case.recordings, case.truck) if case.recordings else ()
    return (*recorded, *advise(case.experiment))


def heed(cases: Sequence[Case], *, force: bool) -> None:
    """Say what looks wrong.

    Raises:
        CalibrationError: a result is not to be used, and `force` does not say to use it nevertheless.
    """
    errors = []
    for case in cases:
        for one in advice_on(case):
            if one.severity == "error" and not force:
                errors.append(str(one).removeprefix(f"{case.experiment.source}: "))
            else:
                warn(f"{case.label}: {one}")
    if errors:
        sentences = "; ".join(dict.fromkeys(errors))
        raise CalibrationError(
            cases[0].experiment.source, f"{sentences} (--force uses the result nevertheless)"
        )
