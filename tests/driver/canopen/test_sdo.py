"""Objects as numbers: what is put is read back, on canopen's own SDO server."""

import pytest
from canopen.objectdictionary import UNSIGNED32
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.canopen.dictionary import VARIABLES, standard_dictionary
from omnimate.driver.canopen.sdo import MAX_RESPONSES, TRIES
from omnimate.driver.errors import NotTaken, SdoRefused, SdoSilent
from tests.foreign.devices import ForeignNode


@given(index=st.sampled_from(sorted(VARIABLES)), value=st.integers(-(2**31), 2**32 - 1))
def test_what_is_put_is_read_back_as_an_unsigned_number(kit, index, value):
    dictionary = standard_dictionary()
    sdo, _ = kit.sdo([ForeignNode(1, described=dictionary)])
    sdo.put(index, 0, value)
    assert sdo.read(index) == value % 2 ** len(dictionary[index])


def test_an_object_that_is_missing_is_none_for_find_and_an_error_for_read(sdo):
    assert sdo.find(0x2F00) is None
    with pytest.raises(SdoRefused) as caught:
        sdo.read(0x2F00, 3)
    assert (caught.value.node, caught.value.index, caught.value.subindex) == (1, 0x2F00, 3)
    assert caught.value.abort_code == 0x06020000


@given(code=st.integers(0, 2**32 - 1))
def test_an_object_that_refuses_to_be_read_with_any_abort_code_is_none_for_find(kit, code):
    device = kit.encoder_device(1)
    device.refuse_read[0x6004, 0] = code
    sdo, _ = kit.sdo([device])
    assert sdo.find(0x6004) is None
    with pytest.raises(SdoRefused, match="refused to read 6004h:00"):
        sdo.read(0x6004)


INDICES = [0x1005, 0x1017, 0x6509]
writes = st.lists(st.tuples(st.sampled_from(INDICES), st.integers(0, 2**16 - 1)))


@given(written=writes)
def test_a_block_that_fails_puts_back_all_that_it_wrote(kit, written):
    device = kit.encoder_device(1, (0x6509, 0, UNSIGNED32, "rw", 7))
    sdo, _ = kit.sdo([device])
    before = [device.number(index) for index in INDICES]
    with pytest.raises(SdoRefused), sdo.restoring():
        put_all(sdo, [*written, (0x2F00, 1)])  # the last object does not exist
    assert [device.number(index) for index in INDICES] == before
    with sdo.restoring():
        put_all(sdo, written)
    assert all(device.number(index) == value for index, value in dict(written).items())


def put_all(sdo, written):
    for index, value in written:
        sdo.put(index, 0, value)


def test_an_object_that_holds_its_value_already_is_not_written(device, sdo):
    device.refuse[0x1017, 0] = 0x06010002
    assert not sdo.put(0x1017, 0, 0)
    assert device.writes == []


def test_an_object_of_another_size_is_written_in_the_size_of_the_device(kit):
    device = kit.encoder_device(1, (0x1017, 0, UNSIGNED32, "rw", 0))
    kit.sdo([device])[0].write(0x1017, 0, 500)
    assert device.get_data(0x1017, 0) == b"\xf4\x01\0\0"


def test_a_value_that_is_confirmed_and_not_kept_is_an_error_with_both_values(device, sdo):
    device.on_write = lambda *_write: device.put(0x1017, 0, 250)
    with pytest.raises(NotTaken) as caught:
        sdo.put(0x1017, 0, 500)
    assert (caught.value.wrote, caught.value.reads) == (500, 250)


@pytest.mark.usefixtures("_impatient")
def test_a_silent_node_is_asked_three_times(kit, device):
    device.power_off()
    sdo, network = kit.sdo([device])
    with pytest.raises(SdoSilent) as caught:
        sdo.read(0x1000)
    requests = [data for can_id, data in network.can_bus.sent if can_id == 0x601 and data[0] == 0x40]
    assert len(requests) == TRIES
    assert (caught.value.node, caught.value.index) == (1, 0x1000)


@pytest.mark.usefixtures("_impatient")
def test_an_answer_to_the_second_try_counts(kit, device):
    sdo, network = kit.sdo([device])
    lost = iter([True, False])
    network.can_bus.change = lambda message, answers: (
        [] if message.data[0] == 0x40 and next(lost) else answers
    )
    assert sdo.read(0x1000) == 0x00020196


@pytest.mark.parametrize(
    ("node", "index"), [(1, 0x6004), (2, 0x1000)], ids=["late, about another object", "of another node"]
)
def test_an_answer_to_another_request_is_not_taken_for_this_one(kit, node, index):
    """canopen's own client takes any answer."""
    sdo, network = kit.sdo([kit.encoder_device(1)])
    other = kit.frame(0x580 + node, b"\x43" + index.to_bytes(2, "little") + b"\0\x63\0\0\0")
    network.can_bus.change = lambda _message, answers: [other, *answers]
    assert sdo.read(0x1000) == 0x00020196


@pytest.mark.usefixtures("_impatient")
def test_an_endless_segmented_answer_is_given_up(kit, device):
    sdo, network = kit.sdo([device])
    segments = 0

    def endless(message, _answers):
        nonlocal segments
        segments += 1
        command = message.data[0]
        if command == 0x80:  # the client gives up
            return []
        if command & 0xE0 == 0x40:  # initiate upload: a segmented transfer of unknown size
            return [kit.frame(0x581, b"\x40" + bytes(message.data[1:4]) + bytes(4))]
        return [kit.frame(0x581, bytes([command & 0x10]) + b"1234567")]

    network.can_bus.change = endless
    with pytest.raises(SdoSilent):
        sdo.read(0x1008)
    assert segments < (TRIES + 1) * MAX_RESPONSES
