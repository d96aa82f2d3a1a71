"""What happened on a drive, node by node and in order of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vehicle.canopen_words import nmt_state_in_words

if TYPE_CHECKING:
    from driver.events import Event
    from driver.monitor import Monitor
    from vehicle.parameters import VehicleParameters
    from vehicle.recording import Gap


OPERATIONAL = "operational"


@dataclass(frozen=True, slots=True)
class NodeReport:
    """One node's frames, counted.

    Attributes:
        node: CANopen node id.
        names: channels and wheels that hang on it.
        state: of its last heartbeat, in words.
        received: PDOs in samples.
        missing: SYNCs without an answer in time.
        late: PDOs after their sample was closed.
        duplicate: second answers to one SYNC.
        wrong_length: frames of an impossible length.
        unknown: frames that nothing expects.
        jumps: readings that no robot can make.
        restarts: boot-ups and losses of the configuration.
        emergencies: EMCY frames.
        is_lost: its heartbeat is overdue.
    """

    node: int
    names: tuple[str, ...]
    state: str
    received: int
    missing: int
    late: int
    duplicate: int
    wrong_length: int
    unknown: int
    jumps: int
    restarts: int
    emergencies: int
    is_lost: bool = False

    @property
    def is_well(self) -> bool:
        """Whether it works now; a drive is not started before it is enabled, and is well for all that."""
        return not self.is_lost and (self.state == OPERATIONAL or self.names[0].startswith("drive of "))


@dataclass(frozen=True, slots=True)
class DriverReport:
    """A whole drive.

    Attributes:
        started: time of the first SYNC [s].
        syncs: sent or seen.
        skipped: periods that the host let pass without a SYNC.
        nodes: in order of their id.
        events: in order of time.
        events_dropped: beyond the bound of the log.
        gaps: of all channels.
        strangers: (identifier, what, frames) that no node of the vehicle should send.
    """

    started: float
    syncs: int
    skipped: int
    nodes: tuple[NodeReport, ...]
    events: tuple[Event, ...]
    events_dropped: int
    gaps: tuple[Gap, ...]
    strangers: tuple[tuple[str, str, int], ...]

    @property
    def is_clean(self) -> bool:
        """Whether every SYNC was answered by every node and nothing else happened."""
        return not (self.events or self.gaps or self.strangers or self.skipped)

    def node(self, node: int) -> NodeReport:
        """Return the report of one node; KeyError where the vehicle has none such."""
        for one in self.nodes:
            if one.node == node:
                return one
        raise KeyError(node)


def make_report(vehicle: VehicleParameters, monitor: Monitor, syncs: int, skipped: int = 0) -> DriverReport:
    """Return what a monitor has seen so far."""
    strangers = ((key, one.what, one.count) for key, one in monitor.strangers.kinds.items())
    return DriverReport(
        monitor.assembler.started or 0.0,
        syncs,
        skipped,
        tuple(_node_report(vehicle, monitor, node) for node in sorted(monitor.counts)),
        monitor.events.all(),
        monitor.events.dropped,
        monitor.assembler.gaps_until_now(),
        tuple(strangers),
    )


def _node_report(vehicle: VehicleParameters, monitor: Monitor, node: int) -> NodeReport:
    counts, state = monitor.counts[node], monitor.supervision.nodes[node]
    channels = [one.channel for one in vehicle.encoders if one.node == node]
    wheels = [f"drive of {one.wheel}" for one in vehicle.drives if one.node == node]
    return NodeReport(
        node,
        (*channels, *wheels),
        "no heartbeat" if state.state is None else nmt_state_in_words(state.state),
        counts.received,
        counts.missing,
        counts.late,
        counts.duplicate,
        counts.wrong_length,
        counts.unknown,
        counts.jumps,
        state.restarts,
        state.emergencies,
        state.is_lost,
    )
