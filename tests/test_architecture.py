"""The rooms: who may import whom, and which libraries belong to one room alone."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MAY_IMPORT = {
    "vehicle": set(),
    "motion": {"vehicle"},
    "driver": {"vehicle"},
    "ipec": {"vehicle"},
    "calib": {"ipec", "vehicle"},
    "vcan_sim": {"motion", "vehicle"},
    "mismatch": {"vehicle", "calib", "ipec", "vcan_sim"},
    "proof": set(),
    "reproduction": {"vehicle", "motion", "calib", "ipec", "vcan_sim"},
    "imports": {"vehicle", "calib"},
    "figures": {"vehicle", "calib"},
    "service": {
        *("vehicle", "motion", "driver", "calib", "ipec", "vcan_sim"),
        *("mismatch", "figures"),
    },
    "cli": {
        *("vehicle", "motion", "driver", "calib", "ipec", "vcan_sim"),
        *("mismatch", "proof", "reproduction", "imports", "figures", "service"),
    },
}
ONLY_IN = {
    "canopen": {"driver", "vcan_sim"},
    "typer": {"cli"},
    "rich": {"cli"},
    "matplotlib": {"cli", "figures"},
    "fastapi": {"service"},
    "sqlalchemy": {"service"},
    "numba": {"vehicle"},
    "rosbags": {"imports"},
}
FILES = sorted(path for room in MAY_IMPORT for path in (ROOT / room).rglob("*.py"))


def imports(path):
    """Yield the first name of every module that a file imports, wherever the import stands."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module.split(".")[0]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_room_imports_only_the_rooms_and_libraries_that_it_may(path):
    room = path.relative_to(ROOT).parts[0]
    for name in imports(path):
        if name in MAY_IMPORT and name != room:
            assert name in MAY_IMPORT[room], f"{room} must not import {name}"
        if name in ONLY_IN:
            assert room in ONLY_IN[name], f"{name} belongs to {sorted(ONLY_IN[name])}"


def test_the_vehicle_room_needs_more_than_numpy_in_named_files_only():
    others = {"can": {"foreign_logs.py"}, "numba": {"compiled.py"}, "tomli_w": {"file.py", "folder.py"}}
    for path in (ROOT / "vehicle").rglob("*.py"):
        for name, files in others.items():
            assert name not in imports(path) or path.name in files


def test_every_room_says_that_it_is_typed_and_what_it_is_for():
    for room in MAY_IMPORT:
        assert (ROOT / room / "py.typed").is_file()
        assert ast.get_docstring(ast.parse((ROOT / room / "__init__.py").read_text(encoding="utf-8")))
