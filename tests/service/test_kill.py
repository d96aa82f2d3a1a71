"""Nothing acknowledged is lost or done twice: services are killed under load, on both databases.

`python -m studies.speed.service_kill` does it 200 times.
"""

import pytest

service_kill = pytest.importorskip("studies.speed.service_kill")


@pytest.mark.slow
def test_what_two_services_acknowledged_is_there_once_after_kill_9(tmp_path, database_url):
    acknowledged, found, stuck = service_kill.trial(tmp_path, database_url, kills=2, count=2)
    assert acknowledged.samples
    assert found == []
    assert stuck == set()
