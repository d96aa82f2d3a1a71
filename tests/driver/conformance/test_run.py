"""The checks pass what is right and fail what is wrong: simulated devices, `LocalNode`, and two dummies."""

import math

import pytest

from docs.generate.conformance import BenchBus, all_results, frame, table
from omnimate.driver.conformance.probe import ConformanceError, Probe
from omnimate.driver.conformance.run import CHECKS, EFFECTS, _result, conform

# What `LocalNode` does not do, by its code: it sends no PDOs, resets nothing, and checks no value.
LOCAL_NODE_FAILS = {
    "SDO segment of no transfer",
    "SDO request of 4 bytes",
    "SDO abort by the client",
    "SDO download without size",
    "NMT stopped",
    "NMT reset node",
    "NMT reset communication",
    "1003h error history",
    "1029h error behaviour",
    "1019h SYNC counter",
    "1800h on each SYNC",
    "1800h on every third SYNC",
    "1800h reserved types",
    "1800h COB-ID in use",
    "1800h event timer",
    "1A00h in use",
    "1A00h absent object",
    "1A00h more than 8 bytes",
    "1010h, 1011h signatures",
    "1010h, 1011h store and restore",
    "mandatory objects",
    "6200h cyclic timer",
}


class Mute:
    """A node that is not there."""

    due = math.inf

    def __init__(self, send):
        self.send = send

    def run(self, now):
        """Have no timer."""

    def receive(self, message, now):
        """Answer nothing."""


class Yes(Mute):
    """A node 1 that answers everything and does nothing."""

    def receive(self, message, now):
        data = bytes(message.data)
        if message.is_remote_frame:
            self.send(frame(message.arbitration_id, b"\x05"))
        elif message.arbitration_id == 0x7E5:
            self.send(frame(0x7E4, bytes(8)))
        elif message.arbitration_id == 0x601:
            self.send(frame(0x581, self.answer(data)))

    def answer(self, data):
        if len(data) != 8:
            return bytes(3)
        heads = {2: b"\x43" + data[1:4] + b"\1", 1: b"\x60" + data[1:4]}
        return heads.get(data[0] >> 5, b"\x20").ljust(8, b"\0")


def probe_of(kind):
    bus = BenchBus(kind)
    return Probe(bus, 1, timeout=0.1, clock=lambda: bus.time)


def outcomes(name):
    return {(result.check.standard, result.check.subject): result.outcome for result in all_results()[name]}


@pytest.mark.parametrize("name", ["encoder", "drive"])
def test_the_simulated_devices_do_all_that_the_standards_ask_for(name):
    assert [result for result in all_results()[name] if result.outcome == "failed"] == []


def test_every_service_is_there_in_one_of_the_simulated_devices_at_least():
    encoder, drive = outcomes("encoder"), outcomes("drive")
    absent = [subject for subject in encoder if encoder[subject] == drive[subject] == "absent"]
    assert absent == [("CiA 301", "1016h heartbeat consumer")]  # they watch one node


def test_local_node_fails_what_its_code_does_not_do():
    assert {
        subject for (_, subject), outcome in outcomes("canopen LocalNode").items() if outcome == "failed"
    } == (LOCAL_NODE_FAILS)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: f"{check.standard} {check.subject}")
def test_every_check_can_fail(check):
    results = [_result(probe_of(kind), check) for kind in (Mute, Yes)]
    failed = {result.check.subject for result in results if result.outcome == "failed"} | LOCAL_NODE_FAILS
    assert check.subject in failed


def test_a_node_that_is_not_there_is_an_error_and_no_list_of_failures():
    with pytest.raises(ConformanceError, match="no answer to SDO about 1000h:00"):
        next(conform(probe_of(Mute)))


@pytest.mark.parametrize("most", EFFECTS)
def test_no_check_does_more_to_a_device_than_is_allowed(most):
    frames = []

    class Watched(Yes):
        def receive(self, message, now):
            frames.append((message.arbitration_id, bytes(message.data)))
            super().receive(message, now)

    results = list(conform(probe_of(Watched), most))
    allowed = EFFECTS[: EFFECTS.index(most) + 1]
    assert {result.check.effect for result in results} <= set(allowed)
    if "resets" not in allowed:
        assert not [data for can_id, data in frames if can_id == 0x000]
    if "writes" not in allowed:  # only downloads to the object that does not exist
        assert {data[1:3] for can_id, data in frames if can_id == 0x601 and data[0] >> 5 == 1} <= {
            b"\xff\x2f"
        }
    if "stores" not in allowed:
        assert not [data for _, data in frames if data[4:] == b"save" or data[:2] == b"\x11\xff"]


def test_the_table_has_a_row_for_each_check():
    rows = table().splitlines()
    assert len(rows) == 2 + len(CHECKS)
    assert "canopen LocalNode" in rows[0]
    assert all(check.demand.endswith(".") for check in CHECKS)
