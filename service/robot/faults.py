"""The robot's faults in the formats of fleet managers: VDA 5050 errors and Open-RMF issues."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.driver.robot.events import Trouble
    from omnimate.driver.robot.report import DriverReport
    from omnimate.service.robot.robot_server import RobotStatus


def vda5050(status: RobotStatus) -> dict[str, Any]:
    """Return the `errors` of a VDA 5050 state: FATAL where it cannot be read or moved, WARNING for a node."""
    errors = []
    if status.problem is not None:
        hint = "check the adapter, the cable and the supply of the bus"
        errors.append(_error("odometryBusLost", "FATAL", status.problem, hint, None))
    for trouble in _troubles(status.report):
        hint = "the next session enables the drives again; see docs/reference/stopping.md"
        errors.append(_error("wheelsStopped", "FATAL", trouble.what, hint, trouble.node))
    for node, description in _faulty_nodes(status.report):
        hint = f"check node {node}; GET /v1/bus lists what happened to it"
        errors.append(_error("encoderNode", "WARNING", description, hint, node))
    return {"errors": errors}


def _error(kind: str, level: str, description: str, hint: str, node: int | None) -> dict[str, Any]:
    references = [] if node is None else [{"referenceKey": "nodeId", "referenceValue": str(node)}]
    return {
        "errorType": kind,
        "errorLevel": level,
        "errorDescription": description,
        "errorHint": hint,
        "errorReferences": references,
    }


def open_rmf(status: RobotStatus) -> dict[str, Any]:
    """Return the `issues` of an Open-RMF robot state."""
    issues: list[dict[str, Any]] = []
    if status.problem is not None:
        issues.append({"category": "odometry bus lost", "detail": status.problem})
    issues += [{"category": "wheels stopped", "detail": trouble.what} for trouble in _troubles(status.report)]
    issues += [
        {"category": "encoder node", "detail": description} for _, description in _faulty_nodes(status.report)
    ]
    return {"issues": issues}


def _troubles(report: DriverReport | None) -> tuple[Trouble, ...]:
    return () if report is None else report.troubles


def _faulty_nodes(report: DriverReport | None) -> Iterator[tuple[int, str]]:
    for node in report.nodes if report is not None else ():
        if not node.is_well:
            state = "its heartbeat is lost" if node.is_lost else node.state
            yield node.node, f"node {node.node} ({', '.join(node.names)}): {state}"
