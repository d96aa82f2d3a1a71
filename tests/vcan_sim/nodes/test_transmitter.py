"""The sending side of a device, as its faults let it send."""

import math

import pytest

from omnimate.vcan_sim.nodes.transmitter import Babble, Disturbance, Transmitter


@pytest.fixture
def sent():
    return []


@pytest.fixture
def transmitter(sent):
    return Transmitter(lambda cob_id, data: sent.append((cob_id, data)))


@pytest.mark.parametrize(("length", "data"), [(0, b""), (1, b"\x01"), (4, b"\x01\x02\0\0")])
def test_a_wrong_length_cuts_or_fills_pdos_and_leaves_other_frames_alone(transmitter, sent, length, data):
    transmitter.disturb(Disturbance(length=length), 0.0)
    transmitter.send_pdo(0x181, b"\x01\x02", 0.0)
    transmitter.send(0x581, b"\x01\x02")
    assert sent == [(0x181, data), (0x581, b"\x01\x02")]


def test_a_late_answer_is_held_back_until_its_time(transmitter, sent):
    transmitter.disturb(Disturbance(late_by=0.5, late_every=2), 0.0)
    for now in (0.0, 0.1):
        transmitter.send_pdo(0x181, bytes([int(10 * now)]), now)
    assert sent == [(0x181, b"\0")]
    assert transmitter.due == pytest.approx(0.6)
    transmitter.run(0.59)
    assert len(sent) == 1
    transmitter.run(0.6)
    assert sent[1:] == [(0x181, b"\x01")]
    assert transmitter.due == math.inf


def test_a_device_that_has_not_sent_a_pdo_babbles_with_the_lowest_priority(transmitter, sent):
    transmitter.disturb(Disturbance(babble=Babble(1, 0.1, None, None)), 0.0)
    transmitter.run(0.0)
    assert sent == [(0x7FF, b"\xff" * 8)]


def test_a_frozen_counter_repeats_what_each_pdo_sent_last(transmitter, sent):
    transmitter.send_pdo(0x181, b"\x01", 0.0)
    transmitter.disturb(Disturbance(frozen=True), 0.0)
    transmitter.send_pdo(0x181, b"\x02", 1.0)
    transmitter.send_pdo(0x281, b"\x07", 1.0)
    assert sent == [(0x181, b"\x01"), (0x181, b"\x01"), (0x281, b"\x07")]
