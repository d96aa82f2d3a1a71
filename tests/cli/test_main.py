"""The command itself: its verbs are known without their code, and are loaded when they are called."""

import subprocess
import sys

import pytest

from omnimate import __version__
from omnimate.cli.verbs import GROUPS, HELP, load_verb, place_of

SLOW = (
    "numba",
    "scipy",
    "matplotlib",
    "canopen",
    "can",
    "mujoco",
    "fastapi",
    "sqlalchemy",
    "uvicorn",
)
TAPE = "direction,x_mm,y_mm\ncw,-290,-220\ncw,-280,-230\nccw,60,-45\nccw,70,-50\n"
CALLED = """
import sys
from omnimate.cli.main import main
for arguments in {calls!r}:
    sys.argv = ["omnimate", *arguments]
    try:
        main()
    except SystemExit as ended:
        assert not ended.code
    print(*arguments[:1], *[name for name in {names!r} if name in sys.modules], file=sys.stderr)
"""


def imported(names, *calls):
    """Return a line for each call in one new process: its verb, and which of these modules are there then."""
    code = CALLED.format(calls=[[str(argument) for argument in call] for call in calls], names=names)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stderr.splitlines()


def test_the_list_of_verbs_imports_no_verb_and_nothing_that_takes_time():
    verbs = [place_of(name)[0] for name in HELP]
    assert imported((*SLOW, "numpy", *verbs), ["--help"]) == ["--help"]


def test_the_help_of_no_verb_imports_anything_that_takes_time():
    assert imported(SLOW, *([verb, "--help"] for verb in HELP)) == list(HELP)


def test_a_tape_is_calibrated_without_compiled_code_and_without_figures(tmp_path, robot_toml):
    (tmp_path / "tape.csv").write_text(TAPE)
    (tmp_path / "vehicle.toml").write_text(robot_toml)
    call = ("umbmark", tmp_path / "tape.csv", "--side", 4, "--vehicle", tmp_path / "vehicle.toml")
    assert imported(("numba", "matplotlib", "scipy.stats", "can"), call) == ["umbmark"]


@pytest.mark.parametrize("name", HELP)
def test_a_verb_is_loaded_under_its_name_and_the_table_says_of_it_what_its_docstring_says(name):
    command = load_verb(name)
    assert command.name == name
    assert command.help.partition("\n\n")[0].replace("\n", " ") == HELP[name]


@pytest.mark.parametrize("call", [("--version",), ("dump", "one.log"), ("dump", "one.log", "--rates")])
def test_a_call_whose_standard_output_is_closed_runs_to_its_end(tmp_path, call):
    (tmp_path / "one.log").write_text("(1700000000.000500) can0 181#409C0000\n")
    command = ["sh", "-c", '"$@" >&-', "sh", sys.executable, "-m", "omnimate.cli.main", *call]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, cwd=tmp_path, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_version_is_printed_without_any_verb(omnimate):
    assert omnimate("--version") == (0, f"omnimate {__version__}\n", "")


def test_the_help_has_groups_and_names_the_verb_to_begin_with(omnimate, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    listed = omnimate("--help").out
    places = [listed.index(f"\n{group}:\n") for group in GROUPS]
    assert places == sorted(places)
    assert "Begin with `omnimate demo`" in listed
    assert "  umbmark    Begin with this: " in listed


def test_the_help_of_every_verb_fits_on_one_line_of_100_characters(omnimate, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    lines = omnimate("--help").out.splitlines()
    assert all(f"  {name:<9}  {line}" in lines for name, line in HELP.items())
