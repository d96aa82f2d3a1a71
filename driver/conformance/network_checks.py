"""NMT, heartbeat, node guarding, EMCY, SYNC, TIME, storing (CiA 301), and LSS (CiA 305)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.lss import NO_ID, LssMaster
from omnimate.driver.conformance.probe import (
    DEVICE_STATE,
    INCOMPATIBLE,
    INVALID_VALUE,
    LOCAL_CONTROL,
    NOT_STORED,
    AbsentError,
    ConformanceError,
    expect,
    expect_code,
)
from omnimate.files.logs.canopen_words import (
    HEARTBEAT,
    NMT_ID,
    NMT_PRE_OPERATIONAL,
    NMT_RESET_COMMUNICATION,
    NMT_RESET_NODE,
    NMT_START,
    NMT_STOP,
    OPERATIONAL,
    PRE_OPERATIONAL,
    SDO_ANSWER,
    SDO_REQUEST,
    STOPPED,
)

if TYPE_CHECKING:
    from omnimate.driver.conformance.probe import Probe

PERIOD = 0.1  # [s] of the heartbeat in the checks
STATES = {NMT_START: OPERATIONAL, NMT_STOP: STOPPED, NMT_PRE_OPERATIONAL: PRE_OPERATIONAL}
# Answers to a wrong signature: CiA 301 asks for 0800002xh, some devices state an invalid value.
WRONG_SIGNATURE = (NOT_STORED, LOCAL_CONTROL, DEVICE_STATE, INVALID_VALUE)
SAVE, LOAD = 0x65766173, 0x64616F6C  # signatures of 1010h and 1011h: "save", "load" in ASCII (CiA 301)


def device_type(probe: Probe) -> None:
    """1000h is there, 4 bytes long."""
    size = len(probe.read(0x1000))
    expect(size == 4, f"1000h has {size} bytes; expected 4")


def error_register(probe: Probe) -> None:
    """1001h is there, 1 byte long."""
    probe.read(0x1001)


def identity(probe: Probe) -> None:
    """1018h is there, with a vendor id that is not 0."""
    count = int.from_bytes(probe.read(0x1018)[:1], "little")
    expect(1 <= count <= 4, f"1018h:00 is {count}; expected 1 to 4")
    expect(int.from_bytes(probe.read(0x1018, 1), "little") != 0, "the vendor id 1018h:01 is 0")


def reset_node(probe: Probe) -> None:
    """NMT reset node ends with the boot-up frame."""
    probe.reset(NMT_RESET_NODE)
    probe.read(0x1000)


def reset_communication(probe: Probe) -> None:
    """NMT reset communication ends with the boot-up frame."""
    probe.reset(NMT_RESET_COMMUNICATION)
    probe.read(0x1000)


def states(probe: Probe) -> None:
    """Start, stop and enter pre-operational lead to the states that the heartbeat reports."""
    has_heartbeat = probe.find(0x1017) is not None
    with probe.restoring((0x1017, 0, 2)):
        _begin_heartbeat(probe)
        try:
            for command, expected in STATES.items():
                probe.nmt(command)
                state = _state(probe, has_heartbeat=has_heartbeat)
                expect(
                    state == expected,
                    f"state {state:02X}h after NMT {command:02X}h; expected {expected:02X}h",
                )
        finally:
            probe.nmt(NMT_PRE_OPERATIONAL)


def stopped_is_silent(probe: Probe) -> None:
    """A stopped node does not answer SDO; afterwards it does."""
    probe.nmt(NMT_STOP)
    try:
        answer = probe.ask(b"\x40\x00\x10".ljust(8, b"\0"))
    finally:
        probe.nmt(NMT_PRE_OPERATIONAL)
    expect(answer is None, "SDO is answered in the state stopped")
    probe.read(0x1000)


def foreign_commands(probe: Probe) -> None:
    """Unknown NMT commands, and those of another node, change nothing."""
    has_heartbeat = probe.find(0x1017) is not None
    with probe.restoring((0x1017, 0, 2)):
        _begin_heartbeat(probe)
        probe.nmt(NMT_PRE_OPERATIONAL)
        other = probe.node % 126 + 1
        for data in (bytes([0x05, probe.node]), bytes([NMT_START]), b""):
            probe.send(NMT_ID, data)
        if not _is_there(probe, other):
            probe.send(NMT_ID, bytes([NMT_START, other]))
        state = _state(probe, has_heartbeat=has_heartbeat)
        expect(state == 0x7F, f"state {state:02X}h; expected pre-operational, 7Fh, as before")


def heartbeat(probe: Probe) -> None:
    """1017h sets the period of the heartbeat, and 0 ends it."""
    probe.need(0x1017)
    with probe.restoring((0x1017, 0, 2)):
        _begin_heartbeat(probe)
        times = [reply.time for reply in probe.heartbeats(6.5 * PERIOD)]
        expect(5 <= len(times) <= 8, f"{len(times)} heartbeats in {6.5 * PERIOD:g} s at 1017h = 100 ms")
        probe.write(0x1017, 0, 0, 2)
        probe.listen(PERIOD)
        expect(not probe.heartbeats(3 * PERIOD), "heartbeats at 1017h = 0")


def heartbeat_consumer(probe: Probe) -> None:
    """1016h refuses to monitor one node twice."""
    if probe.need(0x1016) < 2:
        raise AbsentError("1016h has fewer than two entries")
    with probe.restoring((0x1016, 1, 4), (0x1016, 2, 4)):
        probe.write(0x1016, 1, 126 << 16 | 500, 4)
        expect_code(probe.refusal(0x1016, 2, 126 << 16 | 600, 4), INCOMPATIBLE)


def error_after_heartbeat_loss(probe: Probe) -> None:
    """A monitored heartbeat that ends causes EMCY 8130h, and 1029h:1 decides what state follows."""
    probe.need(0x1016, 1)
    if probe.find(0x1029, 1) is None:
        raise AbsentError("no 1029h:01")
    monitored = next(node for node in range(126, 0, -1) if node != probe.node and not _is_there(probe, node))
    with probe.restoring((0x1016, 1, 4), (0x1017, 0, 2), (0x1029, 1, 1)):
        for behaviour, expected in ((0, 0x7F), (1, 0x05), (2, 0x04)):
            probe.nmt(NMT_PRE_OPERATIONAL)
            probe.write(0x1029, 1, behaviour, 1)
            probe.write(0x1016, 1, monitored << 16 | 100, 4)
            _begin_heartbeat(probe)
            probe.nmt(NMT_START)
            probe.send(0x700 + monitored, b"\x05")
            replies = probe.listen(4 * PERIOD)
            codes = [reply.data[:2] for reply in replies if reply.can_id == 0x80 + probe.node]
            reported = [reply.data[0] for reply in replies if reply.can_id == HEARTBEAT + probe.node]
            state = reported[-1] if reported else 0
            probe.nmt(NMT_PRE_OPERATIONAL)
            expect(b"\x30\x81" in codes, "no EMCY 8130h after a monitored heartbeat ended")
            expect(
                reported and state == expected,
                f"state {state:02X}h at 1029h:01 = {behaviour}; expected {expected:02X}h",
            )


def node_guarding(probe: Probe) -> None:
    """A remote frame on 700h + node is answered with the state, its toggle bit alternating."""
    with probe.restoring((0x1017, 0, 2)):
        if probe.find(0x1017) is not None:
            probe.write(0x1017, 0, 0, 2)
        answers = []
        for _ in range(3):
            answer = probe.guard()
            if answer is None:
                raise AbsentError("no node guarding: a remote frame is not answered")
            answers.append(answer)
    expect(all(len(data) == 1 for data in answers), "a guarding answer that is not of 1 byte")
    toggles = [data[0] & 0x80 for data in answers]
    expect(toggles[0] != toggles[1] != toggles[2], "the toggle bit does not alternate")
    states_seen = {data[0] & 0x7F for data in answers}
    expect(states_seen == {0x7F}, f"states {states_seen}; expected pre-operational, 7Fh")


def guarding_or_heartbeat(probe: Probe) -> None:
    """A node has a heartbeat or node guarding."""
    if probe.find(0x1017) is None:
        try:
            node_guarding(probe)
        except AbsentError as absent:
            raise ConformanceError("neither 1017h nor node guarding") from absent


def error_history(probe: Probe) -> None:
    """1003h:00 is set to 0 to clear the history, and to nothing else."""
    probe.need(0x1003)
    expect_code(probe.refusal(0x1003, 0, 1, 1), INVALID_VALUE)
    expect(probe.refusal(0x1003, 0, 0, 1) is None, "the history is not cleared by writing 0 to 1003h:00")
    expect(probe.need(0x1003) == 0, f"1003h:00 is {probe.need(0x1003)} after clearing")


def emergency_cob_id(probe: Probe) -> None:
    """1014h is 80h + node after a reset."""
    value = probe.need(0x1014)
    expect(value & 0x7FF == 0x80 + probe.node, f"1014h is {value:08X}h; expected {0x80 + probe.node:X}h")


def sync_cob_id(probe: Probe) -> None:
    """1005h is 80h, and no device produces SYNC by itself."""
    value = probe.need(0x1005)
    expect(value & 0x7FF == 0x080, f"1005h is {value:08X}h; expected 80h")
    expect(not value & 1 << 30, "1005h has bit 30 set: the device produces SYNC")


def sync_counter(probe: Probe) -> None:
    """1019h takes 0 and 2 to 240 only."""
    probe.need(0x1019)
    with probe.restoring((0x1019, 0, 1)):
        for value in (1, 241, 255):
            expect_code(probe.refusal(0x1019, 0, value, 1), INVALID_VALUE)
        for value in (2, 240, 0):
            expect(probe.refusal(0x1019, 0, value, 1) is None, f"{value} is refused")


def time_stamp(probe: Probe) -> None:
    """1012h is 100h with bit 31 for a consumer; a TIME frame disturbs nothing."""
    value = probe.need(0x1012)
    expect(value & 0x7FF == 0x100, f"1012h is {value:08X}h; expected 100h in its low bits")
    for data in (bytes(6), bytes(4)):
        probe.send(0x100, data)
    probe.read(0x1000)


def store_signature(probe: Probe) -> None:
    """1010h and 1011h do nothing without their signatures."""
    found = [index for index in (0x1010, 0x1011) if probe.find(index, 1) is not None]
    if not found:
        raise AbsentError("no 1010h:01 and no 1011h:01")
    for index in found:
        expect_code(probe.refusal(index, 1, 0x12345678, 4), *WRONG_SIGNATURE)


def store_and_restore(probe: Probe) -> None:
    """Values stored by 1010h hold after a reset; 1011h brings the factory's values back."""
    probe.need(0x1010, 1)
    probe.need(0x1011, 1)
    before = probe.need(0x1017)
    probe.write(0x1017, 0, 777, 2)
    probe.write(0x1010, 1, SAVE, 4)
    probe.reset(NMT_RESET_NODE)
    stored = probe.need(0x1017)
    probe.write(0x1011, 1, LOAD, 4)
    probe.reset(NMT_RESET_NODE)
    restored = probe.need(0x1017)
    if before != restored:
        probe.write(0x1017, 0, before, 2)
        probe.write(0x1010, 1, SAVE, 4)
    expect(stored == 777, f"1017h is {stored} after saving 777 and a reset")
    expect(restored != 777, "1017h is still the stored one after restoring and a reset")


def lss_selective(probe: Probe) -> None:
    """LSS switches the node with its identity to configuration, where it reports its node id."""
    master = _selected(probe)
    try:
        expect(master.node_id() == probe.node, f"it reports node id {master.node_id()}")
        stated = tuple(probe.need(0x1018, subindex) for subindex in (1, 2, 3, 4))
        expect(
            master.identity() == stated,
            f"it reports {master.identity()}; 1018h is {stated}",
        )
    finally:
        master.leave()


def lss_fastscan(probe: Probe) -> None:
    """A node without an id is found by fastscan, gets its id back, and boots."""
    wanted = tuple(probe.need(0x1018, subindex) for subindex in (1, 2, 3, 4))
    master = _selected(probe)
    expect(master.configure_id(NO_ID), "it does not give its node id up")
    master.leave()
    probe.send(NMT_ID, bytes([NMT_RESET_COMMUNICATION, probe.node]))
    probe.listen(PERIOD)
    found = master.fastscan()
    if found is not None:
        expect(master.configure_id(probe.node), f"it does not take the node id {probe.node}")
        probe.drain()
        master.leave()
        boot = probe.await_frame(HEARTBEAT + probe.node)
        expect(boot == b"\0", "no boot-up after the node id was set")
    expect(found == wanted, f"fastscan found {found}; expected {wanted}")


def _selected(probe: Probe) -> LssMaster:
    """Switch the node to LSS configuration by its identity; raise AbsentError where it has no LSS."""
    master = LssMaster(probe)
    if not master.select([probe.find(0x1018, subindex) or 0 for subindex in (1, 2, 3, 4)]):
        raise AbsentError("no LSS: the node does not answer to its identity")
    return master


def _begin_heartbeat(probe: Probe) -> None:
    if probe.find(0x1017) is not None:
        probe.write(0x1017, 0, round(PERIOD * 1000), 2)


def _state(probe: Probe, *, has_heartbeat: bool) -> int:
    """Return the NMT state by the heartbeat, or by node guarding."""
    if has_heartbeat:
        heard = probe.heartbeats(2.5 * PERIOD)
        expect(heard, "no heartbeat")
        return heard[-1].data[0] & 0x7F
    answer = probe.guard()
    if answer is None:
        raise ConformanceError("neither a heartbeat nor an answer to node guarding")
    return answer[0] & 0x7F


def _is_there(probe: Probe, node: int) -> bool:
    """Return whether another node answers SDO."""
    probe.listen(0.0)
    probe.send(SDO_REQUEST + node, b"\x40\x00\x10".ljust(8, b"\0"))
    return probe.await_frame(SDO_ANSWER + node, PERIOD) is not None
