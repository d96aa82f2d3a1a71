"""`omnimate nmt` and `lss` on the simulated devices."""

import json

import pytest

from tests.cli.conftest import NODES, device_of, identity

BUS = ("--bus", "virtual://x")


def test_a_reset_ends_with_the_boot_up_of_the_node(omnimate, simulated):
    assert omnimate("nmt", "reset", *BUS, "--node", 1).out == "node 1: boot-up\n"
    states = json.loads(omnimate("nmt", "reset-communication", *BUS, "--node", "all", "--json").out)
    assert states == dict.fromkeys(map(str, NODES), "boot-up")


@pytest.mark.parametrize(
    ("command", "state"), [("start", "operational"), ("stop", "stopped"), ("preop", "pre-operational")]
)
def test_the_state_is_that_of_the_heartbeat(omnimate, simulated, command, state):
    omnimate("nmt", "preop", *BUS, "--node", 1)
    omnimate("sdo", "write", "1017h", "100", *BUS, "--node", 1)
    assert omnimate("nmt", command, *BUS, "--node", 1).out == f"node 1: {state}\n"


def test_only_the_state_of_the_addressed_node_is_printed(omnimate, simulated):
    omnimate("nmt", "preop", *BUS, "--node", "all")
    for node, period in ((1, 100), (2, 300)):
        omnimate("sdo", "write", "1017h", period, *BUS, "--node", node)
    assert omnimate("nmt", "start", *BUS, "--node", 2).out == "node 2: operational\n"
    assert json.loads(omnimate("nmt", "start", *BUS, "--node", 2, "--json").out) == {"2": "operational"}
    result = omnimate("nmt", "start", *BUS, "--node", 98)
    assert (result.code, result.out) == (1, "")


@pytest.mark.parametrize("node", [1, 98])
def test_a_node_without_a_heartbeat_is_named_with_exit_code_1(refused, simulated, node):
    assert f"node {node}: no heartbeat within 1.5 s" in refused("nmt", "start", *BUS, "--node", node, out="")


@pytest.mark.parametrize("node", ["0", "128", "x"])
def test_a_node_that_cannot_be_is_refused(omnimate, local_node, node):
    assert "expected 1 to 127, or all" in omnimate("nmt", "stop", *BUS, "--node", node).err


def test_a_device_gets_another_id_by_its_identity_and_keeps_it(omnimate, simulated):
    named = ",".join(map(str, identity(device_of(simulated, 1))))
    assert omnimate("lss", "id", 99, *BUS, "--identity", named, "--store").code == 0
    assert omnimate("nmt", "reset", *BUS, "--node", 1).out == "node 99: boot-up\n"
    assert omnimate("nmt", "reset", *BUS, "--node", 99).out == "node 99: boot-up\n"


def test_the_device_without_an_id_is_found_and_gets_one(omnimate, simulated):
    wanted = identity(device_of(simulated, 2))
    assert "no device without a node id" in omnimate("lss", "find", *BUS).err
    device = device_of(simulated, 2)
    device.lss.pending = 0xFF
    omnimate("nmt", "reset-communication", *BUS, "--node", 2)
    found = json.loads(omnimate("lss", "find", *BUS, "--json").out)
    assert list(found.values()) == wanted
    assert omnimate("lss", "id", 77, *BUS).code == 0
    assert omnimate("sdo", "read", "1018h:04", *BUS, "--node", 77).code == 0


def test_of_several_devices_without_an_id_each_gets_one_in_turn(omnimate, simulated):
    wanted = {tuple(identity(device_of(simulated, node))) for node in (2, 3, 5)}
    for node in (2, 3, 5):
        device_of(simulated, node).lss.pending = 0xFF
        omnimate("nmt", "reset-communication", *BUS, "--node", node)
    calls = [omnimate("lss", "id", new, *BUS, "--json") for new in (40, 41, 42)]
    assert {tuple(json.loads(call.out).values()) for call in calls} == wanted


@pytest.mark.parametrize("text", ["1,2,3", "a,b,c,d", ""])
def test_an_identity_that_cannot_be_is_refused(omnimate, simulated, text):
    assert "expected VENDOR,PRODUCT,REVISION,SERIAL" in omnimate("lss", "id", 5, *BUS, "--identity", text).err
