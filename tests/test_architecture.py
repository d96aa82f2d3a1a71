"""The rooms: who may import whom, which libraries belong to which rooms; neither table says too much."""

import ast
import re
import sys
from functools import cache
from pathlib import Path

import pytest

from docs.generate.tables import imported_rooms
from omnimate.effects import EFFECTS

ROOT = Path(__file__).resolve().parents[1]
MAY_IMPORT = {
    "vehicle": set(),
    "files": {"vehicle", "ipec"},
    "motion": {"vehicle"},
    "driver": {"vehicle", "files"},
    "listen": {"vehicle", "files"},
    "ipec": {"vehicle"},
    "calib": {"vehicle", "ipec"},
    "effects": {"vehicle"},
    "vcan_sim": {"vehicle", "files", "motion", "effects"},
    "mismatch": {"vehicle", "effects", "figures"},
    "fleet": {"vehicle", "files", "motion", "calib", "ipec", "vcan_sim", "mismatch"},
    "figures": {"vehicle", "calib"},
    "client": {"vehicle", "files"},
    "service": {
        *("vehicle", "files", "motion", "driver", "calib", "ipec", "vcan_sim"),
        *("mismatch", "fleet", "figures"),
    },
    "cli": {
        *("vehicle", "files", "motion", "driver", "listen", "calib", "ipec", "effects", "vcan_sim"),
        *("mismatch", "fleet", "figures", "service"),
    },
}
ONLY_IN = {
    "alembic": {"service"},
    "asammdf": {"files"},
    "can": {"files", "driver", "vcan_sim", "service"},
    "canopen": {"driver", "vcan_sim"},
    "cantools": {"files"},
    "distributed": {"fleet"},
    "fastapi": {"service"},
    "fsspec": {"fleet"},
    "matplotlib": {"figures"},
    "mcap": {"files"},
    "numba": {"vehicle"},
    "paho": {"service"},
    "prometheus_client": {"service"},
    "pyarrow": {"files", "fleet"},
    "pydantic": {"service"},
    "rich": {"cli"},
    "rosbags": {"files"},
    "scipy": {"calib", "fleet", "mismatch"},
    "sqlalchemy": {"service"},
    "starlette": {"service"},
    "textual": {"cli"},
    "threadpoolctl": {"mismatch"},
    "tomli_w": {"vehicle", "files", "calib", "effects", "fleet"},
    "typer": {"cli"},
    "uvicorn": {"cli"},
}
FILES = {room: sorted((ROOT / room).rglob("*.py")) for room in MAY_IMPORT}
EVERYWHERE = {"numpy", "omnimate", *sys.stdlib_module_names}
# A learned law, and how poses are measured, are a part of the method.
GENERAL = {"omnimate.effects.law", "omnimate.effects.reference_offset"}
MISMATCH_LAYERS = ("recording", "noise", "candidates", "evidence", "scans", "learn", "answer", "report")
MODULE = re.compile(r"omnimate(\.\w+)+")


def modules_named(path):
    """Yield every module that a file imports, or names in a string that is not a docstring."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    prose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
            match = MODULE.match(node.value)
            if match:
                yield match[0]


@cache
def rooms_and_libraries(room):
    """Return the other rooms and the libraries that a room's files name."""
    names = [name.split(".") for path in FILES[room] for name in modules_named(path)]
    rooms = {parts[1] for parts in names if parts[0] == "omnimate" and len(parts) > 1} - {room}
    return rooms & set(MAY_IMPORT), {parts[0] for parts in names}


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_a_room_imports_the_rooms_that_it_may_and_the_table_allows_no_more_than_that(room):
    assert rooms_and_libraries(room)[0] == MAY_IMPORT[room]


@pytest.mark.parametrize("library", ONLY_IN)
def test_a_library_is_used_in_its_rooms_and_in_all_of_them(library):
    assert {room for room in FILES if library in rooms_and_libraries(room)[1]} == ONLY_IN[library]


def test_every_library_but_numpy_has_its_rooms():
    used = set().union(*(rooms_and_libraries(room)[1] for room in FILES))
    assert used - EVERYWHERE - {"studies"} == set(ONLY_IN)


def test_every_package_at_the_top_level_is_a_room():
    assert {path.parent.name for path in ROOT.glob("*/__init__.py")} == {*MAY_IMPORT, "studies"}


@pytest.mark.parametrize("room", FILES)
def test_every_folder_of_a_room_that_holds_code_is_a_package_and_says_what_it_is_for(room):
    for folder in {path.parent for path in FILES[room]}:
        text = (folder / "__init__.py").read_text(encoding="utf-8")
        assert ast.get_docstring(ast.parse(text)), f"{folder} does not say what it is for"


@pytest.mark.parametrize("room", FILES)
def test_a_room_does_not_import_the_public_interface_which_imports_the_rooms(room):
    for path in FILES[room]:
        names = [name.split(".") for name in modules_named(path)]
        others = {parts[1] for parts in names if parts[0] == "omnimate" and len(parts) > 1} - set(MAY_IMPORT)
        assert others <= {"__version__"}, f"{path} imports {others}"


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_the_page_on_the_architecture_lists_what_a_room_imports(room):
    assert imported_rooms(ROOT / room) == MAY_IMPORT[room]


def test_the_diagnosis_knows_no_effect_by_its_name():
    """Whatever it needs to know of an effect stands in the effect's own file."""
    particular = [kind for kind in EFFECTS if kind.__module__ not in GENERAL]
    names, own = {kind.name for kind in particular}, {kind.__module__ for kind in particular}
    for path in FILES["mismatch"]:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
        assert not {text for text in texts if isinstance(text, str)} & names, path
        assert not {module.rpartition(".")[0] for module in imports(path)} & own, path


def test_no_two_rooms_import_each_other_even_by_a_way_round():
    open_rooms = dict(MAY_IMPORT)
    while open_rooms:
        free = [room for room, needs in open_rooms.items() if not needs & set(open_rooms)]
        assert free, f"a circle among {sorted(open_rooms)}"
        for room in free:
            del open_rooms[room]


@pytest.mark.parametrize("room", FILES)
def test_no_two_modules_of_a_room_import_each_other_not_even_for_their_types(room):
    names = {module_of(path): path for path in FILES[room]}
    needs = {
        name: {part for module in imports(path) for part in (module, module.rpartition(".")[0])} & set(names)
        for name, path in names.items()
    }
    while needs:
        free = [name for name, others in needs.items() if not (others - {name}) & set(needs)]
        assert free, f"{room}: a circle among {sorted(needs)}"
        for name in free:
            del needs[name]


def test_a_folder_of_the_diagnosis_imports_only_the_folders_below_it():
    for number, folder in enumerate(MISMATCH_LAYERS):
        for path in (ROOT / "mismatch" / folder).glob("*.py"):
            others = {
                module.split(".")[2] for module in imports(path) if module.startswith("omnimate.mismatch.")
            }
            assert not others & set(MISMATCH_LAYERS[number + 1 :]), path


def module_of(path):
    """Return the name by which a file is imported; a folder's `__init__.py` has the folder's."""
    return ".".join(("omnimate", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")


def imports(path):
    """Yield the modules that a file imports, at its top, in a function, or for its types alone."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
