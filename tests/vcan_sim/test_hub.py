"""The hub with stock python-can clients: who receives what, and what ends a connection."""

import asyncio
import socket
import threading
from contextlib import contextmanager

import can
import pytest

from omnimate.vcan_sim.errors import HubError
from omnimate.vcan_sim.hub import Hub

PATIENCE = 120.0  # [s]; an upper bound, never waited for


class HubThread:
    """A hub in an event loop of its own."""

    def __init__(self, **settings):
        self.hub = Hub(**settings)
        self.heard = []
        self.port = 0
        self._ready = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()), daemon=True)

    async def _run(self):
        self.loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        self.bus = self.hub.attach(self._listen)
        self.port = await self.hub.start("127.0.0.1", 0)
        self._ready.set()
        await self._stop.wait()
        await self.hub.stop()
        self.bus.shutdown()

    def _listen(self):
        """Keep every frame, and answer SYNC with one."""
        while (message := self.bus.recv(0.0)) is not None:
            self.heard.append((message.arbitration_id, bytes(message.data)))
            if message.arbitration_id == 0x080:
                self.bus.send(can.Message(arbitration_id=0x181, data=b"\x01\x02", is_extended_id=False))

    def __enter__(self):
        self._thread.start()
        assert self._ready.wait(PATIENCE)
        return self

    def __exit__(self, *_):
        self.loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()

    def client(self, channel="can0"):
        return can.Bus(channel, interface="socketcand", host="127.0.0.1", port=self.port, tcp_tune=True)

    @contextmanager
    def raw(self):
        with socket.create_connection(("127.0.0.1", self.port), PATIENCE) as connection:
            connection.settimeout(PATIENCE)
            assert connection.recv(100) == b"< hi >"
            yield connection


@pytest.fixture
def hub():
    with HubThread() as hub:
        yield hub


def frame(can_id, data=b"", **flags):
    return can.Message(arbitration_id=can_id, data=data, **{"is_extended_id": False, **flags})


def read(client, number=1):
    messages = [client.recv(PATIENCE) for _ in range(number)]
    return [(message.arbitration_id, bytes(message.data), message.is_extended_id) for message in messages]


def read_to_end(connection):
    data = b""
    while part := connection.recv(4096):
        data += part
    return data


def test_a_frame_goes_to_all_others_and_not_back(hub):
    with hub.client() as first, hub.client() as second, hub.client() as third:
        first.send(frame(0x123, b"\x00\x0a\xff"))
        second.send(frame(0x1ABCDE, b"", is_extended_id=True))
        assert read(third, 2) == [(0x123, b"\x00\x0a\xff", False), (0x1ABCDE, b"", True)]
        assert read(first) == [(0x1ABCDE, b"", True)]
        assert read(second) == [(0x123, b"\x00\x0a\xff", False)]


def test_the_attached_participant_hears_and_answers(hub):
    with hub.client() as sender, hub.client() as listener:
        sender.send(frame(0x080))
        assert read(sender) == [(0x181, b"\x01\x02", False)]
        assert read(listener, 2) == [(0x080, b"", False), (0x181, b"\x01\x02", False)]
    assert hub.heard == [(0x080, b"")]


def test_all_clients_see_one_frame_at_one_time(hub):
    with hub.client() as sender, hub.client() as second, hub.client() as third:
        sender.send(frame(0x123))
        times = {second.recv(PATIENCE).timestamp, third.recv(PATIENCE).timestamp}
        assert len(times) == 1


def test_nothing_is_lost_or_reordered_flat_out(hub):
    with hub.client() as sender, hub.client() as receiver:
        sent = [(0x100 + number % 0x100, number.to_bytes(4, "little"), False) for number in range(3000)]
        for can_id, data, _ in sent:
            sender.send(frame(can_id, data))
        assert read(receiver, len(sent)) == sent


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="this system cannot acknowledge at once")
def test_the_last_frame_of_a_client_that_closes_at_once_without_reading_is_not_lost(hub):
    with hub.client() as listener:
        for _ in range(5):
            with can.Bus("can0", interface="socketcand", host="127.0.0.1", port=hub.port) as player:
                player.send(frame(0x080))  # the answer stays unread
                assert read(listener, 2)[1][0] == 0x181
                player.send(frame(0x123, b"\x01"))
                assert read(listener) == [(0x123, b"\x01", False)]
                player.send(frame(0x123, b"\x02"))
            assert read(listener) == [(0x123, b"\x02", False)]


def test_a_client_that_joins_a_busy_bus_still_shakes_hands(hub):
    with hub.client() as sender:
        stop = threading.Event()

        def flood():
            while not stop.is_set():
                sender.send(frame(0x123, bytes(8)))

        flooding = threading.Thread(target=flood)
        flooding.start()
        try:
            for _ in range(5):
                with hub.client() as late:
                    assert read(late) == [(0x123, bytes(8), False)]
        finally:
            stop.set()
            flooding.join(PATIENCE)


def test_commands_may_come_in_one_piece(hub):
    with hub.client() as listener, hub.raw() as connection:
        connection.sendall(b"< open can0 >< rawmode >< send 123 2 1 ff >")
        assert read(listener) == [(0x123, b"\x01\xff", False)]


def test_a_remote_frame_is_left_out_and_the_client_stays(hub, caplog):
    with hub.client() as sender, hub.client() as listener:
        sender.send(frame(0x701, is_remote_frame=True, dlc=1))
        sender.send(frame(0x123))
        assert read(listener) == [(0x123, b"", False)]
    assert "remote frames" in caplog.text


@pytest.mark.parametrize(
    "commands",
    [
        b"< open vcan9 >",
        b"< rawmode >",
        b"< open can0 >< bcmmode >",
        b"< open can0 >< rawmode >< send 123 2 11 >",
        b"< open can0 >< rawmode >< sendpdu abc >",
        b"GET / HTTP/1.1\r\n\r\n>",
        b"\xff\xfe>",
        b"<" * 1000,
    ],
)
def test_a_malformed_command_is_answered_by_an_error_and_the_end(hub, commands):
    with hub.raw() as connection:
        connection.sendall(commands)
        assert b"< error " in read_to_end(connection)
    with hub.client() as first, hub.client() as second:
        first.send(frame(0x123))
        assert read(second) == [(0x123, b"", False)]


def test_echo_is_answered(hub):
    with hub.raw() as connection:
        connection.sendall(b"< echo >")
        assert connection.recv(100) == b"< echo >"


def test_a_client_that_does_not_read_is_dropped_and_blocks_nobody(caplog):
    burst = [(0x123, bytes(8), False)] * 500
    with (
        HubThread(max_unread=10_000) as hub,
        hub.client() as sender,
        hub.client() as receiver,
        socket.socket() as lazy,
    ):
        lazy.setsockopt(
            socket.SOL_SOCKET, socket.SO_RCVBUF, 4096
        )  # before it connects, so that it fills soon
        lazy.settimeout(PATIENCE)
        lazy.connect(("127.0.0.1", hub.port))
        assert lazy.recv(6) == b"< hi >"
        lazy.sendall(b"< open can0 >< rawmode >")
        server_side = hub.hub.clients[-1]._transport.get_extra_info("socket")
        server_side.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        bursts = 0
        while "reads too slowly" not in caplog.text:
            for _ in burst:
                sender.send(frame(0x123, bytes(8)))
            assert read(receiver, len(burst)) == burst
            bursts += 1
            assert bursts < 1000
        sender.send(frame(0x321))
        assert read(receiver) == [(0x321, b"", False)]
        assert len(hub.hub.clients) == 2


def test_clients_that_vanish_leave_the_hub_running(hub):
    for _ in range(20):
        with hub.raw() as connection:
            connection.sendall(b"< open can0 >< rawmode >< send 123")
    with hub.client() as first, hub.client() as second:
        first.send(frame(0x123))
        assert read(second) == [(0x123, b"", False)]


def test_stopping_the_hub_ends_its_clients():
    with HubThread() as hub:
        connection = socket.create_connection(("127.0.0.1", hub.port), PATIENCE)
        connection.settimeout(PATIENCE)
        assert connection.recv(100) == b"< hi >"
    with connection:
        assert connection.recv(100) == b""


def test_an_address_in_use_says_so(hub):
    with pytest.raises(HubError, match="cannot listen here") as refused:
        asyncio.run(Hub().start("127.0.0.1", hub.port))
    assert refused.value.port == hub.port
