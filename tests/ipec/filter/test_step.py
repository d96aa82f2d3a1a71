"""What a whole step of the filter takes of its mean readings."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prediction import differentiate, predict_mean
from omnimate.ipec.filter.records import JOINT_A, LINK, STATES, WHEEL
from omnimate.ipec.filter.step import begin_step, update
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.compiled import compiled

SAMPLES = 10
WRONG = 0.01  # of a wheel's travel


@compiled
def drive(all_settings, states, truths, travel):
    """Drive a step with an estimate and with the truth, whose linkage is read without an error."""
    given, state, truth = all_settings[0], states[0], truths[0]
    begin_step(state)
    for _ in range(SAMPLES):
        state.travel[:], truth.travel[:] = travel, travel
        predict_mean(given, state)
        predict_mean(given, truth)
        state.step_travel[:] += travel
        state.step_distance[:] += np.abs(travel)
        state.samples += 1
        state.linkage_samples += 1
        for number in range(3):
            state.residual_sum[number] += truth.mean[JOINT_A + number] - state.mean[JOINT_A + number]
    differentiate(given, state)


def begun(joints=(0.3, -0.2)):
    filter_ = Filter(reference_vehicle())
    start = filter_.start()
    states, filters = start.record.copy(), start.filters.copy()
    given = filter_.settings.copy()
    given["half_count"] = 1e-7
    states["mean"][0, JOINT_A : JOINT_A + 3] = (*joints, given["length"][0])
    filters["covariance"][0] += np.diag([*[1e-4] * 6, *[0.0] * (STATES - 6)])
    return given, states, filters


travels = st.tuples(*[st.floats(0.003, 0.007)] * 4)


@settings(max_examples=30)
@given(travel=travels, wheel=st.integers(0, 3))
def test_an_open_filter_that_knows_the_wrong_wheel_is_not_corrected(travel, wheel):
    given, states, filters = begun()
    truths = states.copy()
    truths["mean"][0, WHEEL + wheel] = filters["offset"][0, WHEEL + wheel] = WRONG
    drive(given, states, truths, np.array(travel))
    update(given[0], states[0], filters[0])
    estimate = states["mean"][0] + filters["offset"][0]
    turned = WRONG * SAMPLES * travel[wheel] / given["wheelbase"][0, 0]
    assert estimate[LINK:6] == pytest.approx(truths["mean"][0, LINK:6], abs=0.02 * turned)
