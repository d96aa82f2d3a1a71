import gc

import pytest

from omnimate.fleet.batch.run import run_batch
from omnimate.mismatch.recording.windows import Windows


@pytest.fixture
def no_collector():
    """Let nothing be collected that refers to itself."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def of_linkages():
    """Return what the process knows of recordings with a linkage, by its identity."""
    # not isinstance(), which asks an object for its class: those of other tests may answer wrongly
    known = [thing for thing in gc.get_objects() if type(thing) is Windows]
    return {id(each): each for each in known if each.signals.recording.vehicle.linkage is not None}


def test_a_batch_keeps_nothing_of_what_it_knew_of_a_linkage(store, tmp_path, no_collector):
    before = of_linkages()
    assert run_batch(str(store), str(tmp_path), diagnosed=False).done == 6
    assert not of_linkages().keys() - before.keys()
