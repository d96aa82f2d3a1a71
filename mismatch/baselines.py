"""What simpler methods answer: one-step-ahead residuals taken for white noise, and a plain choice of terms.

The library's columns, what is tolerated in every robot, the proposals of events and the answer are the
tool's own. What is not: its noise model, its comparison of sets, its unknowns, its refinement.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import Choice, decoded
from omnimate.mismatch.diagnosis import Alternative, Diagnosis, Finding, Parameter, Where
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.investigate import tolerated
from omnimate.mismatch.noise import DEFAULT_LEVELS, Filter, start_of
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.scan import merged, proposals
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.sparse import METHODS, NOTHING, chosen, left, weights
from omnimate.mismatch.terms import skews, smooth_terms
from omnimate.mismatch.uncertainty import sigmas
from omnimate.mismatch.validate import check, too_little
from omnimate.mismatch.where import crossings
from omnimate.mismatch.whitening import gains_of
from omnimate.mismatch.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.choose import Set
    from omnimate.mismatch.sparse import Method
    from omnimate.mismatch.windows import Windows
    from omnimate.vcan_sim.effects.effect import Effect
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

PUSHED = 1e-3  # [m, rad] of every pose in every window, whatever the way driven
EXACT = 1e-5  # [m, rad] of every reading: the last one is believed
ROUNDS = 2  # of proposed events
POSSIBLE = 0.01  # probability from which an alternative is named


def baseline(recordings: Sequence[Recording], name: str) -> Diagnosis:
    """Return what a plain method answers to recordings of one robot; it says nothing about held-out laps.

    Args:
        recordings: of one robot.
        name: of the method, one of `METHODS`.

    Raises:
        RecordingError: as `diagnose`.
        KeyError: no such method.
    """
    method = METHODS[name]
    check(recordings)
    reason = too_little(recordings)
    if reason:
        return Diagnosis("insufficient", reason)
    windows = [windows_of(signals_of(one)) for one in recordings]
    regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
    choice, best = searched(regression, method)
    rows = len(regression.white)
    choice.spread = left(choice, best) / rows
    findings = tuple(_finding(regression, choice, best, one) for one in best)
    ranked = sorted(findings, key=lambda one: -one.explained)
    return Diagnosis("mismatch" if ranked else "agreement", name, tuple(ranked))


def one_step(windows: Windows, levels: Array) -> Filter:
    """Return the filter that predicts from the last readings, taken as exact, and poses as their file states.

    Args:
        windows: of a recording.
        levels: (R,) standard deviations of the residuals.
    """
    states, poses = windows.transition.shape[1], windows.drift.shape[1]
    process = np.zeros((len(windows.drift), states, states))
    process[:, range(poses), range(poses)] = PUSHED**2
    there = np.isfinite(windows.measured)
    variance = np.where(there, EXACT**2 + windows.stated, np.nan)
    gains, _ = gains_of(
        windows.transition, windows.links, process, windows.observe, variance, start_of(windows)
    )
    return Filter(windows, windows.transition, gains, np.where(there, levels**2, np.nan))


def searched(regression: Regression, method: Method) -> tuple[Choice, Set]:
    """Return all terms, and those that a method chooses; events are proposed where it leaves something.

    Args:
        regression: without columns; it gets those of all terms, one step ahead.
        method: of choosing terms.
    """
    terms = smooth_terms([own.signals for own in regression.windows])
    skew = slice(1, 1 + len(regression.add(skews(regression.windows[0].signals))))
    places = regression.add(terms)
    level(regression)
    choice = Choice(terms, places, tolerated(regression, terms, places, skew))
    best = chosen(choice, method, len(regression.white))
    for _ in range(ROUNDS):
        new = merged(terms, proposals(regression, choice, best))
        places = [*places, *regression.add(new)]
        terms = [*terms, *new]
        choice = Choice(terms, places, tolerated(regression, terms, places, skew))
        best = chosen(choice, method, len(regression.white))
    return choice, best


def level(regression: Regression) -> None:
    """Filter one step ahead, each channel in units of what all columns together leave of it."""
    levels = np.ones(regression.windows[0].measured.shape[1])
    for rows in (_data, unexplained):
        regression.filter([one_step(own, levels) for own in regression.windows])
        levels = levels * _sizes(regression, rows(regression))
    regression.filter([one_step(own, levels) for own in regression.windows])


def _data(regression: Regression) -> Array:
    return regression.white[:, 0]


def unexplained(regression: Regression) -> Array:
    """Return what all columns together leave."""
    total, columns = regression.total, regression.white[:, 1:]
    ridge = np.eye(columns.shape[1])
    return np.asarray(regression.white[:, 0] - columns @ np.linalg.solve(total[1:, 1:] + ridge, total[1:, 0]))


def _sizes(regression: Regression, rows: Array) -> Array:
    """Return the root mean square (R,) of rows by channel; one where there are none."""
    channels = regression.windows[0].measured.shape[1]
    power = np.bincount(regression.channel, rows**2, channels)
    count = np.bincount(regression.channel, minlength=channels)
    return np.where(power > 0.0, np.sqrt(power / np.maximum(count, 1)), 1.0)


def _finding(regression: Regression, choice: Choice, best: Set, one: int) -> Finding:
    """Return a member of the chosen set as a finding, with Schwarz weights for probabilities."""
    shares = weights(choice, best, one, len(regression.white))
    term = choice.terms[one]
    coefficients, covariance = next((own, spread) for at, own, spread in decoded(choice, best) if at == one)
    effect = term.built(coefficients)
    intervals = crossings(effect, [own.signals for own in regression.windows])
    return Finding(
        *term.key,
        shares[term.key],
        _alternatives(shares, term.key),
        Where(intervals=intervals),
        _parameters(effect, sigmas(term, effect, covariance)),
        1.0 - left(choice, best) / left(choice, best - {one}),
    )


def _alternatives(shares: dict[tuple[str, str], float], own: tuple[str, str]) -> tuple[Alternative, ...]:
    others = [Alternative(*key, share) for key, share in shares.items() if key not in {own, NOTHING}]
    likely = [other for other in others if other.probability >= POSSIBLE]
    return tuple(sorted(likely, key=lambda other: -other.probability))


def _parameters(effect: Effect, known: dict[str, float | tuple[float, ...]]) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(spec.name, getattr(effect, spec.name), known.get(spec.name, 0.0), spec.unit)
        for spec in effect.parameters
        if spec.name != "intervals"
    )
