"""The service's answers against its OpenAPI document, by all checks of schemathesis, with and without a key.

Peer: the OpenAPI document that the service publishes.

Usage: python -m studies.speed.service_contract [--examples 50] [--phases examples,coverage,fuzzing]

Not checked are the two endless streams, and bodies of TOML and zip, which schemathesis cannot make. Allowed
beyond its rules are 428 for a missing If-Match (RFC 6585), and 422 for values that are in range but that no
robot can have measured.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from studies.benchmark import OMNIMATE, options
from studies.speed.service_process import serving

CONFIG = """
[checks]
missing_required_header.expected-statuses = [400, 401, 403, 404, 406, 415, 422, 428]
positive_data_acceptance.expected-statuses = ["2xx", "3xx", 401, 403, 404, 409, 410, 412, 422, 429, "5xx"]

[[operations]]
include-path = "/v1/robot/stream"
enabled = false

[[operations]]
include-path = "/v1/bus/frames"
enabled = false

[[operations]]
include-operation-id = ["createVehicle", "changeVehicle", "uploadRecording", "uploadDay"]
phases.coverage.enabled = false
phases.fuzzing.enabled = false
phases.stateful.enabled = false
phases.examples.enabled = false
"""


def contract(
    folder: Path, url: str, examples: int, phases: str, key: str | None
) -> subprocess.CompletedProcess[str]:
    """Run schemathesis on a service; its exit code is 0 when nothing failed."""
    config = folder / "schemathesis.toml"
    config.write_text(CONFIG)
    program = str(Path(sys.executable).with_name("schemathesis"))
    headers = ["-H", f"Authorization: Bearer {key}"] if key else []
    return subprocess.run(
        [
            program, "--config-file", str(config), "run", f"{url}/openapi.json", "--checks", "all",
            "--max-examples", str(examples), "--phases", phases, "--seed", "1",
            "--request-timeout", "60", "--no-color", *headers,
        ],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip


def make_key(folder: Path, database: str) -> str:
    """Return a key that may operate."""
    made = subprocess.run(
        [*OMNIMATE, "key", "add", "contract", "--role", "operate", "--database", database],
        cwd=folder, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return made.stdout.strip()


def main() -> None:
    given = options(__doc__, examples=50, phases="examples,coverage,fuzzing,stateful")
    failed = False
    for keyed in (False, True):
        with tempfile.TemporaryDirectory() as place:
            folder, database = Path(place), f"sqlite:///{place}/service.db"
            key = make_key(folder, database) if keyed else None
            with serving(folder, database) as service:
                print("with a key" if keyed else "without a key", flush=True)
                run = contract(folder, service.url, given.examples, given.phases, key)
                print(run.stdout[-3000:], run.stderr[-2000:])
                failed |= run.returncode != 0
    sys.exit(failed)


if __name__ == "__main__":
    main()
