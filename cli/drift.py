"""`omnimate drift`: recordings of one robot -> whether it is time to calibrate again."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cli.console import out

if TYPE_CHECKING:
    from calib.drift_watch import DriftReport, Watched

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
    """Say whether it is time to calibrate again: fine, calibrate again, or cannot tell."""
    from calib.drift_watch import watch_drift
    from cli.loading import load

    report = watch_drift([load(source) for source in sources], false_alarm)
    out.print(verdict(report), soft_wrap=True)


def verdict(report: DriftReport) -> str:
    """Return one line: fine, calibrate again, or cannot tell, with the numbers that say so."""
    since = f"; {report.left_out} recording(s) from before the last calibration left out"
    rest = since if report.left_out else ""
    if report.alarms:
        return f"calibrate again: {_shift(report.alarms[0])}{rest}"
    if not report.tells:
        return f"cannot tell: {_too_few(report)}{rest}"
    worst = max(report.watched, key=lambda one: one.highest)
    return (
        f"fine: no shift in {len(report.watched)} kinds of numbers from {report.used} recording(s); nearest "
        f"to an alarm is the {worst.name}, {worst.highest:.1f} of {worst.threshold:.1f} "
        f"after {len(worst.values)}{rest}"
    )


def _shift(one: Watched) -> str:
    assert one.since is not None  # the caller has an alarm
    unit, scale, digits = _SCREEN[one.unit]
    before, after = one.means
    return (
        f"{one.name} was {scale * before:+.{digits}f} {unit} and is {scale * after:+.{digits}f} {unit} from "
        f"number {one.since} of {len(one.values)} on (sum {one.highest:.1f}, alarm at {one.threshold:.1f})"
    )


def _too_few(report: DriftReport) -> str:
    from calib.drift_watch import ENOUGH

    most = max((len(one.values) for one in report.watched), default=0)
    return (
        f"{most} number(s) of a kind in {report.used} recording(s), and {ENOUGH} are needed: laps of a "
        f"square in one direction with fixes around them, or {ENOUGH} recordings of a robot with a linkage"
    )
