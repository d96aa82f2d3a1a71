"""The time of a call of the command from its start, as a whole process.

Peers: an empty Python, and one that imports numpy.

Usage: python -m studies.speed.cold_start [rounds]

The best of several rounds counts, because the machine may be shared; the processor time beside it says what
the call itself costs. The calls marked 0.3 and 0.6 are to be done within so many seconds.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from studies.benchmark import OMNIMATE, least, options, process_cost

ROUNDS = 7
TAPE = """direction,x_mm,y_mm
cw,-290,-220
cw,-280,-230
cw,-285,-214
ccw,60,-45
ccw,70,-50
ccw,64,-41
"""
CALLS = {
    "python -c pass": (None, (sys.executable, "-c", "pass")),
    "python -c 'import numpy'": (None, (sys.executable, "-c", "import numpy")),
    "omnimate --help": (0.3, (*OMNIMATE, "--help")),
    "omnimate dbc": (0.6, (*OMNIMATE, "dbc", "vehicle.toml", "out.dbc")),
    "omnimate profile list": (0.6, (*OMNIMATE, "profile", "list", "profiles.toml")),
    "omnimate umbmark tape.csv": (
        0.6,
        (*OMNIMATE, "umbmark", "tape.csv", "--side", "4", "--vehicle", "vehicle.toml"),
    ),
    "omnimate dump --help": (0.6, (*OMNIMATE, "dump", "--help")),
    "omnimate simulate --help": (0.6, (*OMNIMATE, "simulate", "--help")),
    "omnimate serve --help": (0.6, (*OMNIMATE, "serve", "--help")),
}


def prepare(folder: Path) -> None:
    """Write what the calls read."""
    from omnimate.calib.profiles import save_profile
    from omnimate.vcan_sim.reference import reference_vehicle
    from omnimate.vehicle.file import save_vehicle

    vehicle = reference_vehicle()
    save_vehicle(vehicle, folder / "vehicle.toml")
    save_profile(folder / "profiles.toml", "concrete", vehicle.trucks)
    (folder / "tape.csv").write_text(TAPE, encoding="utf-8")


def main() -> None:
    rounds = options(__doc__, {"rounds": ROUNDS}).rounds
    print(f"best of {rounds} [s]              wall   processor   wanted")
    with tempfile.TemporaryDirectory() as place:
        prepare(Path(place))
        for name, (wanted, call) in CALLS.items():
            used = least([process_cost(call, folder=place) for _ in range(rounds)])
            print(
                f"{name:<26} {used.wall:6.2f}      {used.processor:6.2f}   {'' if wanted is None else wanted}"
            )


if __name__ == "__main__":
    main()
