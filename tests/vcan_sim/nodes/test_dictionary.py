"""Object dictionaries: values on the bus, and values after a reset."""

from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.nodes.objects import Objects, Variable

sizes = st.sampled_from([1, 2, 4, 8])


def integer(size, *, signed, default=0, relative=False):
    half = 2 ** (8 * size - 1)
    low, high = (-half, half - 1) if signed else (0, 2 * half - 1)
    return Variable(size, signed, True, True, low, high, default, relative)


@given(st.data(), sizes, st.booleans())
def test_an_integer_comes_back_from_its_bytes(data, size, signed):
    variable = integer(size, signed=signed)
    value = data.draw(st.integers(variable.low, variable.high))
    assert len(variable.encode(value)) == size
    assert variable.decode(variable.encode(value)) == value


def test_after_a_reset_settings_stand_over_the_defaults_and_the_node_id_is_added_where_asked():
    variables = {
        (0x1000, 0): integer(4, signed=False, default=5),
        (0x1400, 1): integer(4, signed=False, default=0x200, relative=True),
        (0x6000, 0): integer(4, signed=False, default=6),
    }
    objects = Objects(variables, 9, {(0x6000, 0): 66})
    for key in variables:
        objects[key] = 1
    objects.reset(0x1FFF)
    assert [objects[key] for key in variables] == [5, 0x209, 1]
    objects.reset(0xFFFF)
    assert objects[0x6000, 0] == 66
