"""A scan of foreign devices, also with vendors' EDS files: what is sent, and what is told."""

from __future__ import annotations

from itertools import pairwise

import can
import pytest

from omnimate.driver.canopen.node_access import MasterActiveError
from omnimate.driver.scan.eds_folder import Fit, described_devices, fitting_file
from omnimate.driver.scan.scan import NODES, scan
from tests.foreign.devices import DescribedNode, ForeignDrive
from tests.foreign.robots import devices, foreign_encoder
from tests.samples import OUR_EDS, VENDORS_EDS, cases

UPLOAD, SEGMENT = 0x40, 0x60  # first bytes of requests that read
ENCODER, DRIVE = OUR_EDS
VENDORS = {path.name: path for path in VENDORS_EDS}
on_each_family = pytest.mark.usefixtures("family")
OUR_VENDOR = 0x7FFFFF01


def look(bus, **options):
    return scan(bus, "bench", timeout=0.02, **options)


def by_id(found):
    return {node.node: node for node in found.nodes}


def sync(bus, seconds):
    """Have another master send SYNC for so long."""
    for number in range(int(seconds / 0.02)):
        bus.at(0.02 * number, lambda: bus.inject(0x080, b""))


@on_each_family
def test_every_node_is_found_with_profile_identity_and_pdos_and_nothing_is_written(bench):
    bus = bench(devices("first"))
    found = by_id(look(bus))
    assert sorted(found) == [*range(1, 8), *range(17, 21)]
    assert (found[1].profile, found[17].profile) == (406, 402)
    assert (found[1].vendor, found[1].product, found[1].revision, found[1].serial) == (
        *(0x301, 0x302, 0x303, 0x304),
    )
    assert found[3].tpdos[0].in_words() == "TPDO1 183h type 254 maps 6004h:00 32 bits"
    assert [pdo.in_words() for pdo in found[17].rpdos] == ["RPDO1 211h type 255 maps 6040h:00 16 bits"]
    assert {can_id & 0x780 for _, can_id, _ in bus.sent} == {0x600}
    assert {data[0] & 0xE0 for _, _, data in bus.sent} <= {UPLOAD, SEGMENT}
    assert all(not node.remark for node in found.values())


@on_each_family
def test_the_frames_that_were_sent_are_counted(bench):
    bus = bench([foreign_encoder(5)])
    assert look(bus).sent == {"SDO readings": len(bus.sent)}


@pytest.mark.parametrize("path", cases(*OUR_EDS, *VENDORS_EDS))
def test_a_device_with_a_vendors_eds_is_read_whole(bench, path):
    bus = bench([DescribedNode(5, path)])
    found = by_id(look(bus))
    assert list(found) == [5]
    assert not found[5].remark
    raw = [bus.nodes[5].number(base, 1) for base in range(0x1800, 0x1804)]
    assert [pdo.raw for pdo in found[5].tpdos] == [cob_id for cob_id in raw if cob_id]


@pytest.mark.parametrize(
    ("path", "identity", "fit"),
    cases(
        (ENCODER, (OUR_VENDOR, 0x101, 0x20003), Fit.WHOLE),
        (ENCODER, (OUR_VENDOR, 0x101, 0x20004), Fit.SAME_BEHAVIOUR),
        (ENCODER, (OUR_VENDOR, 0x101, 0x30003), Fit.OTHER_REVISION),
        (ENCODER, (OUR_VENDOR, 0x102, 0x20003), Fit.NOT),
        (DRIVE, (OUR_VENDOR, 48, 1), Fit.VENDOR),
        (VENDORS["elmo_gold.dcf"], (154, 198947, 66550), Fit.WHOLE),
        (VENDORS["elmo_gold.dcf"], (154, 198947, 66551), Fit.SAME_BEHAVIOUR),
        (VENDORS["elmo_gold.dcf"], (154, 198947, 0x20000), Fit.OTHER_REVISION),
        (VENDORS["elmo_gold.dcf"], (154, 198948, 66550), Fit.NOT),
        (VENDORS["maxon_epos2_347717.eds"], (251, 1663172608, 556138496), Fit.WHOLE),
        (VENDORS["faulhaber_605.3150.71-A.eds"], (327, 48, 1), Fit.VENDOR),
        (VENDORS["sick_mls.eds"], (16777302, 4352, 2), Fit.WHOLE),
    ),
)
def test_the_eds_that_fits_is_named_out_of_all(bench, path, identity, fit):
    bus = bench([DescribedNode(5, path, identity)])
    (node,) = look(bus).nodes
    file = fitting_file(node, described_devices(path.parent))
    if fit is Fit.NOT:
        assert file is None
    else:
        assert (file.path, file.fit) == (path, fit)


@on_each_family
def test_the_heartbeat_tells_the_state_and_a_pdo_of_its_own_that_it_is_operational(bench):
    beating, sending = foreign_encoder(5), foreign_encoder(6)
    beating.put(0x1017, 0, 200)
    beating.state = 0x04
    sending.state = 0x05
    found = look(bench([beating, sending]))
    nodes = by_id(found)
    assert found.state(nodes[5]) == 0x04
    assert found.state(nodes[6]) == 0x05
    assert found.traffic.heartbeat_period(5) == pytest.approx(0.2, abs=0.002)
    assert nodes[5].remark == "does not answer SDO"  # as a stopped node must not


@on_each_family
def test_a_node_that_boots_late_is_waited_for(bench):
    late = foreign_encoder(9)
    late.power_off()
    bus = bench([foreign_encoder(5), late])
    bus.at(3.0, late.reset)
    assert sorted(by_id(look(bus, wait=0.5))) == [5]
    late.power_off()
    bus.at(3.0, late.reset)
    found = look(bus, wait=5.0)
    assert sorted(by_id(found)) == [5, 9]
    assert by_id(found)[9].profile == 406


@on_each_family
def test_beside_another_master_only_nodes_that_were_heard_are_read_and_slowly(bench):
    beating = foreign_encoder(5)
    beating.put(0x1017, 0, 200)
    bus = bench([beating, foreign_encoder(6)])
    bus.sleep(0.1)
    bus.forget()  # a boot-up of the silent one
    sync(bus, 10.0)
    found = look(bus, wait=0.5)
    assert found.has_other_master
    assert found.traffic.sync_period == pytest.approx(0.02, abs=0.002)
    assert list(by_id(found)) == [5]
    assert by_id(found)[5].vendor == 0x301
    assert {can_id for _, can_id, _ in bus.sent} == {0x605}
    times = [at for at, _, _ in bus.sent]
    assert min(later - earlier for earlier, later in pairwise(times)) >= 0.0099


@on_each_family
def test_a_node_to_which_another_master_talks_is_left_alone_at_once(bench):
    beating, spoken_to = foreign_encoder(5), foreign_encoder(6)
    for node in (beating, spoken_to):
        node.put(0x1017, 0, 200)
    bus = bench([beating, spoken_to])
    sync(bus, 10.0)
    bus.at(0.5, lambda: bus.inject(0x606, b"\x40\x41\x60\x00\0\0\0\0"))
    bus.at(1.3, lambda: bus.inject(0x605, b"\x40\x41\x60\x00\0\0\0\0"))
    nodes = by_id(look(bus))
    assert all("another master talks to it" in nodes[node].remark for node in (5, 6))
    assert not [frame for frame in bus.sent if frame[1] == 0x606]
    assert max(at for at, _, _ in bus.sent) < 1000.0 + 1.32


@on_each_family
def test_a_node_that_boots_beside_another_master_is_left_to_that_master(bench):
    late = foreign_encoder(9)
    late.power_off()
    bus = bench([late])
    sync(bus, 10.0)
    bus.at(2.0, late.reset)
    (node,) = look(bus).nodes
    assert "left to the other master" in node.remark
    assert bus.sent == []


@on_each_family
def test_two_devices_on_one_id_are_told(bench):
    bus = bench([foreign_encoder(5)])
    bus.add(foreign_encoder(5))
    (node,) = look(bus).nodes
    assert "answered twice" in node.remark


def test_a_node_that_falls_silent_midway_keeps_what_it_said(bench):
    node = ForeignDrive(5, foreign_encoder(6))
    node.add_read_callback(lambda **read: node.power_off() if read["subindex"] == 4 else None)
    (said,) = look(bench([node])).nodes
    assert (said.profile, said.serial) == (402, 0x304)
    assert "no valid SDO answer for 1017h:00" in said.remark


@on_each_family
def test_lss_is_refused_beside_another_master_and_nothing_is_sent(bench):
    bus = bench([foreign_encoder(5)])
    sync(bus, 10.0)
    with pytest.raises(MasterActiveError):
        look(bus, asks_lss=True)
    assert bus.sent == []


def test_what_is_none_of_canopens_is_no_node(bench):
    bus = bench([])
    bus.at(0.1, lambda: bus.far.send(can.Message(arbitration_id=0x705, data=b"\x05", is_extended_id=True)))
    bus.at(0.2, lambda: bus.inject(0x706, b"\x05", is_fd=True))
    found = look(bus, wait=0.0)
    assert found.nodes == ()
    assert len(bus.sent) == len(NODES)
