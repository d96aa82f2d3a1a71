"""Runs all benchmarks after each other: python -m studies.speed. README.md lists them."""

import subprocess
import sys
from pathlib import Path

codes = {}
for path in sorted(Path(__file__).parent.glob("[!_]*.py")):
    if "__main__" in path.read_text(encoding="utf-8"):
        print(f"== {path.stem}", flush=True)
        codes[path.stem] = subprocess.call([sys.executable, "-m", f"studies.speed.{path.stem}"])
failed = [name for name, code in codes.items() if code]
print(f"== {len(codes)} benchmarks, {len(failed)} below what is wanted: {', '.join(failed) or 'none'}")
sys.exit(bool(failed))
