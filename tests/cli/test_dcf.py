"""`omnimate dcf` on the simulated devices."""

import json

import pytest

from omnimate.vcan_sim.nodes.objects import EDS_FOLDER

WHERE = ("--bus", "virtual://x", "--node", 1)
EDS = EDS_FOLDER / "encoder_cia406.eds"


@pytest.fixture
def dcf(tmp_path):
    """Return a DCF of the simulated encoder: a heartbeat of 200 ms, and a faster TPDO1."""
    text = EDS.read_text()
    for section, value in (("[1017]", "200"), ("[1800sub5]", "20"), ("[1018sub1]", "5")):
        assert section in text
        head, _, tail = text.partition(section)
        text = f"{head}{section}\nParameterValue={value}{tail}"
    path = tmp_path / "encoder.dcf"
    path.write_text(text)
    return path


def test_what_differs_is_printed_and_is_a_problem(omnimate, simulated, dcf):
    result = omnimate("dcf", "compare", dcf, *WHERE)
    assert result.code == 1
    assert result.out.splitlines() == [
        "1017h:00 Producer heartbeat time: 0, the DCF states 200",
        "1018h:01 Identity object.Vendor-ID: 1044176, the DCF states 5",
        "1800h:05 TPDO 1 communication parameter.Event timer: 100, the DCF states 20",
    ]
    assert "3 objects are not as" in result.err


def test_what_is_written_differs_no_more_and_what_is_read_only_still_does(omnimate, refused, simulated, dcf):
    assert "written: 2 of 3 objects that differed" in refused("dcf", "write", dcf, *WHERE)
    (left,) = json.loads(omnimate("dcf", "compare", dcf, *WHERE, "--json").out)
    assert (left["index"], left["found"], left["stated"]) == (0x1018, 0xFEED0, 5)


def test_a_negative_value_in_hexadecimal_is_compared_and_written(omnimate, simulated, tmp_path):
    path = tmp_path / "encoder.dcf"
    path.write_text(EDS.read_text().replace("[6010sub1]", "[6010sub1]\nParameterValue=0xFFFFFFFE"))
    assert omnimate("dcf", "compare", path, *WHERE).out.endswith(": 0, the DCF states -2\n")
    assert "written: 1 of 1" in omnimate("dcf", "write", path, *WHERE).err
    assert omnimate("sdo", "read", "6010h:01", *WHERE, "--type", "i32").out == "-2 (FFFFFFFEh)\n"


def test_an_eds_states_nothing_to_compare(omnimate, simulated):
    assert "expected a DCF with ParameterValue" in omnimate("dcf", "compare", EDS, *WHERE).err
