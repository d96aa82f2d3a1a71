"""Our EDS files: they load without a remark, are complete, and agree with themselves."""

import configparser
import logging

import canopen
import pytest

from omnimate.vcan_sim.nodes.objects import EDS_FOLDER, load_dictionary

FILES = sorted(path.name for path in EDS_FOLDER.glob("*.eds"))
ENCODERS = [name for name in FILES if "406" in name]
COMMUNICATION = {
    *(0x1000, 0x1001, 0x1003, 0x1005, 0x1008, 0x1014),
    *(0x1016, 0x1017, 0x1018, 0x1800, 0x1801, 0x1A00),
}
ENCODER = {
    *(0x6000, 0x6002, 0x6003, 0x6004, 0x6030, 0x6200, 0x6500),
    *(0x6501, 0x6503, 0x6504, 0x6505, 0x6506, 0x6509),
}
DRIVE = {
    *(0x6007, 0x6040, 0x6041, 0x6060, 0x6061, 0x6064, 0x606C),
    *(0x6083, 0x6084, 0x608F, 0x6091, 0x60FF, 0x6502),
}


def sections(name):
    parser = configparser.RawConfigParser()
    parser.optionxform = str
    parser.read(EDS_FOLDER / name, encoding="ascii")
    return parser


def test_there_are_three_encoders_and_a_drive():
    assert len(ENCODERS) == 3
    assert [name for name in FILES if name not in ENCODERS] == ["drive_cia402.eds"]


@pytest.mark.parametrize("name", FILES)
def test_plain_canopen_loads_the_file_without_a_remark(name, caplog):
    with caplog.at_level(logging.DEBUG):
        dictionary = canopen.import_od(str(EDS_FOLDER / name), node_id=5)
    assert not caplog.records
    assert dictionary[0x1014].default == 0x85
    assert dictionary[0x1800][1].default == 0x4000_0185
    assert dictionary.device_information.allowed_baudrates >= {125_000, 250_000, 500_000, 1_000_000}


@pytest.mark.parametrize("name", FILES)
def test_the_lists_of_objects_and_the_sections_say_the_same(name):
    parser = sections(name)
    listed = []
    for title in ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"):
        values = dict(parser[title])
        count = int(values.pop("SupportedObjects"), 0)
        assert list(values) == [str(number) for number in range(1, count + 1)]
        listed += [int(value, 0) for value in values.values()]
    objects = [int(section, 16) for section in parser.sections() if len(section) == 4]
    assert listed == objects
    assert {0x1000, 0x1001, 0x1018} == set(listed[:3])


@pytest.mark.parametrize("name", FILES)
def test_every_record_counts_its_subindices(name):
    parser = sections(name)
    for section in parser.sections():
        if len(section) == 4 and "SubNumber" in parser[section]:
            subs = [name for name in parser.sections() if name.startswith(f"{section}sub")]
            assert int(parser[section]["SubNumber"], 0) == len(subs), section


@pytest.mark.parametrize("name", FILES)
def test_every_default_lies_within_the_limits_of_its_object(name):
    for key, variable in load_dictionary(name).items():
        if isinstance(variable.default, int):
            assert variable.low <= variable.default <= variable.high, key


@pytest.mark.parametrize("name", FILES)
def test_the_default_mappings_name_objects_that_may_be_mapped(name):
    variables = load_dictionary(name)
    for (index, sub), variable in variables.items():
        if (0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00) and sub and variable.default:
            target = variables[variable.default >> 16, variable.default >> 8 & 0xFF]
            assert target.mappable
            assert 8 * target.size == variable.default & 0xFF


@pytest.mark.parametrize("name", ENCODERS)
def test_an_encoder_has_the_objects_of_its_profile(name):
    indices = {index for index, _ in load_dictionary(name)}
    assert indices >= COMMUNICATION | ENCODER
    assert load_dictionary(name)[0x1000, 0].default & 0xFFFF == 406
    assert not load_dictionary(name)[0x6004, 0].writable


def test_the_drive_has_the_objects_of_its_profile():
    indices = {index for index, _ in load_dictionary("drive_cia402.eds")}
    assert COMMUNICATION | DRIVE | {0x1400, 0x1600} <= indices
    assert load_dictionary("drive_cia402.eds")[0x1000, 0].default & 0xFFFF == 402


def test_no_two_products_share_a_product_code():
    codes = [load_dictionary(name)[0x1018, 2].default for name in FILES]
    assert len(set(codes)) == len(FILES)
