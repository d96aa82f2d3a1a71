"""The stamps of a SocketCAN socket, on sockets of another family that have the same control messages."""

import socket
import struct
import time

import pytest
from can.interfaces.socketcan import constants

from omnimate.driver.bus.interfaces import SO_TIMESTAMPING, SO_TIMESTAMPNS, StampedSocket, _best

TIMESPEC = struct.Struct("@ll")
KERNEL, OBSOLETE, ADAPTER = TIMESPEC.pack(1000, 1), TIMESPEC.pack(0, 0), TIMESPEC.pack(2000, 2)


def test_the_adapters_stamp_is_the_best_and_the_kernels_stands_in_for_it():
    assert _best(KERNEL + OBSOLETE + ADAPTER) == ADAPTER
    assert _best(KERNEL + OBSOLETE + OBSOLETE) == KERNEL


def test_the_numbers_are_those_of_python_can():
    assert SO_TIMESTAMPNS == constants.SO_TIMESTAMPNS


@pytest.fixture
def pair():
    receiver, sender = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    receiver.bind(("127.0.0.1", 0))
    receiver.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)  # as python-can does
    receiver.settimeout(5.0)
    sender.connect(receiver.getsockname())
    stamped = StampedSocket.take_over(receiver)
    with sender, stamped:
        yield sender, stamped


@pytest.mark.parametrize("has_stamps", [True, False], ids=["stamps of the kernel", "time of reading"])
def test_a_frame_has_one_stamp_of_the_kind_that_python_can_asks_for(pair, has_stamps):
    sender, stamped = pair
    if not has_stamps:
        stamped.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPING, 0)
    before = time.time()
    sender.send(b"frame")
    data, controls, _, _ = stamped.recvmsg(72, 16)
    [(level, kind, content)] = controls
    seconds, nanoseconds = TIMESPEC.unpack(content)
    assert (data, level, kind) == (b"frame", socket.SOL_SOCKET, SO_TIMESTAMPNS)
    assert before - 0.1 <= seconds + nanoseconds * 1e-9 <= time.time() + 0.1


def test_the_socket_is_the_same_and_waits_as_long(pair):
    _, stamped = pair
    assert stamped.gettimeout() == 5.0
    stamped.settimeout(0.0)
    with pytest.raises(BlockingIOError):
        stamped.recvmsg(72, 16)
