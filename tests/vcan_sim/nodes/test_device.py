"""NMT, boot-up, heartbeat and emergencies of the simulated devices."""

import pytest

NODES = [1, 2, 3, 4, 5, 6, 7, 11, 12, 13, 14]


def heartbeats(bench, node):
    return [data[0] for data in bench.pdos(0x700 + node)]


def test_every_node_says_once_that_it_has_booted(bench):
    assert bench.boot_ups == [(0x700 + node, b"\0") for node in NODES]


def test_a_heartbeat_tells_the_state_at_its_period(bench):
    bench.write(1, 0x1017, 0, 30, 2)
    bench.sync(4)
    assert heartbeats(bench, 1) == [0x7F, 0x7F]
    bench.nmt(0x01, 1)
    bench.sync(2)
    assert heartbeats(bench, 1) == [0x05]
    bench.nmt(0x02, 1)
    bench.sync(2)
    assert heartbeats(bench, 1) == [0x04]


def test_a_heartbeat_time_of_0_ends_the_heartbeat(bench):
    bench.write(1, 0x1017, 0, 30, 2)
    bench.write(1, 0x1017, 0, 0, 2)
    bench.sync(10)
    assert heartbeats(bench, 1) == []


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


def test_unknown_commands_and_frames_of_a_wrong_length_change_nothing(bench):
    bench.frame(0x000, b"\x01")
    bench.frame(0x000, b"\x01\x00\x00")
    bench.nmt(0x33, 0)
    bench.write(1, 0x1017, 0, 15, 2)
    bench.sync()
    assert heartbeats(bench, 1) == [0x7F]


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
