"""Configures and starts the nodes of a vehicle's encoders, at first and again after a restart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.configuration import with_ranges
from omnimate.driver.configure import configure_node
from omnimate.driver.network import NMT_PRE_OPERATIONAL, NMT_START
from omnimate.driver.supervision import OPERATIONAL

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from omnimate.driver.configuration import NodeConfiguration
    from omnimate.driver.monitor import Monitor
    from omnimate.driver.sdo import Sdo
    from omnimate.vehicle.parameters import VehicleParameters

WATCHED_OBJECTS = (0x6509, 0x650B)  # a change of these shows a preset or a swapped encoder


class EncoderNodes:
    """The nodes of a vehicle's encoders.

    Args:
        vehicle: Vehicle as its owner believes it to be.
        monitor: Monitor of the bus.
        sdos: Objects of each node by node id.
        nmt: Sends an NMT command to a node: command specifier, node id.

    Attributes:
        vehicle: Vehicle with the ranges by which the counters are unwrapped, after `configure_all`.
        ids: Node ids in order.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        monitor: Monitor,
        sdos: Mapping[int, Sdo],
        nmt: Callable[[int, int], None],
    ) -> None:
        self.vehicle = vehicle
        self.ids = tuple(sorted({encoder.node for encoder in vehicle.encoders}))
        self._monitor, self._sdos, self._nmt = monitor, sdos, nmt
        self._encoder_objects: dict[int, dict[int, int]] = {}
        self._boots: dict[int, int] = {}
        self._interrupted: set[int] = set()  # were operational before they were configured

    def configure(self, node: int) -> NodeConfiguration:
        """Configure one node and return what was read and changed; errors as of `configure_node`.

        Where that fails, the nodes that were operational before are started again.
        """
        self._boots[node] = self._monitor.supervision.nodes[node].boots
        try:
            return configure_node(self._sdos[node], self.vehicle, self._interrupt)
        except BaseException:
            for stopped in self._interrupted:
                self._nmt(NMT_START, stopped)
            self._interrupted.clear()
            raise

    def configure_all(self) -> tuple[NodeConfiguration, ...]:
        """Configure every node and take over the ranges of their counters; errors as of `configure_node`."""
        configurations = tuple(self.configure(node) for node in self.ids)
        self.vehicle = with_ranges(self.vehicle, configurations)
        return configurations

    def start(self, configuration: NodeConfiguration) -> None:
        """Start a configured node and supervise it.

        Raises:
            BusLost: The interface failed.
        """
        node = configuration.node
        self._encoder_objects[node] = configuration.encoder_objects
        for cob_id, length in configuration.lengths.items():
            self._monitor.assembler.expect_length(cob_id, length)
        self._nmt(NMT_START, node)
        self._interrupted.discard(node)
        self._monitor.supervision.started(node, configuration.heartbeat)
        self._monitor.assembler.await_again(node)

    def start_again(self, configuration: NodeConfiguration, now: float) -> bool:
        """Start a node that was configured again at `now` [s], and log what has changed in it.

        Returns:
            Whether the configuration holds; False where the node has booted since, so that it is lost again.

        Raises:
            BusLost: The interface failed.
        """
        node, events = configuration.node, self._monitor.events
        changed = configuration.changed
        amount = f"{len(changed)} objects set anew" if changed else "nothing had changed"
        events.add(now, node, f"configured again ({amount}) and started")
        for index in WATCHED_OBJECTS:
            before = self._encoder_objects[node].get(index)
            after = configuration.encoder_objects.get(index)
            if before != after:
                events.add(now, node, f"{index:04X}h was {before}, is {after}: preset, or another device?")
        self.start(configuration)
        return self._monitor.supervision.nodes[node].boots == self._boots[node]

    def _interrupt(self, command: int, node: int) -> None:
        """Send an NMT command, and remember a node that it takes out of operation."""
        if command == NMT_PRE_OPERATIONAL and self._monitor.supervision.nodes[node].state == OPERATIONAL:
            self._interrupted.add(node)
        self._nmt(command, node)
