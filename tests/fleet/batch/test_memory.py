import gc

import pytest

from omnimate.fleet.batch.run import run_batch
from omnimate.mismatch.recording.windows import Windows


@pytest.fixture
def no_collector():
    """Let nothing be collected but where the batch asks for it."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def test_a_batch_keeps_nothing_of_what_it_knew_of_a_linkage(store, tmp_path, no_collector):
    assert run_batch(str(store), str(tmp_path), diagnosed=False).done == 6
    kept = [thing for thing in gc.get_objects() if isinstance(thing, Windows)]
    assert not [windows for windows in kept if windows.signals.recording.vehicle.linkage is not None]
