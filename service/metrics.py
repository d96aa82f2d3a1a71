"""Figures for Prometheus: calls, samples, nodes, sessions and jobs, read when they are asked for."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from sqlalchemy import func, select

from service.store.tables import JobRow, SessionRow

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from service.parts import Parts

BUCKETS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0)


class Calls:
    """How often each call was made, how it ended, and how long it took."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.seconds = Histogram(
            "omnimate_call_seconds",
            "Duration of calls",
            ["method", "operation", "status"],
            registry=self.registry,
            buckets=BUCKETS,
        )

    def took(self, method: str, operation: str, status: int, seconds: float) -> None:
        """Note a call."""
        self.seconds.labels(method, operation, str(status)).observe(seconds)


class Measured:
    """An ASGI application in front of another one, which notes how long calls take, by their operation."""

    def __init__(self, app: ASGIApp, calls: Calls) -> None:
        self.app, self._calls = app, calls

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a call and note it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        began, status = time.perf_counter(), 500

        async def noted(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        try:
            await self.app(scope, receive, noted)
        finally:
            operation = getattr(scope.get("route"), "operation_id", None) or "other"
            self._calls.took(scope["method"], operation, status, time.perf_counter() - began)


def exposition(parts: Parts, calls: Calls) -> tuple[bytes, str]:
    """Return all figures and their content type."""
    registry = CollectorRegistry()
    samples, incomplete = parts.live.samples
    Counter("omnimate_samples", "Samples of the bus", registry=registry).inc(samples)
    Counter("omnimate_samples_incomplete", "Samples with a missing reading", registry=registry).inc(
        incomplete
    )
    Counter("omnimate_frames", "Frames of the bus", registry=registry).inc(parts.live.tap.frames)
    Gauge("omnimate_listeners", "Clients of the stream", registry=registry).set(parts.hub.listeners)
    Gauge("omnimate_bus_up", "Whether the bus is read", registry=registry).set(parts.live.problem is None)
    _nodes(parts, registry)
    _states(parts, registry)
    return generate_latest(calls.registry) + generate_latest(registry), CONTENT_TYPE_LATEST


def _nodes(parts: Parts, registry: CollectorRegistry) -> None:
    counters = {
        name: Counter(f"omnimate_node_{name}", f"Of each node: {name}", ["node"], registry=registry)
        for name in ("received", "missing", "restarts", "emergencies")
    }
    well = Gauge("omnimate_node_well", "Whether a node works", ["node"], registry=registry)
    for node in parts.live.report.nodes if parts.live.report else ():
        for name, counter in counters.items():
            counter.labels(str(node.node)).inc(getattr(node, name))
        well.labels(str(node.node)).set(node.is_well)


def _states(parts: Parts, registry: CollectorRegistry) -> None:
    with parts.database.reading() as db:
        for name, table in (("sessions", SessionRow), ("jobs", JobRow)):
            gauge = Gauge(f"omnimate_{name}", f"{name} by state", ["state"], registry=registry)
            for state, count in db.execute(select(table.state, func.count()).group_by(table.state)):
                gauge.labels(state).set(count)
