"""The robot's faults in the formats of fleet managers: VDA 5050 errors and Open-RMF issues."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.driver.report import DriverReport


def vda5050(problem: str | None, report: DriverReport | None) -> dict[str, Any]:
    """Return the `errors` of a VDA 5050 state: FATAL where the robot cannot be read, WARNING for a node.

    Args:
        problem: Why the robot cannot be read; None where it can.
        report: The driver's last report of the bus; None before the first one.
    """
    errors: list[dict[str, Any]] = []
    if problem is not None:
        errors.append(
            {
                "errorType": "odometryBusLost",
                "errorLevel": "FATAL",
                "errorDescription": problem,
                "errorHint": "check the adapter, the cable and the supply of the bus",
                "errorReferences": [],
            }
        )
    for node, description in _faulty_nodes(report):
        errors.append(
            {
                "errorType": "encoderNode",
                "errorLevel": "WARNING",
                "errorDescription": description,
                "errorHint": f"check node {node}; GET /v1/bus lists what happened to it",
                "errorReferences": [{"referenceKey": "nodeId", "referenceValue": str(node)}],
            }
        )
    return {"errors": errors}


def open_rmf(problem: str | None, report: DriverReport | None) -> dict[str, Any]:
    """Return the `issues` of an Open-RMF robot state; the arguments are those of `vda5050`."""
    issues: list[dict[str, Any]] = []
    if problem is not None:
        issues.append({"category": "odometry bus lost", "detail": problem})
    issues += [
        {"category": "encoder node", "detail": description} for _, description in _faulty_nodes(report)
    ]
    return {"issues": issues}


def _faulty_nodes(report: DriverReport | None) -> Iterator[tuple[int, str]]:
    for node in report.nodes if report is not None else ():
        if not node.is_well:
            state = "its heartbeat is lost" if node.is_lost else node.state
            yield node.node, f"node {node.node} ({', '.join(node.names)}): {state}"
