"""Every text of the page has a German one in `service/page/german.json`."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from string import Formatter

import pytest

from omnimate.effects import EFFECTS

PAGE = Path(__file__).parents[2] / "service/page"
GERMAN = json.loads((PAGE / "german.json").read_text(encoding="utf-8"))
SCRIPTS = sorted(PAGE.glob("*.js"))
LITERAL = r'"((?:[^"\\\n]|\\.)*)"'
SAME = {  # units, directions and names that are the same in both languages
    "mm", "cw", "ccw", "max,syst", "OmniMate", "UMBmark", "openapi.json", "vehicle.toml",
    "ros2_controllers (YAML)", "VDA 5050 wheelDefinitions",
}  # fmt: skip
NO_TEXT = {"Escape", "Bearer ${key()}", "Deutsch", "English"}


class Texts(HTMLParser):
    """Collects the texts of a document that a person reads."""

    def __init__(self):
        super().__init__()
        self.texts, self.in_code = [], False

    def handle_starttag(self, tag, attrs):
        self.in_code = tag == "code"
        self.texts += [value for name, value in attrs if name in {"aria-label", "title"}]

    def handle_endtag(self, tag):
        self.in_code = False

    def handle_data(self, data):
        if not self.in_code and re.search("[A-Za-z]{2}", data):
            self.texts.append(data.strip())


def texts_of_html():
    parser = Texts()
    for path in PAGE.glob("*.html"):
        parser.feed(path.read_text(encoding="utf-8"))
    return set(parser.texts) - SAME


def texts_of_scripts():
    scripts = "".join(path.read_text(encoding="utf-8") for path in SCRIPTS)
    return set(re.findall(rf"\bt\({LITERAL}", scripts))


def test_every_text_of_the_page_is_there_in_german_and_no_other_is():
    assert set(GERMAN) == texts_of_html() | texts_of_scripts()


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_no_script_writes_a_text_without_its_translation(path):
    code = re.sub(r"^\s*(//|/\*\*).*$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    code = re.sub(rf"\bt\({LITERAL}", "", code)
    words = re.findall(r'["`] ?([A-Z][a-z]+(?:[ .:…][^"`\n]*)?)["`]', code)
    assert set(words) <= NO_TEXT


def values(text):
    return sorted(name for _, name, _, _ in Formatter().parse(text) if name)


def test_a_german_text_has_the_values_of_the_english_one():
    assert [
        (english, german) for english, german in GERMAN.items() if values(english) != values(german)
    ] == []


def test_every_effect_and_every_component_has_a_german_name():
    components = {component for effect in EFFECTS for component in effect.components}
    names = {effect.name for effect in EFFECTS} | components
    assert {name for name in names if GERMAN.get(name, name) == name} == set()
