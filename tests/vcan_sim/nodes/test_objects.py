"""Objects of a device: a value is checked, then stored, then reacted to."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import Abort, SdoAbort
from omnimate.vcan_sim.nodes.objects import Objects, Variable

HEARTBEAT, IDENTITY = (0x1017, 0), (0x1018, 1)


def variable(*, writable):
    return Variable(2, False, writable, True, 0, 1000, 7, False)


@pytest.fixture
def objects():
    variables = {HEARTBEAT: variable(writable=True), IDENTITY: variable(writable=False)}
    return Objects(variables, 1, {})


def test_a_value_is_checked_before_it_is_stored_and_reacted_to_after(objects):
    seen = []
    objects.checks[0x1017] = lambda sub, value: seen.append(("check", sub, value, objects[HEARTBEAT]))
    objects.reactions[0x1017] = lambda sub, value: seen.append(("react", sub, value, objects[HEARTBEAT]))
    objects.write(0x1017, 0, b"\x64\x00")
    assert seen == [("check", 0, 100, 7), ("react", 0, 100, 100)]
    assert objects.read(0x1017, 0) == b"\x64\x00"


def test_a_refused_value_is_neither_stored_nor_reacted_to(objects):
    def refuse(_sub, _value):
        raise SdoAbort(Abort.STATE)

    reactions = []
    objects.checks[0x1017] = refuse
    objects.reactions[0x1017] = lambda *call: reactions.append(call)
    with pytest.raises(SdoAbort) as caught:
        objects.write(0x1017, 0, b"\x64\x00")
    assert caught.value.code == Abort.STATE
    assert objects[HEARTBEAT] == 7
    assert reactions == []


def test_a_measured_object_is_read_from_its_reader_by_sdo_and_by_pdo(objects):
    objects.readers[HEARTBEAT] = lambda: 0x1234
    assert objects.read(*HEARTBEAT) == b"\x34\x12"
    assert objects.reader(HEARTBEAT)() == 0x1234
    assert objects.reader(IDENTITY)() == 7


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
