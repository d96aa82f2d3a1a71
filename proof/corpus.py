"""The corpus: recordings of cases with their labels, which are written apart.

`python -m proof.corpus OUT [--quick]` writes both.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from proof.cases import cases, seed_of
from proof.labels import feel
from proof.scene import scene
from proof.writing import write

if TYPE_CHECKING:
    from proof.cases import Case


def make(folder: Path, case: Case, seed: int) -> dict[str, Any]:
    """Write one case's recording into a folder `1`, and return its label."""
    own = scene(case, seed)
    driven = own.driven(own.faults, own.chance)
    labels = list(own.labels)
    for one in labels:
        if one["effect"] == "bump":
            feel(one, driven.time, driven.counts[:, own.robot.channels.index(one["component"])])
    noise, dropped = (
        2.0 if case.note == "noisier poses" else 1.0,
        0.01 if case.note == "dropped frames" else 0.0,
    )
    write(folder / "1", own.robot, driven, case.poses, noise, dropped, own.chance)
    verdict = {"null": ["agreement"], "insufficient": ["insufficient"]}.get(case.kind, ["mismatch"])
    return {
        "kind": case.kind, "verdict": verdict, "poses": case.poses, "recordings": ["1"], "effects": labels,
        "engine": "own", "drive": case.drive, "note": case.note,
    }  # fmt: skip


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
