"""Objects of a device: a value is checked, then stored, then reacted to."""

import pytest

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
