import socket
import threading

import can
import pytest

from omnimate.driver.bus import bus as module
from omnimate.driver.bus.bus import open_bus
from omnimate.driver.errors import BusError


@pytest.fixture
def serve():
    """Run a scripted TCP server: what it says on each connection, in turn; it closes after the last."""
    listener = socket.create_server(("127.0.0.1", 0))
    connections = []

    def run(scripts):
        for script in scripts:
            connection, _ = listener.accept()
            connections.append(connection)
            for expected, answer in script:
                if expected:
                    connection.recv(len(expected), socket.MSG_WAITALL)
                connection.sendall(answer)

    threads = []

    def start(*scripts):
        threads.append(threading.Thread(target=run, args=(scripts,)))
        threads[-1].start()
        return f"socketcand://127.0.0.1:{listener.getsockname()[1]}/can0", connections

    yield start
    listener.close()
    for thread in threads:
        thread.join()
    for connection in connections:
        connection.close()


GREETING = [(b"", b"< hi >")]
OPENING = [(b"", b"< hi >"), (b"< open can0 >", b"< ok >")]


def test_a_virtual_bus_shares_its_channel_with_python_cans_own():
    ours, theirs = open_bus("virtual://shared"), can.Bus(interface="virtual", channel="shared")
    data = bytearray(b"\x01\x02")
    ours.send(can.Message(arbitration_id=0x181, data=data, is_extended_id=False))
    data[0] = 9
    theirs.send(can.Message(arbitration_id=0x182, is_extended_id=False))
    here, there = ours.recv(0), theirs.recv(0)
    assert ours.recv(0) is None
    ours.shutdown()
    theirs.shutdown()
    assert here is not None
    assert there is not None
    assert (here.arbitration_id, there.arbitration_id, bytes(there.data)) == (0x182, 0x181, b"\x01\x02")


def test_a_server_that_says_nothing_is_given_up(monkeypatch):
    monkeypatch.setattr(module, "PROBE_TIMEOUT", 0.05)
    with (
        socket.create_server(("127.0.0.1", 0)) as mute,
        pytest.raises(BusError, match="no answer from"),
    ):
        open_bus(f"socketcand://127.0.0.1:{mute.getsockname()[1]}/can0")


@pytest.mark.parametrize(
    ("scripts", "says"),
    [
        ([[(b"", b"SSH-2.0-OpenSSH")]], "does not speak socketcand"),
        ([GREETING, [*GREETING, (b"< open can0 >", b"< error >")]], "refuses channel"),
    ],
    ids=["another protocol", "no such channel"],
)
def test_a_server_that_does_not_serve_the_channel_is_named(serve, scripts, says):
    url, _ = serve(*scripts)
    with pytest.raises(BusError, match=says):
        open_bus(url)


def test_frames_glued_to_the_last_answer_are_not_lost(serve):
    """A busy bus: the server's first frame comes in the same segment as its last answer."""
    url, _ = serve(GREETING, [*OPENING, (b"< rawmode >", b"< ok >< frame 181 1.5 1000 >")])
    bus = open_bus(url)
    message = bus.recv(5.0)
    bus.shutdown()
    assert message is not None
    assert (message.arbitration_id, bytes(message.data)) == (0x181, b"\x10\x00")


def test_a_server_that_goes_away_is_noticed_by_reading(serve):
    url, connections = serve(GREETING, [*OPENING, (b"< rawmode >", b"< ok >")])
    bus = open_bus(url)
    connections[1].shutdown(socket.SHUT_RDWR)
    with pytest.raises(can.CanOperationError):
        bus.recv(5.0)
    bus.shutdown()


@pytest.mark.parametrize(
    ("url", "library", "extra"),
    [
        ("slcan:///dev/ttyACM0@500000", "can.interfaces.slcan.serial", "slcan"),
        (
            "udp_multicast://239.74.163.2?port=43117",
            "can.interfaces.udp_multicast.utils.msgpack",
            "multicast",
        ),
    ],
)
def test_an_interface_without_its_library_names_the_extra(monkeypatch, url, library, extra):
    monkeypatch.setattr(library, None)
    with pytest.raises(BusError, match=rf"pip install 'omnimate\[{extra}\]'"):
        open_bus(url)


@pytest.mark.parametrize("url", ["socketcand:///can0", "socketcand://host:port/can0", "can0", ""])
def test_a_malformed_url_is_a_bus_error(url):
    with pytest.raises(BusError) as caught:
        open_bus(url)
    assert caught.value.url == url
