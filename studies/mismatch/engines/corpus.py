"""The corpus: recordings of cases, and their labels in a file beside them.

`python -m studies.mismatch.engines.corpus OUT [--quick]` writes both.
"""

from __future__ import annotations

import argparse
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from studies.mismatch.engines.cases import cases, seed_of
from studies.mismatch.engines.labels import set_bump_times
from studies.mismatch.engines.scene import scene
from studies.mismatch.engines.writing import MEASURING, write

if TYPE_CHECKING:
    from studies.mismatch.engines.cases import Case


def make(folder: Path, case: Case, seed: int) -> dict[str, Any]:
    """Write the recording of a case, and return its label.

    Args:
        folder: Folder of the case; the recording is its subfolder `1`.
        case: What is concealed, and in which drive.
        seed: Seed of all random draws; the same seed gives the same bytes.
    """
    setting = scene(case, seed)
    robot = setting.robot
    driven = setting.driven(setting.faults, setting.chance)
    labels = list(setting.labels)
    for label in labels:
        if label["effect"] == "bump":
            set_bump_times(label, driven.time, driven.counts[:, robot.channels.index(label["component"])])
    measuring = MEASURING[case.poses]
    if measuring is not None and case.note == "noisier poses":
        measuring = replace(measuring, noise=2.0)
    dropped = 0.01 if case.note == "dropped frames" else 0.0
    write(folder / "1", robot, driven, measuring, dropped, setting.chance)
    verdict = {"null": ["agreement"], "insufficient": ["insufficient"]}.get(case.kind, ["mismatch"])
    return {
        "kind": case.kind, "verdict": verdict, "poses": case.poses, "recordings": ["1"], "effects": labels,
        "engine": "own", "drive": case.drive, "note": case.note,
    }  # fmt: skip


def write_case(wanted: tuple[Path, Case, int]) -> dict[str, Any]:
    """Do as `make`, in one argument and over what an earlier run left unfinished."""
    folder, case, seed = wanted
    if folder.exists():
        shutil.rmtree(folder)
    return make(folder, case, seed)


def main() -> None:
    """Write the corpus and its labels."""
    parser = argparse.ArgumentParser(description="Write recordings with concealed effects, and their labels.")
    parser.add_argument("out", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    labels = {}
    for number, case in enumerate(cases(options.quick)):
        name = f"{number:04d}"
        labels[name] = make(options.out / name, case, seed_of(options.seed, number))
    (options.out / "labels.json").write_text(json.dumps(labels, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
