"""`omnimate sdo` and `od` on canopen's `LocalNode` and on the simulated devices."""

import json
from pathlib import Path

import pytest

from docs.generate.conformance import Local, frame
from omnimate.driver.canopen.eds import load_eds
from omnimate.driver.canopen.object_values import variables_of
from omnimate.vcan_sim.reference import reference_vehicle
from tests.samples import OUR_EDS

EDS = Path(__file__).parents[2] / "vcan_sim" / "eds" / "encoder_cia406.eds"
WHERE = ("--bus", "virtual://x", "--node", 1)
DRIVE = ("--bus", "virtual://x", "--node", reference_vehicle().drives[0].node)


@pytest.mark.parametrize("item", ["1000h", "0x1000", "1000", "1000h:00", "Device type", "device TYPE"])
def test_an_object_is_named_by_its_index_or_its_name(omnimate, local_node, item):
    assert omnimate("sdo", "read", item, *WHERE, "--eds", EDS).out == "131478 (00020196h)\n"


def test_text_and_sub_indices_are_read_whole(omnimate, simulated):
    assert omnimate("sdo", "read", "1008h", *WHERE, "--eds", EDS).out == "OmniMate multi-turn encoder\n"
    row = json.loads(omnimate("sdo", "read", "1018h:01", *WHERE, "--json").out)
    assert (row["object"], row["value"], row["type"]) == ("1018h:01", 0xFEED0, "u32")


@pytest.mark.parametrize(
    ("value", "kind"), [("700", None), ("0x2BC", None), ("2BCh", None), ("BC 02", "hex")]
)
def test_what_is_written_is_read(omnimate, local_node, value, kind):
    typed = () if kind is None else ("--type", kind)
    assert omnimate("sdo", "write", "1017h", value, *WHERE, *typed).code == 0
    assert json.loads(omnimate("sdo", "read", "1017h", *WHERE, "--json").out)["value"] == 700


def test_a_value_that_json_has_no_number_for_is_null(omnimate, local_node):
    """NaN is no JSON; the bytes still say what the device holds."""
    written = omnimate("sdo", "write", "1005h", "00 00 C0 7F", *WHERE, "--type", "hex")
    assert written.code == 0, written.err
    printed = omnimate("sdo", "read", "1005h", *WHERE, "--type", "f32", "--json").out
    row = json.loads(printed, parse_constant=pytest.fail)
    assert (row["value"], row["bytes"]) == (None, "0000c07f")


def test_a_negative_number_is_written_as_twos_complement(omnimate, simulated):
    assert omnimate("sdo", "write", "60FFh", "--", *map(str, ("-5",))).code == 2  # the bus is missing
    assert omnimate("sdo", "write", *DRIVE, "--", "60FFh", "-5").code == 0
    assert omnimate("sdo", "read", "60FFh", *DRIVE).out == "-5 (FFFFFFFBh)\n"


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (("write", "1000h", "1", *WHERE), "refused to write 1000h:00: attempt to write a read-only object"),
        (("write", "1017h", "70000", *WHERE), "value '70000' is no u16"),
        (("write", "1017h", "fast", *WHERE), "value 'fast' is no u16"),
        (("write", "2000h", "1", *WHERE), "its type is not known; give --type or --eds"),
        (("read", "2000h", *WHERE), "refused to read 2000h:00"),
        (("read", "no such name", *WHERE), "expected 6004h, 1018h:04, or the name of an object"),
    ],
)
def test_what_cannot_be_is_told(refused, local_node, call, says):
    assert says in refused("sdo", *call, out="")


@pytest.mark.parametrize(
    "call",
    [
        ("sdo", "write", "1017h", "700"),
        ("nmt", "stop"),
        ("dcf", "write", OUR_EDS[1]),
        ("conform", "--most", "reads", "--timeout", 0.02),
    ],
    ids=lambda call: call[0],
)
def test_beside_another_master_nothing_is_sent(refused, on_bench, call):
    bus = on_bench(Local, [frame(0x080, b"")])
    assert "another master sends SYNC" in refused(*call, *WHERE, out="")
    assert bus.recv(0.0) is None


def test_beside_another_master_an_object_is_written_where_it_is_forced(omnimate, local_node):
    local_node._waiting.append(frame(0x080, b""))
    assert omnimate("sdo", "write", "1017h", "700", *WHERE, "--force").code == 0
    assert omnimate("sdo", "read", "1017h", *WHERE).out == "700 (02BCh)\n"


def test_the_dictionary_is_listed_with_all_objects_of_the_eds(omnimate, simulated):
    rows = json.loads(omnimate("od", *WHERE, "--eds", EDS, "--json").out)
    readable = [v for v in variables_of(load_eds(EDS, 1).dictionary) if v.readable]
    assert [row["object"] for row in rows] == [f"{v.index:04X}h:{v.subindex:02X}" for v in readable]
    named = {row["object"]: row for row in rows}
    assert named["1008h:00"]["value"] == "OmniMate multi-turn encoder"
    assert "no data available" in named["1003h:01"]["error"]
    lines = omnimate("od", *WHERE, "--eds", EDS).out.splitlines()
    assert f"{'1017h:00':<9} {'Producer heartbeat time':<44} 0 (0000h)" in lines


def test_without_an_eds_the_objects_of_the_profiles_that_are_there_are_listed(omnimate, local_node):
    rows = json.loads(omnimate("od", *WHERE, "--json").out)
    assert {"1000h:00", "1018h:01", "1800h:01"} <= {row["object"] for row in rows}
    assert not [row for row in rows if "error" in row]
