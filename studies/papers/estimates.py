"""The path of a drive by each estimator, and its measurement by the sonar calibrator."""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np

from omnimate.ipec.corrections import advance_all
from omnimate.ipec.corrector import Corrector, Method, correct
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import Prior
from omnimate.ipec.filter.smoother import smooth
from omnimate.ipec.readings import ordered_counts
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import Array
from studies.papers.linkage_numbers import lap_errors
from studies.papers.robots import LEFT_BEHIND, UNCALIBRATED, Term

# CLAPPER and OmniMate are the papers' equations to the letter, but for the signs. "dead band" is what this
# project runs: CLAPPER which leaves alone what lies within a step of the joint encoder.
Estimator = Literal["plain", "CLAPPER", "OmniMate", "dead band", "filter", "smoother"]
ESTIMATORS: tuple[Estimator, ...] = get_args(Estimator)

# C 6: "to within +-2 millimeters", "about +-0.25 degrees"; O 3.2: +-3 mm beside, +-0.2 degrees. Bounds, not
# standard deviations: with 0.2 degrees of deviation, O's worst of ten laps would be 0.6 degrees and not 0.4.
# They are taken as half widths of a uniform distribution (GUM 4.3.7). O's rear sonar has +-30 mm, 0.3 % of
# 10 m: an error of scale, which the fixes before and after a lap at the same place share.
CLAPPER_SONAR = np.array([0.002, 0.002, math.radians(0.25)])
OMNIMATE_SONAR = np.array([0.003, 0.003, math.radians(0.2)])


def return_errors(
    recording: Recording,
    sonar: Array,
    seed: int,
    estimators: tuple[Estimator, ...] = ESTIMATORS,
    without: Term = "nothing",
) -> dict[Estimator, Array]:
    """Return the return errors `(L, 3)` of each estimator, measured with a sonar of half widths `(3,)`.

    Each estimate is compared lap by lap, from the fix before to the fix after it; no estimator is given more.
    """
    seen = measured(recording, sonar if without != "sonar" else 1e-9 * sonar, seed)
    prior = UNCALIBRATED if recording.vehicle.name == "omnimate" else LEFT_BEHIND
    return {name: lap_errors(recording, path_of(recording, name, seen, prior), seen) for name in estimators}


def path_of(recording: Recording, name: Estimator, seen: Poses, prior: Prior) -> Array:
    """Return the path `(N, 3)` of truck a by an estimator, from the first fix on."""
    start = seen.pose[0]
    if name == "plain":
        return correct(recording, start, method="plain").pose_a
    if name == "dead band":
        return correct(recording, start, method="clapper").pose_a
    if name == "CLAPPER":
        return as_derived(recording, start, "clapper")
    if name == "OmniMate":
        return as_derived(recording, start, "omnimate")
    run = estimate if name == "filter" else smooth
    return run(recording, start, seen.sigma[0], prior=prior).pose_a


def as_derived(recording: Recording, start: Array, method: Method) -> Array:
    """Return the path `(N, 3)` of truck a by C (12)-(13) or O (3)-(4): the whole difference is an error."""
    counts, present = ordered_counts(recording)
    corrector = Corrector(recording.vehicle, method)
    corrector.settings["tolerance"] = 0.0
    state = corrector.start(start).record.copy()
    poses, corrections = np.empty((2, len(counts), 3)), np.empty((len(counts), 3))
    advance_all(corrector.settings, state, counts, present, poses, corrections)
    return np.asarray(poses[0])


def measured(recording: Recording, sonar: Array, seed: int) -> Poses:
    """Return the exact fixes of truck a with the noise of a sonar of half widths `(3,)`."""
    assert recording.poses is not None
    fixes = recording.poses.of("a")
    noise = np.random.default_rng(seed).uniform(-1.0, 1.0, size=fixes.pose.shape) * sonar
    sigma = np.tile(sonar / math.sqrt(3.0), (len(fixes.time), 1))
    return Poses(fixes.time, fixes.body, fixes.pose + noise, sigma)


def sizes(errors: Array) -> tuple[Array, Array]:
    """Return distance [mm] and |heading| [degrees], `(..., L)` each, of return errors `(..., L, 3)`."""
    return 1e3 * np.hypot(errors[..., 0], errors[..., 1]), np.degrees(np.abs(errors[..., 2]))
