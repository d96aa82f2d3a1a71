"""The statistics of UMBmark, counted over many simulated experiments, in about fifteen minutes.

The wheelbase is also fitted with everything free (`calibrate`) to recordings of squares, which takes most of
the time.

Peers: the paper's printed equations beside the exact and the weighted ones, and the Cramer-Rao bound.

Usage: python -m studies.estimators.umbmark_trials
"""

import time
from dataclasses import replace

import numpy as np

from omnimate.calib.umbmark.bootstrap import bootstrap
from omnimate.calib.umbmark.experiment import calibrate
from omnimate.calib.umbmark.guards import advise, without_outliers
from omnimate.calib.umbmark.printed import Method
from studies.benchmark import options
from studies.papers.trials import (
    Trial,
    after_calibration,
    coverage,
    efficiency,
    floor_covariance,
    free_coverage,
    left_over,
    plain_covariance,
)

FIGURE_11 = (0.98874, 1.00084)
METHODS: tuple[Method, ...] = ("printed", "heading", "exact", "weighted")
TRIAL = Trial(*FIGURE_11, floor_covariance(0.025))


def main() -> None:
    options(__doc__)
    sizes = 1e3 * after_calibration(TRIAL, 4000)
    low, high = np.percentile(sizes, [5, 95])
    print(f'"after" with 25 mm of scatter: mean {sizes.mean():.1f} mm, 5 to 95 % {low:.1f} to {high:.1f} mm')
    for factors in (FIGURE_11, (0.95, 1.005)):
        for method in ("printed", "exact", "weighted"):
            left = 1e3 * left_over(Trial(*factors, floor_covariance(0.022)), 1000, method).mean()
            print(f"left over at {factors} with 22 mm of scatter, {method}: {left:.1f} mm")
    plain = Trial(*FIGURE_11, plain_covariance(0.022))
    print("variance over bound, true weights:", efficiency(plain, 100_000, estimated_weights=False).round(3))
    print("variance over bound, own weights, 5 + 5:", efficiency(plain, 100_000).round(3))
    print("variance over bound, own weights, 20 + 20:", efficiency(replace(plain, runs=20), 50_000).round(3))
    for runs in (2, 5):
        for method in METHODS:
            held = 100.0 * coverage(replace(TRIAL, runs=runs), 2000, method)
            print(f"95 % intervals, {runs} + {runs} runs, {method}, hold E_b, E_d in {held.round(1)} %")
    for factors, position in ((FIGURE_11, 0.003), ((0.95, 1.005), 0.022), ((0.90, 1.02), 0.022)):
        for method in METHODS[::2]:
            held = 100.0 * coverage(Trial(*factors, floor_covariance(position)), 1000, method)
            where = f"{factors} with {1e3 * position:.0f} mm of scatter"
            print(f"95 % intervals at {where}, {method}, hold E_b, E_d in {held.round(1)} %")
    for runs, count in ((2, 300), (5, 200)):
        share, fits = free_coverage(replace(TRIAL, runs=runs), count, seed=1000)
        where = f"95 % intervals, {runs} + {runs} runs, everything free"
        print(f"{where}, hold the wheelbase in {100.0 * share:.1f} % of {fits}")
    experiment = TRIAL.drive(np.random.default_rng(0))
    start = time.perf_counter()
    bootstrap(calibrate(experiment))
    print(f"solve and 10 000 resamples: {time.perf_counter() - start:.2f} s")
    chance = np.random.default_rng(5)
    healthy = [TRIAL.drive(chance) for _ in range(3000)]
    alarms = sum(bool(advise(drive) or without_outliers(drive)[1]) for drive in healthy)
    print(f"the guards warn of {alarms} of 3000 healthy experiments")


if __name__ == "__main__":
    main()
