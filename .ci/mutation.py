"""`make mutation FILE=...`: change one operator, number or statement at a time; list what no test notices.

The changes are cosmic-ray's, and the removal of single statements. Each is tried in a copy of the checkout in
which compiled functions are plain Python. `mutation.toml` lists files, their tests, and the survivors that
change no behaviour; with another survivor, or without one of these, the exit code is 1.
`--touched-since COMMIT` takes the listed files that differ from a commit, or whose tests do; `--seconds` ends
that in time.
"""

from __future__ import annotations

import argparse
import difflib
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from cosmic_ray.ast import get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator
from hypothesis import Phase, settings
from touched import touched_files

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parents[1]
CONFIGURATION: dict[str, Any] = tomllib.loads((ROOT / ".ci/mutation.toml").read_text(encoding="utf-8"))
STYLE = (
    "TYPE_CHECKING",
    "& None",
    "& float",
    "& bytes | None",
    "bytes & bytearray",
    ", /, ",
    "strict=False",
    "@dataclass",
)  # only tools or guards read these

BEGAN = time.monotonic()  # [s]
SEEDS = (0, 1, 2)  # of property tests; fixed, so that a result repeats
Mutant = tuple[str, tuple[str, str]]  # a changed source, the line that it changes, and what this becomes


class RemoveStatement(Operator):  # type: ignore[misc]  # cosmic-ray has no types
    """Replaces an assignment or a call in a function by `pass`."""

    def mutation_positions(self, node: Any) -> Iterator[tuple[object, object]]:  # noqa: ANN401, D102
        is_call = node.type == "atom_expr" and node.parent.type == "simple_stmt"
        around = node.parent
        while around is not None and around.type != "funcdef":
            around = around.parent
        if (is_call or node.type == "expr_stmt") and around is not None:
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, _index: int) -> Any:  # noqa: ANN401, D102
        changed = get_ast("pass").children[0]
        changed.prefix = node.get_first_leaf().prefix
        return changed

    @classmethod
    def examples(cls) -> tuple[object, ...]:  # noqa: D102
        return ()


def mutants_of(source: str) -> list[Mutant]:
    """Return each changed source with the line that it changes and what this becomes."""
    found = []
    names = [f"core/{name}" for name in CONFIGURATION["operators"].split()]
    for operator in (*(get_operator(name)() for name in names), RemoveStatement()):
        number = 0
        while (changed := mutate_code(source, operator, number)) is not None:
            number += 1
            lines = list(difflib.ndiff(source.splitlines(), changed.splitlines()))
            was, becomes = (" ".join(line[2:].strip() for line in lines if line[0] == sign) for sign in "-+")
            if not any(word in becomes for word in STYLE):
                found.append((changed, (was, becomes)))
    return found


def prepare(copy: str) -> None:
    """Enter a copy of the checkout, which this process alone uses."""
    place = Path(tempfile.mkdtemp(dir=copy))
    command = ["git", "ls-files", "-z"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for name in listed.split("\0")[:-1]:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, place / name)
    (place / "omnimate").symlink_to(place)
    os.chdir(place)
    sys.path.insert(0, str(place))
    sys.dont_write_bytecode = True
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # loading all takes longer than the tests


def passes(file: str, timeout: int, seed: int, source: str) -> bool:
    """Return whether the tests of a file pass within a time [s] where this is its source.

    Property tests draw their examples from the seed.
    """
    Path(file).write_text(source, encoding="utf-8")
    shutil.rmtree(".hypothesis", ignore_errors=True)  # examples that failed with another change
    if not (child := os.fork()):
        signal.alarm(timeout)  # its default action ends the process
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(1, 2)
        # One failure is enough: to shrink it takes far longer than to find it.
        settings.register_profile("mutation", phases=[Phase.explicit, Phase.generate])
        settings.load_profile("mutation")
        from omnimate.vehicle import compiled

        layout = compiled.layout
        compiled.compiled = compiled.compiled_without_lock = lambda function: function
        # Elements of records have attributes, as in compiled code.
        compiled.layout = lambda fields: np.dtype((np.record, layout(fields)))  # type: ignore[assignment]
        options = [*CONFIGURATION["pytest"], f"--hypothesis-seed={seed}"]
        os._exit(pytest.main([*options, *CONFIGURATION["tests"][file].split()]))
    return os.waitpid(child, 0)[1] == 0


def touched_since(commit: str) -> list[str]:
    """Return the listed files that differ from a commit, or whose tests do."""
    touched = touched_files(ROOT, commit)
    return [
        file for file, tests in CONFIGURATION["tests"].items() if touched.intersection((file, *tests.split()))
    ]


def examine(file: str) -> int:
    """Print the survivors of a file that have no reason, and return the number of errors."""
    start = time.monotonic()
    source = (ROOT / file).read_text(encoding="utf-8")
    excused = {(entry["was"], entry["becomes"]) for entry in CONFIGURATION["equivalent"].get(file, ())}
    found = mutants_of(source)
    with tempfile.TemporaryDirectory() as copy, ProcessPoolExecutor(2, None, prepare, (copy,)) as pool:
        began = time.monotonic()
        if not pool.submit(passes, file, 300, SEEDS[0], source).result():
            sys.exit(f"{file}: its tests fail as they are, with compiled functions as plain Python")
        timeout = 10 + round(5 * (time.monotonic() - began))

        def left(mutants: list[Mutant], seed: int) -> list[Mutant]:
            """Return the mutants that no test notices with the examples of a seed."""
            is_alive = pool.map(partial(passes, file, timeout, seed), [text for text, _ in mutants])
            return [mutant for mutant, alive in zip(mutants, is_alive, strict=True) if alive]

        survivors = left(found, SEEDS[0])
        unexcused = [(text, lines) for text, lines in survivors if lines not in excused]
        for seed in SEEDS[1:]:  # where no example of one seed notices a change, those of the next may
            unexcused = left(unexcused, seed)
    equivalent = [lines for _, lines in survivors if lines in excused]
    stale = excused.difference(equivalent)
    for _, (was, becomes) in unexcused:
        print(f"  survived: {was}\n        as: {becomes}")
    for was, becomes in sorted(stale):
        print(f"  listed, yet no survivor: {was}\n        as: {becomes}")
    killed = len(found) - len(unexcused) - len(equivalent)
    counts = f"{killed} killed, {len(equivalent)} equivalent"
    seconds = time.monotonic() - start
    print(f"{file}: {len(found)} mutants, {counts}, {len(unexcused)} survived, {seconds:.0f} s", flush=True)
    return len(unexcused) + len(stale)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="*", default=list(CONFIGURATION["tests"]))
    parser.add_argument("--touched-since", metavar="COMMIT")
    parser.add_argument("--seconds", type=float, default=math.inf, help="begin no other file after so long")
    arguments = parser.parse_args()
    commit, errors = arguments.touched_since, 0
    for listed in arguments.files if commit is None else touched_since(commit):
        if time.monotonic() - BEGAN < arguments.seconds:
            errors += examine(listed)
        else:
            print(f"{listed}: left to the daily run, for want of time")
    sys.exit(errors > 0)
