"""The frame feed: every frame to the lap's recorder and to every reader, none of which delays the bus."""

from unittest.mock import Mock, call

import can
import pytest

from omnimate.service.robot.frame_feed import QUEUED_LINES, FrameFeed
from omnimate.vcan_sim.reference import reference_vehicle

MESSAGE = can.Message(arbitration_id=0x181, data=b"\x01\x02", is_extended_id=False)


def test_a_frame_reaches_the_recorder_of_the_lap_and_no_one_between_laps():
    feed, recorder = FrameFeed(), Mock()
    feed.frame(1.0, MESSAGE)
    feed.use(reference_vehicle())
    feed.recorder = recorder
    feed.frame(2.0, MESSAGE)
    feed.use(reference_vehicle())
    feed.recorder = None
    feed.frame(3.0, MESSAGE)
    assert recorder.mock_calls == [call.frame(2.0, MESSAGE), call.use(reference_vehicle())]
    assert feed.frames == 3


def test_every_reader_gets_every_frame_as_candump_prints_it_until_its_block_ends():
    feed = FrameFeed()
    with feed.reader() as first, feed.reader() as second:
        feed.frame(1.5, MESSAGE)
        assert first.get_nowait() == second.get_nowait() == "(0000000001.500000) can0 181#0102"
    feed.frame(2.5, MESSAGE)
    assert first.empty()


def test_a_reader_gets_frames_that_a_full_disk_refuses():
    feed = FrameFeed()
    feed.recorder = Mock()
    feed.recorder.frame.side_effect = OSError("full")
    with feed.reader() as lines:
        with pytest.raises(OSError, match="full"):
            feed.frame(1.5, MESSAGE)
        assert lines.qsize() == 1


def test_a_reader_that_does_not_read_loses_frames_and_delays_nothing():
    feed = FrameFeed()
    with feed.reader() as lines:
        for number in range(QUEUED_LINES + 10):
            feed.frame(float(number), MESSAGE)
        assert lines.qsize() == QUEUED_LINES
        assert lines.get_nowait().startswith("(0000000000.000000)")


def test_a_feed_that_fails_in_its_block_still_loses_its_reader():
    feed = FrameFeed()
    with pytest.raises(KeyError), feed.reader() as lines:
        raise KeyError
    feed.frame(1.0, MESSAGE)
    assert lines.empty()
