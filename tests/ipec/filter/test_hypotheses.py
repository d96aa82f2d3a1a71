"""The probabilities of the filter's hypotheses before a drive."""

import numpy as np
import pytest

from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS, SLOPE, chances_before
from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL, WATCHED


@pytest.mark.parametrize("prior", [CALIBRATED, NOMINAL, WATCHED])
def test_each_reading_wanders_with_the_odds_of_the_prior(prior):
    """Forms share the odds; a truck that creeps alone on a slope needs two things to be wrong."""
    chance, wrong = np.exp(chances_before(prior.wrong)), prior.wrong
    for number in range(len(READINGS)):
        forms = {hypothesis.form for hypothesis in HYPOTHESES if hypothesis.reading == number}
        share = 1.0 - (1.0 - wrong) / len(forms) if SLOPE in forms else 1.0
        wandering = [hypothesis.reading == number for hypothesis in HYPOTHESES]
        assert chance[wandering].sum() / chance[0] == pytest.approx(share * wrong / (1.0 - wrong))
