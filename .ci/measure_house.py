"""Print how large the project is, and through how many modules a recording passes in a diagnosis.

Usage: python .ci/measure_house.py [--hops]
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOT_PRODUCT = {"tests", "studies", "docs", "examples", ".ci"}


def sizes() -> None:
    """Print lines of Python of the product, the studies and the tests, and files below 40 lines."""
    command = ["git", "ls-files", "*.py"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    lines = {name: len((ROOT / name).read_text("utf-8").splitlines()) for name in listed}
    product = {name: count for name, count in lines.items() if name.split("/", 1)[0] not in NOT_PRODUCT}
    rooms = sorted({name.split("/")[0] for name in product if "/" in name})
    print(f"product {sum(product.values())} lines")
    for room in rooms:
        print(f"  {room} {_within(room, product)}")
    for folder in ("studies", "tests"):
        print(f"{folder} {_within(folder, lines)} lines")
    short = [name for name, count in product.items() if count < 40]
    packages = sum(name.endswith("__init__.py") for name in short)
    print(f"product files below 40 lines: {len(short)}, of which __init__.py {packages}")


def _within(folder: str, lines: dict[str, int]) -> int:
    return sum(count for name, count in lines.items() if name.startswith(f"{folder}/"))


def hops() -> None:
    """Print the modules to which a diagnosis passes a recording, and how often one is returned to."""
    import omnimate
    from omnimate.motion import paths

    recording = omnimate.simulate(program=paths.figure_eight(laps=2), seed=1)
    route: list[str] = []

    def note(frame: object, event: str, _argument: object) -> None:
        if event != "call":
            return
        code = frame.f_code  # type: ignore[attr-defined]
        if "omnimate" not in code.co_filename and str(ROOT) not in code.co_filename:
            return
        count = code.co_argcount + code.co_kwonlyargcount
        given = [frame.f_locals.get(name) for name in code.co_varnames[:count]]  # type: ignore[attr-defined]
        held = [value[0] if isinstance(value, (list, tuple)) and value else value for value in given]
        if any(value is recording for value in held):
            module = code.co_filename
            if not route or route[-1] != module:
                route.append(module)

    sys.setprofile(note)
    try:
        omnimate.diagnose([recording])
    finally:
        sys.setprofile(None)
    seen: set[str] = set()
    returns = sum(module in seen or bool(seen.add(module)) for module in route)
    print(f"diagnose: a recording enters {len(seen)} modules in {len(route)} hops, {returns} of them returns")


if __name__ == "__main__":
    sizes()
    if "--hops" in sys.argv[1:]:
        hops()
