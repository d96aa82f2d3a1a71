"""Heartbeats: the rhythm of the producer, and when a consumer misses one."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.nodes.heartbeat import HeartbeatConsumer, HeartbeatProducer

milliseconds = st.integers(1, 0xFFFF)


@given(milliseconds, st.floats(0.0, 0.99), st.floats(0.0, 1e4))
def test_a_heartbeat_that_was_sent_a_little_late_does_not_shift_the_next_ones(period, late, start):
    producer = HeartbeatProducer()
    producer.configure(period, start)
    for number in range(1, 5):
        producer.sent(producer.due + late * period * 1e-3)
        assert producer.due == pytest.approx(start + (number + 1) * period * 1e-3)


@given(milliseconds, st.floats(1.5, 100.0))
def test_after_a_pause_of_more_than_a_period_the_rhythm_starts_anew(period, late):
    producer = HeartbeatProducer()
    producer.configure(period, 0.0)
    now = producer.due + late * period * 1e-3
    producer.sent(now)
    assert producer.due == pytest.approx(now + period * 1e-3)


@given(st.integers(1, 127), milliseconds, st.floats(0.0, 1e4))
def test_a_node_is_watched_from_its_first_heartbeat_on(node, period, now):
    consumer = HeartbeatConsumer()
    consumer.configure(node << 16 | period)
    assert consumer.due == math.inf
    assert consumer.receive(node, now)
    assert consumer.due == pytest.approx(now + period * 1e-3)
    assert not consumer.receive(node % 127 + 1, now + 1.0)


def test_without_a_time_no_node_is_watched():
    consumer = HeartbeatConsumer()
    consumer.configure(5 << 16)
    assert not consumer.receive(5, 0.0)
    assert consumer.due == math.inf
