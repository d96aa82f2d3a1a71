"""What each group of the filter's hypotheses earns: the error along drives without it, over that with it.

In every drive of `tracking_worlds` the hypotheses are mixed with all of them, and without each group. All
mixtures come from one run, as the hypotheses influence each other by the point of linearisation only.

The table has, for each group, the geometric mean of the ratio of rms position errors without and with it, the
largest ratio and its drive (the group earns this much there), the smallest ratio (it costs this much there),
and the geometric mean of the ratio of NEES. Errors below 2 mm count as 2 mm.

Peer: the filter with all of its hypotheses, over the same drives.

Usage: python -m studies.estimators.hypotheses [--seeds N ...] [--without GROUP ...] [--folder FOLDER]
    [WORLD ...]

Draw seeds that chose no constant. With --without, the named groups are left out together instead, as one
group may replace another. FOLDER keeps drives (`build/tracking` by default).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import gmean

from omnimate.ipec.errors import LinkageChannelError
from omnimate.ipec.filter.estimate import Table
from omnimate.ipec.filter.fixes import fix_records
from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS, Hypothesis
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.mixture import MIN_LOG_ODDS, TURNED_AXLE_PROBABILITY, mix_hypotheses
from omnimate.ipec.filter.poses import add_axle_angle_variance, fill_pose
from omnimate.ipec.filter.records import JOINT_BIAS, STATES
from omnimate.ipec.filter.step import finish_step, predict
from omnimate.ipec.linkage_check import check_linkage
from omnimate.ipec.readings import ordered_counts
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.recording import Recording
from studies.estimators.tracking import errors_of, judge_of, nees, rms
from studies.estimators.tracking_worlds import drives_of

STRIDE = 10  # steps between two poses that are judged
NEGLIGIBLE = -10.0  # log odds of a hypothesis without weight, above the filter's own least odds
FLOOR = 0.002  # [m] below which an error counts as this: a good tracker's scatter


@compiled
def run_subsets(
    settings: Record,
    states: Record,
    filters: Record,
    table: Table,
    priors: Array,
    poses: Array,
    sigmas: Array,
) -> None:
    """Run the filter over a recording, and mix subsets of its hypotheses after every `STRIDE` steps.

    `settings` (of which the prior is changed), `states` `(1,)` and `filters` `(H,)` are those of an open
    filter, and are moved to the end. `priors` `(S, H)` are log probabilities, -inf of a hypothesis that is
    left out. `poses` of truck a [m, m, rad] `(S, N, 3)` and `sigmas` are filled: of the first subset at every
    sample, of the others where they are mixed.
    """
    state, moves, steps = states[0], np.empty((0, STATES + 2)), 0
    trial, subset_settings = states.copy(), settings.copy()
    odds = priors.copy()
    for sample in range(len(table.counts)):
        settings[0].log_prior[:] = np.maximum(odds[0] - odds[0].max(), NEGLIGIBLE)
        state.score[:] = 0.0
        if predict(settings, states, table.counts[sample], table.present[sample]):
            finish_step(settings, states, filters, moves)
        fill_pose(state.mean, state.covariance, 0, poses[0, sample], sigmas[0, sample])
        if not state.predicted:
            continue
        for subset in range(len(odds)):
            odds[subset] += state.score
            odds[subset] = np.where(
                priors[subset] > -np.inf, np.maximum(odds[subset], odds[subset].max() + MIN_LOG_ODDS), -np.inf
            )
            if steps % STRIDE == 0:
                trial[0] = state
                trial[0].score[:] = 0.0
                subset_settings[0].log_prior[:] = odds[subset]
                mix_hypotheses(subset_settings[0], trial[0], filters)
                trial[0].mean[:] += trial[0].move
                bias = trial[0].mean[JOINT_BIAS]
                variance = TURNED_AXLE_PROBABILITY * bias * bias
                add_axle_angle_variance(trial[0].covariance, trial[0].mean, trial[0].origin, variance)
                fill_pose(
                    trial[0].mean, trial[0].covariance, 0, poses[subset, sample], sigmas[subset, sample]
                )
        steps += 1


class Result(NamedTuple):
    """Root mean square of the position error [m], and NEES."""

    error: float
    nees: float


def groups() -> dict[str, IntArray]:
    """Return the numbers of the hypotheses in each group: of one form and kind of reading, or of one size."""
    members: dict[str, list[int]] = {}
    largest: dict[object, float] = {}
    for number, hypothesis in enumerate(HYPOTHESES[1:], 1):
        for name in _groups_of(hypothesis, largest):
            members.setdefault(name, []).append(number)
    return {name: np.array(numbers) for name, numbers in members.items()}


def _groups_of(hypothesis: Hypothesis, largest: dict[object, float]) -> list[str]:
    """Return the groups of a hypothesis; `largest` has the largest size of each kind before it."""
    kind = hypothesis.reading, hypothesis.form, hypothesis.correlation_length
    size = hypothesis.sizes[0] / largest.setdefault(kind, hypothesis.sizes[0])
    where = READINGS[hypothesis.reading]
    where = {"a": "wheel", "w": "truck", "j": "joint", "l": "link", "b": "wheel"}[where[0]]
    form = FORM_NAMES[hypothesis.form]
    names = [f"{form}: {where}"]
    if form in {"wander", "push"}:
        names.append(f"{form}: size {size:.2f}")
    if form == "wander" and where != "wheel":
        names.append(f"wander: length {hypothesis.correlation_length:g}")
    return names


FORM_NAMES = ("wander", "off centre", "link scale", "play", "late", "slope", "push")
WHOLE, EVERY = "with all", "all but the first"


def measure(recording: Recording, subsets: dict[str, IntArray]) -> dict[str, Result]:
    """Return error and NEES along a drive without the hypotheses of each subset, by its name."""
    check_linkage(recording)
    filter_, judge = Filter(recording.vehicle), judge_of(recording)
    begun = filter_.start()
    table = Table(*ordered_counts(recording), fix_records(recording, None))
    priors = np.tile(filter_.settings["log_prior"][0], (len(subsets), 1))
    for row, left_out in zip(priors, subsets.values(), strict=True):
        row[left_out] = -np.inf
    poses = np.full((len(subsets), len(recording), 3), np.nan)
    sigmas = poses.copy()
    run_subsets(filter_.settings, begun.record.copy(), begun.filters.copy(), table, priors, poses, sigmas)
    results, time = {}, recording.time
    for name, pose, sigma in zip(subsets, poses, sigmas, strict=True):
        mixed = np.isfinite(pose[:, 0])
        if name != WHOLE:
            for axis in range(3):  # the difference is smooth, the path is not
                moved, scale = pose[mixed, axis] - poses[0, mixed, axis], sigma[mixed, axis]
                pose[:, axis] = poses[0, :, axis] + np.interp(time, time[mixed], moved)
                sigma[:, axis] = np.interp(time, time[mixed], scale)
        error = errors_of(judge, time, pose)
        results[name] = Result(rms(error), nees(judge, error, time, sigma))
    return results


def tabulate(drives: dict[str, dict[str, Result]], names: list[str]) -> None:
    """Print the table of all drives so far."""
    print(f"\n{len(drives)} drives{'':<19} mean  largest at{'':<37} smallest at{'':<34} NEES")
    places = list(drives)
    for name in names:
        ratios = np.array(
            [max(drive[name].error, FLOOR) / max(drive[WHOLE].error, FLOOR) for drive in drives.values()]
        )
        change = np.array([drive[name].nees / drive[WHOLE].nees for drive in drives.values()])
        most, least = int(ratios.argmax()), int(ratios.argmin())
        print(
            f"{name:<25}{gmean(ratios):10.3f} {ratios[most]:8.2f} {places[most][:38]:<38}"
            f"{ratios[least]:8.2f} {places[least][:38]:<38}{gmean(change):6.2f}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[9001])
    parser.add_argument("--folder", type=Path, default=Path("build/tracking"))
    parser.add_argument("--without", nargs="+", choices=groups(), metavar="GROUP")
    parser.add_argument("worlds", nargs="*")
    asked = parser.parse_args()
    subsets = {WHOLE: np.array([], np.int64), **groups(), EVERY: np.arange(1, len(HYPOTHESES))}
    if asked.without:
        together = np.unique(np.concatenate([subsets[name] for name in asked.without]))
        subsets = {WHOLE: subsets[WHOLE], "without them": together}
    drives: dict[str, dict[str, Result]] = {}
    for world in asked.worlds or ["made", "common", "engine"]:
        for seed in asked.seeds:
            for what, recording in drives_of(world, asked.folder, seed):
                try:
                    results = measure(recording, subsets)
                except LinkageChannelError:
                    continue
                drives[f"{world} {seed}: {what}"] = results
            tabulate(drives, list(subsets)[1:])


if __name__ == "__main__":
    main()
