"""The time of the quick question of `diagnose --triage`, alone and as a whole process.

Peers, in the same run: the whole diagnosis and the simulation of the same drive, and an empty Python.

Usage: python -m studies.speed.triage_speed [--samples 20000] [rounds]

The best of several rounds counts, because the machine may be shared; 0.3 s are wanted for 20,000 samples.
The processor time beside it says what the question itself costs.
"""

import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from subprocess import DEVNULL, run

from omnimate.files.recordings.folder import save_recording
from omnimate.mismatch import diagnose
from omnimate.mismatch.triage import triage
from studies.benchmark import OMNIMATE, best, duration, options
from studies.speed.diagnose_speed import simulated

WANTED = 0.3  # [s]


def main() -> None:
    given = options(__doc__, {"rounds": 7}, samples=20_000)
    lap = simulated(1)
    triage([lap])
    diagnose([lap])
    laps = 1 + given.samples // len(lap)
    simulation = duration(lambda: simulated(laps))
    recording = simulated(laps)
    asked = best(lambda: triage([recording]), given.rounds)
    used = best(lambda: triage([recording]), given.rounds, time.process_time)
    whole = duration(lambda: diagnose([recording]))
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "drive"
        save_recording(recording, folder)
        process, empty = (
            best(partial(run, command, check=True, stdout=DEVNULL), given.rounds)
            for command in (
                [*OMNIMATE, "diagnose", "--triage", str(folder)],
                [sys.executable, "-c", "pass"],
            )
        )
    print(
        f"{len(recording)} samples, {recording.time[-1] - recording.time[0]:.0f} s of driving: "
        f"triage {asked:.2f} s (wanted {WANTED}; processor {used:.2f} s), "
        f"{asked / whole:.3f} of the whole diagnosis, "
        f"{asked / simulation:.2f} of the simulation of the drive; "
        f"as a process, with reading the log, {process:.2f} s (an empty Python {empty:.2f} s)"
    )
    sys.exit(asked > WANTED)


if __name__ == "__main__":
    main()
