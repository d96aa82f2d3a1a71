"""Runs all benchmarks, one after the other: python -m benchmarks."""

import subprocess
import sys
from pathlib import Path

names = sorted(path.stem for path in Path(__file__).parent.glob("[!_]*.py"))
codes = []
for name in names:
    print(f"== {name}", flush=True)
    codes.append(subprocess.call([sys.executable, "-m", f"benchmarks.{name}"]))
sys.exit(max(codes))
