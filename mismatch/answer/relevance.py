"""Which findings are relevant, and which are traces: what is there, and changes hardly anything."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtr

from omnimate.mismatch.answer.constancy import UNUSUAL
from omnimate.mismatch.answer.nominal import innovations, open_loop
from omnimate.mismatch.answer.omnibus import RELEVANT, RELEVANT_SQUARE
from omnimate.mismatch.answer.rerun import rerun
from omnimate.mismatch.candidates.terms import UNKNOWN
from omnimate.mismatch.diagnosis import Change
from omnimate.mismatch.heldout import held_out
from omnimate.mismatch.recording.folds import SHORTEST

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.diagnosis import Finding, Fit
    from omnimate.mismatch.fit import Fitted
    from omnimate.mismatch.heldout import HeldOut
    from omnimate.vehicle.se2 import Array


def relevant(
    present: Sequence[Finding], fit: Fitted, residuals: HeldOut, summary: Fit
) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return what is found apart from its traces.

    Findings are relevant together, if the simulator that has them misses some channel by a twentieth less
    where no fit has seen it, from one reading to the next or open loop. Those that last, and pushes, must
    predict such data better than the robot as described does, and each of them better than the others do
    without it. What has a law and no name must also change a twentieth of what a nominal robot misses, as
    every floor makes it miss some.
    """
    laws = {effect.component for effect in fit.chosen.effects if effect.name == "law"}
    misses = _misses(fit.regression, summary, laws)
    predicts = _falls(fit, residuals.before, residuals.after) or _shrinks(summary.rerun.values())

    def is_relevant(finding: Finding) -> bool:
        if not is_large(finding, misses, laws):
            return False
        numbers = _numbers(fit, finding)
        return not numbers or (predicts and _adds(numbers, fit, residuals, summary))

    pairs = [(finding, is_relevant(finding)) for finding in present]
    return tuple(finding for finding, yes in pairs if yes), tuple(
        finding for finding, yes in pairs if not yes
    )


def is_large(finding: Finding, misses: Sequence[tuple[Change, float]], laws: Collection[str]) -> bool:
    """Say whether the findings change enough of the simulation, or one that has no name does.

    `misses` are those of `_misses`; `laws` are the components of which a law was learned.
    """
    if finding.effect != UNKNOWN:
        return any(change.after < (1.0 - RELEVANT) * change.before for change, _ in misses)
    stands_out = any(
        change.before**2 - change.after**2 >= RELEVANT_SQUARE * max(change.before, usual) ** 2
        for change, usual in misses
    )
    return stands_out or finding.component not in laws


def _misses(regression: Regression, fit: Fit, laws: Collection[str]) -> list[tuple[Change, float]]:
    """Return by how much each channel is missed without and with the findings, and by a nominal robot.

    The latter is asked of laws only, and 0 without any.
    """
    nominal_channels, nominal_rerun = (innovations(regression), open_loop(regression)) if laws else ({}, {})
    return [
        (change, nominal.get(name, 0.0))
        for changes, nominal in ((fit.channels, nominal_channels), (fit.rerun, nominal_rerun))
        for name, change in changes.items()
    ]


def _numbers(fit: Fitted, finding: Finding) -> set[int]:
    """Return the numbers of a finding's effects in a fit that must predict unseen stretches.

    None of what no effect of the fit describes, or of a named one at a moment or a place: it acts in few
    stretches, and may be in none that is left out.
    """
    names = {finding.key, ("law", finding.component)} if finding.effect == UNKNOWN else {finding.key}
    return {
        number
        for number, term in enumerate(fit.chosen.terms)
        if term.key in names and (term.is_unknown or not term.is_local)
    }


def _adds(numbers: Collection[int], fit: Fitted, residuals: HeldOut, summary: Fit) -> bool:
    """Say whether some effects of a fit predict what the others do not.

    No other stretch of the drive says what a push was, so that only the open-loop error is asked of pushes.
    """
    without = held_out(fit, residuals.kind, numbers)
    repeats = not any(fit.chosen.terms[number].is_unknown for number in numbers)
    if repeats and _falls(fit, without.after, residuals.after):
        return True
    others = rerun(fit, without)
    return _shrinks(Change(others[name].after, change.after) for name, change in summary.rerun.items())


def _falls(fit: Fitted, before: Array, after: Array) -> bool:
    """Say whether the chi-square of residuals (V,) falls: Student's t over what repeats independently.

    That is recordings, or the blocks of 8 s of a single one.
    """
    regression = fit.regression
    stretch = regression.owner
    if len(regression.windows) == 1:
        time = regression.windows[0].time
        stretch = regression.of_rows([np.floor((time - time[0]) / SHORTEST).astype(np.int64)])
    gain = np.bincount(stretch, before**2 - after**2)
    if len(gain) < 2:
        return False
    error = float(gain.std(ddof=1)) / np.sqrt(len(gain))
    return float(stdtr(len(gain) - 1, -gain.mean() / max(error, 1e-300))) < UNUSUAL


def _shrinks(changes: Iterable[Change]) -> bool:
    """Say whether open-loop errors shrink by a twentieth, in the geometric mean of channels.

    True for a drive that is too short for an open loop.
    """
    logs = [np.log(change.after / change.before) for change in changes]
    return not logs or float(np.mean(logs)) < np.log(1.0 - RELEVANT)
