"""The LSS slave: any identity is found by fastscan, and an id that is given is the one that it boots with."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.nodes.lss import UNCONFIGURED, LssSlave

identities = st.tuples(*[st.integers(0, 2**32 - 1)] * 4)


class Master:
    """An LSS master of some slaves."""

    def __init__(self, *slaves):
        self.heard, self.slaves, self.booted = [], [], []
        for node, identity in slaves:
            slave = LssSlave(node, lambda identity=identity: identity, self.heard.append, self.note_boot)
            self.slaves.append(slave)

    def note_boot(self):
        self.booted.append([slave.pending for slave in self.slaves])

    def ask(self, *data):
        self.heard.clear()
        for slave in self.slaves:
            slave.receive(bytes(data).ljust(8, b"\0"))
        return list(self.heard)

    def number(self, command, value, *rest):
        return self.ask(command, *value.to_bytes(4, "little"), *rest)

    def select(self, identity):
        return [self.number(0x40 + place, value) for place, value in enumerate(identity)][-1]

    def fastscan(self):
        """Return the identity of one slave without an id."""
        if not self.number(0x51, 0, 0x80, 0, 0):
            return None
        found = []
        for place in range(4):
            value = 0
            for bit in range(31, -1, -1):
                value |= (not self.number(0x51, value, bit, place, place)) << bit
            if not self.number(0x51, value, 0, place, (place + 1) % 4):
                return None
            found.append(value)
        return tuple(found)


@given(identity=identities, other=identities)
def test_fastscan_finds_the_identity_of_the_device_that_has_no_id(identity, other):
    master = Master((UNCONFIGURED, identity), (5, other))
    assert master.fastscan() == identity
    assert master.ask(0x5E) == [bytes([0x5E, 0xFF]).ljust(8, b"\0")]  # it alone is in configuration


@given(first=identities, second=identities)
def test_fastscan_finds_two_devices_one_after_the_other(first, second):
    master = Master((UNCONFIGURED, first), (UNCONFIGURED, second))
    found = []
    for node in (7, 8):
        found.append(master.fastscan())
        master.ask(0x11, node)
        for slave in master.slaves:  # it boots with its id
            slave.active = slave.pending
        master.ask(0x04, 0)
    assert sorted(found, key=str) == sorted([first, second], key=str) or first == second


def test_with_an_id_there_is_no_fastscan():
    assert Master((5, (1, 2, 3, 4))).fastscan() is None


@given(identity=identities, named=identities)
def test_only_the_whole_identity_selects(identity, named):
    master = Master((5, identity))
    assert bool(master.select(named)) == (named == identity)
    master.ask(0x04, 0)
    assert master.select(identity) == [bytes([0x44]).ljust(8, b"\0")]


@pytest.mark.parametrize(("node", "error"), [(1, 0), (127, 0), (255, 0), (0, 1), (128, 1)])
def test_node_ids_that_do_not_exist_are_refused(node, error):
    master = Master((5, (1, 2, 3, 4)))
    master.ask(0x04, 1)
    assert master.ask(0x11, node) == [bytes([0x11, error]).ljust(8, b"\0")]
    assert master.slaves[0].pending == (5 if error else node)


@pytest.mark.parametrize("place", range(6))
def test_a_device_outside_of_one_range_of_the_identity_does_not_answer(place):
    master = Master((5, (1, 2, 30, 400)))
    numbers = [1, 2, 30, 30, 400, 400]
    assert [master.number(0x46 + n, value) for n, value in enumerate(numbers)][-1][0][0] == 0x4F
    numbers[place] += -1 if place in {3, 5} else 1
    assert [master.number(0x46 + n, value) for n, value in enumerate(numbers)][-1] == []


def test_without_an_id_it_answers_to_be_one_of_those():
    assert Master((UNCONFIGURED, (1, 2, 3, 4))).ask(0x4C) == [bytes([0x50]).ljust(8, b"\0")]
    assert Master((5, (1, 2, 3, 4))).ask(0x4C) == []
