"""Run the blocks of documentation pages, and hold what they print against what the pages show."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.docs.pages import Block, blocks
from tests.docs.shown import plain, same

PORTS = ("8080", "29536")
"""Ports that the pages name; each is replaced by a free one, as several checkouts may be tested at once."""

SECONDS = 1800.0
PROGRESS = re.compile(r"^\S.*: \d+%$")  # which a command says of itself where it takes long
"""After which a page is given up [s]: an upper bound, which a page that ends by itself never comes near."""


@dataclass(frozen=True, slots=True)
class Step:
    """One command, or one file, of a page.

    Attributes:
        block: Where it stands.
        line: Line of the page.
        command: What the shell runs.
        shown: Lines that the page shows as its output; None where it shows none.
        first: Line of the page at which the shown output begins.
    """

    block: Block
    line: int
    command: str
    shown: tuple[str, ...] | None
    first: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a step: its exit code and the lines that it printed."""

    step: Step
    code: int
    printed: tuple[str, ...]

    @property
    def problem(self) -> str:
        """What is wrong with it, as a sentence; empty where nothing is."""
        place = f"{self.step.block.page}:{self.step.line}: {self.step.command.splitlines()[0]}"
        printed = "\n".join(self.printed)
        if self.code:
            return f"{place}\nended with exit code {self.code}, expected 0; it printed\n{printed}"
        if self.step.shown is None or same(self.step.shown, self.printed):
            return ""
        shown = "\n".join(self.step.shown)
        return f"{place}\nprinted\n{printed}\n\nthe page shows\n{shown}"


def steps_of(page: Path) -> list[Step]:
    """Return what a page runs, in its order."""
    result: list[Step] = []
    listed = blocks(page)
    for number, block in enumerate(listed):
        if block.not_run:
            continue
        if block.title:
            result.append(_file(block))
        elif block.language == "python":
            below = listed[number + 1] if number + 1 < len(listed) else None
            result.append(_program(block, below))
        elif block.language == "console":
            result += commands_of(block)
    return result


def _file(block: Block) -> Step:
    marker = "END_OF_THE_FILE"
    text = "\n".join(block.lines)
    command = f"mkdir -p \"$(dirname '{block.title}')\"; cat > '{block.title}' <<'{marker}'\n{text}\n{marker}"
    return Step(block, block.line, command, None, block.line)


def _program(block: Block, below: Block | None) -> Step:
    text = "\n".join(block.lines)
    command = f"python - <<'END_OF_THE_PROGRAM'\n{text}\nEND_OF_THE_PROGRAM"
    if below is None or below.language != "text" or below.after != "python":
        return Step(block, block.line, command, None, block.line)
    return Step(block, block.line, command, below.lines, below.line)


def commands_of(block: Block) -> list[Step]:
    """Return the commands of a `console` block, each with the lines below it."""
    result: list[Step] = []
    number = 0
    while number < len(block.lines):
        start = number
        command = block.lines[number]
        if not command.startswith("$ "):
            raise ValueError(f"{block.page}:{block.line + number}: expected a line that begins with '$ '")
        while block.lines[number].endswith("\\"):
            number += 1
            command += "\n" + block.lines[number].removeprefix("> ")
        number += 1
        first = number
        while number < len(block.lines) and not block.lines[number].startswith("$ "):
            number += 1
        shown = block.lines[first:number]
        while shown and not shown[-1].strip():
            shown = shown[:-1]
        result.append(
            Step(block, block.line + start, command.removeprefix("$ "), shown or None, block.line + first)
        )
    return result


def run(pages: list[Path], folder: Path) -> list[Outcome]:
    """Run the steps of some pages in one shell and one folder, up to the first that fails."""
    steps = [step for page in pages for step in steps_of(page)]
    ports = dict(zip(PORTS, free_ports(len(PORTS)), strict=True))
    kept = folder.parent / f"{folder.name}.steps"
    kept.mkdir()
    script = kept / "script.sh"
    script.write_text("".join(_scripted(kept, number, step) for number, step in enumerate(steps)))
    for port, free in ports.items():
        script.write_text(script.read_text().replace(port, free))
    _shell(script, folder)
    return [outcome for number, step in enumerate(steps) if (outcome := _outcome(kept, number, step, ports))]


def _scripted(kept: Path, number: int, step: Step) -> str:
    name = kept / str(number)
    check = f"code=$?; echo $code > {name}.code; [ $code = 0 ] || exit 0"
    return f"{{ {step.command}\n}} > {name}.out 2>&1\n{check}\n"


def _outcome(kept: Path, number: int, step: Step, ports: dict[str, str]) -> Outcome | None:
    code, printed = kept / f"{number}.code", kept / f"{number}.out"
    if not code.exists():
        return Outcome(step, -1, (f"it did not end within {SECONDS:.0f} s",)) if printed.exists() else None
    text = printed.read_text()
    for port, free in ports.items():
        text = text.replace(free, port)
    lines = (line for line in plain(text) if not PROGRESS.search(line))
    return Outcome(step, int(code.read_text()), tuple(lines))


def _shell(script: Path, folder: Path) -> None:
    """Run a script in a process group of its own, which ends with it."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {
        **os.environ,
        "PATH": path,
        "COLUMNS": "100",
        "NO_COLOR": "1",
        "TERM": "dumb",
        "PYTHONUNBUFFERED": "1",
        "MPLBACKEND": "Agg",
    }
    with subprocess.Popen(
        ["bash", script],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    ) as shell:
        try:
            with contextlib.suppress(subprocess.TimeoutExpired):
                shell.wait(SECONDS)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(shell.pid, signal.SIGKILL)


def free_ports(count: int) -> list[str]:
    """Return numbers of ports on which nothing listens."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [str(each.getsockname()[1]) for each in sockets]
    finally:
        for each in sockets:
            each.close()
