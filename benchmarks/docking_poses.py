"""How well poses at docks alone calibrate a real robot: the first and the last pose of each OptiOdom drive.

The circular and ivanjko sets are used, the free drives are held out.

Peers, in the same run: all poses, and the nominal robot.

Usage: python -m benchmarks.docking_poses [ROOT]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from omnimate.calib.paths.least_squares import SPACING, calibrate_path
from omnimate.importers.optiodom.drives import read_set
from omnimate.importers.optiodom.files import find_sets
from omnimate.importers.optiodom.scores import score

if TYPE_CHECKING:
    from omnimate.calib.paths.drives import Drive

ROOT = "../shared/data/real/optiodom/diff"
WANTED = 0.020  # [m] rms on the free drives
USED = {"circular", "ivanjko"}


def docked(drive: Drive) -> Drive:
    """Return a drive of whose poses the first and the last one are known."""
    ends = [0, -1]
    return replace(drive, fix_time=drive.fix_time[ends], pose=drive.pose[ends], sigma=drive.sigma[ends])


def main() -> int:
    sets = [read_set(folder) for folder in find_sets(sys.argv[1] if len(sys.argv) > 1 else ROOT)]
    used = [data for data in sets if data.path in USED]
    drives = [drive for data in used for drive in data.drives]
    worst = 0.0
    for words, chosen, spacing in (
        ("docks alone", [docked(drive) for drive in drives], 0.0),
        ("all poses", drives, SPACING),
    ):
        calibration = calibrate_path(chosen, used[0].kinematics, spacing=spacing)
        for data in sets:
            if data.path == "free":
                raw, fitted = score(data, data.kinematics), score(data, calibration.kinematics)
                change = f"{1e3 * raw.rms:.1f} -> {1e3 * fitted.rms:.1f} mm rms"
                print(f"{words}: {len(drives)} drives; {data.name} {change}")
                if words == "docks alone":
                    worst = max(worst, fitted.rms)
    print(f"wanted with docks alone: at most {1e3 * WANTED:.0f} mm rms")
    return 0 if worst <= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
