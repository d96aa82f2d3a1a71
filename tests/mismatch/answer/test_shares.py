"""An error's share is asked where noise hides it, from one reading to the next, and where it adds up."""

import numpy as np
import pytest

from omnimate.mismatch.answer.omnibus import RELEVANT_SQUARE
from omnimate.mismatch.answer.rerun import STRETCH
from omnimate.mismatch.answer.shares import OUTLYING, largest_share, open_loop_shares, scaled
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.unknown import raw_columns, unknown_errors

ERROR = ("b.right", "turn rate")


@pytest.fixture(scope="module")
def hidden(regression, drive, effect):
    """Return the regression of a drive whose wheel b.right rolls a little more in turns to the left."""
    law = effect("law", "b.right", acts_on="travel", formula="0.003 * turn_rate")
    return regression(drive(law, laps=3))


@pytest.fixture(scope="module")
def fitted(hidden):
    """Return the number of the error, its whitened columns, and its coefficients in each row."""
    unknown = unknown_errors(hidden)
    names = [(term.component, term.fixed["quantity"]) for term in unknown.terms]
    number = names.index(ERROR)
    columns = unknown.columns[:, slices_of(unknown.widths)[number]].astype(float)
    sizes = np.linalg.solve(columns.T @ columns + np.eye(columns.shape[1]), columns.T @ hidden.white[:, 0])
    return number, columns, np.tile(sizes, (len(columns), 1))


def test_what_noise_hides_from_one_reading_to_the_next_shows_where_it_adds_up(hidden, fitted):
    number, columns, sizes = fitted
    scale, data = scaled(hidden.white[:, 0], hidden.channel)
    names = hidden.windows[0].names
    at_once = largest_share(
        names, hidden.channel, data, (columns * sizes).sum(axis=1) / scale, np.ones(len(data))
    )
    added_up = open_loop_shares(hidden, {number: sizes})[number]
    assert added_up.open_loop
    assert at_once.share < RELEVANT_SQUARE < added_up.share


def test_an_error_that_a_robot_does_not_have_shows_nowhere(hidden, fitted, regression, drive):
    number, _, sizes = fitted
    healthy = regression(drive(laps=3))
    rows = np.resize(sizes, (len(healthy.channel), sizes.shape[1]))
    assert open_loop_shares(healthy, {number: rows})[number].share < RELEVANT_SQUARE


def test_what_an_effect_of_the_fit_has_taken_is_no_share_of_an_error(hidden, fitted):
    number, _, sizes = fitted
    taken = hidden.branch()
    taken.raw = list(hidden.raw)
    taken.extend(raw_columns(hidden, {number})[number], [sizes.shape[1]])
    shares = open_loop_shares(taken, {number: sizes})
    assert abs(shares[number].share) < 0.05 * open_loop_shares(hidden, {number: sizes})[number].share


def test_thinned_windows_read_each_channel_once_in_a_stretch(regression, drive, watched):
    [windows] = regression(watched(drive(laps=2), every=35)).windows
    thin = windows.thinned(STRETCH)
    for row in range(thin.measured.shape[1]):
        [at] = np.nonzero(np.isfinite(thin.measured[:, row]))
        assert thin.measured[at, row] == pytest.approx(windows.measured[at, row])
        assert len(at) == np.ceil((windows.time[-1] - windows.time[0]) / STRETCH)
        assert np.diff(windows.time[at]) == pytest.approx(STRETCH, abs=2.0)


def test_outliers_are_cut_and_do_not_set_the_scale():
    chance = np.random.default_rng(0)
    values = chance.normal(size=400) * np.repeat([1.0, 5.0], 200)
    values[:200:50] = 10.0
    scale, cut = scaled(values, np.repeat([0, 1], 200))
    assert scale[0] == pytest.approx(1.0, rel=0.2)
    assert scale[-1] == pytest.approx(5.0, rel=0.2)
    assert np.abs(cut).max() == OUTLYING
