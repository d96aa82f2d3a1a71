"""The `omnimate` command: its verbs, and what its exit codes mean.

Exit codes: 0 all is well; 1 an error that the message explains, or data that had to be left out; 2 the call
itself is wrong.
"""

from __future__ import annotations

import sys

import typer

from cli.calibrate import calibrate
from cli.console import complain, take_flaws
from cli.dbc import dbc
from cli.demo import demo
from cli.design import design
from cli.diagnose import diagnose
from cli.drift import drift
from cli.dump import dump
from cli.import_ import app as importing
from cli.profile import app as profiles
from cli.prove import prove
from cli.record import record
from cli.replay import replay
from cli.reproduce import reproduce
from cli.serve import keys, serve
from cli.sim import sim
from cli.simulate import simulate
from cli.track import track
from cli.umbmark import umbmark
from vehicle.errors import OmnimateError

app = typer.Typer(
    name="omnimate",
    help="Odometry that a robot fleet trusts: read, calibrate, simulate.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for verb in (
    demo,
    sim,
    simulate,
    record,
    replay,
    track,
    dump,
    dbc,
    umbmark,
    calibrate,
    drift,
    design,
    diagnose,
    prove,
    reproduce,
    serve,
):
    app.command()(verb)

app.add_typer(importing, name="import")
app.add_typer(profiles, name="profile")
app.add_typer(keys, name="key")


def main() -> None:
    """Run one verb; a problem that the user can solve is one sentence on stderr and exit code 1."""
    take_flaws()
    try:
        app()
    except SystemExit as ended:
        if take_flaws() and not ended.code:
            sys.exit(1)
        raise
    except OmnimateError as error:
        complain(str(error))
        sys.exit(1)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output went away, as `head` does
        sys.exit(1)


if __name__ == "__main__":
    main()
