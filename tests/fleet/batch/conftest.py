import pytest

from omnimate.fleet.hall.hall import draw_hall, write_store

pytest.importorskip("pyarrow")


@pytest.fixture(scope="session")
def store(tmp_path_factory):
    """Return a store of three robots on two days, as its folder."""
    folder = tmp_path_factory.mktemp("store")
    write_store(draw_hall(3, 5, faulty=0, places=0, sync_period=0.04), folder, range(2), 1, 1.0)
    return folder
