"""Metrics for Prometheus: calls, samples, nodes, sessions and jobs, read at each request for them."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from fastapi.routing import APIRoute
from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from sqlalchemy import func, select
from sqlalchemy.exc import SQLAlchemyError

from omnimate.service.store.tables import JobRow, SessionRow

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from omnimate.service.components import Components

BUCKETS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0)


def call_histogram() -> Histogram:
    """Return the histogram of how often each call was made, how it ended, and how long it took [s]."""
    labels = ["method", "operation", "status"]
    return Histogram("omnimate_call_seconds", "Duration of calls", labels, registry=None, buckets=BUCKETS)


def operation_id(route: APIRoute) -> str:
    """Return the id of a call in the OpenAPI document, which is the name of its function: `getRobot`."""
    first, *others = route.name.split("_")
    return first + "".join(other.capitalize() for other in others)


class CallTimer:
    """An ASGI application in front of another one, which measures how long calls take, by their operation."""

    def __init__(self, app: ASGIApp, seconds: Histogram) -> None:
        self.app, self._seconds = app, seconds

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a call, and note its duration."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        began, status = time.perf_counter(), 500

        async def send_noting_status(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        try:
            await self.app(scope, receive, send_noting_status)
        finally:
            route = scope.get("route")
            operation = operation_id(route) if isinstance(route, APIRoute) else "other"
            labelled = self._seconds.labels(scope["method"], operation, str(status))
            labelled.observe(time.perf_counter() - began)


def exposition(components: Components, seconds: Histogram) -> tuple[bytes, str]:
    """Return all metrics as Prometheus reads them, and their content type."""
    registry = CollectorRegistry()
    registry.register(seconds)
    status, events = components.robot.status, components.events
    for name, help_text, count in (
        ("omnimate_samples", "Samples of the bus", status.samples),
        ("omnimate_samples_incomplete", "Samples with a missing reading", status.incomplete),
        ("omnimate_frames", "Frames of the bus", status.frames),
    ):
        Counter(name, help_text, registry=registry).inc(count)
    Gauge("omnimate_listeners", "Clients of the stream", registry=registry).set(events.listeners)
    Gauge("omnimate_bus_up", "Whether the bus is read", registry=registry).set(status.problem is None)
    _nodes(components, registry)
    _states(components, registry)
    return generate_latest(registry), CONTENT_TYPE_LATEST


def _nodes(components: Components, registry: CollectorRegistry) -> None:
    counters = {
        name: Counter(f"omnimate_node_{name}", f"Of each node: {name}", ["node"], registry=registry)
        for name in ("received", "missing", "restarts", "emergencies")
    }
    well = Gauge("omnimate_node_well", "Whether a node works", ["node"], registry=registry)
    report = components.robot.status.report
    for node in report.nodes if report else ():
        for name, counter in counters.items():
            counter.labels(str(node.node)).inc(getattr(node, name))
        well.labels(str(node.node)).set(node.is_well)


def _states(components: Components, registry: CollectorRegistry) -> None:
    """Count the sessions and jobs; while the database is away, none of them has a value."""
    up = Gauge("omnimate_database_up", "Whether the database answers", registry=registry)
    gauges = [
        (table, Gauge(f"omnimate_{name}", f"{name} by state", ["state"], registry=registry))
        for name, table in (("sessions", SessionRow), ("jobs", JobRow))
    ]
    try:
        with components.database.reading() as db:
            counts = [
                (gauge, state, count)
                for table, gauge in gauges
                for state, count in db.execute(select(table.state, func.count()).group_by(table.state))
            ]
    except SQLAlchemyError:
        return
    up.set(1)
    for gauge, state, count in counts:
        gauge.labels(state).set(count)
