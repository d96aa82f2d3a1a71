"""Services of CiA 301 and 305 beside SDO and PDO: guarding, SYNC counter, storing, ids."""

import pytest


def test_a_remote_frame_is_answered_with_the_state_and_a_toggle_bit(bench):
    answers = []
    for _ in range(3):
        bench.take()
        bench.frame(0x701, is_remote_frame=True, dlc=1)
        answers += bench.take()
    assert answers == [(0x701, b"\x7f"), (0x701, b"\xff"), (0x701, b"\x7f")]


def test_a_node_with_a_heartbeat_does_not_answer_guarding(bench):
    bench.write(1, 0x1017, 0, 1000, 2)
    bench.take()
    bench.frame(0x701, is_remote_frame=True, dlc=1)
    assert bench.take() == []


@pytest.mark.parametrize(("behaviour", "state"), [(0, 0x7F), (1, 0x05), (2, 0x04)])
def test_when_the_master_stops_guarding_the_node_says_so_and_does_what_1029h_asks(bench, behaviour, state):
    bench.write(1, 0x1029, 1, behaviour, 1)
    bench.write(1, 0x100C, 0, 100, 2)
    bench.write(1, 0x100D, 0, 3, 1)
    bench.nmt(1, 1)
    bench.frame(0x701, is_remote_frame=True, dlc=1)
    bench.take()
    bench.sync(25)  # 0.375 s
    assert (0x081, b"\x30\x81\x11" + bytes(5)) in bench.take()
    bench.frame(0x701, is_remote_frame=True, dlc=1)
    answers = [data for can_id, data in bench.take() if can_id == 0x701]
    assert answers[0][0] & 0x7F == state


def test_with_a_sync_counter_a_pdo_begins_at_its_start_value(bench):
    bench.write(1, 0x1019, 0, 4, 1)
    bench.answer_sync(1, 2)
    bench.nmt(0x80, 1)
    bench.write(1, 0x1800, 1, 0xC000_0181, 4)
    bench.write(1, 0x1800, 6, 3, 1)
    bench.write(1, 0x1800, 1, 0x4000_0181, 4)
    bench.nmt(1, 1)
    bench.take()
    answered = []
    for counter in (1, 2, 3, 4, 1, 2, 3):
        bench.frame(0x080, bytes([counter]))
        answered.append(len(bench.pdos(0x181)))
    assert answered == [0, 0, 1, 0, 1, 0, 1]


def test_a_sync_of_an_unexpected_length_is_an_emergency_and_is_answered(bench):
    bench.answer_sync(1)
    bench.frame(0x080, b"\x01")
    assert [data[:2] for can_id, data in bench.take() if can_id == 0x081] == [b"\x40\x82"]


@pytest.mark.parametrize("value", [1, 241, 255])
def test_the_sync_counter_overflows_at_2_to_240(bench, value):
    assert bench.aborts(1, 0x1019, 0, value, 1) == 0x06090030


def test_what_is_stored_outlives_the_power_and_what_is_restored_is_the_factorys(bench):
    bench.write(1, 0x1017, 0, 700, 2)
    bench.nmt(0x81, 1)
    assert bench.read(1, 0x1017) == 0
    bench.write(1, 0x1017, 0, 700, 2)
    bench.write(1, 0x1010, 1, int.from_bytes(b"save", "little"), 4)
    bench.nmt(0x81, 1)
    assert bench.read(1, 0x1017) == 700
    bench.write(1, 0x1011, 1, int.from_bytes(b"load", "little"), 4)
    assert bench.read(1, 0x1017) == 700
    bench.nmt(0x81, 1)
    assert bench.read(1, 0x1017) == 0


def test_a_device_that_lss_gives_another_id_boots_with_it_and_its_cob_ids_follow(bench):
    identity = [bench.read(1, 0x1018, sub) for sub in (1, 2, 3, 4)]
    for command, value in zip((0x40, 0x41, 0x42, 0x43), identity, strict=True):
        bench.frame(0x7E5, bytes([command]) + value.to_bytes(4, "little") + bytes(3))
    bench.frame(0x7E5, b"\x11\x63".ljust(8, b"\0"))
    bench.frame(0x7E5, b"\x04\x00".ljust(8, b"\0"))
    assert bench.read(1, 0x1000)  # until the next reset it keeps its id
    bench.take()
    bench.nmt(0x82, 1)
    assert (0x763, b"\0") in bench.take()
    assert bench.read(0x63, 0x1014) == 0x80 + 0x63
    assert bench.request(1, b"\x40\x00\x10\x00\0\0\0\0") is None


def test_a_drive_shows_its_error_code_in_603fh(bench):
    node = bench.vehicle.drives[0].node
    bench.write(node, 0x1016, 1, 126 << 16 | 100, 4)
    bench.frame(0x700 + 126, b"\x05")
    assert bench.read(node, 0x603F) == 0
    bench.sync(20)
    assert bench.read(node, 0x603F) == 0x8130
