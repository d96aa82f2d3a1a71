"""Check that commits are named `area: what changes`, as a commit-msg hook (FILE) or in the gate (--since)."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

FORM = re.compile(r"[a-z_]+(\([a-z_ -]+\))?: [a-z].{2,}")
LONGEST = 72  # characters of a subject that `git log --oneline` shows whole in a terminal


def problem(subject: str) -> str | None:
    """Return what is wrong with the subject of a commit, or None."""
    if subject.startswith(("Merge ", "Revert ", "fixup! ", "squash! ")):
        return None
    if not FORM.fullmatch(subject):
        return "expected `area: what changes`, imperative, in lower case after the colon"
    if len(subject) > LONGEST:
        return f"{len(subject)} characters; expected at most {LONGEST}"
    return None


def main(arguments: list[str]) -> int:
    """Check one message in a file, or the commits since another one; return the exit code."""
    if arguments[:1] == ["--since"]:
        command = ["git", "log", "--no-merges", "--format=%s", f"{arguments[1]}..HEAD"]
        log = subprocess.run(command, check=False, capture_output=True, text=True)
        if log.returncode:
            print(f"commits: {arguments[1]} is not in this clone; nothing is checked")
            return 0
        subjects = log.stdout.splitlines()
    else:
        subjects = Path(arguments[0]).read_text(encoding="utf-8").splitlines()[:1]
    problems = [(subject, found) for subject in subjects if (found := problem(subject))]
    for subject, found in problems:
        print(f"commit {subject!r}: {found}", file=sys.stderr)
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
