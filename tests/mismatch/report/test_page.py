"""The report: one page, nothing outside itself, nothing that a name could break."""

from dataclasses import replace
from html.parser import HTMLParser

import pytest

from omnimate.mismatch import Diagnosis
from omnimate.mismatch.diagnosis import Calibrated, Parameter
from omnimate.mismatch.report.page import render

VOID = {"meta", "br", "line", "circle", "rect", "polyline"}
OPEN = {"th", "li"}


class Balanced(HTMLParser):
    """Keeps the tags that are open."""

    def __init__(self):
        super().__init__()
        self.open, self.seen = [], []

    def handle_starttag(self, tag, _attrs):
        self.seen.append(tag)
        if tag not in VOID | OPEN:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID | OPEN:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def diagnosis(diagnosed, effect):
    return diagnosed(effect("wheel_diameter", "a.left", ratio=1.004))


def test_every_finding_is_on_a_page_with_balanced_tags(diagnosis):
    page = render(diagnosis)
    parser = Balanced()
    parser.feed(page)
    assert parser.open == []
    assert parser.seen.count("article") == len(diagnosis.findings)
    assert "svg" in parser.seen


def test_the_page_needs_nothing_outside_itself(diagnosis):
    page = render(diagnosis)
    assert "http" not in page
    assert "src=" not in page
    assert "<script" not in page
    assert len(page) < 2_000_000


def test_what_is_calibrated_beside_the_findings_is_shown(diagnosis):
    number = Calibrated("wheelbase", "b", (Parameter("ratio", 1.0123, 0.001, "1"),))
    assert "Calibrated as well" not in render(replace(diagnosis, calibrated=()))
    page = render(replace(diagnosis, calibrated=(number,)))
    assert "Calibrated as well" in page
    assert "1.0123" in page


def test_a_hostile_name_is_text(diagnosis):
    bad = "<script>alert(1)</script>"
    page = render(replace(diagnosis, robot=bad, recordings=(bad,), says=bad))
    assert bad not in page
    assert "&lt;script&gt;" in page


def test_an_answer_without_any_fit_has_a_page():
    page = render(
        Diagnosis("insufficient", "too little", robot="r", recordings=("x",), drive_next=("a lap",))
    )
    assert "a lap" in page
