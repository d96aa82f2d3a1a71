import pytest

from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.errors import EdsError
from tests.driver.conftest import DEVICE_TYPE
from tests.samples import OUR_EDS, VENDORS_EDS, cases

GOOD = f"[DeviceInfo]\nVendorName=Maker\nVendorNumber=0x5\n{DEVICE_TYPE}"


def load(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "device.eds"
    path.write_bytes(text.encode(encoding))
    return load_eds(path, 5)


OBJECTS = [10, 17]  # of our files
VENDORS_OBJECTS = [39, 73, 167, 75, 20, 157, 100, 33]


@pytest.mark.parametrize(
    ("path", "objects"),
    cases(*zip(OUR_EDS, OBJECTS, strict=True), *zip(VENDORS_EDS, VENDORS_OBJECTS, strict=True)),
)
def test_every_sample_file_loads(path, objects):
    assert len(load_eds(path, 5).dictionary) == objects


def test_every_file_in_the_folder_is_tested(shared_data):
    files = [path for path in (shared_data / "eds").iterdir() if path.suffix in {".eds", ".dcf"}]
    assert sorted(files) == sorted(VENDORS_EDS)


def test_all_oddities_of_a_file_are_repaired():
    encoder, drive = (load_eds(path, 5) for path in OUR_EDS)
    assert encoder.remarks == (
        "line 8: not UTF-8; read as Windows-1252",
        "line 18: ObjectType='0x07 # VAR' read as 0x07",
        "line 30: PDOMapping='01' read as 1",
    )
    assert encoder.dictionary.device_information.product_number == 0x101
    assert (encoder.dictionary[0x1800][1].default, encoder.dictionary[0x1800][2].default) == (0x40000185, 254)
    assert encoder.dictionary[0x1801][1].default == 0x80000285
    assert set(encoder.dictionary[0x1A01]) == {0}
    assert drive.dictionary[0x1016][4].access_type == "rw"
    assert drive.dictionary[0x1800][1].value == 0x185


def test_a_good_file_needs_no_remark(tmp_path):
    eds = load(tmp_path, GOOD)
    assert eds.remarks == ()
    assert eds.dictionary[0x1000].default == 0x00020196


@pytest.mark.parametrize(
    ("old", "new", "remark"),
    [
        ("VendorNumber=0x5", "VendorNumber=", "line 3: VendorNumber='' is no number; left out"),
        ("ObjectType=0x7", "ObjectType=0x7 # VAR", "line 6: ObjectType='0x7 # VAR' read as 0x7"),
        ("DataType=0x0007", "DataType=", "line 7: DataType='' is no number; taken for 0x000F"),
        ("PDOMapping=0", "PDOMapping=01", "line 10: PDOMapping='01' read as 1"),
        ("PDOMapping=0", "PDOMapping 0", "line 10: 'PDOMapping 0' is no key=value; ignored"),
        (
            "AccessType=ro",
            "AccessType=ro\nAccessType=rw",
            "line 9: AccessType is given twice in its section; the second one is ignored",
        ),
        (
            "[1000]",
            "[DeviceInfo]\nX=1\n[1000]",
            "line 4: section [DeviceInfo] is given twice; the second one is ignored",
        ),
    ],
)
def test_each_repair_is_reported_with_its_line(tmp_path, old, new, remark):
    eds = load(tmp_path, GOOD.replace(old, new))
    assert eds.remarks == (remark,)
    assert 0x1000 in eds.dictionary


@pytest.mark.parametrize(
    "comments", ["Lines=2\nLine1=first\n", "Line1=first\n", "Lines=4\nLine2=second\n", "Lines=x\n"]
)
def test_comments_without_all_of_their_lines_are_no_reason_to_refuse_a_file(tmp_path, comments):
    eds = load(tmp_path, f"{GOOD}[Comments]\n{comments}")
    assert 0x1000 in eds.dictionary


BROKEN_OBJECTS = [
    "[1018sub1]\nParameterName=Vendor\nDataType=0x7\n",  # without its object
    "[2000]\nObjectType=0x7\nDataType=0x7\n",  # without a name
    "[2000]\nParameterName=A\nObjectType=0x8\n[2000Name]\nNrOfEntries=3\n1=one\n",
    "[2000]\nParameterName=A\nObjectType=0x9\n[2000sub1]\nObjectType=0x7\n",
]


@pytest.mark.parametrize("broken", BROKEN_OBJECTS)
def test_a_broken_object_is_left_out_and_named_and_the_others_are_read(tmp_path, broken):
    after = GOOD.split("[1000]")[1].replace("Device type", "After it")
    eds = load(tmp_path, f"{GOOD}{broken}[6000]{after}")
    assert {0x1000, 0x6000} <= set(eds.dictionary)
    index = broken[1:5]
    assert [remark for remark in eds.remarks if remark.startswith(f"[{index}")]


def test_windows_1252_is_read_and_reported(tmp_path):
    eds = load(tmp_path, GOOD.replace("Maker", "Drehgeber für Räder “neu”"), "cp1252")
    assert eds.dictionary.device_information.vendor_name == "Drehgeber für Räder “neu”"
    assert eds.remarks == ("line 2: not UTF-8; read as Windows-1252",)


def test_missing_dummies_are_added(tmp_path):
    eds = load(tmp_path, GOOD + "[DummyUsage]\nDummy0005=1\n")
    assert "Dummy0001" in eds.remarks[0]
    assert 5 in eds.dictionary


def test_an_array_that_gives_the_number_of_its_objects_has_all_of_them(tmp_path):
    """CompactSubObj of CiA 306; its lists hold the names and the values that are not as of the others."""
    text = (
        "[2000]\nParameterName=Limit\nObjectType=0x8\nDataType=0x7\nAccessType=rw\nDefaultValue=7\n"
        "CompactSubObj=12\n[2000Name]\nNrOfEntries=1\n3=Third\n[2000Value]\nNrOfEntries=1\n12=0x22\n"
    )
    eds = load(tmp_path, GOOD + text)
    assert eds.remarks == ()
    limits = eds.dictionary[0x2000]
    assert [limits[subindex].name for subindex in (0, 1, 3, 12)] == [
        "NrOfObjects",
        "Limit1",
        "Third",
        "Limit12",
    ]
    assert set(limits) == set(range(13))
    assert limits[0].default == 12
    assert [(limits[place].default, limits[place].value) for place in (3, 12)] == [(7, None), (7, 0x22)]


def test_sections_of_sub_indices_in_other_case_are_understood(tmp_path):
    record = "[2a00]\nParameterName=Record\nObjectType=9\n"
    entry = "[2a00SUBA]\nParameterName=Tenth\nDataType=5\nAccessType=ro\n"
    assert load(tmp_path, GOOD + record + entry).dictionary[0x2A00][10].name == "Tenth"


def test_keys_in_other_case_are_understood(tmp_path):
    assert (
        load(tmp_path, GOOD.replace("ParameterName", "parametername")).dictionary[0x1000].name
        == "Device type"
    )


@pytest.mark.parametrize("text", ["[1000]\nObjectType=0x7\n", "\0\1\2", "[1018sub1]\nParameterName=x\n"])
def test_what_is_no_eds_is_an_error_that_names_the_file(tmp_path, text):
    path = tmp_path / "bad.eds"
    path.write_text(text)
    with pytest.raises(EdsError, match=r"bad\.eds"):
        load_eds(path, 1)
