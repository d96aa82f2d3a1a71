"""Vendors' DCF files on canopen's LocalNode: what differs is told, and written in the order of CiA 301."""

from __future__ import annotations

from dataclasses import replace

import canopen
import pytest

from omnimate.driver.bus.clock import WallClock
from omnimate.driver.canopen.dcf import differences, load_descriptions, stated_values, write_values
from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import EdsError
from tests.foreign.devices import DescribedNode, ForeignEncoder
from tests.foreign.robots import devices, two_trucks
from tests.samples import OUR_EDS, VENDORS_EDS, cases

NODE = 5
OFF = 1 << 31
WRONG_STATE, READ_ONLY = 0x08000022, 0x06010002
ENCODER, DRIVE = OUR_EDS
FILES = cases(DRIVE, *(path for path in VENDORS_EDS if path.suffix == ".dcf"))

DCF = """[DeviceInfo]
VendorNumber={vendor}
[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x00020196
[1006]
ParameterName=Cycle period
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=0
ParameterValue={period}
[1019]
ParameterName=Counter overflow
ObjectType=0x7
DataType=0x0005
AccessType=rw
DefaultValue=0
ParameterValue=10
[2000]
ParameterName=Gain
ObjectType=0x7
DataType=0x0008
AccessType=rw
DefaultValue=0
ParameterValue=0.5
[6004]
ParameterName=Position
ObjectType=0x7
DataType={type}
AccessType=ro
DefaultValue=0
PDOMapping=1
"""


class StrictNode(DescribedNode):
    """A device with other values than its DCF states; it takes PDO parameters while the PDO is off alone."""

    def __init__(self, path):
        super().__init__(NODE, path)
        for variable in stated_values(self.object_dictionary):
            first, *rest = variable.encode_raw(variable.value)
            self.store(variable.index, variable.subindex, bytes([first ^ 1, *rest]))
        self.add_write_callback(self._check)

    def _check(self, *, index, subindex, data, **_):
        if index == 0x1019 and self.number(0x1006):
            raise canopen.SdoAbortedError(WRONG_STATE)
        if not 0x1400 <= index < 0x1C00:
            return
        base = index & ~0x200
        is_switching = index == base and subindex == 1
        is_entry_in_use = index != base and subindex and self.number(index)
        if (not is_switching and not self.number(base, 1) & OFF) or is_entry_in_use:
            raise canopen.SdoAbortedError(WRONG_STATE)


def sdo_on(bus, dictionary):
    return BusNetwork(bus, WallClock(1.0)).sdo(NODE, {NODE: dictionary}, 0.02)


def dcf(tmp_path, period=15000, vendor=0x301, data_type="0x0007"):
    path = tmp_path / "device.dcf"
    path.write_text(DCF.format(period=period, vendor=vendor, type=data_type))
    return path


@pytest.mark.parametrize("path", FILES)
def test_a_device_that_is_as_its_dcf_states_differs_in_nothing_and_is_not_written(bench, path):
    node = DescribedNode(NODE, path)
    for variable in stated_values(node.object_dictionary):
        node.store(variable.index, variable.subindex, variable.encode_raw(variable.value))
    bus = bench([node])
    sdo = sdo_on(bus, node.object_dictionary)
    assert list(differences(sdo, node.object_dictionary)) == []
    assert all(data[0] & 0xE0 == 0x40 for _, _, data in bus.sent)


@pytest.mark.parametrize("path", FILES)
def test_all_that_may_be_written_is_written_in_the_order_that_a_strict_device_asks_for(bench, path):
    node = StrictNode(path)
    sdo = sdo_on(bench([node]), node.object_dictionary)
    wrong = list(differences(sdo, node.object_dictionary))
    left = write_values(sdo, node.object_dictionary, wrong)
    assert len(wrong) == len(stated_values(node.object_dictionary))
    assert all(node.object_dictionary.get_variable(d.index, d.subindex).access_type != "rw" for d in left)
    assert [d.index for d in differences(sdo, node.object_dictionary)] == [d.index for d in left]


def test_what_the_device_refuses_is_told_and_the_rest_written(bench):
    node = StrictNode(DRIVE)
    node.refuse[0x1017, 0] = READ_ONLY
    sdo = sdo_on(bench([node]), node.object_dictionary)
    left = write_values(sdo, node.object_dictionary, list(differences(sdo, node.object_dictionary)))
    (refused,) = (difference for difference in left if difference.index == 0x1017)
    assert "read-only" in refused.in_words()
    assert node.number(0x1800, 1) == 0x185


def test_the_counter_of_sync_is_written_while_the_period_is_0(bench, tmp_path):
    node = StrictNode(dcf(tmp_path))
    sdo = sdo_on(bench([node]), node.object_dictionary)
    wrong = list(differences(sdo, node.object_dictionary))
    assert {difference.index for difference in wrong} == {0x1006, 0x1019, 0x2000}
    assert write_values(sdo, node.object_dictionary, wrong) == ()
    assert (node.number(0x1006), node.number(0x1019)) == (15000, 10)


def robot_with(**changes):
    """Return the robot without drives whose first encoder has these changes."""
    robot = two_trucks()
    first = replace(robot.encoders[0], **changes)
    return replace(robot, encoders=(first, *robot.encoders[1:]), drives=())


@pytest.fixture
def configured(begun):
    """Return what configures a robot whose first encoder has a DCF, and gives that node's remarks."""

    def configure(path, more=(), **changes):
        robot = robot_with(eds=str(path), **changes)
        nodes = [ForeignEncoder(1, more=more), *devices()[1:7]]
        driver, _ = begun(nodes, robot, descriptions=load_descriptions(robot))
        return driver.configure().nodes[0].remarks

    return configure


def test_the_driver_tells_where_a_node_is_not_as_its_dcf_states_but_for_what_it_sets_itself(
    configured, tmp_path
):
    gain = (0x2000, 0, canopen.objectdictionary.REAL32, "rw", 2.5)
    said = [remark for remark in configured(dcf(tmp_path), [gain]) if "device.dcf" in remark]
    assert said == ["device.dcf: 2000h:00 Gain: 2.5, the DCF states 0.5"]


def test_a_description_of_another_device_or_of_another_width_is_told(configured, tmp_path):
    remarks = configured(dcf(tmp_path, vendor=0x999, data_type="0x0006"))
    assert any("describes vendor 999h, the device is of vendor 301h" in remark for remark in remarks)
    assert any("6004h:00 has 16 bits; vehicle.toml says 32" in remark for remark in remarks)


def test_an_object_that_the_description_does_not_have_is_told(configured, tmp_path):
    extra = (0x2041, 0, canopen.objectdictionary.UNSIGNED32, "ro", 0)
    remarks = configured(dcf(tmp_path), [extra], object="2041h")
    assert any("2041h:00 is not in it" in remark for remark in remarks)


def test_a_position_of_a_vendor_is_mapped_and_read(begun):
    objects = [(0x2041, sub, canopen.objectdictionary.UNSIGNED32, "ro", 40 * sub) for sub in (1, 2)]
    encoder = ForeignEncoder(1, more=objects)
    driver, _ = begun([encoder, *devices()[1:7]], robot_with(object="2041h:2"))
    driver.configure()
    assert encoder.number(0x1A00, 1) == 0x20410220
    assert driver.cycle().counts[0] == 80


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(EdsError, match=r"gone\.eds: cannot be read"):
        load_descriptions(robot_with(eds=str(tmp_path / "gone.eds")))


@pytest.mark.parametrize("path", cases(*(path for path in (ENCODER, *VENDORS_EDS) if path.suffix == ".eds")))
def test_an_eds_states_no_values(path):
    assert stated_values(load_eds(path, NODE).dictionary) == ()
