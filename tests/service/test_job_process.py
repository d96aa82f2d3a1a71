"""A job in its own process, as its parent sees it: progress, a result, an error, or a death."""

import multiprocessing
import os
import subprocess
import sys
from unittest.mock import Mock

import pytest

from omnimate.service.jobs.diagnosing import run_diagnosis
from omnimate.service.jobs.process import NICENESS, JobProcess, running
from omnimate.service.jobs.queue import finish_job
from omnimate.service.store.tables import JobRow


def outcome_of(messages, go_on=lambda _message: True, *, close=True):
    """Return the outcome of a process that sent messages and ended."""
    ours, theirs = multiprocessing.Pipe()
    for message in messages:
        theirs.send(message)
    if close:
        theirs.close()
    process = Mock(exitcode=-9, is_alive=lambda: False)
    return JobProcess(process, ours).outcome(go_on)


def test_the_last_message_is_the_outcome():
    assert outcome_of([{"progress": 0.5, "doing": "fitting"}, {"verdict": "agreement"}]) == {
        "verdict": "agreement"
    }


def test_each_report_of_progress_is_handed_on():
    reports = []
    messages = [{"progress": 0.1, "doing": "a"}, {"progress": 0.2, "doing": "b"}, {"error": "too short"}]
    outcome_of(messages, lambda message: reports.append(message) or True)
    assert reports == messages[:2]


def test_a_diagnosis_that_is_not_wanted_any_more_has_no_outcome():
    assert outcome_of([{"progress": 0.1, "doing": "a"}, {"error": "x"}], lambda _message: False) is None


@pytest.mark.parametrize("close", [True, False])
def test_a_process_that_ends_without_a_result_has_died(close):
    messages = [{"progress": 0.1, "doing": "a"}]
    assert outcome_of(messages, close=close) == {"died": "its process ended with code -9"}


def run(work, *arguments, **options):
    """Return the outcome of a job in a process of its own."""
    with running("diagnosis", work, *arguments, **options) as process:
        return process.outcome(lambda _message: True)


def test_a_folder_that_is_no_recording_is_an_error_with_its_reason(tmp_path):
    outcome = run(run_diagnosis, str(tmp_path), [("lap", "lap")])
    assert outcome["error"] == "lap: no such folder; a recording is a folder with vehicle.toml and can.log"


def test_a_process_ends_with_its_block(tmp_path):
    before = set(multiprocessing.active_children())
    with running("diagnosis", run_diagnosis, str(tmp_path), [("lap", "lap")]):
        assert len(set(multiprocessing.active_children()) - before) == 1
    assert set(multiprocessing.active_children()) == before


def test_the_traceback_of_an_error_is_logged_by_the_parent_and_kept_out_of_the_outcome(caplog):
    outcome = outcome_of([{"error": "an error in the job itself: x", "traceback": "File 1, line 2"}])
    assert outcome == {"error": "an error in the job itself: x"}
    assert caplog.messages == ["an error in the job itself: x\nFile 1, line 2"]


def take_memory(_report, size):
    """Take an amount of memory [bytes]."""
    return {"taken": len(bytearray(size))}


def niceness(_report):
    """Return by how much this process gives way to others."""
    return {"niceness": os.nice(0)}


def test_a_job_that_takes_too_much_memory_fails_with_its_reason_and_is_not_tried_again():
    outcome = run(take_memory, 2_000_000_000, memory=1_000_000_000)
    assert outcome == {"error": "this diagnosis takes more than 1000 MB of memory", "limit": "memory"}
    row = JobRow(state="running", attempts=1)
    assert not finish_job(row, outcome)
    assert (row.state, row.error) == ("failed", outcome["error"])


def test_a_job_gives_way_to_the_service():
    assert run(niceness) == {"niceness": min(os.nice(0) + NICENESS, 19)}


PROGRAM = """
from tests.service.test_job_process import niceness, run
if __name__ == "__main__":
    print(run(niceness))
"""
LITTLE_MEMORY = "import resource; resource.setrlimit(resource.RLIMIT_DATA, (1_000_000_000, 1_000_000_000))"


@pytest.mark.parametrize(
    ("first", "temporary"), [(LITTLE_MEMORY, "t"), ("", "d" * 120)], ids=["memory", "socket"]
)
def test_a_job_runs_where_memory_is_less_than_a_jobs_or_a_folder_too_deep_for_a_socket(
    first, temporary, tmp_path
):
    folder = tmp_path / temporary
    folder.mkdir()
    (folder / "job.py").write_text(first + PROGRAM)
    environment = {**os.environ, "TMPDIR": str(folder), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    ended = subprocess.run(
        [sys.executable, folder / "job.py"], env=environment, capture_output=True, text=True, check=True
    )
    assert "niceness" in ended.stdout


ENDLESS = """
import threading
from omnimate.service.jobs.process import running

def work(report_progress):
    print("working", flush=True)
    threading.Event().wait()

if __name__ == "__main__":
    with running("diagnosis", work) as process:
        process.outcome(lambda _message: True)
"""


@pytest.mark.skipif(os.name != "posix", reason="kill -9")
def test_a_job_ends_with_a_service_that_is_killed(tmp_path):
    """Also one that reports no progress; all processes of the service hold its output, which then ends."""
    program = tmp_path / "program.py"
    program.write_text(ENDLESS)
    with subprocess.Popen([sys.executable, program], stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout.readline() == "working\n"
        service.kill()
        assert service.communicate(timeout=30)[0] == ""
