"""What a report draws: residuals along the drive, signatures, and the candidates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import wheel_number
from omnimate.mismatch.diagnosis import Evidence, Signature, Trace
from omnimate.mismatch.recording.folds import laps_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.diagnosis import Finding
    from omnimate.mismatch.fit import Fitted
    from omnimate.mismatch.heldout import HeldOut
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

_BINS = 14


def evidence_of(
    fit: Fitted,
    residuals: HeldOut,
    findings: Sequence[Finding],
    candidates: tuple[tuple[str, str, float, float], ...],
) -> Evidence:
    """Return what a report draws of a diagnosis."""
    fitted = fit.regression
    traces = tuple(_trace(fitted, number, residuals) for number in range(len(fitted.windows)))
    numbers = {finding.key: number for number, finding in enumerate(findings)}
    signatures = [
        signature
        for number, effect in enumerate(fit.chosen.effects)
        if (effect.name, effect.component) in numbers
        and (signature := _signature(fit, number, effect, numbers)) is not None
    ]
    return Evidence(tuple(fitted.windows[0].names), traces, tuple(signatures), candidates)


def _trace(fitted: Regression, number: int, residuals: HeldOut) -> Trace:
    windows = fitted.windows[number]
    of_recording = fitted.owner == number
    grids = []
    for rows in (residuals.before, residuals.after):
        grid = np.full(windows.measured.shape, np.nan)
        grid[fitted.moment[of_recording], fitted.channel[of_recording]] = rows[of_recording]
        grids.append(grid)
    lap = np.full(len(windows.ends), -1)
    for count, (start, end) in enumerate(laps_of(windows.signals.recording)):
        lap[(windows.time >= start) & (windows.time <= end)] = count
    path = windows.signals.path[windows.ends, 0, :2]
    return Trace(windows.signals.recording.source, windows.time, path, lap, grids[0], grids[1])


def _signature(
    fit: Fitted, number: int, effect: Effect, numbers: dict[tuple[str, str], int]
) -> Signature | None:
    """Return an effect's part of the data against the quantity that it depends on, in bins."""
    fitted = fit.regression
    predicted = fitted.white[:, fit.chosen.places[number]] @ fit.chosen.values[number]
    rows = fitted.white[:, 0] + predicted
    power = np.bincount(fitted.channel, weights=predicted**2)
    channel = int(np.argmax(power))
    pairs = [_quantity(effect, windows) for windows in fitted.windows]
    of_channel = fitted.channel == channel
    values = fitted.of_rows([along for along, _ in pairs])[of_channel]
    edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1)))
    if len(edges) < 3:
        return None
    group = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    count = np.maximum(np.bincount(group, minlength=len(edges) - 1), 1)
    means = [
        np.bincount(group, weights=one[of_channel], minlength=len(edges) - 1) / count
        for one in (rows, predicted)
    ]
    return Signature(
        numbers[effect.name, effect.component],
        pairs[0][1],
        fitted.windows[0].names[channel],
        0.5 * (edges[1:] + edges[:-1]),
        means[0],
        1.0 / np.sqrt(count),
        means[1],
    )


def _quantity(effect: Effect, windows: Windows) -> tuple[Array, str]:
    """Return what an effect depends on, at every window's end `(M + 1,)`, and what that is called."""
    signals, block, component = windows.signals, windows.signals.block, effect.component
    joint = 1 if component == "joint_b" else 0
    truck = 1 if component in {"b", "joint_b"} and len(signals.trucks) > 1 else 0
    values, label = windows.time - windows.time[0], "time [s]"
    match effect.plotted_over:
        case "wheel angle":
            order = getattr(effect, "order", 1.0)
            values = _turns(order * windows.at_ends(block.angle[:, wheel_number(component)]))
            label = f"angle of {component}{f' x {order:g}' if order != 1.0 else ''} [degrees]"
        case "joint angle":
            values = np.degrees(signals.reading[windows.ends, joint])
            label = f"angle of joint_{'ab'[joint]} [degrees]"
        case "heading":
            values, label = _turns(signals.path[windows.ends, 0, 2]), "heading [degrees]"
        case "link length":
            values, label = signals.reading[windows.ends, 2], "link length [m]"
        case "speed":
            values, label = windows.at_ends(block.speed.mean(axis=1)), "speed [m/s]"
        case "turn rate":
            values = np.degrees(windows.at_ends(block.twist[:, truck, 2] / block.period))
            label = f"turn rate of truck {'ab'[truck]} [degrees/s]"
    return values, label


def _turns(angle: Array) -> Array:
    """Return angles [rad] as degrees within one turn."""
    return np.asarray(np.degrees(angle % (2.0 * np.pi)))
