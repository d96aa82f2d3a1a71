"""Laws that hold for every effect of the vocabulary."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from omnimate.effects import EFFECTS, effect_named
from omnimate.effects.effect import JOINT, LINK, POSES, TRUCK, WHEEL
from omnimate.effects.errors import EffectError

VOCABULARY = {
    "wheel_diameter", "wheel_eccentricity", "radius_vs_speed", "radius_step", "bump", "slip_patch",
    "traction_slip", "wheelbase", "turn_scrub", "wheel_misalignment", "lateral_slip", "floor_slope",
    "castor_kick", "reference_offset", "joint_bias", "joint_eccentricity", "joint_backlash", "link_bias",
    "link_eccentricity", "link_scale", "count_loss", "latency", "gear_backlash", "gear_harmonic",
    "clock_drift", "law",
}  # fmt: skip
TOUCHED = {
    "encoder": {"angle", "turned"},
    "travel": {"travel"},
    "body": {"twist"},
    "reading": {"reading"},
    "poses": set(),
}
# where a scale beyond null is nothing that the drive meets
CHOSEN = {
    "bump": {"times": (1000.6, 1003.3), "lost": (0.003, 0.005)},
    "radius_step": {"ratio": 1.01, "time": 1002.0},
    "slip_patch": {"fraction": 0.1, "intervals": ((1001.0, 1002.0), (1004.0, 1005.0))},
    "clock_drift": {"rate": 0.05},
    "law": {
        "formula": "0.01 * (1 + speed + way) * cos(3 * joint_a)",
        "over": "heading",
        "knots": (0.0, 2.0, 4.0),
        "ordinates": (0.01, 0.02, -0.03),
        "period": 6.283,
    },
}
NULL = {"bump": {"times": (1001.0,), "lost": (0.0,)}}


def strong(kind, component):
    values = {parameter.name: (parameter.null or 0.0) + parameter.scale for parameter in kind.parameters}
    return kind(component, **CHOSEN.get(kind.name, values))


def null(kind, component):
    values = {parameter.name: parameter.null for parameter in kind.parameters if parameter.null is not None}
    return kind(component, **NULL.get(kind.name, values))


# Of components that are alike the last one: a column that is taken for another shows there.
FAMILIES = (WHEEL, TRUCK, JOINT, LINK, POSES)
every_effect = pytest.mark.parametrize(
    ("kind", "component"),
    [
        pytest.param(kind, family[-1], id=f"{kind.name}-{family[-1]}")
        for kind in EFFECTS
        for family in FAMILIES
        if family[-1] in kind.components
    ],
)


def test_the_effects_are_those_of_the_vocabulary():
    assert {kind.name for kind in EFFECTS} == VOCABULARY
    assert len(EFFECTS) == len(VOCABULARY)
    assert all(effect_named(kind.name) is kind for kind in EFFECTS)


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(EffectError, match=r"'wheel_size'; expected one of .*wheel_diameter"):
        effect_named("wheel_size")


@every_effect
def test_null_parameters_change_nothing(kind, component, block, acted):
    for name, after in acted(null(kind, component), block).items():
        assert after == pytest.approx(getattr(block, name), abs=1e-12)


@every_effect
def test_an_effect_changes_the_signal_of_its_stage_and_no_other(kind, component, block, acted):
    effect = strong(kind, component)
    after = acted(effect, block)
    changed = {name for name in after if not np.allclose(after[name], getattr(block, name), atol=1e-9)}
    assert changed == TOUCHED[effect.acts_at()]


@every_effect
def test_what_acts_for_some_time_changes_nothing_before_and_after_it(kind, component, block, acted):
    effect = strong(kind, component)
    during = effect.acts_during(block)
    begin, end = (-np.inf, np.inf) if during is None else during
    outside = (block.time <= begin) | (block.time > end)
    assert outside.any() == (kind.name in {"bump", "slip_patch"})
    for name, after in acted(effect, block).items():
        assert after[outside] == pytest.approx(getattr(block, name)[outside], abs=1e-12)


@every_effect
@settings(max_examples=5)
@given(cuts=st.lists(st.integers(0, 400), max_size=5))
@example(cuts=range(400))
def test_any_cut_into_blocks_gives_the_same_as_one_block(kind, component, block, acted, cuts):
    effect = strong(kind, component)
    whole, parts = acted(effect, block), acted(effect, block, cuts)
    for name, signal in whole.items():
        assert parts[name] == pytest.approx(signal, abs=1e-11)


@every_effect
def test_a_block_is_not_changed_in_place(kind, component, block, acted):
    before = {name: getattr(block, name).copy() for name in ("angle", "turned", "travel", "twist", "reading")}
    strong(kind, component).act(block)
    assert all(np.array_equal(getattr(block, name), old) for name, old in before.items())


@every_effect
def test_parameters_state_a_unit_a_scale_and_bounds_that_hold_null(kind, component):
    effect = strong(kind, component)
    assert set(effect.values()) == {field.name for field in (*kind.parameters, *kind.texts)}
    for parameter in kind.parameters:
        assert parameter.unit
        assert parameter.scale > 0.0
        assert parameter.null is None or parameter.low <= parameter.null <= parameter.high


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_an_unknown_component_and_a_value_out_of_bounds_are_refused(kind):
    with pytest.raises(EffectError, match="expected one of"):
        kind("c")
    effect = strong(kind, kind.components[0])
    for parameter in kind.parameters:
        beyond = {"lost": (0.0, 1e13), "times": (0.0, 1e13), "intervals": ((0.0, 1e13),)}.get(
            parameter.name, 1e13
        )
        with pytest.raises(EffectError, match="expected"):
            replace(effect, **{parameter.name: beyond})


@every_effect
def test_only_encoders_of_wheels_have_something_to_recover(kind, component, block):
    effect = strong(kind, component)
    recovered = effect.recover(block)
    changed = not np.allclose(recovered.travel, block.travel, atol=1e-12)
    assert changed == (effect.acts_at() == "encoder")


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_the_documentation_says_how_an_effect_shows_what_it_looks_like_and_where_it_is_from(kind):
    title, *paragraphs = sys.modules[kind.__module__].__doc__.strip().split("\n\n")
    assert title.lower().replace(" ", "_").startswith(kind.name.partition("_vs_")[0])
    assert all(paragraph.endswith(".") for paragraph in (title, *paragraphs))
    for words in ("It is seen", "It is confused with", "The source is"):
        assert sum(paragraph.startswith(words) for paragraph in paragraphs) == 1
