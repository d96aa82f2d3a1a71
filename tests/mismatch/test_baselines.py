"""Baselines: the tool's columns and answer, with a plain residual and a plain choice."""

import numpy as np
import pytest

from omnimate.mismatch.baselines import baseline, level, unexplained
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.sparse import METHODS
from omnimate.mismatch.terms import smooth_terms
from omnimate.mismatch.windows import windows_of
from omnimate.proof.scoring.judging import first_right, fits
from omnimate.proof.scoring.score import rows

LABEL = {
    "kind": "single",
    "effects": [
        {
            "effect": "wheel_diameter",
            "component": "a.left",
            "intervals": [],
            "parameters": {"ratio": {"value": 1.004, "unit": "1"}},
            "acceptable": [
                {"effect": one, "component": "a.left"} for one in ("count_loss", "radius_vs_speed")
            ],
        }
    ],
}


@pytest.fixture(scope="module")
def worn(drive, effect):
    return drive(effect("wheel_diameter", "a.left", ratio=1.004))


@pytest.mark.parametrize("name", METHODS)
def test_a_worn_wheel_is_among_the_findings_of_an_answer_that_is_scored_as_the_tools(worn, name):
    answer = baseline([worn], name).as_json()
    assert answer["verdict"] == "mismatch"
    truth = LABEL["effects"][0]
    assert any(fits(one["effect"], one["component"], truth) for one in answer["findings"])
    table = {row.name: row for row in rows({"worn": LABEL}, {"worn": answer})}
    assert table["one effect: right first"].hits == first_right(LABEL, answer)
    assert name == "lasso" or first_right(LABEL, answer)  # which shares it among what looks alike
    assert table["held-out residual after <= 1.05"].of == 0


def test_a_healthy_robot_agrees(drive):
    assert baseline([drive()], "STLSQ").verdict == "agreement"


def test_a_method_that_does_not_exist_is_refused(worn):
    with pytest.raises(KeyError):
        baseline([worn], "oracle")


def test_each_channel_is_in_units_of_what_all_columns_leave_of_it(drive):
    windows = [windows_of(signals_of(drive()))]
    regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
    regression.add(smooth_terms([own.signals for own in windows]))
    level(regression)
    rows = unexplained(regression)
    for channel in range(3):
        assert np.sqrt(np.mean(rows[regression.channel == channel] ** 2)) == pytest.approx(1.0, abs=0.02)
