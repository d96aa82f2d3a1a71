from multiprocessing.pool import ThreadPool

import pytest

from omnimate.fleet.hall.hall import draw_hall
from studies.estimators.fleet_hall import SAME, SOON, Laps, study


@pytest.mark.slow
def test_in_a_small_hall_sick_robots_and_bad_places_are_told_apart_and_nobody_else_is_listed():
    hall = draw_hall(24, 11, faulty=3, places=2, seed=3)
    with ThreadPool(1) as pool:
        outcome = study(Laps(hall, 3.0, 60.0, pool), 11, lambda _text: None)
    assert not outcome.false
    assert all(wait is not None and wait <= SOON for wait in outcome.waits.values())
    assert all(distance < SAME for _, distance in outcome.places)
