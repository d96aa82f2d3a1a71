"""Compiled functions: compiled at the first call, kept by content, and never stale; and their records."""

import importlib
import os
import shutil
import subprocess
import sys
from typing import Annotated

import numpy as np
import pytest

from omnimate.vehicle.compiled import Array, IntArray, compiled, layout, record


class Fields:
    number: int
    value: float
    place: Annotated[Array, (2, 3)]
    counts: Annotated[IntArray, 4]


def test_a_record_has_the_annotated_fields_in_their_order_and_shape():
    kind = layout(Fields)
    assert kind.names == ("number", "value", "place", "counts")
    assert kind["number"] == np.int64
    assert kind["value"] == np.float64
    assert (kind["place"].shape, kind["counts"].shape) == ((2, 3), (4,))
    assert kind["counts"].base == np.int64


def test_a_new_record_is_one_and_all_zero():
    one = record(Fields)
    assert one.shape == (1,)
    assert one["place"].sum() == 0.0


@compiled
def double(records):
    records[0].value = 2.0 * records[0].value
    records[0].place[1, 2] = records[0].value


def test_a_compiled_function_changes_the_record_it_is_given():
    one = record(Fields)
    one["value"] = 1.5
    double(one)
    assert one["value"][0] == 3.0
    assert one["place"][0, 1, 2] == 3.0


def test_it_keeps_name_and_documentation_and_the_plain_function():
    @compiled
    def halve(value):
        """Return half of it."""
        return 0.5 * value

    assert (halve.__name__, halve.__doc__) == ("halve", "Return half of it.")
    assert halve.__wrapped__(3.0) == 1.5


def plain(value):
    return value + 1.0


@compiled
def marked(value):
    return plain(value) * 2.0


@compiled
def caller(value):
    return marked(value)


@compiled
def factorial(number):
    if number < 2:
        return 1
    return number * factorial(number - 1)


@pytest.mark.usefixtures("cache")  # empty: what is loaded from it is not compiled again
def test_functions_that_it_calls_are_native_code_whether_they_are_marked_or_not():
    assert caller(3.0) == 8.0
    (overload,) = caller.native().overloads.values()
    assert not overload.objectmode
    assert len(marked.native().signatures) == len(compiled(plain).native().signatures) == 1


def test_it_may_call_itself():
    assert factorial(5) == 120


def test_marking_a_function_twice_gives_one_compiled_function():
    assert compiled(plain) is compiled(plain)


def test_numba_is_imported_when_the_first_function_is_called():
    program = """
import sys
from omnimate.vehicle.se2 import wrap_angle
assert not {"numba", "llvmlite"} & set(sys.modules)
wrap_angle(1.0)
assert "numba" in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Return an empty cache folder that compiled functions use now."""
    numba = pytest.importorskip("numba")
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def modules(tmp_path, monkeypatch):
    """Return a function that writes modules, all with the same date, and imports the first one again."""
    folder = tmp_path / "modules"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def load(**sources):
        for name, source in sources.items():
            path = folder / f"{name}.py"
            path.write_text("from omnimate.vehicle.compiled import compiled\n" + source)
            os.utime(path, (1e9, 1e9))
            sys.modules.pop(name, None)
        importlib.invalidate_caches()
        return importlib.import_module(next(iter(sources)))

    yield load
    for path in folder.glob("*.py"):
        sys.modules.pop(path.stem, None)


ABOVE = "from below import inner\n@compiled\ndef outer(x):\n    return inner(x) + 1.0\n"
BELOW = "LIMIT = 10.0\n@compiled\ndef inner(x):\n    return min(2.0 * x, LIMIT)\n"


def hits(function):
    return sum(function.native().stats.cache_hits.values())


@pytest.mark.usefixtures("cache")
def test_the_next_process_takes_it_from_the_disk(modules):
    assert modules(above=ABOVE, below=BELOW).outer(3.0) == 7.0
    again = modules(above=ABOVE, below=BELOW)
    assert again.outer(3.0) == 7.0
    assert hits(again.outer) == 1


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize(("old", "new"), [("2.0 *", "3.0 *"), ("10.0", "5.0")])
def test_a_change_below_is_compiled_anew_although_no_date_tells_of_it(modules, old, new):
    assert modules(above=ABOVE, below=BELOW).outer(4.0) == 9.0
    changed = modules(above=ABOVE, below=BELOW.replace(old, new))
    assert changed.outer(4.0) == {"2.0 *": 11.0, "10.0": 6.0}[old]
    assert hits(changed.outer) == 0
    back = modules(above=ABOVE, below=BELOW)
    assert back.outer(4.0) == 9.0
    assert hits(back.outer) == 1


@pytest.mark.usefixtures("cache")
def test_another_copy_of_the_same_code_takes_it_from_the_disk(modules, tmp_path, monkeypatch):
    """As another checkout of a release, or its installation in another environment."""
    assert modules(above=ABOVE, below=BELOW).outer(3.0) == 7.0
    copy = shutil.copytree(tmp_path / "modules", tmp_path / "copy", copy_function=shutil.copyfile)
    monkeypatch.syspath_prepend(str(copy))
    for name in ("above", "below"):
        sys.modules.pop(name)
    outer = importlib.import_module("above").outer
    assert outer.__wrapped__.__code__.co_filename.startswith(str(copy))
    assert outer(3.0) == 7.0
    assert hits(outer) == 1


@pytest.mark.usefixtures("cache")
def test_records_of_another_layout_are_compiled_anew(modules):
    source = "@compiled\ndef first(records):\n    return records[0].value\n"
    for kind in ([("value", "f8"), ("number", "i8")], [("number", "i8"), ("value", "f8")]):
        records = np.zeros(1, kind)
        records["number"], records["value"] = 7, 2.5
        assert modules(reader=source).first(records) == 2.5


def test_without_a_folder_to_write_into_it_compiles_all_the_same(cache, modules):
    cache.write_text("a file where the folder should be")
    module = modules(above=ABOVE, below=BELOW)
    assert module.outer(3.0) == 7.0
    assert cache.is_file()


@pytest.mark.usefixtures("modules")
def test_a_function_that_no_file_holds_is_compiled_without_a_disk_cache(cache):
    scope = {}
    exec("def triple(x):\n    return 3.0 * x\n", scope)
    assert compiled(scope["triple"])(2.0) == 6.0
    assert not list(cache.rglob("*.nbi"))


@pytest.mark.slow
def test_processes_that_compile_at_the_same_time_all_compute_what_they_should(tmp_path):
    """Each calls the same functions with another type; their entries would share numba's numbered files."""
    program = """
import sys
import numpy as np
from omnimate.vehicle.se2 import transform_xy
kind = sys.argv[1]
pose = np.array([1, 2, 0], dtype=kind)
assert transform_xy(pose, 0.5, 0.25) == (1.5, 2.25)
assert transform_xy(np.ones((3, 2), dtype=kind)[:, 0] - pose, 0.0, 0.0)[1] == -1.0
"""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    for _ in range(2):
        running = [
            subprocess.Popen([sys.executable, "-c", program, kind], env=environment)
            for kind in ("float64", "float32", "int64")
        ]
        assert [process.wait(timeout=300) for process in running] == [0, 0, 0]


def test_for_a_user_without_a_home_it_compiles_without_a_disk_cache(modules, monkeypatch):
    def no_home(path):
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("pathlib.Path.expanduser", no_home)
    module = modules(above=ABOVE, below=BELOW)
    assert module.outer(3.0) == 7.0
    assert module.outer.native().stats.cache_path is None
