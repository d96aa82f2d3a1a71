"""Each broken situation gives exactly the sentence in `tests/data/driver/errors.toml`."""

import tomllib
from dataclasses import replace
from pathlib import Path

import can
import pytest

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.errors import BusLost, DriverError, NodeError
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.passive import PassiveReader
from omnimate.vehicle.parameters import Bus

GOLDEN = tomllib.loads(
    (Path(__file__).parents[1] / "data" / "driver" / "errors.toml").read_text(encoding="utf-8")
)


def falls_silent(kit):
    device = kit.encoder_device(1)
    device.on_write = lambda *_write: device.power_off()
    return device


def without(device, *indices):
    for index in indices:
        device.object_dictionary.indices.pop(index, None)
    return device


def has(device, index, subindex, value):
    device.put(index, subindex, value)
    return device


def refuses(device, *where, code):
    device.refuse[where] = code
    return device


def refuses_sync(kit, code):
    return refuses(has(kit.encoder_device(1), 0x1005, 0, 0x40000080), 0x1005, 0, code=code)


def keeps(kit, kept, where):
    """Return a device that confirms what is written to an object, and keeps another value."""
    device = kit.encoder_device(1)
    device.on_write = lambda *write: device.put(*where, kept) if write[:2] == where else None
    return device


def enabled(kit, change=lambda _device: None):
    driver, bus = kit.driver_and_bus(kit.drive("a.left", 17), kit.drive("a.right", 18))
    change(bus.devices[17])
    driver.configure()
    driver.enable()
    return driver


def lose_the_bus(kit):
    driver, bus = kit.driver_and_bus()
    driver.configure()
    bus.is_dead = True
    driver.cycle()


def load_text(text):
    Path("encoder.eds").write_text(text, encoding="utf-8")
    load_eds("encoder.eds", 1)


def two_pdos(kit):
    return kit.one_truck((kit.wheel_encoder("a.left", 1), kit.wheel_encoder("a.right", 1, cob_id=0x281)))


SITUATIONS = {
    "node_is_silent": lambda kit: kit.configure(None),
    "node_falls_silent_while_it_is_configured": lambda kit: kit.configure(falls_silent(kit)),
    "node_refuses_a_write_in_its_state": lambda kit: kit.configure(refuses_sync(kit, 0x08000022)),
    "node_refuses_a_write_of_a_read_only_object": lambda kit: kit.configure(refuses_sync(kit, 0x06010002)),
    "node_refuses_a_read": lambda kit: enabled(
        kit, lambda device: device.refuse_read.update({(0x6041, 0): 0x08000000})
    ),
    "node_confirms_a_value_and_keeps_another": lambda kit: kit.configure(keeps(kit, 3, (0x1800, 2))),
    "device_does_not_keep_a_cob_id": lambda kit: kit.configure(keeps(kit, 0x2FF, (0x1801, 1)), cob_id=0x1A1),
    "device_has_another_profile": lambda kit: kit.configure(
        has(kit.encoder_device(1), 0x1000, 0, 0x00020192)
    ),
    "device_has_another_vendor": lambda kit: kit.configure(kit.encoder_device(1), vendor=9),
    "device_has_another_product": lambda kit: kit.configure(kit.encoder_device(1), product=9),
    "device_has_no_serial_number": lambda kit: kit.configure(
        without(kit.encoder_device(1), 0x1018), serial=77
    ),
    "mapping_is_refused": lambda kit: kit.configure(
        refuses(kit.encoder_device(1), 0x1A00, 1, 0x60040020, code=0x06040041)
    ),
    "mapping_has_a_gap_of_three_bits": lambda kit: kit.configure(kit.encoder_device(1), start_bit=3),
    "device_has_too_few_tpdos": lambda kit: kit.configure(
        without(kit.encoder_device(1), 0x1801), two_pdos(kit)
    ),
    "drive_has_no_rpdo": lambda kit: enabled(kit, lambda device: without(device, *range(0x1400, 0x1404))),
    "drive_stays_switch_on_disabled": lambda kit: enabled(
        kit, lambda device: setattr(device, "on_write", lambda *_write: None)
    ),
    "drives_are_not_enabled": lambda kit: kit.driver_and_bus()[0].command((0.0, 0.0)),
    "vehicle_has_no_drives": lambda kit: kit.driver_and_bus()[0].enable(),
    "command_has_a_speed_too_few": lambda kit: enabled(kit).command((1.0,)),
    "bus_would_be_full": lambda kit: Driver(
        replace(kit.one_truck(), bus=Bus(10_000, 0.01)), kit.FakeBus(), clock=kit.FakeClock()
    ).configure(),
    "bus_interface_fails": lose_the_bus,
    "bus_has_no_sync": lambda kit: list(
        PassiveReader(kit.one_truck(), kit.FakeBus()).samples(idle=0.0, patience=0.0)
    ),
    "bus_is_given_without_its_interface": lambda _kit: open_bus("can0"),
    "bus_interface_does_not_exist": lambda _kit: open_bus("socketcan://can99"),
    "bus_url_has_no_host": lambda _kit: open_bus("socketcand:///can0"),
    "eds_does_not_exist": lambda _kit: load_eds("encoder.eds", 1),
    "eds_is_no_ini_file": lambda _kit: load_text("\0\1\2"),
    "eds_has_only_a_broken_object": lambda _kit: load_text("[1018sub1]\nParameterName=Vendor\n"),
}


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
