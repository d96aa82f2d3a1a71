"""What the plots of a report show: every step of the path, the extremes of a trace, and all events."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.figures.page import SHADES, VARIABLES
from omnimate.mismatch.diagnosis import Diagnosis, Evidence, Finding, Signature, Trace, Where
from omnimate.mismatch.report.plots import _envelope, _levels, _steps, floor_plans, residual_traces, signature
from omnimate.mismatch.report.style import CSS

COUNT = 50


def diagnosis(*events):
    """Return a diagnosis of one recording, with events as (start, end) [s]."""
    angle = np.linspace(0.0, 2.0 * np.pi, COUNT)
    path = np.column_stack([np.cos(angle), np.sin(angle)])
    residual = np.column_stack([5.0 * np.sin(angle), np.full(COUNT, np.nan)])
    lap = np.repeat([0, 1], COUNT // 2)
    trace = Trace("drive", 100.0 + np.arange(COUNT, dtype=float), path, lap, residual, 0.1 * residual)
    where = Where(("joint_a",), events, "always", places=tuple((0.0, 0.0) for _ in events))
    finding = Finding("bump", "a.left", 0.99, (), where, (), 0.5)
    evidence = Evidence(channels=("joint_a", "link"), traces=(trace,))
    return Diagnosis("mismatch", "a bump", findings=(finding,), evidence=evidence)


@given(st.lists(st.integers(0, SHADES - 1), min_size=2, max_size=60))
def test_every_step_of_a_path_is_drawn_in_one_shade(levels):
    path = np.column_stack([np.arange(len(levels)), np.zeros(len(levels))])
    drawn = [
        (x, y)
        for shade in range(SHADES)
        for x, y, gap in _steps(path, np.array(levels) == shade)[0].reshape(-1, 3)
        if np.isnan(gap)
    ]
    assert sorted(drawn) == [(at, at + 1) for at in range(len(levels) - 1)]


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=2000))
def test_an_envelope_keeps_the_extremes_and_the_order(values):
    residual = np.array(values)
    time, kept = _envelope(np.arange(len(values), dtype=float), residual)
    assert (kept.min(), kept.max()) == (residual.min(), residual.max())
    assert np.all(np.diff(time) > 0.0)
    assert len(kept) <= min(len(values), 360)


def test_a_larger_residual_has_a_stronger_shade():
    shades = [int(_levels(np.full((20, 2), sigma))[10]) for sigma in (0.5, 1.0, 2.0, 3.0, 5.0, 50.0)]
    assert shades == sorted(shades)
    assert (shades[0], shades[-1]) == (0, SHADES - 1)


def test_channels_that_were_not_read_have_no_trace():
    page = residual_traces(diagnosis())
    assert page.count("<figure>") == 1
    assert "joint_a" in page


@pytest.mark.parametrize("events", [(), ((110.0, 110.001), (120.0, 125.0))])
def test_every_event_is_marked_in_the_traces_and_on_the_floor_plan_of_the_nominal_robot(events):
    assert residual_traces(diagnosis(*events)).count("var(--band)") == len(events)
    nominal, explained = floor_plans(diagnosis(*events)).split("nominal robot")
    assert nominal.count("var(--ink)") == len(events)
    assert "var(--ink)" not in explained


def test_a_signature_shows_what_was_found_and_what_was_predicted():
    at = np.linspace(-1.0, 1.0, 5)
    text = signature(Signature(0, "turn rate [degrees/s]", "joint_a", at, at, 0.1 + 0.0 * at, 0.9 * at))
    assert {"var(--before)", "var(--after)"} <= set(re.findall(r"var\([\w-]+\)", text))
    assert "turn rate [degrees/s]" in text


def test_the_style_sheet_defines_every_colour_of_the_figures_in_light_and_in_dark():
    for variable in VARIABLES:
        assert CSS.count(f"--{variable}:#") == 2, variable
