"""PDOs: the order of remapping, transmission types, inhibit and event timers, and what RPDOs carry."""

import pytest

STATE, VALUE, NOT_MAPPABLE, TOO_LONG = 0x08000022, 0x06090030, 0x06040041, 0x06040042
OFF, ON = 0xC000_0181, 0x4000_0181


def remap(bench, entries):
    """Go through the whole order of bus.md."""
    bench.nmt(0x80, 1)
    bench.map_pdo(1, 0x1A00, entries, ON, kind=1)
    bench.write(1, 0x1801, 1, 0xC000_0281, 4)
    bench.nmt(0x01, 1)
    bench.take()


def test_as_delivered_tpdo1_is_cyclic_and_tpdo2_answers_sync(bench):
    bench.nmt(0x01, 1)
    bench.sync(20)  # 300 ms
    sent = bench.take()
    assert sum(can_id == 0x181 for can_id, _ in sent) == 3
    assert sum(can_id == 0x281 for can_id, _ in sent) == 20


def test_nothing_is_sent_before_nmt_starts_the_node_or_after_it_stops_it(bench):
    bench.sync(20)
    assert bench.take() == []
    bench.nmt(0x01)
    bench.sync(2)
    assert bench.take()
    bench.nmt(0x02)
    bench.sync(20)
    assert bench.take() == []


@pytest.mark.parametrize(
    ("entries", "data"),
    [
        ([0x10010008, 0x60040020, 0x65000010], b"\x00\x04\x03\x02\x01\x00\x00"),
        ([0x60040010], b"\x04\x03"),  # a shorter length than the object's own: its low bytes
    ],
)
def test_a_remapped_pdo_carries_its_objects_one_behind_the_other(bench, entries, data):
    remap(bench, entries)
    bench.sync(count=0x0102_0304)
    assert bench.pdos(0x181) == [data]


def test_the_mapping_is_written_in_the_order_of_cia_301_only(bench):
    assert bench.aborts(1, 0x1A00, 0, 0, 1) == STATE  # the PDO is valid
    bench.write(1, 0x1800, 1, OFF, 4)
    assert bench.aborts(1, 0x1A00, 1, 0x65000010, 4) == STATE  # the number of entries is not 0
    bench.write(1, 0x1A00, 0, 0, 1)
    assert bench.aborts(1, 0x1A00, 1, 0x65000010, 4) is None
    assert bench.aborts(1, 0x1A00, 0, 1, 1) is None
    bench.nmt(0x01, 1)
    assert bench.aborts(1, 0x1A00, 0, 0, 1) == STATE  # operational


@pytest.mark.parametrize(
    ("entry", "code"),
    [
        (0x60000010, NOT_MAPPABLE),  # no PDO may carry it
        (0x60040040, NOT_MAPPABLE),  # longer than the object
        (0x60040004, NOT_MAPPABLE),  # no whole byte
        (0x00050008, 0x06020000),  # dummies fill up RPDOs only
        (0x21000020, 0x06020000),
        (0x60040120, 0x06090011),
    ],
)
def test_an_object_that_cannot_be_mapped_is_refused(bench, entry, code):
    bench.write(1, 0x1800, 1, OFF, 4)
    bench.write(1, 0x1A00, 0, 0, 1)
    assert bench.aborts(1, 0x1A00, 1, entry, 4) == code


def test_more_than_eight_bytes_are_refused(bench):
    bench.write(1, 0x1800, 1, OFF, 4)
    bench.write(1, 0x1A00, 0, 0, 1)
    for sub in (1, 2, 3):
        bench.write(1, 0x1A00, sub, 0x60040020, 4)
    assert bench.aborts(1, 0x1A00, 0, 3, 1) == TOO_LONG
    assert bench.aborts(1, 0x1A00, 0, 9, 1) == VALUE
    assert bench.aborts(1, 0x1A00, 0, 2, 1) is None


@pytest.mark.parametrize("cob_id", [0x000, 0x080, 0x180, 0x581, 0x601, 0x701, 0x2000_0181, 0x182])
def test_a_cob_id_that_is_taken_extended_or_changed_while_valid_is_refused(bench, cob_id):
    assert bench.aborts(1, 0x1800, 1, cob_id, 4) == VALUE


def test_a_cob_id_is_changed_by_way_of_bit_31(bench):
    bench.write(1, 0x1801, 1, 0xC000_0281, 4)
    assert bench.aborts(1, 0x1801, 1, 0xC000_01E5, 4) is None
    assert bench.aborts(1, 0x1801, 1, 0x4000_01E5, 4) is None
    bench.nmt(0x01, 1)
    bench.sync()
    assert len(bench.pdos(0x1E5)) == 1


@pytest.mark.parametrize("kind", [241, 252, 253])
def test_reserved_transmission_types_and_remote_requests_are_refused(bench, kind):
    assert bench.aborts(1, 0x1800, 2, kind, 1) == VALUE


def test_the_inhibit_time_is_written_while_the_pdo_is_off_only(bench):
    assert bench.aborts(1, 0x1800, 3, 100, 2) == STATE
    bench.write(1, 0x1800, 1, OFF, 4)
    assert bench.aborts(1, 0x1800, 3, 100, 2) is None


@pytest.mark.parametrize("every", [1, 7, 240])
def test_a_transmission_type_n_answers_every_nth_sync(bench, every):
    bench.answer_sync(1, tpdo=every)
    answered = []
    for number in range(1, 2 * every + 2):
        bench.sync()
        if bench.pdos(0x181):
            answered.append(number)
    assert answered == [every, 2 * every] if every > 1 else [1, 2, 3]


def test_type_0_answers_a_sync_only_after_a_change(bench):
    bench.answer_sync(1, tpdo=0)
    bench.sync(3)
    assert len(bench.pdos(0x181)) == 1  # the first value is news
    bench.sync(3, count=5)
    assert bench.pdos(0x181) == [b"\x05\0\0\0"]


def event_driven(bench, inhibit=0, event=0):
    bench.write(1, 0x1801, 1, 0xC000_0281, 4)
    bench.write(1, 0x1800, 1, OFF, 4)
    bench.write(1, 0x1800, 2, 255, 1)
    bench.write(1, 0x1800, 3, inhibit, 2)
    bench.write(1, 0x1800, 5, event, 2)
    bench.write(1, 0x1800, 1, ON, 4)
    bench.nmt(0x01, 1)
    bench.take()


def test_type_255_sends_on_change(bench):
    event_driven(bench)
    bench.sync(3)
    assert bench.pdos(0x181) == []
    bench.sync(3, count=7)
    assert bench.pdos(0x181) == [b"\x07\0\0\0"]


def test_the_inhibit_time_in_units_of_100_us_thins_out_changes(bench):
    event_driven(bench, inhibit=1000)  # 100 ms
    for step in range(1, 41):  # 0.6 s of dither
        bench.sync(count=step)
    assert 5 <= len(bench.pdos(0x181)) <= 6


def test_a_change_within_the_inhibit_time_is_sent_at_its_end(bench):
    event_driven(bench, inhibit=300)  # 30 ms
    bench.sync(4, count=1)
    bench.take()
    bench.sync(count=2)
    bench.sync(count=3)
    assert bench.pdos(0x181) == [b"\x02\0\0\0"]
    bench.sync(3)
    assert bench.pdos(0x181) == [b"\x03\0\0\0"]


def test_the_event_timer_sends_without_a_change(bench):
    event_driven(bench, event=45)
    bench.sync(20)  # 300 ms
    assert len(bench.pdos(0x181)) == 6


def test_an_rpdo_of_a_wrong_length_is_refused_by_emcy_8210_until_a_right_one_comes(bench):
    bench.nmt(0x01, 11)
    bench.take()
    bench.frame(0x20B, b"\x06")
    assert bench.pdos(0x08B) == [b"\x10\x82\x11" + bytes(5)]
    assert bench.read(11, 0x6040) == 0
    bench.frame(0x20B, b"\x06\x00")
    assert bench.pdos(0x08B) == [bytes(8)]
    assert bench.read(11, 0x6040) == 6


def test_a_synchronous_rpdo_counts_from_the_next_sync_on(bench):
    bench.write(11, 0x1400, 2, 1, 1)
    bench.nmt(0x01, 11)
    bench.frame(0x20B, b"\x06\x00")
    assert bench.read(11, 0x6040) == 0
    bench.sync()
    assert bench.read(11, 0x6040) == 6


def test_an_rpdo_may_be_filled_up_with_dummies(bench):
    bench.map_pdo(11, 0x1600, [0x0006_0010, 0x60FF_0020], 0x20B)
    bench.nmt(0x01, 11)
    bench.frame(0x20B, b"\xaa\xbb\x04\x03\x02\x01")
    assert bench.read(11, 0x60FF) == 0x01020304
