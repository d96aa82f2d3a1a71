import shutil

import pytest

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.run import run_batch
from omnimate.fleet.batch.store import StoredRecording, recordings_in
from omnimate.fleet.batch.work import delete_recording
from omnimate.fleet.judge import judge_day

pytest.importorskip("pyarrow")


def judged(store, results):
    """Process a store and judge each of its days; return the bytes of all files by their paths."""
    run_batch(str(store), str(results), diagnosed=False)
    for day in sorted({stored.day for stored in recordings_in(open_files(str(store)), "*")[0]}):
        judge_day(open_files(str(results)), day)
    return {path.relative_to(results): path.read_bytes() for path in results.rglob("*") if path.is_file()}


def folders(root):
    return sorted(path.relative_to(root) for path in root.rglob("*") if path.is_dir())


@pytest.mark.parametrize("day", ["2062-01-01", "2026-01-01"])
def test_after_a_recording_of_a_wrong_day_was_deleted_all_is_as_without_it(store, tmp_path, day):
    mine, results = tmp_path / "store", tmp_path / "results"
    shutil.copytree(store, mine)
    before, places = judged(mine, results), folders(results)
    stored = recordings_in(open_files(str(mine)), "*")[0][0]
    folder = mine / stored.partition / stored.name
    wrong = StoredRecording(stored.robot, day, "wrong")
    shutil.copytree(folder, mine / wrong.partition / wrong.name)
    judged(mine, results)
    assert delete_recording(open_files(str(mine)), open_files(str(results)), wrong)
    assert judged(mine, results) == before
    assert (folders(mine), folders(results)) == (folders(store), places)
    assert not delete_recording(open_files(str(mine)), open_files(str(results)), wrong)
