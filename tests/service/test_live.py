"""A service in a process of its own, as its clients meet it: streams, examples, and its own document."""

import shutil
import subprocess
import sys
from pathlib import Path

import httpx2
import pytest

from studies.speed.service_contract import contract

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
PATIENCE = 600.0  # [s] of an example that normally takes seconds


def test_the_page_and_the_document_come_without_any_other_host(url):
    page = httpx2.get(url, timeout=60.0)
    assert "default-src 'self'" in page.headers["content-security-policy"]
    assert "http" not in page.text.replace("http-equiv", "").replace("http://www.w3.org", "")
    document = httpx2.get(f"{url}/openapi.json", timeout=60.0).json()
    assert document["openapi"].startswith("3.1")
    calls = [call for path in document["paths"].values() for call in path.values()]
    assert len({call["operationId"] for call in calls}) == len(calls)


@pytest.mark.parametrize(
    ("program", "example", "words"),
    [
        ("bash", "05_fleet.sh", ["wheel_separation_multiplier: 0.98"]),
        (sys.executable, "06_fleet_client.py", ["E_max,syst", "is now at version"]),
    ],
    ids=["curl", "python"],
)
def test_the_example_calibrates_the_robot(url, program, example, words):
    if program == "bash" and shutil.which("curl") is None:
        pytest.skip("curl is not on this machine")
    command = [program, EXAMPLES / example, url, "1", "2"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=PATIENCE)
    assert all(word in done.stdout for word in words)


@pytest.mark.slow
def test_another_generator_makes_a_client_from_the_document(url, tmp_path):
    generator = Path(sys.executable).with_name("openapi-python-client")
    subprocess.run(
        [generator, "generate", "--url", f"{url}/openapi.json", "--meta", "setup", "--output-path",
         tmp_path / "gen"], check=True, capture_output=True, timeout=PATIENCE,
    )  # fmt: skip
    code = "from omnimate_client.api.umbmark import accept_result; from omnimate_client.models import Solve"
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path / "gen", check=True)


@pytest.mark.slow
def test_no_answer_is_one_that_the_document_does_not_know(url, tmp_path):
    run = contract(tmp_path, url, 3, "examples,fuzzing", None)
    assert run.returncode == 0, run.stdout[-4000:]
