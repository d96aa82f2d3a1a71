"""What a fit leaves is predicted by the drive where something is left, and by nothing where only noise is."""

from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lsim

from omnimate.mismatch import diagnose
from omnimate.mismatch.answer.omnibus import ERROR_RATE, leftover
from omnimate.mismatch.candidates.quantities import OSCILLATION, shared_quantities
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.unknown import FIELD, FLOOR, unknown_errors
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS, NoiseLevels
from omnimate.mismatch.recording.signals import signals_of


@pytest.fixture(scope="module")
def fit_of(regression, drive):
    """Return a function that makes a fit that leaves noise, and some of a component's error.

    The drive itself has neither, so that open loop no error shows.
    """
    shown = regression(drive(laps=2)).with_noise(DEFAULT_LEVELS)
    shown.raw = [(0.0 * inputs, 0.0 * measured) for inputs, measured in shown.raw]
    unknown = unknown_errors(shown)
    stretch = (shown.time // 4.0).astype(int)

    def made(seed, quantity="", share=0.0, component="joint_b"):
        residual = np.random.default_rng(seed).normal(size=len(shown.channel))
        for term, place in zip(unknown.terms, slices_of(unknown.widths), strict=True):
            if (term.component, term.fixed["quantity"]) == (component, quantity):
                curves = unknown.columns[:, place][:, 1:]  # after a level; the one that most rows show
                column = curves[:, ((curves**2).sum(axis=0) ** 2 / (curves**4).sum(axis=0)).argmax()]
                residual += np.sqrt(share / (1.0 - share) * len(column) / 3.0 / (column @ column)) * column
        given = SimpleNamespace(residual=residual, project_out=lambda columns: columns)
        posterior = SimpleNamespace(
            regression=shown, candidates=SimpleNamespace(stretch=stretch), given=lambda _: given
        )
        return posterior, unknown, ()

    return made


@pytest.fixture(scope="module")
def of_noise(fit_of):
    """What predicts the noise of seed 1."""
    return leftover(*fit_of(1))


@pytest.mark.parametrize("seed", range(5))
def test_noise_is_predicted_by_nothing(fit_of, seed):
    found = leftover(*fit_of(seed))
    assert found.p_value > ERROR_RATE
    assert not found.predictions
    assert not found.relevant


@pytest.mark.parametrize(
    ("component", "quantity"),
    [
        ("joint_b", "heading of a"),
        ("left", FLOOR.format(0.5)),
        ("b.right", FLOOR.format(0.4)),
        ("b", FIELD.format(0.5)),
        ("joint_b", "oscillation of 0.6 Hz after accelerations"),
        ("a.left", "recent speed"),
    ],
)
def test_what_a_components_error_leaves_is_predicted_by_it(fit_of, of_noise, component, quantity):
    found = leftover(*fit_of(1, quantity, 0.3, component))
    assert found.p_value < ERROR_RATE
    assert (found.predictions[0].component, found.predictions[0].quantity) == (component, quantity)
    assert found.relevant
    assert found.probability > of_noise.probability


@pytest.mark.parametrize("length", [1.67, 2.5, 5.0])
def test_a_field_that_is_longer_than_a_slab_and_shorter_than_the_room_is_found(fit_of, length):
    """A length next to it may predict it as well on a short drive."""
    found = leftover(*fit_of(1, FIELD.format(length), 0.3, "b"))
    assert found.relevant
    assert found.predictions[0].component == "b"


@pytest.mark.parametrize(
    "quantity", ["yaw acceleration of link", "turns of joint_a", "past acceleration of a.left"]
)
def test_what_depends_on_a_quantity_at_the_same_instant_is_predicted_on_its_channel(fit_of, quantity):
    """No component's error does that: what a sensor reads too much stays in the next prediction."""
    posterior, unknown, members = fit_of(1)
    place = dict(zip(unknown.quantities, slices_of(unknown.quantities.values()), strict=True))[quantity]
    mine = posterior.regression.channel == 1
    residual = posterior.given(()).residual
    residual[mine] += np.sqrt(0.3 / 0.7) * unknown.curves[mine, place.start]
    found = leftover(posterior, unknown, members)
    assert found.p_value < ERROR_RATE
    assert {prediction.shown.channel for prediction in found.predictions} == {"joint_b"}
    assert quantity in {prediction.quantity for prediction in found.predictions}
    assert found.predictions[0].shown.share == pytest.approx(0.3, abs=0.15)


@pytest.mark.parametrize("quantity", ["turn rate", "heading of a"])
def test_the_share_is_that_of_the_channel_on_which_an_error_shows(fit_of, quantity):
    [prediction, *_] = leftover(*fit_of(1, quantity, share=0.3)).predictions
    assert prediction.shown.channel == "joint_b"
    assert prediction.shown.share == pytest.approx(0.3, abs=0.15)


def test_what_only_a_robot_with_less_noise_than_a_nominal_one_shows_is_a_trace(fit_of):
    posterior, unknown, members = fit_of(1, "heading of a", share=0.3)
    finer = NoiseLevels(*(value / 3.0 for value in asdict(DEFAULT_LEVELS).values()))
    found = leftover(posterior, unknown, members)
    posterior.regression = posterior.regression.with_noise(finer)
    finest = leftover(posterior, unknown, members)
    assert finest.p_value == found.p_value < ERROR_RATE
    assert found.relevant
    assert not finest.relevant


def test_what_predicts_explains_itself_away(fit_of):
    fit = fit_of(1, "heading of a", share=0.3)
    rows, found = fit[0].given(()).residual[:, None], leftover(*fit)
    assert np.var(found.project_out(rows)) < np.var(rows)
    assert found.project_out(found.predictions[0].columns) == pytest.approx(0.0, abs=1e-9)


def test_a_reading_that_follows_the_links_yaw_acceleration_is_unknown_there(drive, effect):
    hidden = effect("law", "joint_b", acts_on="reading", formula="0.01 * link_yaw_acceleration")
    answer = diagnose([drive(hidden, laps=3)])
    assert answer.verdict == "mismatch"
    assert answer.findings[0].key == ("unknown", "joint_b")
    assert "yaw acceleration of link" in answer.findings[0].depends_on


def test_a_reading_that_oscillates_after_accelerations_is_unknown_there(drive):
    """The oscillator is scipy's, and its frequency lies between those of the predictors."""
    healthy = drive(laps=3)
    vehicle, time = healthy.vehicle, healthy.time
    turned = 0.5 * (healthy.wheel_angle("a.left") + healthy.wheel_angle("a.right"))
    speed = np.gradient(turned * 0.5 * vehicle.wheel_diameter("a.left"), time)
    turn = 2.0 * np.pi * 0.9
    _, angle, _ = lsim(([0.01 * turn**2], [1.0, 0.1 * turn, turn**2]), np.gradient(speed, time), time)
    counts = healthy.counts.copy()
    joint = vehicle.channels.index("joint_b")
    counts[:, joint] += np.round(angle / vehicle.encoder("joint_b").scale).astype(counts.dtype)
    answer = diagnose([replace(healthy, counts=counts)])
    assert answer.verdict == "mismatch"
    assert answer.findings[0].key == ("unknown", "joint_b")
    assert answer.findings[0].depends_on[0] in {
        OSCILLATION.format(hertz, "accelerations") for hertz in (0.8, 1.0)
    }


def test_quantities_are_of_order_one_and_none_is_what_the_second_truck_answers_to_the_floor(drive):
    [quantities] = shared_quantities([signals_of(drive(laps=1))])
    assert not {"speed of b.left", "acceleration of b.right", "rate of joint_b"} & set(quantities)
    for name, curves in quantities.items():
        assert np.abs(curves).max() < 50.0, name
