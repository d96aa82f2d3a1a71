"""Recordings that an engine writes twice."""

import json

import pytest


@pytest.fixture
def written_twice(tmp_path):
    """Return a function that writes a case twice, checks that it is the same, and gives label and folder."""

    def write(make, *arguments, **options):
        folders = [tmp_path / name for name in ("first", "again")]
        labels = [json.loads(json.dumps(make(folder, *arguments, **options))) for folder in folders]
        assert labels[0] == labels[1]
        files = [
            {path.relative_to(folder).name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
            for folder in folders
        ]
        assert files[0] == files[1]
        assert {"can.log", "run.toml", "vehicle.toml"} <= files[0].keys()
        return labels[0], folders[0] / "1"

    return write
