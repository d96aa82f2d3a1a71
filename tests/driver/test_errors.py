"""Each broken situation gives exactly the sentence in `tests/data/driver/errors.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import can
import pytest

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.errors import BusLost, DriverError, NodeError
from omnimate.driver.robot.configure import configure_node
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.passive import PassiveReader
from omnimate.vehicle.parameters import Bus

GOLDEN = tomllib.loads(
    (Path(__file__).parents[1] / "data" / "driver" / "errors.toml").read_text(encoding="utf-8")
)
PRODUCES_SYNC = 0x40000080
SITUATIONS = {}


def situation(function):
    SITUATIONS[function.__name__] = function
    return function


def configure(kit, device, **changes):
    vehicle = kit.one_truck((kit.wheel_encoder("a.left", 1, **changes), kit.wheel_encoder("a.right", 2)))
    sdo, network = kit.sdo([device] if device else [])
    configure_node(sdo, vehicle, network.nmt_command)


def with_drives(kit, change):
    drives = (kit.drive("a.left", 17), kit.drive("a.right", 18))
    devices = [kit.encoder_device(1), kit.encoder_device(2), kit.drive_device(17), kit.drive_device(18)]
    change(devices[2])
    driver = Driver(kit.one_truck(drives=drives), kit.Bus(devices), clock=kit.Clock())
    driver.configure()
    driver.enable()
    return driver


@situation
def node_is_silent(kit):
    configure(kit, None)


@situation
def node_falls_silent_while_it_is_configured(kit):
    device = kit.encoder_device(1)
    device.on_write = lambda *_write: setattr(device, "mute", True)
    configure(kit, device)


def refuse_sync(kit, abort_code):
    device = kit.encoder_device(1)
    device.objects[0x1005, 0][0] = PRODUCES_SYNC
    device.refuse[0x1005, 0] = abort_code
    configure(kit, device)


@situation
def node_refuses_a_write_in_its_state(kit):
    refuse_sync(kit, 0x08000022)


@situation
def node_refuses_a_write_of_a_read_only_object(kit):
    refuse_sync(kit, 0x06010002)


@situation
def node_refuses_a_read(kit):
    def refuse(device):
        device.refuse_read[0x6041, 0] = 0x08000000

    with_drives(kit, refuse)


def keep(kit, kept, where, size, **changes):
    """Configure a device that confirms what is written to an object, and keeps another value."""
    device = kit.encoder_device(1)
    device.on_write = lambda *write: device.put(*where, kept, size) if write[:2] == where else None
    configure(kit, device, **changes)


@situation
def node_confirms_a_value_and_keeps_another(kit):
    keep(kit, 3, (0x1800, 2), 1)


@situation
def device_does_not_keep_a_cob_id(kit):
    keep(kit, 0x2FF, (0x1801, 1), 4, cob_id=0x1A1)


@situation
def device_has_another_profile(kit):
    device = kit.encoder_device(1)
    device.objects[0x1000, 0][0] = 0x00020192
    configure(kit, device)


@situation
def device_has_another_vendor(kit):
    configure(kit, kit.encoder_device(1), vendor=9)


@situation
def device_has_another_product(kit):
    configure(kit, kit.encoder_device(1), product=9)


@situation
def device_has_no_serial_number(kit):
    device = kit.encoder_device(1)
    del device.objects[0x1018, 4]
    configure(kit, device, serial=77)


@situation
def mapping_is_refused(kit):
    device = kit.encoder_device(1)
    device.refuse[0x1A00, 1, 0x60040020] = 0x06040041
    configure(kit, device)


@situation
def mapping_has_a_gap_of_three_bits(kit):
    configure(kit, kit.encoder_device(1), start_bit=3)


@situation
def device_has_too_few_tpdos(kit):
    device = kit.encoder_device(1)
    for key in [key for key in device.objects if key[0] == 0x1801]:
        del device.objects[key]
    encoders = (kit.wheel_encoder("a.left", 1), kit.wheel_encoder("a.right", 1, cob_id=0x281))
    sdo, network = kit.sdo([device])
    configure_node(sdo, kit.one_truck(encoders), network.nmt_command)


@situation
def drive_has_no_rpdo(kit):
    def remove(device):
        for key in [key for key in device.objects if 0x1400 <= key[0] < 0x1404]:
            del device.objects[key]

    with_drives(kit, remove)


@situation
def drive_stays_switch_on_disabled(kit):
    with_drives(kit, lambda device: setattr(device, "on_write", None))


@situation
def drives_are_not_enabled(kit):
    Driver(kit.one_truck(), kit.Bus(), clock=kit.Clock()).command((0.0, 0.0))


@situation
def vehicle_has_no_drives(kit):
    Driver(kit.one_truck(), kit.Bus(), clock=kit.Clock()).enable()


@situation
def command_has_a_speed_too_few(kit):
    with_drives(kit, lambda _device: None).command((1.0,))


@situation
def bus_would_be_full(kit):
    vehicle = replace(kit.one_truck(), bus=Bus(10_000, 0.01))
    Driver(vehicle, kit.Bus(), clock=kit.Clock()).configure()


@situation
def bus_interface_fails(kit):
    bus = kit.Bus([kit.encoder_device(1), kit.encoder_device(2)])
    driver = Driver(kit.one_truck(), bus, clock=kit.Clock())
    driver.configure()
    bus.is_dead = True
    driver.cycle()


@situation
def bus_has_no_sync(kit):
    list(PassiveReader(kit.one_truck(), kit.Bus()).samples(idle=0.0, patience=0.0))


@situation
def bus_is_given_without_its_interface(_kit):
    open_bus("can0")


@situation
def bus_interface_does_not_exist(_kit):
    open_bus("socketcan://can99")


@situation
def bus_url_has_no_host(_kit):
    open_bus("socketcand:///can0")


@situation
def eds_does_not_exist(_kit):
    load_eds("encoder.eds", 1)


@situation
def eds_is_no_ini_file(_kit):
    Path("encoder.eds").write_bytes(b"\0\1\2")
    load_eds("encoder.eds", 1)


@situation
def eds_has_only_a_broken_object(_kit):
    Path("encoder.eds").write_text("[1018sub1]\nParameterName=Vendor\n", encoding="utf-8")
    load_eds("encoder.eds", 1)


@pytest.mark.usefixtures("_impatient")
@pytest.mark.parametrize("name", SITUATIONS)
def test_the_sentence_is_the_golden_one_and_an_error_of_a_node_names_it(kit, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DriverError) as caught:
        SITUATIONS[name](kit)
    error = caught.value
    assert str(error) == GOLDEN[name]
    assert isinstance(error, NodeError) or not name.startswith(("node", "device", "map"))
    if isinstance(error, NodeError):  # its short form leaves the advice out
        assert str(error).startswith(f"node {error.node}: {error.problem}; ")
        assert len(str(error)) > len(error.problem) + 20


def test_every_golden_sentence_belongs_to_a_situation():
    assert set(GOLDEN) == set(SITUATIONS)


@pytest.mark.parametrize("end", ["  ", "\n", ": "])
def test_a_traceback_in_what_an_interface_says_is_left_out(end):
    """python-can's socketcand client puts its traceback into the text of its error."""
    said = f"Failed to receive: [Errno 104] reset{end}Traceback (most recent call last):\n  File x, line 1\n"
    lost = BusLost(can.CanError(said))
    assert lost.cause == "Failed to receive: [Errno 104] reset"
    assert str(lost) == (
        "the bus interface failed: Failed to receive: [Errno 104] reset; "
        "check the adapter, its cable and the power of the bus"
    )


def test_an_interface_that_says_nothing_is_named_by_the_kind_of_its_error():
    assert BusLost(BrokenPipeError()).cause == "BrokenPipeError"
