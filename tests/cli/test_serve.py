"""`omnimate serve` and `omnimate key`: without the extra `service`, options from everywhere, and keys."""

import re
import socket
from pathlib import Path

import pytest

from omnimate.cli import serve
from omnimate.cli.verbs import load_verb


@pytest.fixture
def without_fastapi(monkeypatch):
    """An installation without the extra."""
    monkeypatch.setattr(serve, "find_spec", lambda name: None if name == "fastapi" else object())


@pytest.mark.parametrize(
    "arguments", [("serve",), ("key", "add", "hall"), ("key", "list"), ("key", "revoke", "0")]
)
def test_without_the_extra_a_sentence_says_how_to_install_it(refused, without_fastapi, arguments):
    assert "the service needs fastapi: pip install 'omnimate[service]'" in refused(*arguments, out="")


def test_a_key_is_made_listed_and_revoked(omnimate, refused, tmp_path):
    database = ("--database", f"sqlite:///{tmp_path}/service.db")
    key = omnimate("key", "add", "hall", "--role", "operate", *database).out.strip()
    identity = re.fullmatch(r"omk_([0-9a-f]{8})_\S+", key)[1]
    listed = omnimate("key", "list", *database).out
    assert identity in listed
    assert key not in listed
    assert omnimate("key", "revoke", identity, *database).code == 0
    assert "there is no key '0000'; omnimate key list shows which there are" in refused(
        "key", "revoke", "0000", *database, out=""
    )


@pytest.mark.parametrize("arguments", [("list",), ("revoke", "0000")])
def test_keys_of_a_database_that_is_not_there_are_none_and_it_is_not_made(refused, tmp_path, arguments):
    assert "there is no such file" in refused(
        "key", *arguments, "--database", f"sqlite:///{tmp_path}/none.db", out=""
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["", " ", "x" * 101])
def test_a_key_needs_a_name_that_can_be_listed(refused, tmp_path, name):
    assert "expected 1 to 100 characters" in refused(
        "key", "add", name, "--database", f"sqlite:///{tmp_path}/service.db", out=""
    )


@pytest.mark.parametrize("options", [("--jobs", "4"), ("--scheduler", "tcp://10.0.0.1:8786")])
def test_workers_of_dask_are_refused_at_the_start_without_dask(refused, monkeypatch, options):
    monkeypatch.setattr(serve, "find_spec", lambda name: None if name == "distributed" else object())
    assert "needs Dask: pip install 'omnimate[cluster]'" in refused("serve", *options, out="")


def test_a_port_in_use_is_named_with_what_to_do_before_the_robot_is_started(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with socket.create_server(("127.0.0.1", 0)) as other:
        assert "is in use, perhaps by another omnimate serve: end that program, or choose" in refused(
            "serve", "--port", str(other.getsockname()[1]), out=""
        )


def test_an_address_of_another_machine_is_named(omnimate, refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    omnimate("key", "add", "hall")
    assert "cannot listen at 192.0.2.1, port 0: " in refused(
        "serve", "--host", "192.0.2.1", "--port", "0", out=""
    )


@pytest.fixture
def settings_of(omnimate, monkeypatch):
    """Return a function that calls `serve` and returns the settings with which it would listen."""
    taken = []
    monkeypatch.setattr(serve, "_listen", lambda settings, *, as_json: taken.append((settings, as_json)))

    def settings(*arguments):
        result = omnimate("serve", *arguments)
        assert result.code == 0, result.err
        return taken[-1][0]

    return settings


def test_the_call_is_stronger_than_the_environment_and_that_than_the_file(settings_of, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("sheet.json").write_text("{}")
    file = tmp_path / "serve.toml"
    file.write_text(
        'host = "127.0.0.2"\nport = 1\nrate = 5\nfactsheet = "sheet.json"\nflight-recorder = "flights"\n'
    )
    monkeypatch.setenv("OMNIMATE_PORT", "2")
    monkeypatch.setenv("OMNIMATE_RATE", "6")
    monkeypatch.setenv("OMNIMATE_CONFIG", str(file))
    settings = settings_of("--rate", "7")
    assert (settings.host, settings.port, settings.rate) == ("127.0.0.2", 2, 7.0)
    assert (settings.factsheet, settings.pace) == (Path("sheet.json"), 40.0)
    assert settings.flight_recorder == Path("flights")


def test_every_option_has_its_variable():
    options = [option for option in load_verb("serve").params if option.name != "help"]
    assert options
    assert {option.envvar for option in options} == {f"OMNIMATE_{option.name.upper()}" for option in options}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('hosts = "127.0.0.1"', "hosts: unknown key; expected one of bus, vehicle, database, host, port,"),
        ('config = "other.toml"', "config: unknown key; expected one of bus,"),
        ("port = 99999", "port: 99999; "),
        ("jobs = 1.5", "jobs: 1.5; "),
        ("port = true", "port: True; "),
        ('log-format = "xml"', "log-format: 'xml'; "),
        ('host = ["127.0.0.1"]', "host: ['127.0.0.1']; expected text or a number"),
        ("host", "(syntax): not TOML"),
        ('vehicle = "nowhere.toml"', "vehicle: 'nowhere.toml'; "),
    ],
)
def test_a_file_with_a_mistake_is_refused_and_the_key_is_named(refused, tmp_path, text, problem):
    file = tmp_path / "serve.toml"
    file.write_text(text)
    assert f"error: {file}: {problem}" in refused("serve", "--config", file, out="")


@pytest.mark.parametrize("option", ["--vehicle", "--factsheet", "--config"])
def test_a_file_that_is_not_there_is_a_mistake_of_the_call(option, omnimate, tmp_path, monkeypatch):
    """Nothing is loaded or made before that."""
    monkeypatch.chdir(tmp_path)
    result = omnimate("serve", option, "nowhere.toml")
    assert (result.code, "nowhere.toml" in result.err) == (2, True)
    assert list(tmp_path.iterdir()) == []
