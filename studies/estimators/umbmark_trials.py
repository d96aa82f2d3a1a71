"""How often the intervals of UMBmark hold the truth, and its guards warn, over many simulated experiments.

It takes about fifteen minutes; `python -m studies reproduce` has bias and variance.

The wheelbase is also fitted with everything free (`calibrate`) to recordings of squares, which takes most of
the time.

Peers: the paper's printed equations with the exact and the weighted ones, and the true parameters.

Usage: python -m studies.estimators.umbmark_trials
"""

from dataclasses import replace

import numpy as np

from omnimate.calib.umbmark.bootstrap import bootstrap
from omnimate.calib.umbmark.experiment import calibrate
from omnimate.calib.umbmark.guards import advise, without_outliers
from omnimate.calib.umbmark.printed import Method
from studies.benchmark import duration, options
from studies.papers.trials import Trial, coverage, floor_covariance, free_coverage

FIGURE_11 = (0.98874, 1.00084)
METHODS: tuple[Method, ...] = ("printed", "heading", "exact", "weighted")
TRIAL = Trial(*FIGURE_11, floor_covariance(0.025))


def main() -> None:
    options(__doc__)
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
    print(f"solve and 10 000 resamples: {duration(lambda: bootstrap(calibrate(experiment))):.2f} s")
    chance = np.random.default_rng(5)
    healthy = [TRIAL.drive(chance) for _ in range(3000)]
    alarms = sum(bool(advise(drive) or without_outliers(drive)[1]) for drive in healthy)
    print(f"the guards warn of {alarms} of 3000 healthy experiments")


if __name__ == "__main__":
    main()
