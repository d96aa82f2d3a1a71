"""A fleet's results over REST: daily reports, floors, robots, findings and the webhooks that get them."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query
from fastapi import Path as PathParameter
from fastapi.responses import HTMLResponse, Response
from sqlalchemy.orm import Session as Db

from omnimate.fleet.batch.files import Files
from omnimate.fleet.report_store import list_days
from omnimate.service.calls import Answer, Call, Operating, Reading
from omnimate.service.fleets import models, webhooks
from omnimate.service.fleets import results as views
from omnimate.service.routes.common import ALWAYS, After, Done, Limit, Page
from omnimate.service.routes.diagnoses import REPORT_HEADERS
from omnimate.service.routes.fleets import PREFIX, FleetName, RobotName
from omnimate.service.store.tables import DeliveryRow, FindingRow, FleetRow, WebhookRow, find_row, read_page
from omnimate.service.umbmark.models import Id

router = APIRouter(prefix=PREFIX, tags=["fleets"], responses=ALWAYS)
ReportDay = Annotated[
    str,
    PathParameter(
        pattern=f"{models.DAY_PATTERN}|^{views.LATEST}$", description="Date of the report, or `latest`."
    ),
]
WebhookId = Annotated[Id, PathParameter(description="The id of the webhook.")]
RobotLimit = Annotated[int, Query(ge=1, le=2000, description="The largest number of items of the page.")]


@router.get("/{fleet}/nights")
def list_nights(
    fleet: FleetName, call: Reading, limit: Limit = 50, after: models.Day | None = None
) -> Page[str]:
    """Return the dates of the daily reports, newest first."""
    days = [day for day in list_days(_results(call, fleet)) if after is None or day < after]
    return Page(items=days[:limit], next=days[limit - 1] if len(days) > limit else None)


@router.get("/{fleet}/nights/{day}")
def get_night(fleet: FleetName, day: ReportDay, call: Reading) -> models.FleetNight:
    """Return a daily report: faulty robots (`sick`), bad places, and recordings that failed."""
    return views.report_view(views.report_of(_results(call, fleet), day))


@router.get("/{fleet}/nights/{day}/floor")
def get_floor(
    fleet: FleetName,
    day: ReportDay,
    call: Reading,
    floor: Annotated[
        str | None,
        Query(
            max_length=64,
            pattern=f"^$|{models.PLAIN_PATTERN}",
            description="That with most recordings by default.",
        ),
    ] = None,
) -> models.FleetFloor:
    """Return a floor as of a daily report: where robots drove, and its bad places."""
    results = _results(call, fleet)
    return views.floor_view(results, views.report_of(results, day), floor)


@router.get("/{fleet}/robots")
def list_robots(
    fleet: FleetName,
    call: Reading,
    state: models.State | None = None,
    limit: RobotLimit = 200,
    after: models.PlainName | None = None,
) -> Page[models.FleetRobot]:
    """Return the robots as of the latest report, in the order of their names."""
    results = _results(call, fleet)
    robots = [
        robot
        for robot in views.robots_view(results, views.latest_report(results))
        if (state is None or robot.state == state) and (after is None or robot.robot > after)
    ]
    return Page(items=robots[:limit], next=robots[limit - 1].robot if len(robots) > limit else None)


@router.get("/{fleet}/robots/{robot}")
def get_fleet_robot(fleet: FleetName, robot: RobotName, call: Reading) -> models.FleetRobot:
    """Return a robot as of the latest report."""
    return views.robot_view(_results(call, fleet), robot)


@router.get("/{fleet}/robots/{robot}/history")
def get_history(fleet: FleetName, robot: RobotName, call: Reading) -> models.FleetHistory:
    """Return a robot's numbers day by day, without the effect of bad places."""
    return views.history_view(_results(call, fleet), robot)


@router.get("/{fleet}/robots/{robot}/recordings")
def list_robot_recordings(
    fleet: FleetName,
    robot: RobotName,
    call: Reading,
    limit: Limit = 50,
    after: Annotated[str | None, Query(max_length=100, pattern=models.PLAIN_PATTERN)] = None,
) -> Page[models.FleetRecording]:
    """Return the results of a robot's recordings, newest first."""
    results = _results(call, fleet)
    views.robot_view(results, robot)
    items, next_page = views.recordings_view(results, robot, limit, after)
    return Page(items=items, next=next_page)


@router.get("/{fleet}/robots/{robot}/report", response_class=HTMLResponse)
def get_robot_report(fleet: FleetName, robot: RobotName, call: Reading) -> Response:
    """Return the finding's report as an HTML page that needs no other file."""
    from omnimate.service.fleets.report import render

    results = _results(call, fleet)
    history = views.history_view(results, robot)
    recordings, _ = views.recordings_view(results, robot, 30, None)
    return HTMLResponse(render(fleet, history, recordings), headers=REPORT_HEADERS)


@router.get("/{fleet}/findings")
def list_findings(
    fleet: FleetName,
    call: Reading,
    state: models.FindingState | None = None,
    limit: Limit = 50,
    after: After = None,
) -> Page[models.Finding]:
    """Return the findings of a fleet, newest first."""
    where = [FindingRow.fleet == fleet, *([FindingRow.state == state] if state else [])]
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
        rows, next_page = read_page(db, FindingRow, limit, after, *where)
        return Page(items=[models.Finding.of(row) for row in rows], next=next_page)


@router.post("/{fleet}/webhooks", status_code=201, response_model=models.Webhook)
def create_webhook(fleet: FleetName, body: models.WebhookStart, call: Operating) -> Response:
    """Have findings sent to an address. The answer holds the secret that signs them, this once."""

    def act(db: Db) -> Answer:
        find_row(db, FleetRow, fleet)
        row = webhooks.add_webhook(db, fleet, body.url)
        location = {"Location": f"{PREFIX}/{fleet}/webhooks/{row.id}"}
        return Answer(webhooks.webhook_view(row, whole=True), 201, location)

    return call.change(body, act)


@router.get("/{fleet}/webhooks")
def list_webhooks(
    fleet: FleetName, call: Reading, limit: Limit = 50, after: After = None
) -> Page[models.Webhook]:
    """Return the webhooks of a fleet, newest first."""
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
        rows, next_page = read_page(db, WebhookRow, limit, after, WebhookRow.fleet == fleet)
        return Page(items=[webhooks.webhook_view(row) for row in rows], next=next_page)


@router.get("/{fleet}/webhooks/{webhook_id}")
def get_webhook(fleet: FleetName, webhook_id: WebhookId, call: Reading) -> models.Webhook:
    """Return a webhook without its secret."""
    with call.components.database.reading() as db:
        return webhooks.webhook_view(find_row(db, WebhookRow, webhook_id, fleet=fleet))


@router.delete("/{fleet}/webhooks/{webhook_id}", response_model=Done)
def delete_webhook(fleet: FleetName, webhook_id: WebhookId, call: Operating) -> Response:
    """Remove a webhook; messages that wait for it are given up."""

    def act(db: Db) -> Answer:
        webhooks.remove_webhook(db, find_row(db, WebhookRow, webhook_id, fleet=fleet))
        return Answer(Done(done=f"webhook {webhook_id} is removed"))

    return call.change(None, act)


@router.get("/{fleet}/webhooks/{webhook_id}/deliveries")
def list_deliveries(
    fleet: FleetName,
    webhook_id: WebhookId,
    call: Reading,
    limit: Limit = 50,
    after: After = None,
) -> Page[models.Delivery]:
    """Return the messages to a webhook, newest first: waiting, accepted or given up."""
    with call.components.database.reading() as db:
        find_row(db, WebhookRow, webhook_id, fleet=fleet)
        rows, next_page = read_page(db, DeliveryRow, limit, after, DeliveryRow.webhook == webhook_id)
        return Page(items=[models.Delivery.of(row) for row in rows], next=next_page)


def _results(call: Call, fleet: str) -> Files:
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
    return call.components.stores.results_of(fleet)
