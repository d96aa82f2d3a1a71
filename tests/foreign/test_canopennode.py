"""Devices on CANopenNode: what they do without the driver, and what `omnimate conform` says of them.

The other cases run on them, too, wherever a test has the fixture `family`.
"""

from __future__ import annotations

import pytest

from omnimate.driver.conformance.probe import Probe
from omnimate.driver.conformance.run import conform
from tests.foreign import robots
from tests.foreign.canopennode.nodes import CanOpenNodeDrive, CanOpenNodeEncoder, family, what_is_missing
from tests.foreign.robots import drive, two_trucks
from tests.foreign.test_stopping import COUNTS, OUT

if missing := what_is_missing():
    pytest.skip(missing, allow_module_level=True)

NODE = 1  # the encoder of a.left


def test_drives_stop_by_themselves_without_the_driver_and_the_next_driver_drives(
    enabled, driver_on, canopennode, monkeypatch
):
    """1016h and 6007h as the driver sets them; EMCY 8130h from before does not stop the next one."""
    monkeypatch.setattr(robots, "FAMILY", family(canopennode))
    _, bus = enabled(seconds=0.3)
    bus.sleep(0.35)  # the driver's heartbeat comes every 0.1 s, and is missed after 0.5 s
    assert bus.nodes[OUT].velocity > 0.9 * COUNTS
    bus.sleep(0.35)
    assert [bus.nodes[node].velocity for node in range(OUT, OUT + 4)] == [0.0] * 4
    assert bus.nodes[OUT].number(0x1001) != 0
    another = driver_on(two_trucks(), bus)
    another.configure()
    another.enable()
    drive(another, 1.0)
    assert another.drives.troubles == ()
    assert bus.nodes[OUT].number(0x1001) == 0
    assert bus.nodes[OUT].velocity > 0.9 * COUNTS


@pytest.mark.parametrize("kind", [CanOpenNodeEncoder, CanOpenNodeDrive])
def test_the_devices_do_all_that_conform_asks_for(bench, canopennode, kind):
    encoder = CanOpenNodeEncoder(canopennode, NODE)
    drive = CanOpenNodeDrive(canopennode, NODE + 1, encoder, "first")
    bus = bench([encoder, drive])
    node = NODE if kind is CanOpenNodeEncoder else NODE + 1
    results = list(conform(Probe(bus, node, 0.1)))
    assert [(result.check.subject, result.reason) for result in results if result.outcome == "failed"] == []
    assert sum(result.outcome == "passed" for result in results) > 40
