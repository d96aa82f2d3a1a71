"""An experiment by every method, and the advice on it."""

import numpy as np
import pytest

from omnimate.calib.errors import MethodError
from omnimate.calib.umbmark.assessment import assess
from omnimate.calib.umbmark.experiment import Experiment, calibrate, usable_methods
from omnimate.calib.umbmark.guards import advise
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.vehicle.parameters import Truck

TRUCK = Truck(0.340, 0.150, 0.150)
CW = np.array([(0.150, 0.152, np.nan), (0.148, 0.139, np.nan), (0.152, 0.146, np.nan)])
CCW = np.array([(0.221, -0.214, np.nan), (0.207, -0.209, np.nan), (0.214, -0.220, np.nan)])


def experiment(cw=CW, ccw=CCW):
    return Experiment("tape", TRUCK, ReturnErrors(cw, ccw, 4.0, "tape"))


def test_it_holds_the_calibration_by_every_usable_method_and_all_advice():
    data = experiment()
    assessment = assess(data, (), "a")
    methods = usable_methods(data.errors)
    assert tuple(result.correction.method for result in assessment.calibrations) == methods
    assert assessment.by("printed").truck == calibrate(data, "printed").truck
    assert assessment.advice == advise(data)
    assert assessment.is_usable


@pytest.mark.parametrize("method", ["heading", "weighted"])
def test_a_method_that_the_data_do_not_allow_says_what_it_needs(method):
    with pytest.raises(MethodError, match=f"^tape: the method {method} needs the heading of every run"):
        assess(experiment(), (), "a").by(method)


def test_an_experiment_with_an_error_among_its_advice_is_not_usable():
    assessment = assess(experiment(CW[:1], CCW[:1]), (), "a")
    assert [advice.severity for advice in assessment.advice] == ["error"]
    assert not assessment.is_usable
