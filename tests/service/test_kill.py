"""Nothing acknowledged is lost: the service is killed under load, on both databases.

`python -m studies.speed.service_kill` does it 200 times.
"""

import pytest

service_kill = pytest.importorskip("studies.speed.service_kill")


@pytest.mark.slow
def test_what_was_answered_201_is_there_after_kill_9(tmp_path, database_url):
    promises, missing, stuck = service_kill.trial(tmp_path, database_url, kills=1)
    assert promises > 0
    assert missing == []
    assert stuck == set()
