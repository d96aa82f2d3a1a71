"""Which file fits a device."""

import pytest

from omnimate.driver.scan.eds_folder import Fit, described_devices, fitting_file
from omnimate.driver.scan.node import NodeReading
from tests.driver.conftest import DEVICE_TYPE


def folder(path, *files):
    for name, product, revision in files:
        (path / name).parent.mkdir(exist_ok=True)
        numbers = f"VendorNumber=0x2F\nProductNumber={product}\nRevisionNumber={revision}\n"
        (path / name).write_text(f"[DeviceInfo]\n{numbers}{DEVICE_TYPE}")
    return described_devices(path)


def node(vendor=0x2F, product=7, revision=0x10002, device_type=0x00020196):
    return NodeReading(5, device_type, vendor, product, revision)


@pytest.mark.parametrize(
    ("product", "revision", "fit"),
    [
        (7, 0x10002, Fit.WHOLE),
        (7, 0, Fit.WHOLE),
        (7, 0x10003, Fit.SAME_BEHAVIOUR),
        (7, 0x20002, Fit.OTHER_REVISION),
        (0, 0, Fit.VENDOR),
        (8, 0x10002, Fit.NOT),
    ],
)
def test_a_file_fits_as_well_as_its_numbers_do(tmp_path, product, revision, fit):
    (device,) = folder(tmp_path, ("a.eds", product, revision))
    assert device.fit(node()) is fit


def test_the_best_file_counts_and_files_that_fit_as_well_are_named(tmp_path):
    devices = folder(
        tmp_path,
        ("a.eds", 7, 0x10003),
        ("below/b.EDS", 7, 0x10002),
        ("c.dcf", 7, 0x10002),
        ("d.txt", 7, 0x10002),
    )
    assert fitting_file(node(), devices).in_words() == "b.EDS, or c.dcf"
    assert (
        fitting_file(node(revision=0x10009), devices[:1]).in_words() == "a.eds, is of another minor revision"
    )


def test_a_file_of_another_vendor_or_of_another_type_of_device_fits_not(tmp_path):
    (device,) = folder(tmp_path, ("a.eds", 0, 0))
    assert device.fit(node(vendor=0x30)) is Fit.NOT
    assert device.fit(node(vendor=None)) is Fit.NOT
    assert device.fit(node(device_type=0x00020192)) is Fit.NOT
    assert fitting_file(node(vendor=None), [device]) is None


def test_a_file_that_cannot_be_read_is_told_and_passed_over(tmp_path):
    (tmp_path / "broken.eds").write_text("no EDS at all")
    folder(tmp_path, ("good.eds", 7, 1))
    errors = []
    assert [device.path.name for device in described_devices(tmp_path, errors.append)] == ["good.eds"]
    assert "broken.eds" in str(errors[0])
