"""The report of a robot's finding: one self-contained HTML page."""

from __future__ import annotations

from datetime import date
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from omnimate.figures.page import css, embedded, panel
from omnimate.fleet.report import display_unit
from omnimate.mismatch.report.style import Head, html_report

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.service.fleets.models import FleetCourse, FleetHistory, FleetRecording

WIDTH, HEIGHT = 620.0, 220.0  # [px] of a plot
VERDICTS = {"fine": "agreement", "sick": "mismatch"}  # the report's classes of colour
HOW_TO_READ = (
    "A point is a day's estimate of a number of the robot, relative to its vehicle.toml; the bar holds "
    "95 %. The effect of bad places of the floor is taken out. The line is the day since which the number "
    "changed, most likely. A robot is faulty when its e-value passes the e-BH procedure at 1 % over the "
    "whole fleet; it drifts from an e-value of 20 on, which at most one healthy robot in twenty reaches."
)


def render(fleet: str, history: FleetHistory, recordings: Sequence[FleetRecording]) -> str:
    """Return the report of a robot."""
    robot = history.robot
    note = f"Fleet {fleet}; {robot.kind}" if robot.kind else f"Fleet {fleet}"
    colour = VERDICTS.get(robot.state, "insufficient")
    head = Head(
        "Report",
        robot.robot,
        "faulty" if robot.state == "sick" else robot.state,
        colour,
        robot.says or "Nothing stands out.",
        note,
    )
    sections = [
        *_evidence(history),
        "<h2>Day by day</h2>",
        *(_plot(course, history) for course in history.courses),
        "<h2>Recordings</h2>",
        *_recordings(recordings),
    ]
    return html_report(head, sections, HOW_TO_READ)


def _evidence(history: FleetHistory) -> Iterable[str]:
    change = history.robot.change
    if change is None:
        return
    factor, unit = display_unit(change.name)
    rows = {
        "number": change.name,
        "since": f"{change.since}, {change.earliest} to {change.latest} with 90 %",
        "changed by": f"{factor * change.size:+.3f} ± {1.96 * factor * change.sigma:.3f} {unit}",
        "a day": f"{factor * change.per_day:+.3f} {unit}" if change.shape == "ramp" else "no more",
        "e-value": f"10^{change.log_e / np.log(10.0):.1f}",
        "that it is this number": f"{100.0 * change.share:.0f} %",
    }
    cells = "".join(f"<tr><th scope=row>{key}</th><td>{escape(text)}</td></tr>" for key, text in rows.items())
    yield f"<h2>The likeliest change</h2><table>{cells}</table>"


def _plot(course: FleetCourse, history: FleetHistory) -> str:
    factor, unit = display_unit(course.name)
    days = np.array([date.fromisoformat(day).toordinal() for day in course.days], float)
    value, sigma = factor * np.array(course.value), factor * np.array(course.sigma)
    axes = panel(WIDTH, HEIGHT, f"days since {course.days[0]}", f"{course.name} [{unit}]")
    axes.errorbar(days - days[0], value, 1.96 * sigma, fmt="o", color=css("after"), ecolor=css("soft"), ms=4)
    change = history.robot.change
    if change is not None and history.robot.state != "fine" and change.name == course.name:
        since = date.fromisoformat(change.since).toordinal() - days[0] - 0.5
        axes.axvline(since, color=css("before"), linestyle="--")
    return f"<figure>{embedded(axes, f'{course.name} of {history.robot.robot}, day by day')}</figure>"


def _recordings(recordings: Sequence[FleetRecording]) -> Iterable[str]:
    yield "<table><tr><th>day</th><th>recording</th><th>triage</th><th>says</th></tr>"
    for recording in recordings:
        says = recording.problem or recording.diagnosis or recording.says or ""
        yield (
            f"<tr><td>{recording.day}</td><td>{escape(recording.recording)}</td>"
            f"<td>{escape(recording.triage or '-')}</td><td>{escape(says)}</td></tr>"
        )
    yield "</table>"
