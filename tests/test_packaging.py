"""The package: every room but the studies, every file of a room, the version, and the extras."""

import re
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

import omnimate

ROOT = Path(__file__).resolve().parents[1]
STUDIES = {"studies"}
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGED = SETTINGS["tool"]["setuptools"]
EXTRAS = SETTINGS["project"]["optional-dependencies"]
NAMED = re.compile(r"(?:omnimate|'\.)\[([a-z,]+)\]")


def folder_of(package):
    """Return the folder of a package, relative to the project."""
    return Path(*package.split(".")[1:])


def test_every_package_but_the_studies_is_in_the_wheel_and_nothing_else():
    rooms = {path.parents[0].name for path in ROOT.glob("*/__init__.py")} - STUDIES
    folders = {path.parent.relative_to(ROOT) for room in rooms for path in (ROOT / room).rglob("__init__.py")}
    listed = [folder_of(package) for package in PACKAGED["packages"]]
    assert len(listed) == len(set(listed))
    assert set(listed) == folders | {Path()}


@pytest.mark.parametrize("room", sorted({package.split(".")[1] for package in PACKAGED["packages"][1:]}))
def test_every_file_of_a_room_is_code_of_a_package_or_data_of_one(room):
    packages = {folder_of(package): package for package in PACKAGED["packages"]}
    for path in (path.relative_to(ROOT) for path in (ROOT / room).rglob("*") if path.is_file()):
        if "__pycache__" in path.parts:
            continue
        if path.suffix == ".py":
            assert path.parent in packages, f"{path} is in no package"
        else:
            patterns = PACKAGED["package-data"].get(f"omnimate.{room}", [])
            inside = str(path.relative_to(room))
            assert any(fnmatch(inside, pattern) for pattern in patterns), f"{path} is no package data"


def test_the_newest_version_of_the_changelog_is_the_version_of_the_package():
    versions = re.findall(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert versions[0] == omnimate.__version__


def test_every_extra_that_code_or_a_page_or_another_extra_names_exists():
    rooms = {package.split(".")[1] for package in PACKAGED["packages"][1:]} | STUDIES
    files = [path for folder in (*rooms, "docs") for path in (ROOT / folder).rglob("*.[pm][yd]")]
    texts = [
        path.read_text(encoding="utf-8") for path in (*files, ROOT / "pyproject.toml", ROOT / "Makefile")
    ]
    named = {name for text in texts for names in NAMED.findall(text) for name in names.split(",")}
    assert {"service", "rosbag"} <= named <= set(EXTRAS)


def test_the_table_of_extras_has_every_extra_that_is_not_for_work_on_the_project_itself():
    page = (ROOT / "docs" / "reference" / "buses.md").read_text(encoding="utf-8")
    table = set(re.findall(r"^\| `([a-z0-9]+)` \| ", page.partition("## Extras")[2], re.MULTILINE))
    assert table == set(EXTRAS) - {"dev", "docs", "fuzz"}
