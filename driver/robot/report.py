"""The report of a drive: frame counters and states of the nodes, and events in order of time."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from omnimate.driver.robot.events import NodeCounts
from omnimate.files.logs.canopen_words import NMT_STATES, OPERATIONAL, nmt_state_in_words

if TYPE_CHECKING:
    from omnimate.driver.robot.events import Event, Trouble
    from omnimate.driver.robot.monitor import Monitor
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Gap


@dataclass(slots=True, kw_only=True)
class NodeReport(NodeCounts):
    """The state of one node, with its frame counters."""

    node: int  # CANopen node id
    names: tuple[str, ...]  # channels that the node measures, and drives of wheels that it contains
    state: str  # NMT state in its last heartbeat, in words
    restarts: int = 0  # number of boot-ups and losses of the configuration
    emergencies: int = 0  # number of EMCY frames
    is_lost: bool = False  # whether its heartbeat is overdue

    @property
    def is_well(self) -> bool:
        """Whether it works: its heartbeat is not overdue, and it is operational or a drive."""
        return not self.is_lost and (
            self.state == NMT_STATES[OPERATIONAL] or self.names[0].startswith("drive of ")
        )


@dataclass(frozen=True, slots=True, eq=False)  # compared by identity: a report is a moment
class DriverReport:
    """Counters, events and gaps from the first SYNC until now."""

    started: float  # time of the first SYNC [s]; 0 before it
    syncs: int  # number of SYNCs sent or received
    skipped: int  # number of periods that the host let pass without a SYNC
    nodes: tuple[NodeReport, ...]  # report of each node, in order of the node ids
    events: tuple[Event, ...]  # events in order of time
    events_dropped: int  # number of events that were dropped because the log was full
    gaps: tuple[Gap, ...]  # gaps of all channels
    # identifier, description and number of frames that nothing expects, by kind
    unknown_frames: tuple[tuple[str, str, int], ...]
    # what stopped all wheels since the drives were last enabled; empty where nothing did
    troubles: tuple[Trouble, ...] = ()

    @property
    def is_clean(self) -> bool:
        """Whether every SYNC was answered by every node and nothing else happened."""
        return not (self.events or self.gaps or self.unknown_frames or self.skipped)

    @property
    def problems(self) -> tuple[Event, ...]:
        """Events that somebody must put right before the data can be trusted, in order of time."""
        return tuple(event for event in self.events if event.is_problem)

    def node(self, node: int) -> NodeReport:
        """Return the report of one node; raises KeyError where the vehicle has no such node."""
        for report in self.nodes:
            if report.node == node:
                return report
        raise KeyError(node)


def make_report(vehicle: VehicleParameters, monitor: Monitor, syncs: int, skipped: int = 0) -> DriverReport:
    """Return the report of all frames that a monitor has received so far."""
    monitor.assembler.update_counts()
    return DriverReport(
        monitor.assembler.started or 0.0,
        syncs,
        skipped,
        tuple(_node_report(vehicle, monitor, node) for node in sorted(monitor.counts)),
        monitor.events.all(),
        monitor.events.dropped,
        monitor.assembler.gaps_until_now(),
        monitor.unknown.rows(),
    )


def _node_report(vehicle: VehicleParameters, monitor: Monitor, node: int) -> NodeReport:
    counts, state = monitor.counts[node], monitor.supervision.nodes[node]
    channels = [encoder.channel for encoder in vehicle.encoders if encoder.node == node]
    wheels = [f"drive of {drive.wheel}" for drive in vehicle.drives if drive.node == node]
    return NodeReport(
        **asdict(counts),
        node=node,
        names=(*channels, *wheels),
        state="no heartbeat" if state.state is None else nmt_state_in_words(state.state),
        restarts=state.restarts,
        emergencies=state.emergencies,
        is_lost=state.is_lost,
    )
