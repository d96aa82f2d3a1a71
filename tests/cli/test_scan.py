"""`omnimate scan` on the simulated devices."""

import json

import pytest

from docs.generate.conformance import Local, frame
from omnimate.cli.console import out
from omnimate.vcan_sim.nodes.objects import EDS_FOLDER
from tests.cli.conftest import NODES, device_of, identity

BUS = ("--bus", "virtual://x?bitrate=250000")


def take_id(bus, node):
    while bus.recv(0.0):  # its boot-up with the former id
        pass
    device = device_of(bus, node)
    device.lss.pending = 0xFF
    bus.send(frame(0x000, bytes([0x82, node])))
    return identity(device)


def test_the_nodes_are_listed_and_the_draft_is_written_beside_its_eds_files(accepted, simulated, tmp_path):
    path = tmp_path / "vehicle.toml"
    result = accepted("scan", *BUS, "--eds", EDS_FOLDER, "--write", path)
    assert "406 multi-turn encoder" in result.out
    assert "drive_cia402.eds" in result.out
    assert "no SYNC; no other master" in result.out
    assert f"drafted: {path}" in result.out
    text = path.read_text()
    assert "bitrate = 250000" in text
    line = next(line for line in text.splitlines() if line.startswith("eds = "))
    assert (tmp_path / line.split('"')[1]).resolve().parent == EDS_FOLDER.resolve()


def test_json_says_all_that_was_read(omnimate, simulated):
    said = json.loads(omnimate("scan", *BUS, "--eds", EDS_FOLDER, "--json").out)
    assert [node["node"] for node in said["nodes"]] == NODES
    first = said["nodes"][0]
    assert (first["profile"], first["device"], first["vendor"]) == (406, "406 multi-turn encoder", 0xFEED0)
    assert first["name"] == "OmniMate multi-turn encoder"
    assert first["pdos"][1]["carries"] == [{"object": "6004h:00", "bits": 32}]
    assert first["eds"]["fit"] == "whole"
    assert first["objects"]["6501h:00"] == 40000
    assert said["other_master"] == []


def test_no_line_is_longer_than_80_characters_on_such_a_screen(omnimate, simulated, monkeypatch):
    monkeypatch.setattr(out, "_force_terminal", True)
    monkeypatch.setattr(out, "_width", 80)
    lines = omnimate("scan", *BUS, "--eds", EDS_FOLDER).out.splitlines()
    assert max(map(len, lines)) <= 80


def test_a_device_without_an_id_is_told_and_gets_one_only_when_asked(omnimate, simulated):
    identity = take_id(simulated, 2)
    assert [node["node"] for node in json.loads(omnimate("scan", *BUS, "--json").out)["nodes"]] == [
        node for node in NODES if node != 2
    ]
    said = json.loads(omnimate("scan", *BUS, "--lss", "--json").out)
    assert list(said["without_id"][0].values()) == [*identity, None]
    assert 2 not in [node["node"] for node in said["nodes"]]
    said = json.loads(omnimate("scan", *BUS, "--lss", "--assign", 6, "--json").out)
    assert list(said["without_id"][0].values()) == [*identity, 8]  # 6 and 7 are in use
    assert 8 in [node["node"] for node in said["nodes"]]


def test_several_devices_without_an_id_are_all_found(omnimate, simulated):
    identities = {tuple(take_id(simulated, node)) for node in (2, 5, 12)}
    found = json.loads(omnimate("scan", *BUS, "--lss", "--json").out)["without_id"]
    assert {tuple(device.values())[:4] for device in found} == identities
    given = json.loads(omnimate("scan", *BUS, "--lss", "--assign", 40, "--json").out)["without_id"]
    assert sorted(device["given"] for device in given) == [40, 41, 42]


def test_beside_another_master_the_words_say_so_and_lss_is_refused(omnimate, on_bench):
    on_bench(Local, [frame(0x080, b"")])
    assert "another master works here (SYNC)" in omnimate("scan", *BUS).out
    on_bench(Local, [frame(0x080, b"")])
    assert "another master sends SYNC" in omnimate("scan", *BUS, "--lss").err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--assign", 5], "add --lss"),
        (["--write", __file__], "exists already"),
        (["--eds", __file__], "is a file"),
    ],
)
def test_a_call_that_cannot_be_is_refused(omnimate, local_node, arguments, words):
    result = omnimate("scan", *BUS, *arguments)
    assert result.code
    assert words in result.err


def test_a_node_that_is_heard_and_does_not_answer_is_a_problem(omnimate, on_bench):
    on_bench(Local, [frame(0x705, b"\x04")])
    result = omnimate("scan", *BUS)
    assert result.code == 1
    assert "node 5: does not answer SDO" in result.err
    assert "stopped" in result.out
