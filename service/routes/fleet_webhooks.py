"""Findings over REST, and the webhooks to which they are sent."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as PathParameter
from fastapi.responses import Response
from sqlalchemy.orm import Session as Db

from omnimate.service.calls import Answer, Operating, Reading
from omnimate.service.fleets.models import Delivery, Finding, FindingState, Webhook, WebhookStart
from omnimate.service.fleets.webhooks import add_webhook, remove_webhook, webhook_view
from omnimate.service.routes.common import ALWAYS, After, Done, Limit, Page
from omnimate.service.routes.fleets import PREFIX, FleetName
from omnimate.service.store.tables import DeliveryRow, FindingRow, FleetRow, WebhookRow, find_row, read_page
from omnimate.service.umbmark.models import Id

router = APIRouter(prefix=PREFIX, tags=["fleets"], responses=ALWAYS)
WebhookId = Annotated[Id, PathParameter(description="The id of the webhook.")]


@router.get("/{fleet}/findings")
def list_findings(
    fleet: FleetName,
    call: Reading,
    state: FindingState | None = None,
    limit: Limit = 50,
    after: After = None,
) -> Page[Finding]:
    """Return the findings of a fleet, newest first."""
    where = [FindingRow.fleet == fleet, *([FindingRow.state == state] if state else [])]
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
        rows, next_page = read_page(db, FindingRow, limit, after, *where)
        return Page(items=[Finding.of(row) for row in rows], next=next_page)


@router.post("/{fleet}/webhooks", status_code=201, response_model=Webhook)
def create_webhook(fleet: FleetName, body: WebhookStart, call: Operating) -> Response:
    """Have findings sent to an address. The answer holds the secret that signs them, this once."""

    def act(db: Db) -> Answer:
        find_row(db, FleetRow, fleet)
        row = add_webhook(db, fleet, body.url)
        location = {"Location": f"{PREFIX}/{fleet}/webhooks/{row.id}"}
        return Answer(webhook_view(row, whole=True), 201, location)

    return call.change(body, act)


@router.get("/{fleet}/webhooks")
def list_webhooks(fleet: FleetName, call: Reading, limit: Limit = 50, after: After = None) -> Page[Webhook]:
    """Return the webhooks of a fleet, newest first."""
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
        rows, next_page = read_page(db, WebhookRow, limit, after, WebhookRow.fleet == fleet)
        return Page(items=[webhook_view(row) for row in rows], next=next_page)


@router.get("/{fleet}/webhooks/{webhook_id}")
def get_webhook(fleet: FleetName, webhook_id: WebhookId, call: Reading) -> Webhook:
    """Return a webhook without its secret."""
    with call.components.database.reading() as db:
        return webhook_view(find_row(db, WebhookRow, webhook_id, fleet=fleet))


@router.delete("/{fleet}/webhooks/{webhook_id}", response_model=Done)
def delete_webhook(fleet: FleetName, webhook_id: WebhookId, call: Operating) -> Response:
    """Remove a webhook; messages that wait for it are given up."""

    def act(db: Db) -> Answer:
        remove_webhook(db, find_row(db, WebhookRow, webhook_id, fleet=fleet))
        return Answer(Done(done=f"webhook {webhook_id} is removed"))

    return call.change(None, act)


@router.get("/{fleet}/webhooks/{webhook_id}/deliveries")
def list_deliveries(
    fleet: FleetName,
    webhook_id: WebhookId,
    call: Reading,
    limit: Limit = 50,
    after: After = None,
) -> Page[Delivery]:
    """Return the messages to a webhook, newest first: waiting, accepted or given up."""
    with call.components.database.reading() as db:
        find_row(db, WebhookRow, webhook_id, fleet=fleet)
        rows, next_page = read_page(db, DeliveryRow, limit, after, DeliveryRow.webhook == webhook_id)
        return Page(items=[Delivery.of(row) for row in rows], next=next_page)
