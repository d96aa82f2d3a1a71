"""The messages of VDA 5050 2.1 (VDA and VDMA, 2024): headers, connection, state, factsheet."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Literal

from omnimate.service.robot.faults import vda5050

if TYPE_CHECKING:
    from omnimate.driver.report import DriverReport

VERSION = "2.1.0"
INTERFACE = "uagv/v2"  # name of the interface and major version, the first parts of each topic
ACTIONS = ("factsheetRequest", "stateRequest")  # of the standard, that this interface carries out
ConnectionState = Literal["ONLINE", "OFFLINE", "CONNECTIONBROKEN"]


@dataclass(slots=True)
class Sender:
    """One robot's headers: its topics, and the number of messages sent on each.

    Attributes:
        manufacturer: Part of the topic.
        serial: Serial number, part of the topic.
        sent: Messages by topic.
    """

    manufacturer: str
    serial: str
    sent: dict[str, int] = field(default_factory=dict)

    def topic(self, name: str) -> str:
        """Return the full topic of a kind of messages."""
        return f"{INTERFACE}/{self.manufacturer}/{self.serial}/{name}"

    def message(self, name: str, content: dict[str, Any], now: float) -> dict[str, Any]:
        """Return a message with its header.

        Args:
            name: Topic.
            content: The message without its header.
            now: Time [s] since 1970.
        """
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


def connection(state: ConnectionState) -> dict[str, Any]:
    """Return the content of a connection message."""
    return {"connectionState": state}


def state_of(
    seen: dict[str, Any],
    problem: str | None,
    report: DriverReport | None,
    actions: list[dict[str, Any]],
) -> dict[str, Any]:
    """Return the content of a state message.

    The robot is in service: this interface takes no orders. What the standard requires and nobody here
    knows (battery, safety) has placeholders, and an information that says so.

    Args:
        seen: The last `state` event of the stream; empty before the first one.
        problem: Why the robot cannot be read; None where it can.
        report: The driver's last report of the bus; None before the first one.
        actions: States of the instant actions that were asked for.
    """
    content: dict[str, Any] = {
        "orderId": "",
        "orderUpdateId": 0,
        "lastNodeId": "",
        "lastNodeSequenceId": 0,
        "nodeStates": [],
        "edgeStates": [],
        "driving": bool(seen.get("driving")) or any(seen.get("wheels", ())),
        "actionStates": actions,
        "batteryState": {"batteryCharge": 100.0, "charging": False},
        "operatingMode": "SERVICE",
        **vda5050(problem, report),
        "safetyState": {"eStop": "NONE", "fieldViolation": False},
        "information": [
            {
                "infoType": "placeholders",
                "infoLevel": "INFO",
                "infoDescription": "batteryState and safetyState are not known to this interface",
                "infoReferences": [],
            }
        ],
    }
    pose = next((seen[name] for name in ("filter", "ipec", "plain") if seen.get(name)), None)
    if pose is not None:
        content["agvPosition"] = {
            "x": pose["x"],
            "y": pose["y"],
            "theta": math.remainder(pose["theta"], math.tau),
            "mapId": "odometry",  # a frame of its own, which begins where the robot was switched on
            "positionInitialized": False,
        }
    return content


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
    mine = [{"actionType": name, "actionScopes": ["INSTANT"]} for name in ACTIONS]
    return content | {"protocolFeatures": features | {"agvActions": [*others, *mine]}}
