"""Wrong calls: each gives the sentence and the exit code in `tests/data/cli/wrong_calls.toml`."""

import re
import shlex
import socket
import tomllib
from pathlib import Path

import pytest

from omnimate.calib.profiles import save_profile
from omnimate.vcan_sim.reference import reference_single
from omnimate.vehicle.file import save_vehicle

CALLS = tomllib.loads((Path(__file__).parents[1] / "data/cli/wrong_calls.toml").read_text(encoding="utf-8"))
HEAD = "direction,x_mm,y_mm\n"
FILES = {
    "tape.csv": HEAD + "cw,-290,-220\ncw,-280,-230\nccw,60,-45\nccw,70,-50\n",
    "single.csv": HEAD + "cw,-290,-220\nccw,60,-45\n",
    "swapped.csv": HEAD + "ccw,-290,-220\nccw,-280,-230\ncw,60,-45\ncw,70,-50\n",
    "word.csv": HEAD + "cw,-290,-220\ncw,far,-230\nccw,60,-45\nccw,70,-50\n",
    "notes.txt": "buy oil\n",
}


@pytest.fixture
def here(tmp_path):
    """Return a folder with a robot of one truck, tables, a profile, an empty folder, and a file of prose."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    save_vehicle(reference_single(), tmp_path / "vehicle.toml")
    save_profile(tmp_path / "profiles.toml", "concrete", reference_single().trucks)
    (tmp_path / "empty").mkdir()
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs/drive.log").write_text("(1700000000.000500) can0 181#409C0000\n")
    return tmp_path


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_call_is_answered_by_its_sentence_and_its_code(omnimate, here, monkeypatch, name):
    monkeypatch.chdir(here)
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        places = {"here": here, "port": closed.getsockname()[1]}
        result = omnimate(*shlex.split(CALLS[name]["call"].format(**places)))
    assert result.code == CALLS[name]["code"]
    assert sentence(result.err).startswith(CALLS[name]["says"].format(**places).strip())
    assert not (here / "out").exists()


def sentence(text):
    """Return the last thing on stderr, without the lines about usage and without line breaks."""
    said = re.sub(r"^Usage:.*$|^Try .*$|^Error: ", " ", text, flags=re.MULTILINE)
    return " ".join(said.split()).removeprefix("Error ")
