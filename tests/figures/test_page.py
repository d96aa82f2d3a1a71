"""Figures inside a page: an element in the page's colours, which needs nothing outside the page."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from omnimate.figures.page import VARIABLES, css, embedded, panel
from omnimate.figures.style import STYLE


def drawn(title="a figure", label="x [m]"):
    axes = panel(300.0, 200.0, label, "y [m]")
    axes.plot(np.arange(5), np.arange(5) ** 2, "o-", color=css("before"))
    axes.scatter([1.0], [2.0], facecolors="none", edgecolors=css("c5"))
    return embedded(axes, title)


def test_the_same_figure_is_the_same_text():
    assert drawn() == drawn()


def test_every_colour_is_a_variable_of_the_page():
    text = drawn()
    assert {f"var(--{name})" for name in ("before", "c5", "line", "soft")} <= set(
        re.findall(r"var\([\w-]+\)", text)
    )
    assert re.findall(r"(?:fill|stroke): (?!none|var\()[^;\"]*", text) == []


def test_every_variable_has_a_colour_that_no_other_figure_has():
    colours = {css(variable) for variable in VARIABLES}
    assert len(colours) == len(VARIABLES)
    assert not colours & set(STYLE.values())


def test_the_element_is_well_formed_and_of_the_size_that_was_asked_for():
    element = ET.fromstring(drawn().replace("xlink:", ""))
    assert element.tag == "svg"
    assert element.get("viewBox") == "0 0 300 200"


def test_the_element_needs_nothing_outside_itself_and_styles_nothing_else():
    text = drawn()
    assert "http" not in text
    assert "<style" not in text
    assert "font-family" not in text


def test_elements_of_two_figures_share_no_name_unless_they_are_the_same():
    axes = panel(300.0, 150.0, "x [m]", "y [m]")
    axes.plot([0.0, 1.0], [0.0, 1.0], color=css("after"))
    named = [
        dict(re.findall(r'id="(\w+)"[^>]*>(.*?)</', text, re.DOTALL))
        for text in (drawn(), embedded(axes, ""))
    ]
    assert all(named)
    assert all(named[0][name] == named[1][name] for name in named[0].keys() & named[1].keys())


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", 'a "quoted" name'])
def test_a_hostile_name_is_text(name):
    assert name not in drawn(title=name)
    assert "<script" not in drawn(label=name)
