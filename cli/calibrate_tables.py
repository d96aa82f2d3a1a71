"""The tables and sentences that `omnimate calibrate` and `omnimate design` print: millimetres and degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calib.design import Design
    from calib.estimates import DownWeighted, Estimate
    from calib.kinematics import Coordinate
    from calib.least_squares import Quantity
    from calib.optiodom_score import RobotScores, Score

_SCREEN = {"1": ("%", 1e2), "rad": ("deg", math.degrees(1.0)), "m": ("mm", 1e3), "s": ("ms", 1e3)}
_MOST_NAMED = 5  # fixes that are listed one by one


def table_of(title: str, left: Sequence[str], right: Sequence[str]) -> Table:
    """Return an empty table with columns of words, then columns of numbers."""
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    for head in left:
        table.add_column(Text(head))
    for head in right:
        table.add_column(Text(head), justify="right")
    return table


def quantities_table(title: str, quantities: Sequence[Quantity]) -> Table:
    """Return parameters before and after, with their bound and interval."""
    heads = ("unit", "nominal", "calibrated", "sigma\n(Cramer-Rao)", "95 % from", "to")
    table = table_of(title, ("parameter",), heads)
    for one in quantities:
        unit, scale = screen_unit(one.name)
        numbers = (one.nominal, one.value, one.sigma, one.low, one.high)
        table.add_row(Text(one.name), unit, *(f"{scale * number:.4f}" for number in numbers))
    return table


def screen_unit(name: str) -> tuple[str, float]:
    """Return the unit in which a quantity is shown, and what it is times from SI."""
    if name.endswith(("yaw", "offset")) or name.startswith("joint"):
        return "deg", math.degrees(1.0)
    return ("ms", 1e3) if name.endswith("time") else ("mm", 1e3)


def factors_table(estimate: Estimate) -> Table:
    """Return the coordinates of the fit: what is known without a drive, the bound, and what is held."""
    table = table_of(
        "What the drives tell", ("coordinate",), ("change", "bound", "known without\na drive", "")
    )
    held = {one.name: one.reason for one in estimate.held}
    for one, change, sigma in zip(estimate.names, estimate.coordinates, estimate.sigma, strict=True):
        word = f"held: {held[one.name]}" if one.name in held else ""
        bound = "-" if one.name in held else _size(one, sigma)
        table.add_row(Text(one.name), _size(one, change, sign=True), bound, _size(one, one.doubt), Text(word))
    return table


def noise_sentences(estimate: Estimate) -> list[str]:
    """Return what the fit says about its noise, its conditioning and the fixes that it did not believe."""
    noises = [
        f"{one.noise.name} {one.value:.3g} {one.noise.unit} ({_how(one.freedom)})"
        for one in estimate.noises
        if one.freedom > 0.0 or one.noise.name == "roughness"
    ]
    told = f"condition number {estimate.condition:.3g} of the information on what was estimated"
    bad = estimate.down_weighted
    sentences = [
        "noise: " + "; ".join(noises),
        f"{told}; {estimate.fixes} absolute poses or readings, whitened residual {estimate.rms:.2f}",
    ]
    sentences += [_contradicted(fix) for fix in bad[:_MOST_NAMED]]
    if len(bad) > _MOST_NAMED:
        sentences.append(f"down-weighted: {len(bad) - _MOST_NAMED} more")
    return sentences


def scores_table(robot: RobotScores) -> Table:
    """Return the scores of one OptiOdom robot on all sets: final / rms distance."""
    heads = (
        "runs",
        "raw\nfinal, rms",
        "printed UMBmark\nfinal, rms",
        "least squares\nfinal, rms",
        "and markers\nplaced",
    )
    table = table_of(
        f"{robot.kind}: dead reckoning against motion capture, millimetres; calibrated on the squares",
        ("set", "calibration"),
        heads,
    )
    for one in robot.sets:
        seen = "has seen it" if one.seen else "held out"
        scores = (_score(score) for score in (one.raw, one.printed, one.fitted, one.placed))
        table.add_row(Text(one.name), seen, str(one.runs), *scores)
    return table


def designs_table(designs: Sequence[Design]) -> Table:
    """Return the candidate drives: bounds before anybody drives, and what they leave on a square."""
    heads = (
        "drives",
        "wheels\nroll [m]",
        "wheelbase\n[%]",
        "E_s\n[%]",
        "E_d\n[%]",
        "left on a 4 m\nsquare [mm]",
    )
    table = table_of("Cramer-Rao bound of each drive, one sigma", ("drive",), heads)
    for one in designs:
        bounds = ("-" if math.isnan(sigma) else f"{1e2 * sigma:.4f}" for sigma in one.sigma)
        left = "not told" if math.isnan(one.leaves) else f"{1e3 * one.leaves:.1f}"
        table.add_row(Text(one.name), str(one.laps), f"{one.way:.0f}", *bounds, left)
    return table


def _how(freedom: float) -> str:
    return f"estimated, {freedom:.0f} degrees of freedom" if freedom > 0.0 else "assumed"


def _contradicted(fix: DownWeighted) -> str:
    far = f"{fix.distance:.1f} sigma from what all others say, weight {fix.weight:.2g}"
    return f"down-weighted: {fix.source}, {fix.time:.3f} s: {far}"


def _score(score: Score | None) -> str:
    return "-" if score is None else f"{1e3 * score.final:.1f}, {1e3 * score.rms:.1f}"


def _size(one: Coordinate, value: float, *, sign: bool = False) -> str:
    unit, scale = {"1": ("%", 1e2), "rad": ("deg", math.degrees(1.0)), "m": ("mm", 1e3), "s": ("ms", 1e3)}[
        one.unit
    ]
    number = f"{scale * value:+.4f}" if sign else f"{scale * value:.4f}"
    return f"{number} {unit}"
