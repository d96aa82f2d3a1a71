"""The daily report of a fleet in words, and its figures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.cli.console import say
from omnimate.cli.tables import new_table, show
from omnimate.fleet.report import (
    describe_effect,
    describe_mismatch,
    display_unit,
    format_onset,
    format_rate,
    format_size,
)

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.figures.fleet import MapPlace
    from omnimate.fleet.model.histories import History
    from omnimate.fleet.report import BadPlace, Change, DailyReport


def show_daily_report(report: DailyReport) -> None:
    """Print a daily report: recordings judged, faulty robots, bad places, and what failed."""
    floors = ", ".join(
        f"floor {floor.floor} {1e3 * floor.roughness:.2f}".replace("  ", " ") for floor in report.floors
    )
    say(
        f"{report.day}: {report.recordings} recordings, {len(report.changes)} robots judged, "
        f"{len(report.faulty)} faulty, {len(report.places)} bad places; {floors} mm/sqrt(m)"
    )
    if report.faulty:
        rows: list[tuple[str, ...]] = [
            (change.robot, change.name, format_onset(change), format_size(change), format_rate(change))
            for change in report.faulty
        ]
        show(new_table("faulty robots", ("robot", "what", "since", "by", "a day"), rows=rows))
    if report.places:
        heads = ("floor", "x [m]", "y [m]", "+- [m]", "what", "a crossing [mm]", "crossings")
        first = 0 if len(report.floors) > 1 else 1  # the name of the only floor is left out
        rows = [_place_cells(place)[first:] for place in report.places]
        show(new_table("bad places", heads[first:], rows=rows))
    for mismatch in report.repeated:
        say(describe_mismatch(mismatch))
    for robot, recording, why in report.failed:
        say(f"{robot}, {recording}: no results: {why}")


def _place_cells(place: BadPlace) -> tuple[str, ...]:
    spread = math.sqrt(0.5 * float(np.trace(place.covariance)))
    return (
        place.floor,
        f"{place.x:.2f}",
        f"{place.y:.2f}",
        f"{spread:.2f}",
        describe_effect(place),
        f"{1e3 * place.per_crossing:.1f}",
        f"{place.crossings}",
    )


def draw_daily_report(report: DailyReport, folder: Path) -> None:
    """Draw the floor, and the history of every faulty robot's parameter, into a folder.

    Raises:
        PlotError: A file cannot be written.
    """
    from omnimate.figures.fleet import plot_floor_map

    folder.mkdir(parents=True, exist_ok=True)
    for floor, driven in report.driven.items():
        places = [_on_map(place) for place in report.places if place.floor == floor]
        words = f"floor {floor}" if floor else "the floor"
        path = folder / (f"floor-{floor}.png" if floor else "floor.png")
        plot_floor_map(places, driven, path, title=f"{report.day}: bad places of {words}")
    histories = {history.robot: history for history in report.histories}
    for change in report.faulty:
        _draw_history(change, histories[change.robot], folder / f"{change.robot}.png")


def _on_map(place: BadPlace) -> MapPlace:
    from omnimate.figures.fleet import MapPlace

    return MapPlace(
        place.effect,
        place.x,
        place.y,
        place.reach,
        place.covariance,
        f"{1e3 * place.per_crossing:.1f} mm",
        place.size if place.effect == "creep" else None,
    )


def _draw_history(change: Change, history: History, path: Path) -> None:
    from omnimate.figures.fleet import plot_history

    column = history.names.index(change.name)
    factor, unit = display_unit(change.name)
    plot_history(
        history.days,
        factor * history.value[:, column],
        factor * np.sqrt(history.covariance[:, column, column]),
        path,
        since=float(history.days[history.dates.index(change.since)]),
        label=f"{change.name} relative to file [{unit}]",
        title=change.robot,
    )
