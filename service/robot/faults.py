"""What is wrong with the robot, in a fleet's words: VDA 5050 errors, Open-RMF issues."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

    from driver.report import DriverReport


def vda5050(problem: str | None, report: DriverReport | None) -> dict[str, Any]:
    """Return the `errors` of a VDA 5050 state: FATAL where the robot cannot be read, WARNING for a node."""
    found: list[dict[str, Any]] = []
    if problem is not None:
        found.append(
            {
                "errorType": "odometryBusLost",
                "errorLevel": "FATAL",
                "errorDescription": problem,
                "errorHint": "check the adapter, the cable and the supply of the bus",
                "errorReferences": [],
            }
        )
    for node, what in _nodes(report):
        found.append(
            {
                "errorType": "encoderNode",
                "errorLevel": "WARNING",
                "errorDescription": what,
                "errorHint": f"look at node {node}; GET /v1/bus says what has happened to it",
                "errorReferences": [{"referenceKey": "nodeId", "referenceValue": str(node)}],
            }
        )
    return {"errors": found}


def open_rmf(problem: str | None, report: DriverReport | None) -> dict[str, Any]:
    """Return the `issues` of an Open-RMF robot state."""
    issues: list[dict[str, Any]] = []
    if problem is not None:
        issues.append({"category": "odometry bus lost", "detail": problem})
    issues += [{"category": "encoder node", "detail": what} for _, what in _nodes(report)]
    return {"issues": issues}


def _nodes(report: DriverReport | None) -> Iterator[tuple[int, str]]:
    for one in report.nodes if report is not None else ():
        if not one.is_well:
            state = "its heartbeat is lost" if one.is_lost else one.state
            yield one.node, f"node {one.node} ({', '.join(one.names)}): {state}"
