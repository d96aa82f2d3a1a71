"""The worlds whose drives `tracking` judges: recordings of two trucks, and their true or measured poses.

The worlds of `studies/mismatch` share no code with the estimator, and `made` is of the project's own
simulator. Drives are kept in a folder, so that they are made a single time.
"""

from __future__ import annotations

import json
import shutil
from functools import partial
from typing import TYPE_CHECKING

from omnimate.files.recordings.folder import load_recording
from studies.mismatch.engines.cases import Case
from studies.mismatch.engines.scene import scene
from studies.mismatch.engines.vocabulary import VOCABULARY
from studies.mismatch.engines.writing import Measuring, write

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from omnimate.vehicle.recording import Recording
    from studies.mismatch.engines.scene import Scene

    Drives = Iterator[tuple[str, Recording]]

EXACT = Measuring((1e-6, 1e-6, 1e-6), 0.05, both=False)
SEED = 4  # of the worlds that were in view when the constants were chosen
NO_SENSE = {"clock_drift"}  # of the poses, which judge here
DRIVES = ("eights", "slalom", "squares")


def engine(folder: Path, seed: int = SEED) -> Drives:
    """Yield drives of `studies.mismatch.engines.engine`: each effect of its vocabulary, and healthy ones."""
    names: list[tuple[tuple[str, str], ...]] = [()] * 3
    names += [
        ((effect, VOCABULARY[effect].components[0]),) for effect in VOCABULARY if effect not in NO_SENSE
    ]
    for number, effects in enumerate(names):
        case = Case("single" if effects else "null", effects, DRIVES[number % 3], "mocap")
        setting = scene(case, seed * 1000 + number)
        what = " ".join(effects[0]) if effects else f"healthy {number + 1}"
        yield what, _kept(folder / f"{number:02d}", partial(_driven, setting))


def _driven(setting: Scene, at: Path) -> None:
    driven = setting.driven(setting.faults, setting.chance)
    write(at, setting.robot, driven, EXACT, 0.0, setting.chance)


def mujoco(folder: Path, seed: int = SEED) -> Drives:
    """Yield drives of the contact physics in `engines/mujoco`: each fault in turn."""
    from studies.mismatch.engines.mujoco import corpus

    for number, name in enumerate(corpus.FAULTS):

        def make(at: Path, name: str = name, number: int = number) -> None:
            at.mkdir(parents=True)
            (key,) = corpus.write(at, [name], seed * 1000 + number, poses="exact")
            shutil.move(at / key / "1", at / "1")

        yield name, _kept(folder / f"{number:02d}", make, inside="1")


def bullet(folder: Path, seed: int = SEED) -> Drives:
    """Yield drives of the linked pair in `engines/bullet`."""
    from studies.mismatch.engines.bullet.cases import make

    for number in range(2, 62, 5):  # every fifth robot is the pair
        yield from _labelled(folder / f"{number:02d}", lambda at, k=number: make((at, seed, k), EXACT))


def wide(folder: Path, seed: int = SEED) -> Drives:
    """Yield drives of robots of all sizes in `engines/wide`."""
    from studies.mismatch.engines.wide.cases import make

    for number in range(24):
        yield from _labelled(folder / f"{number:02d}", lambda at, k=number: make((at, seed, k), EXACT))


def recorded(folder: Path) -> Drives:
    """Yield the recordings in a folder with `labels.json`, such as `../shared/data/contact`."""
    for key, label in json.loads((folder / "labels.json").read_text(encoding="utf-8")).items():
        recording = load_recording(folder / key / label["recordings"][0])
        if (
            recording.vehicle.linkage is not None
            and recording.poses is not None
            and len(recording.poses.of("a").time) > 1
        ):
            effects = " and ".join(f"{each['effect']} {each['component']}" for each in label["effects"])
            yield label.get("what") or label.get("drive") or effects or "healthy", recording


def _labelled(folder: Path, make: Callable[[Path], dict[str, object]]) -> Drives:
    """Yield the recording of a case that labels itself, if it is of two trucks."""

    def made(at: Path) -> None:
        label = make(at)
        (at / "label.json").write_text(json.dumps(label), encoding="utf-8")

    recording = _kept(folder, made, inside="1")
    label = json.loads((folder / "label.json").read_text(encoding="utf-8"))
    if recording.vehicle.linkage is not None:
        effects = " and ".join(f"{each['effect']} {each['component']}" for each in label["effects"])
        yield effects or "healthy", recording


def _kept(folder: Path, make: Callable[[Path], None], inside: str = ".") -> Recording:
    """Return the recording in a folder, which is made where it is absent."""
    if not folder.exists():
        unfinished = folder.with_name(folder.name + ".unfinished")
        shutil.rmtree(unfinished, ignore_errors=True)
        make(unfinished)
        unfinished.rename(folder)
    return load_recording(folder / inside)
