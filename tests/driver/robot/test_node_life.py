"""Nodes that boot, fall silent, leave operation or report emergencies, in any order."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule, run_state_machine_as_test

from omnimate.driver.robot.driver import Driver

NODES = (1, 2)
NODE = st.sampled_from(NODES)
OPERATIONAL, PRE_OPERATIONAL, STOPPED = 0x05, 0x7F, 0x04
RECOVERY_SYNCS = 2000  # more than the longest pause between two attempts (5 s), and the silence before it


class Nodes(RuleBasedStateMachine):
    """Two encoders on a bus."""

    kit = None

    @initialize()
    def begin(self):
        self.bus = self.kit.FakeBus([self.kit.encoder_device(node) for node in NODES])
        self.driver = Driver(self.kit.one_truck(), self.bus, clock=self.kit.FakeClock())
        self.driver.configure()
        self.emergencies = dict.fromkeys(NODES, 0)
        self.cycle()

    def cycle(self):
        sample = self.driver.cycle()
        for node, is_present in zip(NODES, sample.present, strict=True):
            device = self.bus.devices[node]
            is_answering = device.state == OPERATIONAL and device.is_powered and device.hears_sync
            assert is_answering or not is_present
        report = self.driver.report()
        assert {node: report.node(node).emergencies for node in NODES} == self.emergencies
        return sample

    @rule(syncs=st.sampled_from([1, 3, 250]))
    def syncs_are_sent(self, syncs):
        for _ in range(syncs):
            self.cycle()

    @rule(node=NODE, is_powered=st.booleans())
    def a_node_falls_silent_or_is_back(self, node, is_powered):
        self.bus.devices[node].is_powered = is_powered

    @rule(node=NODE, hears_sync=st.booleans())
    def a_node_misses_sync_or_hears_it_again(self, node, hears_sync):
        self.bus.devices[node].hears_sync = hears_sync

    @rule(node=NODE)
    def a_node_boots(self, node):
        restarts = self.driver.report().node(node).restarts
        was_running = self.driver._supervision.nodes[node].is_running
        self.bus.devices[node].reset()
        self.cycle()
        assert self.driver.report().node(node).restarts == restarts + was_running

    @rule(node=NODE)
    def a_node_boots_and_its_boot_up_is_lost(self, node):
        """It had a heartbeat, and produces none until it is configured again."""
        device = self.bus.devices[node]
        if device.state == OPERATIONAL:
            self.bus.queue.append(self.kit.frame(0x700 + node, bytes([OPERATIONAL])))
            self.cycle()
            device.reset()
            self.bus.queue.clear()

    @rule(node=NODE, state=st.sampled_from([PRE_OPERATIONAL, STOPPED]))
    def a_node_leaves_operation(self, node, state):
        device = self.bus.devices[node]
        if device.state == OPERATIONAL:
            device.state = state
            self.cycle()
            self.bus.queue.extend([self.kit.frame(0x700 + node, bytes([state]))] * 2)

    @rule(node=NODE)
    def a_node_reports_an_emergency(self, node):
        self.bus.queue.append(self.kit.frame(0x080 + node, b"\x10\x81\x11\0\0\0\0\0"))
        self.emergencies[node] += 1
        self.cycle()

    @rule()
    def all_nodes_answer_again(self):
        for device in self.bus.devices.values():
            device.is_powered = device.hears_sync = True
        assert any(all(self.cycle().present) for _ in range(RECOVERY_SYNCS))

    def teardown(self):
        self.driver.close()


@pytest.mark.usefixtures("_impatient")
def test_only_operational_nodes_are_read_each_fault_is_reported_once_and_nodes_recover(kit):
    Nodes.kit = kit
    run_state_machine_as_test(Nodes, settings=settings(max_examples=10, stateful_step_count=15))
