"""Any interface of python-can opens by its URL, with its keys and its bit timing."""

import sys
from types import ModuleType
from urllib.parse import urlencode

import can
import pytest
from can.interfaces import BACKENDS
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.bus.adapters import BusUrl
from omnimate.driver.bus.bus import open_bus
from omnimate.driver.errors import BusError


class Adapter(can.BusABC):
    """A vendor's interface that keeps how it was opened.

    :param bool quiet:
        A key that stands in the documentation only.
    """

    def __init__(self, channel="1", bitrate=500_000, timing=None, serial=None, **kwargs):
        self.channel_info = "adapter"
        self.opened = {"channel": channel, "bitrate": bitrate, "timing": timing, "serial": serial, **kwargs}
        super().__init__(channel)
        self._is_shutdown = True  # there is nothing to shut down

    def send(self, msg, timeout=None):
        raise NotImplementedError


class Plain(can.BusABC):
    """An interface that takes a channel alone."""

    def __init__(self, channel="1"):
        self.channel_info = "plain"
        self.opened = {"channel": channel}
        super().__init__(channel)
        self._is_shutdown = True

    def send(self, msg, timeout=None):
        raise NotImplementedError


@pytest.fixture(autouse=True)
def vendors(monkeypatch):
    module = ModuleType("vendor_adapters")
    module.Adapter, module.Plain = Adapter, Plain
    monkeypatch.setitem(sys.modules, "vendor_adapters", module)
    monkeypatch.setitem(BACKENDS, "acme", ("vendor_adapters", "Adapter"))
    monkeypatch.setitem(BACKENDS, "acme_plain", ("vendor_adapters", "Plain"))
    monkeypatch.setitem(BACKENDS, "acme_absent", ("vendor_that_is_not_installed", "Bus"))


words = st.text("abcdefghijklmnopqrstuvwxyz_", min_size=1)
values = st.one_of(st.booleans(), st.integers(), st.sampled_from(["ACTIVE", "PCAN_USBBUS1", "a b/c", ""]))


channels = st.sampled_from(["", "0", "PCAN_USBBUS1", "/dev/ttyACM0", "239.0.0.1", "ff15::1"])
options = st.dictionaries(words, values)


@given(interface=words, channel=channels, options=options, slashes=st.sampled_from(["", "//"]))
def test_the_parts_of_a_url_are_what_it_was_made_of(interface, channel, options, slashes):
    query = f"?{urlencode(options)}" if options else ""
    url = BusUrl.of(f"{interface}:{slashes}{channel}{query}")
    assert (url.interface, url.channel, url.options) == (interface, channel, options)


@pytest.mark.parametrize(
    "url", ["acme://USB1?bitrate=250000&serial=0x1F", "acme:USB1?serial=31&bitrate=250000"]
)
def test_the_keys_of_the_url_are_those_of_the_interface(url):
    opened = open_bus(url, 1_000_000).opened
    assert (opened["channel"], opened["bitrate"], opened["serial"]) == ("USB1", 250_000, 31)


def test_the_robots_bit_rate_is_used_where_the_url_has_none_and_the_interface_takes_one():
    assert open_bus("acme://", 125_000).opened["bitrate"] == 125_000
    assert open_bus("acme://").opened["bitrate"] == 500_000
    assert open_bus("acme_plain://7", 125_000).opened == {"channel": "7"}


def test_a_sample_point_becomes_a_bit_timing():
    timing = open_bus("acme://?bitrate=250000&sample_point=87.5", 1_000_000).opened["timing"]
    assert (timing.bitrate, timing.sample_point) == (250_000, 87.5)


def test_registers_become_a_bit_timing():
    url = "acme://?f_clock=16000000&brp=2&tseg1=13&tseg2=2&sjw=1"
    timing = open_bus(url).opened["timing"]
    assert (timing.bitrate, timing.f_clock, timing.sample_point) == (500_000, 16_000_000, 87.5)


def test_a_key_that_is_documented_only_is_passed_on():
    assert open_bus("acme://?quiet=true").opened["quiet"] is True


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("acme://?bitrat=250000", r"acme has no bitrat; expected .*bitrate"),
        ("acme://?bitrate=250000&bitrate=1", "bitrate is given twice"),
        ("acme://?bitrate=250000&sample_point=1", "no controller with 8000000 Hz has this bit timing"),
        (
            "acme://?brp=2&tseg1=13",
            "bit timing of brp, tseg1; expected bitrate and sample_point, or brp",
        ),
        ("acme_plain://7?sample_point=80&bitrate=1000", "acme_plain takes no bit timing"),
        ("acme_absent://7", "what acme_absent needs is not installed"),
        ("nobody://7", r"unknown interface 'nobody'; expected one of .*pcan://.*vector://"),
        ("PCAN_USBBUS1", "expected interface://channel"),
    ],
)
def test_a_url_that_cannot_be_opened_says_why(url, says):
    with pytest.raises(BusError, match=says):
        open_bus(url)


@pytest.mark.parametrize("name", ["pcan", "kvaser", "vector", "gs_usb", "cantact", "neovi", "ixxat"])
def test_an_adapter_that_is_not_here_is_a_bus_error(name):
    with pytest.raises(BusError, match=f"{name}://"):
        open_bus(f"{name}://0?bitrate=250000")


def test_frames_pass_between_two_udp_multicast_buses():
    pytest.importorskip("msgpack")
    url = "udp_multicast://239.74.163.2?port=43117&fd=false"
    try:
        sender, receiver = open_bus(url), open_bus(url)
    except BusError as error:
        pytest.skip(f"no multicast on this machine: {error}")
    with sender, receiver:
        sender.send(can.Message(arbitration_id=0x181, data=b"\x01\x02", is_extended_id=False))
        message = receiver.recv(5.0)
    assert (message.arbitration_id, bytes(message.data)) == (0x181, b"\x01\x02")
