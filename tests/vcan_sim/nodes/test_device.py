"""NMT, boot-up, heartbeat, guarding, SYNC counter, storing and ids of the simulated devices."""

import pytest

NODES = [1, 2, 3, 4, 5, 6, 7, 11, 12, 13, 14]


def heartbeats(bench, node):
    return [data[0] for data in bench.pdos(0x700 + node)]


def test_every_node_says_once_that_it_has_booted(bench):
    assert bench.boot_ups == [(0x700 + node, b"\0") for node in NODES]


@pytest.mark.parametrize("command", [0x81, 0x82])
def test_a_reset_boots_again_and_forgets_the_communication_parameters(bench, command):
    bench.write(1, 0x1017, 0, 30, 2)
    bench.nmt(0x01, 1)
    bench.nmt(command, 1)
    assert (0x701, b"\0") in bench.take()
    assert bench.read(1, 0x1017) == 0
    bench.sync(3)
    assert heartbeats(bench, 1) == []


def test_only_a_reset_of_the_node_forgets_its_application_parameters(bench):
    bench.write(1, 0x6000, 0, 1, 2)
    bench.nmt(0x82, 1)
    assert bench.read(1, 0x6000) == 1
    bench.nmt(0x81, 1)
    assert bench.read(1, 0x6000) == 0


def test_a_command_to_one_node_leaves_the_others_alone(bench):
    bench.write(1, 0x1017, 0, 15, 2)
    bench.write(2, 0x1017, 0, 15, 2)
    bench.nmt(0x01, 2)
    bench.sync()
    sent = bench.take()
    assert (0x701, b"\x7f") in sent
    assert (0x702, b"\x05") in sent


def test_a_watched_heartbeat_that_stops_is_reported_once_and_taken_back_when_it_returns(bench):
    bench.write(1, 0x1016, 1, 0x7F_0064, 4)  # node 127, 100 ms
    bench.sync(20)
    assert bench.pdos(0x081) == []  # supervision starts with the first heartbeat
    bench.frame(0x77F, b"\x05")
    bench.sync(20)
    assert bench.pdos(0x081) == [b"\x30\x81\x11" + bytes(5)]
    assert bench.read(1, 0x1001) == 0x11
    assert bench.read(1, 0x1003, 0) == 1
    assert bench.read(1, 0x1003, 1) == 0x8130
    bench.frame(0x77F, b"\x05")
    assert bench.pdos(0x081) == [bytes(8)]
    assert bench.read(1, 0x1001) == 0


def test_frames_that_are_not_of_the_base_format_are_ignored(bench):
    bench.frame(0x080, is_extended_id=True)
    bench.frame(0x080, is_remote_frame=True)
    bench.frame(0x080, is_error_frame=True)
    assert bench.simulated.syncs == 0


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
