"""The messages of VDA 5050 2.1 (VDA and VDMA, 2024): headers, connection, state, factsheet."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from omnimate.driver.canopen.cia402 import FAULT, FAULT_MASK, FAULT_REACTION
from omnimate.service.robot.faults import vda5050

if TYPE_CHECKING:
    from omnimate.driver.robot.report import DriverReport
    from omnimate.service.robot.robot_server import RobotStatus

VERSION = "2.1.0"
INTERFACE = "uagv/v2"  # name of the interface and major version, the first parts of each topic
ACTIONS = ("factsheetRequest", "stateRequest")  # of the standard, that this interface carries out
# Emergency error codes of CiA 402-2 for too low a voltage: of the mains, and of the DC link.
LOW_VOLTAGE, LOW_VOLTAGE_MASK = (0x3120, 0x3220), 0xFFF0
GOOD, BAD = 80.0, 20.0  # [%] of charge that VDA 5050 has for robots that know these two levels alone
UNKNOWN = (
    "batteryState is what the drives report: 20 % after a low voltage, 80 % otherwise; whether it is "
    "charging is not known. safetyState is what the drives report: eStop where one was stopped from outside; "
    "protective fields, and an eStop that no drive reports, are not known"
)


@dataclass(slots=True)
class Sender:
    """One robot's headers: its topics, and the number of messages sent on each."""

    manufacturer: str
    serial: str
    sent: dict[str, int] = field(default_factory=dict)

    def topic(self, name: str) -> str:
        """Return the full topic of a kind of messages."""
        return f"{INTERFACE}/{self.manufacturer}/{self.serial}/{name}"

    def message(self, name: str, content: dict[str, Any], now: float) -> dict[str, Any]:
        """Return a message with its header."""
        number = self.sent.get(name, 0)
        self.sent[name] = number + 1
        stamp = datetime.fromtimestamp(now, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        header = {
            "headerId": number,
            "timestamp": stamp,
            "version": VERSION,
            "manufacturer": self.manufacturer,
            "serialNumber": self.serial,
        }
        return header | content


def state_of(status: RobotStatus, actions: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the content of a state message.

    The operating mode is SERVICE: this interface takes no orders. Battery and safety states are those that
    the drives report; an `information` lists what is unknown. `actions` are the states of instant actions.
    """
    event = status.state
    content: dict[str, Any] = {
        "orderId": "",
        "orderUpdateId": 0,
        "lastNodeId": "",
        "lastNodeSequenceId": 0,
        "nodeStates": [],
        "edgeStates": [],
        "driving": bool(event.get("driving")) or any(event.get("wheels", ())),
        "actionStates": actions,
        "batteryState": battery_state(status.report),
        "operatingMode": "SERVICE",
        **vda5050(status),
        "safetyState": safety_state(status.report),
        "information": [
            {
                "infoType": "knownFromDrives",
                "infoLevel": "INFO",
                "infoDescription": UNKNOWN,
                "infoReferences": [],
            }
        ],
    }
    pose = next((event[name] for name in ("filter", "ipec", "plain") if event.get(name)), None)
    if pose is not None:
        content["agvPosition"] = {
            "x": pose["x"],
            "y": pose["y"],
            "theta": math.remainder(pose["theta"], math.tau),
            "mapId": "odometry",  # whose origin is the pose at which the robot was switched on
            "positionInitialized": False,
        }
    return content


def battery_state(report: DriverReport | None) -> dict[str, Any]:
    """Return the battery's state: good, unless a drive's emergency message reported a low voltage."""
    codes = {trouble.emergency or 0 for trouble in report.troubles} if report is not None else set()
    is_low = any(code & LOW_VOLTAGE_MASK in LOW_VOLTAGE for code in codes)
    return {"batteryCharge": BAD if is_low else GOOD, "charging": False}


def safety_state(report: DriverReport | None) -> dict[str, Any]:
    """Return the safety state, as far as drives report it.

    A drive that leaves operation enabled without a fault, and without a command of this driver, was stopped
    from outside: by its input for a quick stop, or because its power was taken away (CiA 402-2, transitions
    9 and 11). A person has to enable it again: the standard's `MANUAL`.
    """
    troubles = report.troubles if report is not None else ()
    words = [trouble.status for trouble in troubles if trouble.status is not None]
    is_stopped = any(word & FAULT_MASK not in {FAULT, FAULT_REACTION} for word in words)
    return {"eStop": "MANUAL" if is_stopped else "NONE", "fieldViolation": False}


def action_state(action: dict[str, Any]) -> dict[str, Any]:
    """Return the state of an instant action after it was carried out, or refused."""
    kind, known = str(action.get("actionType", "")), action.get("actionType") in ACTIONS
    state = {
        "actionId": str(action.get("actionId", "")),
        "actionType": kind,
        "actionStatus": "FINISHED" if known else "FAILED",
    }
    if not known:
        state["resultDescription"] = f"only {' and '.join(ACTIONS)} are carried out here"
    return state


def with_actions(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a factsheet with the actions of this interface."""
    features = content["protocolFeatures"]
    others = [action for action in features["agvActions"] if action.get("actionType") not in ACTIONS]
    supported = [{"actionType": name, "actionScopes": ["INSTANT"]} for name in ACTIONS]
    return content | {"protocolFeatures": features | {"agvActions": [*others, *supported]}}
