from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.batch.work import DIAGNOSED_PART, diagnosed_part
from omnimate.fleet.hall.hall import draw_hall, hall_lap
from omnimate.mismatch.diagnosis import Where


@pytest.fixture(scope="module")
def laps():
    """Return a lap of a single truck and one of a robot with a linkage."""
    hall = draw_hall(3, 5, faulty=0, places=0, sync_period=0.04)
    return [hall_lap(hall, hall.robots[number], 0, 0, 3.0) for number in (0, 2)]


@pytest.mark.parametrize(
    ("seen", "expected"),
    [
        ((100.0, 104.0), 72.0),
        ((1.0, 3.0), 0.0),  # before which half a minute is not there
        (None, None),  # all along: the middle
    ],
)
def test_with_a_linkage_it_is_the_minute_around_what_is_seen_first(laps, seen, expected):
    lap = laps[1]
    first, last = lap.time[0], lap.time[-1]
    intervals = () if seen is None else ((first + 150.0, first + 160.0), (first + seen[0], first + seen[1]))
    part = diagnosed_part(lap, Where(intervals=intervals))
    start = first + expected if expected is not None else 0.5 * (first + last - DIAGNOSED_PART)
    assert part.time[0] == pytest.approx(start, abs=0.05)
    assert part.time[-1] - part.time[0] == pytest.approx(DIAGNOSED_PART, abs=0.1)
    rows = np.searchsorted(lap.time, part.time)
    assert np.array_equal(part.counts, lap.counts[rows])
    assert (
        len(part.poses.time) == ((lap.poses.time >= start) & (lap.poses.time <= start + DIAGNOSED_PART)).sum()
    )


def test_a_part_without_a_dock_has_no_poses(laps):
    lap = laps[1]
    late = replace(lap.poses, time=np.full(len(lap.poses.time), lap.time[-1]))
    far = replace(lap, poses=late)
    assert diagnosed_part(far, Where(intervals=((lap.time[0], lap.time[0] + 1.0),))).poses is None


def test_a_single_truck_is_diagnosed_from_its_whole_drive(laps):
    assert diagnosed_part(laps[0], Where()) is laps[0]
