"""The studies on the command line: `python -m studies --help`, from a checkout."""

from __future__ import annotations

import typer

from omnimate.cli.main import run
from studies.datasets.command import calibrate, importers, umbmark
from studies.faults.command import faults
from studies.mismatch.command import prove
from studies.mismatch.rules import rules
from studies.papers.command import reproduce

app = typer.Typer(
    name="studies",
    help="Studies of the project: the papers reproduced, the mismatch tool proven, the driver under faults, "
    "public data sets. "
    "Benchmarks are modules of their own, `python -m studies.speed.NAME`; studies/README.md lists them all.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in (reproduce, prove, rules, faults, calibrate, umbmark):
    app.command()(command)
app.add_typer(importers, name="import")

if __name__ == "__main__":
    run(app)
