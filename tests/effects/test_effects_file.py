"""Effects files."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects import EFFECTS
from omnimate.effects.errors import EffectsFileError
from omnimate.effects.file import format_effects, load_effects, parse_effects, save_effects


@st.composite
def effects(draw):
    kind = draw(st.sampled_from(EFFECTS))
    values = {}
    count = draw(st.integers(0, 3))
    for parameter in kind.parameters:
        number = st.floats(parameter.low, parameter.high)
        if parameter.name in {"times", "lost", "ordinates"}:
            number = st.lists(number, min_size=count, max_size=count).map(tuple)
        if parameter.name == "intervals":
            number = st.lists(st.tuples(number, number), max_size=3).map(tuple)
        if parameter.name == "knots":
            number = st.just(tuple(float(knot) for knot in range(count)))
            values["over"] = "speed" if count else ""
        if parameter.name == "period":
            number = st.sampled_from([0.0, 7.5])
        values[parameter.name] = draw(number)
    return kind(draw(st.sampled_from(kind.components)), **values)


@given(st.lists(effects(), max_size=5))
def test_what_is_written_is_read_back_equal(written):
    assert parse_effects(format_effects(written)) == tuple(written)


def test_a_file_holds_effects_in_order_and_sigmas_that_do_no_harm(tmp_path):
    path = tmp_path / "effects.toml"
    first, second = EFFECTS[0]("a.left", 1.01), EFFECTS[1]("b.right", 4e-4, 1.2)
    save_effects(path, [first, second], [{"ratio": 1e-4}, {}])
    assert load_effects(path) == (first, second)
    assert "1e-4" in path.read_text() or "0.0001" in path.read_text()


def test_an_empty_file_has_no_effects():
    assert parse_effects("") == ()


def test_numbers_may_be_whole_and_what_has_no_null_may_be_left_out():
    (effect,) = parse_effects('[[effect]]\nname = "gear_harmonic"\ncomponent = "a.left"\namplitude = 0')
    assert effect == effect.__class__("a.left", 0.0)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(EffectsFileError, match=r"none\.toml: \(file\): cannot be read"):
        load_effects(tmp_path / "none.toml")
