import os
import shutil
import signal
import subprocess
import sys
import threading

import pytest

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.run import Workers, run_batch
from omnimate.fleet.batch.tables import decode_columns
from omnimate.fleet.errors import FleetError
from omnimate.fleet.judge import judge_day

CLUSTER = """
import sys
from omnimate.fleet.batch.run import Workers, run_batch
if __name__ == "__main__":
    run_batch(*sys.argv[1:], workers=Workers(jobs=2))
"""
CHILD = "import sys; from omnimate.fleet.batch.run import run_batch; run_batch(*sys.argv[1:])"


def contents(results):
    """Return the bytes of all result files by their paths."""
    return {path.relative_to(results): path.read_bytes() for path in results.rglob("*.parquet")}


def column(results, table, name):
    files = open_files(str(results))
    return [
        value
        for path in files.glob(f"{table}/*/*/*.parquet")
        for value in decode_columns(files.read(path))[name]
    ]


@pytest.fixture(scope="module")
def results(store, tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    assert run_batch(str(store), str(folder)).done == 6
    return folder


def test_every_recording_has_its_results_in_all_tables_by_robot_and_day(results):
    for table in ("recordings", "numbers", "ways", "crossings"):
        assert len(list(results.glob(f"{table}/robot=*/day=2026-03-0[23]/060000-*.parquet"))) == 6
    assert column(results, "recordings", "error") == [None] * 6
    assert set(column(results, "recordings", "triage")) <= {"agreement", "mismatch", "insufficient"}
    assert set(column(results, "numbers", "name")) == {
        *("left wheel", "right wheel", "wheelbase", "joint_a", "joint_b")
    }


def test_what_is_known_is_not_processed_again(store, results):
    before = contents(results)
    assert run_batch(str(store), str(results)).known == 6
    assert contents(results) == before


def test_a_recording_that_changed_is_processed_again_and_its_old_results_go(store, tmp_path):
    mine, results = tmp_path / "store", tmp_path / "results"
    shutil.copytree(store, mine)
    run_batch(str(mine), str(results), day="2026-03-02")
    poses = next(mine.glob("robot=tug-*/day=2026-03-02/*/poses.csv"))
    poses.write_text("\n".join(poses.read_text().splitlines()[:-1]) + "\n")
    outcome = run_batch(str(mine), str(results), day="2026-03-02")
    assert (outcome.done, outcome.known) == (1, 2)
    assert len(list(results.glob("recordings/robot=tug-*/*/*.parquet"))) == 1


def test_results_stay_of_a_recording_whose_name_begins_with_that_of_another(store, tmp_path):
    """`lap` is processed after `lap-1`, and deletes only its own former results."""
    mine, results = tmp_path / "store", tmp_path / "results"
    recording = next(store.glob("robot=tug-*/day=2026-03-02/*"))
    for name in ("lap-1", "lap"):
        shutil.copytree(recording, mine / recording.relative_to(store).parent / name)
    run_batch(str(mine), str(results), diagnosed=False)
    for folder in mine.glob("robot=*/*/*"):
        (folder / "vehicle.toml").write_text("name = 3\n")
        run_batch(str(mine), str(results), diagnosed=False)
        assert sorted(column(results, "recordings", "recording")) == ["lap", "lap-1"]


@pytest.mark.parametrize("scheme", ["", "file://"])
def test_names_with_the_characters_of_patterns_are_names_as_any_other(store, results, tmp_path, scheme):
    """Robots, recordings and folders may be called `tug [7]`: the same results, and known the next time."""
    root = tmp_path / "hall [2]"
    recording = next(store.glob("robot=tug-*/day=2026-03-02/*"))
    mine = root / "store/robot=tug [7]/day=2026-03-02/lap*"
    shutil.copytree(recording, mine)
    call = f"{scheme}{root}/store", f"{scheme}{root}/results"
    assert run_batch(*call).done == 1
    assert run_batch(*call).known == 1
    assert column(root / "results", "recordings", "error") == [None]
    hashes = column(root / "results", "recordings", "recording_hash")
    assert set(hashes) <= set(column(results, "recordings", "recording_hash"))
    (mine / "vehicle.toml").write_text("name = 3\n")
    assert run_batch(*call).done == 1
    assert len(column(root / "results", "recordings", "recording")) == 1


@pytest.mark.parametrize("table", ["recordings", "ways"])
def test_a_damaged_result_is_named_by_the_report_with_what_repairs_it(store, results, tmp_path, table):
    mine = tmp_path / "results"
    shutil.copytree(results, mine)
    path = next(mine.glob(f"{table}/*/*/*.parquet"))
    path.write_bytes(b"")
    row = "recordings" / path.relative_to(mine / table)
    with pytest.raises(FleetError, match=f"damaged or gone: .*; delete {row}, and `omnimate fleet run"):
        judge_day(open_files(str(mine)))
    (mine / row).unlink()
    assert run_batch(str(store), str(mine)).done == 1
    assert contents(mine) == contents(results)


def test_a_damaged_row_of_a_recording_is_written_again(store, results, tmp_path):
    mine = tmp_path / "results"
    shutil.copytree(results, mine)
    next(mine.glob("recordings/*/*/*.parquet")).write_bytes(b"PAR1")
    assert run_batch(str(store), str(mine)).done == 1
    assert contents(mine) == contents(results)


def test_a_broken_recording_says_why_and_the_others_have_their_results(store, tmp_path):
    mine, results = tmp_path / "store", tmp_path / "results"
    shutil.copytree(store, mine)
    next(mine.glob("robot=tug-*/day=2026-03-02/*/vehicle.toml")).write_text("name = 3\n")
    outcome = run_batch(str(mine), str(results), day="2026-03-02")
    assert (outcome.done, outcome.failed) == (3, ())
    again = run_batch(str(mine), str(results), day="2026-03-02")
    assert (again.done, again.known) == (0, 3)
    errors = [error for error in column(results, "recordings", "error") if error]
    assert len(errors) == 1
    assert "vehicle.toml" in errors[0]
    assert str(tmp_path) not in errors[0]
    for batch in (outcome, again):
        assert [error for _, error in batch.unreadable] == errors


@pytest.mark.parametrize("day", ["2026-99-99", "2026-02-30", "20260302", "2026-W10-1", "today"])
def test_a_folder_whose_day_is_no_date_is_left_out_and_named(store, tmp_path, day):
    mine, results = tmp_path / "store", tmp_path / "results"
    shutil.copytree(next(store.glob("robot=tug-*/day=2026-03-02")), mine / f"robot=x/day={day}")
    with pytest.raises(FleetError, match=f"no recording .robot=x/day={day} is of no date"):
        run_batch(str(mine), str(results), diagnosed=False)
    shutil.copytree(next(store.glob("robot=tug-*/day=2026-03-02")), mine / "robot=x/day=2026-03-02")
    outcome = run_batch(str(mine), str(results), diagnosed=False)
    assert (outcome.done, outcome.undated) == (1, (f"robot=x/day={day}",))
    assert not list(results.glob(f"*/robot=x/day={day}"))


@pytest.mark.slow
def test_results_are_the_same_bytes_when_workers_are_killed_at_any_moment(store, results, tmp_path):
    """Each worker is killed once it has written some more files than the one before; the last one may end."""
    broken = tmp_path / "results"
    for files in (1, 6, 15, 22):
        worker = subprocess.Popen([sys.executable, "-c", CHILD, str(store), str(broken)])
        while worker.poll() is None and len(contents(broken)) < files:
            pass
        if worker.poll() is None:
            worker.send_signal(signal.SIGKILL)
        worker.wait()
    run_batch(str(store), str(broken))
    assert contents(broken) == contents(results)


@pytest.mark.slow
def test_results_are_the_same_bytes_when_processes_of_dask_are_killed_while_they_work(
    store, results, tmp_path
):
    """Each time some more files are there, one worker is killed, in turn; Dask starts another."""
    distributed = pytest.importorskip("distributed")
    mine, over = tmp_path / "results", threading.Event()
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0"
    ) as cluster:
        killed = []

        def kill():
            for files in (1, 9, 17):
                while len(contents(mine)) < files and not over.wait(0.01):
                    pass
                nanny = cluster.workers.get(len(killed) % 2)  # none while another takes its place
                if nanny is not None and nanny.pid is not None and not over.is_set():
                    os.kill(nanny.pid, signal.SIGKILL)
                    killed.append(nanny.pid)

        killer = threading.Thread(target=kill)
        killer.start()
        outcome = run_batch(str(store), str(mine), workers=Workers(scheduler=cluster.scheduler_address))
        over.set()
        killer.join()
    assert killed
    assert outcome.failed == ()
    assert contents(mine) == contents(results)


@pytest.mark.slow
def test_results_are_the_same_bytes_when_the_scheduler_is_killed(store, results, tmp_path):
    """The batch's process, which is the scheduler, is killed once files are there, and started again."""
    pytest.importorskip("distributed")
    broken = tmp_path / "results"
    batch = subprocess.Popen([sys.executable, "-c", CLUSTER, str(store), str(broken)])
    while batch.poll() is None and len(contents(broken)) < 5:
        pass
    batch.send_signal(signal.SIGKILL)
    batch.wait()
    run_batch(str(store), str(broken))
    assert contents(broken) == contents(results)


def test_results_are_the_same_bytes_by_workers_of_dask_in_a_remote_store(store, results, tmp_path):
    distributed = pytest.importorskip("distributed")
    pytest.importorskip("fsspec")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:
        address = cluster.scheduler_address
        outcome = run_batch(
            f"file://{store}", f"file://{tmp_path}/results", workers=Workers(scheduler=address)
        )
    assert outcome.done == 6
    assert contents(tmp_path / "results") == contents(results)


@pytest.mark.parametrize("address", ["10.0.0.1", "http://10.0.0.1:8786"])
def test_the_address_of_no_scheduler_is_refused_with_what_was_expected(store, tmp_path, address):
    pytest.importorskip("distributed")
    with pytest.raises(FleetError, match=r"workers: Dask .*expected .* tcp://10.0.0.1:8786, or memory"):
        run_batch(str(store), str(tmp_path / "results"), workers=Workers(scheduler=address))


def test_a_store_without_recordings_is_refused_with_what_was_expected(tmp_path):
    with pytest.raises(FleetError, match="robot=NAME/day=YYYY-MM-DD"):
        run_batch(str(tmp_path), str(tmp_path / "results"))
    assert not list(tmp_path.iterdir())
