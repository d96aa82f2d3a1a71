"""All checks in their order, and a run of them against one node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from omnimate.driver.conformance import network_checks, pdo_checks, profile_checks, sdo_checks
from omnimate.driver.conformance.probe import (
    AbortedError,
    AbsentError,
    ConformanceError,
)
from omnimate.files.logs.canopen_words import NMT_PRE_OPERATIONAL

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from omnimate.driver.conformance.probe import Probe

    Rows = tuple[tuple[str, Callable[[Probe], None], "Effect"], ...]

Outcome = Literal["passed", "failed", "absent"]
Effect = Literal["reads", "writes", "resets", "stores"]  # what a check does to a device, the harmless first
EFFECTS: tuple[Effect, ...] = ("reads", "writes", "resets", "stores")


@dataclass(frozen=True, slots=True)
class Check:
    """One demand of a standard."""

    standard: str  # standard that asks for it
    subject: str  # object or service that it concerns
    run: Callable[[Probe], None]  # raises what is wrong; its docstring is the demand
    # what it does to the device: it reads, writes and puts back, changes the NMT state or resets, or stores
    effect: Effect = "reads"

    @property
    def demand(self) -> str:
        """What the standard asks for, in one sentence."""
        return (self.run.__doc__ or "").strip()


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome of a check."""

    check: Check  # the check
    # whether the device does it, does it wrongly, or does not have it at all where it need not
    outcome: Outcome
    reason: str = ""  # why it did not pass; empty where it did


_CIA_301: Rows = (
    ("1000h device type", network_checks.device_type, "reads"),
    ("1001h error register", network_checks.error_register, "reads"),
    ("1018h identity", network_checks.identity, "reads"),
    ("SDO expedited upload", sdo_checks.expedited_upload, "reads"),
    ("SDO segmented upload", sdo_checks.segmented_upload, "reads"),
    ("SDO toggle bit", sdo_checks.toggle_error, "reads"),
    ("SDO absent object", sdo_checks.absent_object, "reads"),
    ("SDO absent sub-index", sdo_checks.absent_subindex, "reads"),
    ("SDO unknown command", sdo_checks.unknown_command, "reads"),
    ("SDO segment of no transfer", sdo_checks.stray_segment, "reads"),
    ("SDO request of 4 bytes", sdo_checks.short_request, "reads"),
    ("SDO abort by the client", sdo_checks.client_abort, "reads"),
    ("SDO block upload", sdo_checks.block_upload, "reads"),
    ("SDO read-only object", sdo_checks.read_only, "writes"),
    ("SDO short download", sdo_checks.short_download, "writes"),
    ("SDO long download", sdo_checks.long_download, "writes"),
    ("SDO download without size", sdo_checks.download_without_size, "writes"),
    ("SDO segmented download", sdo_checks.segmented_download, "writes"),
    ("SDO short segments", sdo_checks.short_segments, "writes"),
    ("SDO block download", sdo_checks.block_download, "writes"),
    ("heartbeat or node guarding", network_checks.guarding_or_heartbeat, "reads"),
    ("1017h heartbeat", network_checks.heartbeat, "writes"),
    ("1016h heartbeat consumer", network_checks.heartbeat_consumer, "writes"),
    ("node guarding", network_checks.node_guarding, "resets"),
    ("NMT states", network_checks.states, "resets"),
    ("NMT stopped", network_checks.stopped_is_silent, "resets"),
    ("NMT foreign commands", network_checks.foreign_commands, "resets"),
    ("NMT reset node", network_checks.reset_node, "resets"),
    ("NMT reset communication", network_checks.reset_communication, "resets"),
    ("1003h error history", network_checks.error_history, "writes"),
    ("1014h COB-ID EMCY", network_checks.emergency_cob_id, "reads"),
    ("1029h error behaviour", network_checks.error_after_heartbeat_loss, "resets"),
    ("1005h COB-ID SYNC", network_checks.sync_cob_id, "reads"),
    ("1019h SYNC counter", network_checks.sync_counter, "writes"),
    ("1012h TIME", network_checks.time_stamp, "writes"),
    ("1800h on each SYNC", pdo_checks.answers_sync, "resets"),
    ("1800h on every third SYNC", pdo_checks.every_third_sync, "resets"),
    ("1800h reserved types", pdo_checks.reserved_types, "resets"),
    ("1800h switched off", pdo_checks.switched_off, "resets"),
    ("1800h COB-ID in use", pdo_checks.cob_id_while_valid, "resets"),
    ("1800h event timer", pdo_checks.event_timer, "resets"),
    ("1A00h in use", pdo_checks.mapping_order, "resets"),
    ("1A00h changed", pdo_checks.mapping_changes, "resets"),
    ("1A00h absent object", pdo_checks.mapping_of_nothing, "resets"),
    ("1A00h more than 8 bytes", pdo_checks.mapping_too_long, "resets"),
    ("1400h short RPDO", pdo_checks.rpdo_length, "resets"),
    ("1010h, 1011h signatures", network_checks.store_signature, "writes"),
    ("1010h, 1011h store and restore", network_checks.store_and_restore, "stores"),
)
_CIA_305: Rows = (
    ("LSS switch state selective", network_checks.lss_selective, "resets"),
    ("LSS fastscan", network_checks.lss_fastscan, "stores"),
)
_CIA_406: Rows = (
    ("mandatory objects", profile_checks.encoder_objects, "reads"),
    ("6004h position", profile_checks.encoder_position, "writes"),
    ("6200h cyclic timer", profile_checks.encoder_timer, "resets"),
)
_CIA_402: Rows = (
    ("mandatory objects", profile_checks.drive_objects, "reads"),
    ("read-only objects", profile_checks.drive_read_only, "writes"),
    ("6060h modes", profile_checks.drive_modes, "writes"),
    ("6040h, 6041h states", profile_checks.drive_states, "resets"),
)
CHECKS: tuple[Check, ...] = tuple(
    Check(standard, subject, run, effect)
    for standard, checks in (
        ("CiA 301", _CIA_301), ("CiA 305", _CIA_305), ("CiA 406", _CIA_406), ("CiA 402", _CIA_402),
    )
    for subject, run, effect in checks
)  # fmt: skip


def conform(probe: Probe, most: Effect = "resets") -> Iterator[Result]:
    """Run the checks against a node that do no more to it than `most`; it is pre-operational at the end.

    Raises BusLost, or ConformanceError where the node does not answer SDO at all.
    """
    allowed = EFFECTS[: EFFECTS.index(most) + 1]
    probe.read(0x1000)
    for check in CHECKS:
        if check.effect in allowed:
            yield _result(probe, check)
    if "resets" in allowed:
        probe.nmt(NMT_PRE_OPERATIONAL)


def _result(probe: Probe, check: Check) -> Result:
    try:
        check.run(probe)
    except AbsentError as absent:
        return Result(check, "absent", str(absent))
    except (ConformanceError, AbortedError) as error:
        return Result(check, "failed", str(error))
    return Result(check, "passed")
