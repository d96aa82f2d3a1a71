"""The benchmarks: each is listed with its peer, and says how it is run."""

import ast
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[3] / "studies"
MODULES = {
    ".".join(path.relative_to(FOLDER).with_suffix("").parts): path.read_text(encoding="utf-8")
    for path in FOLDER.rglob("[!_]*.py")
}
NAMES = sorted(name for name, text in MODULES.items() if "Usage: python -m" in text)


def test_the_list_names_every_benchmark_and_no_other():
    rows = [line.split("|") for line in (FOLDER / "README.md").read_text(encoding="utf-8").splitlines()]
    assert sorted(row[1].strip(" `") for row in rows if len(row) == 5 and "`" in row[1]) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_benchmark_names_its_peer_and_its_command(name):
    text = ast.get_docstring(ast.parse(MODULES[name]))
    assert "\nPeer" in text
    assert f"\nUsage: python -m studies.{name}" in text
