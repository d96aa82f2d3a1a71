"""The generated part of the client: it is that of the service, it is typed, and it needs no other library."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from docs.generate.client import COMMAND, FOLDER, generated

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "06_fleet_client.py"
WRONG = """
from omnimate.client import Client

client = Client("http://127.0.0.1:8080")
client.umbmark.start_session(how="fly")
client.umbmark.get_session("k3")["stat"]
client.vehicles.change_vehicle("tug", "toml")
"""


@pytest.mark.parametrize("name", ["models.py", "operations.py"])
def test_the_client_is_that_of_the_service(name):
    kept = (FOLDER / name).read_text(encoding="utf-8")
    assert kept == generated()[name], f"the REST interface has changed; run: {COMMAND}"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return the lines that mypy prints about users' programs, without the settings of this project."""
    wrong = tmp_path_factory.mktemp("wrong") / "wrong.py"
    wrong.write_text(WRONG)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", f"--cache-dir={os.devnull}"]
    done = subprocess.run(
        [*command, EXAMPLE, wrong], capture_output=True, text=True, check=False, cwd=ROOT / ".mypy_path"
    )
    return done.stdout.splitlines()


@pytest.mark.slow
def test_mypy_accepts_the_example(found):
    assert "(checked 2 source files)" in found[-1]
    assert not [line for line in found if EXAMPLE.name in line]


@pytest.mark.slow
def test_mypy_finds_wrong_values_fields_and_missing_conditions(found):
    value, field, condition = (line for line in found if "wrong.py" in line and " error: " in line)
    assert 'Argument "how" to "start_session"' in value
    assert 'TypedDict "Session" has no key "stat"' in field
    assert 'Missing named argument "if_match"' in condition


def test_the_client_loads_no_library_but_those_of_python():
    code = "import sys, omnimate.client; print(sorted({name.partition('.')[0] for name in sys.modules}))"
    before = subprocess.run(
        [sys.executable, "-c", code.replace(", omnimate.client", "")],
        capture_output=True,
        text=True,
        check=True,
    )
    after = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(eval(after.stdout)) - set(eval(before.stdout))
    assert loaded - sys.stdlib_module_names == {"omnimate"}
