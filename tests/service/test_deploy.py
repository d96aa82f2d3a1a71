"""The files in `deploy/`: their metrics are exported, their commands and variables are the service's."""

import json
import re
import shlex

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from omnimate.cli.config_file import options_by_key
from omnimate.cli.verbs import load_verb
from tests.docs.pages import ROOT
from tests.docs.test_pages import parse

DEPLOY = ROOT / "deploy"
METRIC = re.compile(r"\bomnimate_\w+")
SUFFIXES = {"counter": ("_total",), "histogram": ("_bucket", "_count", "_sum"), "gauge": ("",)}


def text_of(name):
    return (DEPLOY / name).read_text(encoding="utf-8")


def unit_lines(key):
    return re.findall(rf"^{key}=(.*)$", text_of("omnimate.service"), re.MULTILINE)


def dockerfile_list(instruction):
    return json.loads(re.search(rf"^{instruction} (\[.*\])$", text_of("Dockerfile"), re.MULTILINE)[1])


def expressions(name):
    """Return the expressions of the alert rules, or of the dashboard's panels."""
    if name == "alerts.yml":
        return [rule["expr"] for group in yaml.safe_load(text_of(name))["groups"] for rule in group["rules"]]
    return [target["expr"] for panel in json.loads(text_of(name))["panels"] for target in panel["targets"]]


@pytest.mark.parametrize("name", ["alerts.yml", "dashboard.json"])
def test_every_metric_that_is_used_is_exported(client, name):
    families = list(text_string_to_metric_families(client.get("/metrics").text))
    exported = {family.name + suffix for family in families for suffix in SUFFIXES[family.type]}
    used = {metric for expression in expressions(name) for metric in METRIC.findall(expression)}
    assert used
    assert used <= exported


@pytest.mark.parametrize("name", ["alerts.yml", "dashboard.json"])
def test_every_expression_closes_its_brackets(name):
    for expression in expressions(name):
        unquoted = re.sub(r'"[^"]*"', "", expression)
        while unquoted != (less := re.sub(r"\([^][(){}]*\)|\[\w+\]|\{[^][(){}]*\}", "", unquoted)):
            unquoted = less
        assert not set(unquoted) & set("()[]{}"), expression


@pytest.mark.parametrize(
    "command",
    [
        shlex.split(unit_lines("ExecStart")[0]),
        dockerfile_list("ENTRYPOINT") + dockerfile_list("CMD"),
        dockerfile_list("ENTRYPOINT")
        + yaml.safe_load(text_of("compose.yaml"))["services"]["omnimate"]["command"],
    ],
    ids=["unit", "container", "compose"],
)
def test_the_command_is_one_that_serve_takes(command):
    assert command[0].rpartition("/")[2] == "omnimate"
    assert command[1] == "serve"
    parse(command[1:])


def test_every_variable_is_one_that_serve_reads():
    known = {option.envvar for option in load_verb("serve").params}
    texts = [path.read_text(encoding="utf-8") for path in DEPLOY.iterdir()]
    named = {name for text in texts for name in re.findall(r"OMNIMATE_[A-Z_]*[A-Z]", text)}
    assert {"OMNIMATE_HOST", "OMNIMATE_DATABASE"} <= named <= known


def test_every_key_of_the_configuration_is_an_option():
    keys = set(re.findall(r"^(?:# )?([a-z-]+) = ", text_of("serve.toml"), re.MULTILINE))
    assert {"host", "bus"} <= keys <= set(options_by_key(load_verb("serve")))


def test_the_container_is_given_every_room_of_the_package():
    given = set(re.findall(r"^!/(\w+)$", text_of("Dockerfile.dockerignore"), re.MULTILINE))
    rooms = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"studies"}
    assert given >= rooms
