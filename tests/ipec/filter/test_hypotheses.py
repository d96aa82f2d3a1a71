"""The probabilities of the filter's hypotheses before a drive."""

import numpy as np
import pytest

from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS, chances_before
from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL, WATCHED


@pytest.mark.parametrize("prior", [CALIBRATED, NOMINAL, WATCHED])
def test_each_reading_wanders_with_the_odds_of_the_prior(prior):
    chance = np.exp(chances_before(prior.wrong))
    for number in range(len(READINGS)):
        wandering = [hypothesis.reading == number for hypothesis in HYPOTHESES]
        assert chance[wandering].sum() / chance[0] == pytest.approx(prior.wrong / (1.0 - prior.wrong))
