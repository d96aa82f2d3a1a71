"""Object dictionaries: values on the bus, and values after a reset."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort
from omnimate.vcan_sim.nodes.dictionary import ObjectStore, Variable, load_dictionary

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


@given(sizes, st.binary(max_size=9))
def test_data_of_another_length_are_refused(size, data):
    variable = integer(size, signed=False)
    if len(data) == size:
        return
    with pytest.raises(SdoAbort) as caught:
        variable.decode(data)
    assert caught.value.code == Abort.LENGTH


def test_after_a_reset_settings_stand_over_the_defaults_and_the_node_id_is_added_where_asked():
    variables = {
        (0x1000, 0): integer(4, signed=False, default=5),
        (0x1400, 1): integer(4, signed=False, default=0x200, relative=True),
        (0x6000, 0): integer(4, signed=False, default=6),
    }
    store = ObjectStore(variables, 9, {(0x6000, 0): 66})
    for key in variables:
        store[key] = 1
    store.reset(0x1FFF)
    assert [store[key] for key in variables] == [5, 0x209, 1]
    store.reset(0xFFFF)
    assert store[0x6000, 0] == 66


def test_a_missing_object_and_a_missing_sub_index_have_their_own_codes():
    store = ObjectStore({(0x1018, 0): integer(1, signed=False)}, 1, {})
    for key, code in (((0x1018, 3), Abort.NO_SUBINDEX), ((0x1019, 0), Abort.NO_OBJECT)):
        with pytest.raises(SdoAbort) as caught:
            store.data(key)
        assert caught.value.code == code


def test_an_eds_file_is_read_into_entries_by_index_and_sub_index():
    variables = load_dictionary("encoder_cia406.eds")
    assert variables[0x6004, 0].size == 4
    assert not variables[0x6004, 0].writable
    assert variables[0x6004, 0].mappable
