"""The `omnimate` command, and its exit codes.

Exit codes: 0 success; 1 an error that the message explains, or data that had to be left out; 2 a wrong
call.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, cast

from omnimate.cli.console import print_error, take_problems
from omnimate.cli.verbs import command
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from typer import Typer

app = command()


def main() -> None:
    """Run one verb of `omnimate`."""
    run(app)


def run(app: Typer) -> None:
    """Run a command; a problem that the user can solve is one sentence on stderr and exit code 1."""
    take_problems()
    if cast("TextIO | None", sys.stdout) is None:  # closed by the caller, as by `>&-`
        sys.stdout = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115  # until the process ends
    try:
        app()
    except SystemExit as ended:
        if take_problems() and not ended.code:
            sys.exit(1)
        raise
    except OmnimateError as error:
        print_error(str(error))
        sys.exit(1)
    except MemoryError:
        print_error("this takes more memory than there is; give fewer or shorter recordings, or free memory")
        sys.exit(1)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output went away, as `head` does
        sys.exit(1)
    except OSError as error:
        print_error(f"{error.filename or 'output'}: {error.strerror or error}")
        sys.exit(1)


if __name__ == "__main__":
    main()
