"""Configures and starts the nodes of a vehicle's encoders, at first and again after a restart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.node_setup import wake
from omnimate.driver.robot.configure import configure_node, with_ranges
from omnimate.files.logs.canopen_words import (
    NMT_PRE_OPERATIONAL,
    NMT_RESET_COMMUNICATION,
    NMT_START,
    OPERATIONAL,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from omnimate.driver.canopen.node_setup import NodeConfiguration
    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.driver.robot.monitor import Monitor
    from omnimate.vehicle.parameters import VehicleParameters

PRESET_OBJECTS = (0x6509, 0x650B)  # a change of these shows a preset or a swapped encoder


class EncoderNodes:
    """The nodes of a vehicle's encoders; `vehicle` has their ranges after `configure_all`."""

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
        self._boots: dict[int, int] = {}  # boot-ups heard before the last configuration
        self._known_boots: dict[int, int] = {}  # and before the last start
        self._interrupted: set[int] = set()  # were operational before they were configured

    def configure(self, node: int) -> NodeConfiguration:
        """Configure one node and return what was read and changed; errors as of `configure_node`.

        Where that fails, the nodes that were operational before are started again.
        """
        state = self._monitor.supervision.nodes[node]
        woken = wake(self._sdos[node], self._nmt)
        self._boots[node] = state.boots  # it has answered, so that an earlier boot-up has been read
        try:
            configuration = configure_node(self._sdos[node], self.vehicle, self._interrupt)
        except BaseException:
            for stopped in self._interrupted:
                self._nmt(NMT_START, stopped)
            self._interrupted.clear()
            raise
        configuration.woken = woken
        return configuration

    def configure_all(self) -> tuple[NodeConfiguration, ...]:
        """Configure every node and take over the ranges of their counters; errors as of `configure_node`."""
        configurations = tuple(self.configure(node) for node in self.ids)
        self.vehicle = with_ranges(self.vehicle, configurations)
        return configurations

    def start(self, configuration: NodeConfiguration) -> bool:
        """Start a configured node and supervise it; return whether the configuration holds.

        It does not where the node has booted since it began, so that what was written before is lost. Raises
        BusLost.
        """
        self._take_over(configuration)
        self._nmt(NMT_START, configuration.node)
        self._monitor.assembler.node_started(configuration.node)
        return self._holds(configuration)

    def _take_over(self, configuration: NodeConfiguration) -> None:
        """Expect of a node what was configured."""
        node = configuration.node
        self._known_boots[node] = self._boots[node]
        self._encoder_objects[node] = configuration.encoder_objects
        for cob_id, length in configuration.lengths.items():
            is_timed = cob_id in configuration.timed
            self._monitor.assembler.expect_length(cob_id, length, is_timed=is_timed)
        self._interrupted.discard(node)
        self._monitor.supervision.started(node, configuration.heartbeat)

    def start_again(self, configuration: NodeConfiguration, now: float) -> bool:
        """Start a node that was configured again at `now` [s], and log what has changed; return as `start`.

        A node that has lost objects restarted. Where its boot-up was not heard, it is made to send one, so
        that it stands in the recording, and is configured again. A node that has lost nothing and sends its
        PDOs is not started again: the boot-up or the heartbeat did not come from it. Raises BusLost.
        """
        node, events = configuration.node, self._monitor.events
        changed = configuration.changed
        if configuration.woken:
            events.add(now, node, configuration.woken)
        if changed and self._boots[node] == self._known_boots[node]:
            events.add(
                now, node, "restarted unheard: its communication is reset, so that its boot-up is heard"
            )
            self._nmt(NMT_RESET_COMMUNICATION, node)
            return False
        if not changed and self._monitor.assembler.is_answering(node):
            events.add(now, node, "has not restarted: its objects are as they were, and its PDOs go on")
            self._take_over(configuration)
            return self._holds(configuration)
        amount = f"{len(changed)} objects written again" if changed else "nothing had changed"
        events.add(now, node, f"configured again ({amount}) and started")
        for index in PRESET_OBJECTS:
            before = self._encoder_objects[node].get(index)
            after = configuration.encoder_objects.get(index)
            if before != after:
                events.add(now, node, f"{index:04X}h was {before}, is {after}: preset, or another device?")
        return self.start(configuration)

    def _holds(self, configuration: NodeConfiguration) -> bool:
        node = configuration.node
        return self._monitor.supervision.nodes[node].boots == self._boots[node]

    def _interrupt(self, command: int, node: int) -> None:
        """Send an NMT command, and remember a node that it takes out of operation."""
        if command == NMT_PRE_OPERATIONAL and self._monitor.supervision.nodes[node].state == OPERATIONAL:
            self._interrupted.add(node)
        self._nmt(command, node)
