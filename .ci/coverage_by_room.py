"""Print which part of each room's lines the tests ran, from the data that `pytest --cov` left behind."""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from pathlib import Path

from coverage import Coverage

with tempfile.TemporaryDirectory() as folder:
    report = Path(folder, "coverage.json")
    coverage = Coverage(messages=False)
    coverage.load()
    coverage.json_report(outfile=str(report))
    files = json.loads(report.read_text(encoding="utf-8"))["files"]

lines, covered = Counter[str](), Counter[str]()
for path, result in files.items():
    room = Path(path).parts[0] if "/" in path else "omnimate"
    for name in (room, "all"):
        lines[name] += result["summary"]["num_statements"]
        covered[name] += result["summary"]["covered_lines"]
print("Statements that the tests ran in their own process, without what numba compiles:")
for room in sorted(lines, key=lambda name: (name == "all", name)):
    print(f"  {room:<13}{100 * covered[room] / lines[room]:5.1f} %  of {lines[room]:6d}")
