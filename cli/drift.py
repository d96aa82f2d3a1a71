"""`omnimate drift`: recordings of one robot -> whether it is time to calibrate again."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import say, warn

if TYPE_CHECKING:
    from omnimate.calib.monitoring.drift import DriftReport, MonitoredQuantity

_SCREEN = {"m": ("mm", 1e3, 1), "rad": ("degrees", math.degrees(1.0), 3), "1": ("%", 1e2, 3)}


def drift(
    sources: Annotated[
        list[Path],
        typer.Argument(help="Recording folders of one robot since its last calibration.", exists=True),
    ],
    false_alarm: Annotated[
        float, typer.Option(help="Drives between two false alarms, on the average.", min=10.0)
    ] = 1000.0,
) -> None:
    """Later, from new recordings: say whether it is time to calibrate again."""
    from omnimate.calib.monitoring.drift import monitor_drift
    from omnimate.cli.loading import load

    report = monitor_drift([load(source) for source in sources], false_alarm)
    say(verdict(report))
    for source in report.apart:
        warn(f"{source} differs from the values before it; one such value is no drift: repeat its fixes")


def verdict(report: DriftReport) -> str:
    """Return one line: fine, calibrate again, or cannot tell, with the statistics behind it."""
    since = f"; {report.left_out} recording(s) from before the last calibration left out"
    rest = since if report.left_out else ""
    if report.alarms:
        return f"calibrate again: {_shift(report.alarms[0])}{rest}"
    if not report.has_enough_values:
        return f"cannot tell: {_too_few(report)}{rest}"
    worst = max(report.quantities, key=lambda quantity: quantity.highest)
    return (
        f"fine: no shift in {len(report.quantities)} kinds of numbers from {report.used} recording(s); "
        f"nearest to an alarm is the {worst.name}, {worst.highest:.1f} of {worst.threshold:.1f} "
        f"after {len(worst.values)}{rest}"
    )


def _shift(quantity: MonitoredQuantity) -> str:
    assert quantity.since is not None  # the caller has an alarm
    unit, scale, digits = _SCREEN[quantity.unit]
    before, after = quantity.means
    return (
        f"{quantity.name} was {scale * before:+.{digits}f} {unit} and is {scale * after:+.{digits}f} {unit} "
        f"from number {quantity.since} of {len(quantity.values)} on "
        f"(sum {quantity.highest:.1f}, alarm at {quantity.threshold:.1f})"
    )


def _too_few(report: DriftReport) -> str:
    from omnimate.calib.monitoring.drift import MIN_VALUES

    most = max((len(quantity.values) for quantity in report.quantities), default=0)
    return (
        f"{most} number(s) of a kind in {report.used} recording(s), and {MIN_VALUES} are needed: laps of a "
        f"square in one direction with fixes around them, or {MIN_VALUES} drives with turns of a robot "
        "with a linkage"
    )
