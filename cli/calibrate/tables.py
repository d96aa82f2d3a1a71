"""The tables and sentences that `omnimate calibrate` prints: millimetres and degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.text import Text

from omnimate.cli.tables import new_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from omnimate.calib.estimation.chains import Coordinate
    from omnimate.calib.estimation.estimates import DownWeighted, Estimate
    from omnimate.calib.paths.least_squares import Quantity

_SCREEN = {"1": ("%", 1e2), "rad": ("deg", math.degrees(1.0)), "m": ("mm", 1e3), "s": ("ms", 1e3)}
_MOST_NAMED = 5  # fixes that are listed one by one


def quantities_table(title: str, quantities: Sequence[Quantity]) -> Table:
    """Return parameters before and after, with their bound and interval."""
    heads = ("unit", "nominal", "calibrated", "sigma\n(Cramer-Rao)", "95 % from", "to")
    table = new_table(title, ("parameter",), heads)
    for quantity in quantities:
        unit, scale = screen_unit(quantity.name)
        numbers = (quantity.nominal, quantity.value, quantity.sigma, quantity.low, quantity.high)
        table.add_row(Text(quantity.name), unit, *(f"{scale * number:.4f}" for number in numbers))
    return table


def screen_unit(name: str) -> tuple[str, float]:
    """Return the unit in which a quantity is shown, and what it is times from SI."""
    if name.endswith(("yaw", "offset")) or name.startswith("joint"):
        return "deg", math.degrees(1.0)
    return ("ms", 1e3) if name.endswith("time") else ("mm", 1e3)


def factors_table(estimate: Estimate) -> Table:
    """Return the coordinates of the fit: what is known without a drive, the bound, and what is held."""
    table = new_table(
        "What the drives say", ("coordinate",), ("change", "bound", "known without\na drive", "")
    )
    held = {parameter.name: parameter.reason for parameter in estimate.held}
    for parameter, change, sigma in zip(
        estimate.parameters, estimate.coordinates, estimate.sigma, strict=True
    ):
        word = f"held: {held[parameter.name]}" if parameter.name in held else ""
        bound = "-" if parameter.name in held else _size(parameter, sigma)
        sizes = _size(parameter, change, sign=True), bound, _size(parameter, parameter.prior_sigma)
        table.add_row(Text(parameter.name), *sizes, Text(word))
    return table


def noise_sentences(estimate: Estimate) -> list[str]:
    """Return what the fit says about its noise, its conditioning and the fixes that it did not believe."""
    noises = [
        f"{noise.source.name} {noise.value:.3g} {noise.source.unit} ({_how(noise.freedom)})"
        for noise in estimate.noises
        if noise.freedom > 0.0 or noise.source.name == "roughness"
    ]
    known = f"condition number {estimate.condition:.3g} of the information on what was estimated"
    bad = estimate.down_weighted
    sentences = ["noise: " + "; ".join(noises)] if noises else []
    sentences += [
        f"{known}; {estimate.fixes} absolute poses or readings, whitened residual {estimate.rms:.2f}",
    ]
    sentences += [_contradicted(fix) for fix in bad[:_MOST_NAMED]]
    if len(bad) > _MOST_NAMED:
        sentences.append(f"down-weighted: {len(bad) - _MOST_NAMED} more")
    return sentences


def _how(freedom: float) -> str:
    return f"estimated, {freedom:.0f} degrees of freedom" if freedom > 0.0 else "assumed"


def _contradicted(fix: DownWeighted) -> str:
    far = f"{fix.distance:.1f} sigma from what all others say, weight {fix.weight:.2g}"
    return f"down-weighted: {fix.source}, {fix.time:.3f} s: {far}"


def _size(parameter: Coordinate, value: float, *, sign: bool = False) -> str:
    unit, scale = _SCREEN[parameter.unit]
    number = f"{scale * value:+.4f}" if sign else f"{scale * value:.4f}"
    return f"{number} {unit}"
