"""Effects files."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vcan_sim.effects import EFFECTS
from vcan_sim.effects.file import format_effects, load_effects, parse_effects, save_effects
from vcan_sim.errors import EffectsFileError


@st.composite
def effects(draw):
    kind = draw(st.sampled_from(EFFECTS))
    values = {}
    count = draw(st.integers(0, 3))
    for one in kind.parameters:
        number = st.floats(one.low, one.high)
        if one.name in {"times", "lost"}:
            number = st.lists(number, min_size=count, max_size=count).map(tuple)
        if one.name == "intervals":
            number = st.lists(st.tuples(number, number), max_size=3).map(tuple)
        values[one.name] = draw(number)
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


HEAD = '[[effect]]\nname = "wheel_diameter"\ncomponent = "a.left"\nratio = 1.01\n[[effect]]\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("not toml", r"\(syntax\): not TOML"),
        ("colour = 1", "colour: unknown key"),
        ("effect = 3", r"expected \[\[effect\]\] tables"),
        (HEAD, "effect 2: name: None; expected text"),
        (
            HEAD + 'name = "wheel_size"\ncomponent = "a.left"',
            "effect 2: effect 'wheel_size'; expected one of",
        ),
        (HEAD + 'name = "joint_bias"\ncomponent = "link"\nbias = 0.1', "effect 2: .*'link'; expected one of"),
        (
            HEAD + 'name = "joint_bias"\ncomponent = "joint_a"',
            r"effect 2 \(joint_bias\): bias: missing; in rad",
        ),
        (HEAD + 'name = "joint_bias"\ncomponent = "joint_a"\nbias = "much"', "'much'; expected a number"),
        (HEAD + 'name = "joint_bias"\ncomponent = "joint_a"\nbias = true', "True; expected a number"),
        (HEAD + 'name = "joint_bias"\ncomponent = "joint_a"\nbias = nan', "nan rad; expected -3.2 to 3.2"),
        (HEAD + 'name = "joint_bias"\ncomponent = "joint_a"\nbias = 9.0', "9.0 rad; expected -3.2 to 3.2"),
        (
            HEAD + 'name = "joint_bias"\ncomponent = "joint_a"\nbias = 0.1\nwidth = 1',
            "width: unknown key; expected bias",
        ),
        (
            HEAD + 'name = "bump"\ncomponent = "a.left"\ntimes = 3.0\nlost = [0.01]',
            "times: 3.0; expected a list of numbers",
        ),
        (
            HEAD + 'name = "bump"\ncomponent = "a.left"\ntimes = [3.0]\nlost = []',
            "1 times, 0 losses; expected equal",
        ),
        (
            HEAD + 'name = "slip_patch"\ncomponent = "a.left"\nfraction = 0.1\nintervals = [[1.0]]',
            "expected a list of .start, end. pairs",
        ),
    ],
)
def test_an_error_names_file_entry_and_what_was_expected(text, says):
    with pytest.raises(EffectsFileError, match=says) as caught:
        parse_effects(text, "robot/effects.toml")
    assert str(caught.value).startswith("robot/effects.toml: ")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(EffectsFileError, match=r"none\.toml: \(file\): cannot be read"):
        load_effects(tmp_path / "none.toml")
