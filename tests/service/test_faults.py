"""The robot's faults in the formats of fleet managers."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from omnimate.driver.robot.events import Trouble
from omnimate.driver.robot.report import NodeReport
from omnimate.service.robot.faults import open_rmf, vda5050
from omnimate.service.robot.robot_server import RobotStatus

WELL = NodeReport(node=1, names=("a.left",), state="operational", received=10)
DRIVE = replace(WELL, node=9, names=("drive of a.left",), state="pre-operational")


def report(*nodes, troubles=()):
    return SimpleNamespace(nodes=nodes, troubles=troubles)


@pytest.mark.parametrize("words", [vda5050, open_rmf])
@pytest.mark.parametrize("bus", [None, report(WELL, DRIVE)])
def test_a_robot_without_faults_has_an_empty_list(words, bus):
    assert list(words(RobotStatus(None, report=bus)).values()) == [[]]


def test_a_lost_bus_is_fatal():
    (error,) = vda5050(RobotStatus("no adapter"))["errors"]
    assert (error["errorLevel"], error["errorDescription"]) == ("FATAL", "no adapter")
    assert open_rmf(RobotStatus("no adapter")) == {
        "issues": [{"category": "odometry bus lost", "detail": "no adapter"}]
    }


@pytest.mark.parametrize(
    ("node", "description"),
    [
        (replace(WELL, is_lost=True), "node 1 (a.left): its heartbeat is lost"),
        (replace(WELL, state="stopped"), "node 1 (a.left): stopped"),
        (replace(DRIVE, is_lost=True), "node 9 (drive of a.left): its heartbeat is lost"),
    ],
)
def test_a_faulty_node_is_a_warning_that_names_it(node, description):
    (error,) = vda5050(RobotStatus(None, report=report(WELL, node)))["errors"]
    assert (error["errorLevel"], error["errorDescription"]) == ("WARNING", description)
    assert error["errorReferences"] == [{"referenceKey": "nodeId", "referenceValue": str(node.node)}]
    assert open_rmf(RobotStatus(None, report=report(node)))["issues"][0]["detail"] == description


@pytest.mark.parametrize(
    ("node", "references"), [(9, [{"referenceKey": "nodeId", "referenceValue": "9"}]), (None, [])]
)
def test_what_has_stopped_all_wheels_is_fatal(node, references):
    stopped = report(WELL, DRIVE, troubles=(Trouble(1.0, node, "heartbeat lost"),))
    (error,) = vda5050(RobotStatus(None, report=stopped))["errors"]
    assert (error["errorLevel"], error["errorDescription"]) == ("FATAL", "heartbeat lost")
    assert error["errorReferences"] == references
    issues = open_rmf(RobotStatus(None, report=stopped))["issues"]
    assert issues == [{"category": "wheels stopped", "detail": "heartbeat lost"}]
