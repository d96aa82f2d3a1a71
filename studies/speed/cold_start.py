"""The time of a call of the command from its start, as a whole process.

Peers: an empty Python, and one that imports numpy.

Usage: python -m studies.speed.cold_start [rounds]

The best of several rounds counts, because the machine may be shared; the processor time beside it says what
the call itself costs. The calls marked 0.3 and 0.6 are to be done within so many seconds.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROUNDS = 7
TAPE = """direction,x_mm,y_mm
cw,-290,-220
cw,-280,-230
cw,-285,-214
ccw,60,-45
ccw,70,-50
ccw,64,-41
"""
COMMAND = (sys.executable, "-m", "omnimate.cli.main")
CALLS = {
    "python -c pass": (None, (sys.executable, "-c", "pass")),
    "python -c 'import numpy'": (None, (sys.executable, "-c", "import numpy")),
    "omnimate --help": (0.3, (*COMMAND, "--help")),
    "omnimate dbc": (0.6, (*COMMAND, "dbc", "vehicle.toml", "out.dbc")),
    "omnimate profile list": (0.6, (*COMMAND, "profile", "list", "profiles.toml")),
    "omnimate umbmark tape.csv": (
        0.6,
        (*COMMAND, "umbmark", "tape.csv", "--side", "4", "--vehicle", "vehicle.toml"),
    ),
    "omnimate dump --help": (0.6, (*COMMAND, "dump", "--help")),
    "omnimate simulate --help": (0.6, (*COMMAND, "simulate", "--help")),
    "omnimate serve --help": (0.6, (*COMMAND, "serve", "--help")),
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


def measure(call: tuple[str, ...], folder: Path) -> tuple[float, float]:
    """Return wall time and processor time of a process [s]."""
    used, begin = processor_time(), time.perf_counter()
    subprocess.run(call, cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - begin, processor_time() - used


def processor_time() -> float:
    """Return what all processes that have ended used so far [s]."""
    now = os.times()
    return now.children_user + now.children_system


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    print(f"best of {rounds} [s]              wall   processor   wanted")
    with tempfile.TemporaryDirectory() as place:
        prepare(Path(place))
        for name, (wanted, call) in CALLS.items():
            times = [measure(call, Path(place)) for _ in range(rounds)]
            wall, processor = (min(column) for column in zip(*times, strict=True))
            print(f"{name:<26} {wall:6.2f}      {processor:6.2f}   {'' if wanted is None else wanted}")


if __name__ == "__main__":
    main()
