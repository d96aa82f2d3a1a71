"""Every command and every program of the documentation runs and prints what its page shows."""

import re
import shlex
from concurrent.futures import ThreadPoolExecutor

import pytest
from typer.main import get_command

from omnimate.cli.verbs import whole_command
from studies.__main__ import app as STUDIES  # noqa: N812
from tests.docs.pages import PAGES, ROOT, blocks, groups
from tests.docs.running import commands_of, run, steps_of

RUN = {name: pages for name, pages in groups().items() if any(steps_of(page) for page in pages)}
NOT_RUN = [block for pages in groups().values() for page in pages for block in blocks(page) if block.not_run]
SLOW = {  # 10 s to two minutes each
    "tutorial", "how-to/can-log.md", "how-to/nights.md", "how-to/fleet.md", "how-to/device.md",
    "how-to/monitor.md", "how-to/other-tools.md", "how-to/python-client.md", "how-to/two-wheel-robot.md",
    "how-to/write-an-effect.md", "reference/diagnosis.md", "index.md",
}  # fmt: skip
EXAMPLES = sorted(path.name for path in (ROOT / "examples").glob("[0-9][0-9]_*"))


@pytest.fixture(scope="session")
def running(request, tmp_path_factory):
    """The outcomes of the pages that are asked for; two run at a time, each in its own folder and shell."""
    names = [item.callspec.params["name"] for item in request.session.items if "running" in item.fixturenames]
    with ThreadPoolExecutor(2) as pool:
        yield {name: pool.submit(run, RUN[name], tmp_path_factory.mktemp("page")) for name in names}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else [])
        for name in sorted(RUN, key=lambda name: name != "tutorial")
    ],
)
def test_what_a_page_says_happens(name, running):
    problems = [outcome.problem for outcome in running[name].result() if outcome.problem]
    assert not problems, "\n\n".join(problems)


@pytest.mark.parametrize("block", NOT_RUN, ids=lambda block: f"{block.page.stem}:{block.line}")
def test_commands_that_need_hardware_have_options_that_exist(block):
    for step in commands_of(block):
        words = shlex.split(step.command, comments=True)
        if words[0] == "omnimate":
            parse(words[1:])
        elif words[:3] == ["python", "-m", "studies"]:
            parse(words[3:], get_command(STUDIES))


def parse(words, command=None):
    """Parse the options of a verb, without looking at its files."""
    command = command or whole_command()
    context = command.make_context("omnimate", [], resilient_parsing=True)
    while hasattr(command, "commands"):
        command = command.get_command(context, words[0])
        assert command is not None, f"omnimate has no verb {words[0]!r}"
        context, words = type(context)(command, parent=context, info_name=words[0]), words[1:]
    command.make_parser(context).parse_args(args=[word for word in words if word != "&"])


def test_an_option_that_does_not_exist_is_noticed():
    with pytest.raises(Exception, match="--no-such-option"):
        parse(["record", "lap", "--no-such-option"])


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_is_shown_and_run_by_a_page(name):
    pages = [page for page in PAGES.rglob("*.md") if f'--8<-- "examples/{name}"' in page.read_text()]
    assert pages, f"no page includes examples/{name}"
    assert any(name in step.command for page in pages for step in steps_of(page) if not step.block.title)


def test_examples_are_numbered_without_gaps():
    numbers = [int(name[:2]) for name in EXAMPLES]
    assert numbers == list(range(1, len(numbers) + 1))


def test_the_readme_names_two_commands_that_the_makefile_has():
    readme, makefile = (ROOT / "README.md").read_text(), (ROOT / "Makefile").read_text()
    commands = re.findall(r"^\$ make (\w+)", readme, re.MULTILINE)
    assert commands == ["demo", "test"]
    assert all(re.search(rf"^{command}:", makefile, re.MULTILINE) for command in commands)
