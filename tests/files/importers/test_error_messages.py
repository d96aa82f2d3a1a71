"""Broken input of importers against its whole message: tests/data/importers."""

import pytest

from omnimate.files.importers.csv_file.importer import read_csv
from omnimate.vehicle.errors import OmnimateError
from studies.datasets.optiodom.scores import experiment_of_optiodom
from tests.samples import broken


@pytest.mark.parametrize("case", broken("importers/optiodom_sets.toml"))
def test_a_broken_optiodom_set_is_answered_with_its_message(tmp_path, case):
    (tmp_path / "set_metadata.csv").write_text(case["metadata"], encoding="utf-8")
    (tmp_path / "set_run-01.csv").write_text(case["rows"], encoding="utf-8")
    with pytest.raises(OmnimateError) as caught:
        experiment_of_optiodom(tmp_path)
    assert str(caught.value) == case["message"].replace("FOLDER", str(tmp_path))


@pytest.mark.parametrize("case", broken("importers/csv_mappings.toml"))
def test_a_broken_mapping_or_csv_file_is_answered_with_its_message(tmp_path, case):
    (tmp_path / "map.toml").write_text(case["mapping"], encoding="utf-8")
    (tmp_path / "drive.csv").write_text(case["table"], encoding="utf-8")
    with pytest.raises(OmnimateError) as caught:
        read_csv(tmp_path / "drive.csv", tmp_path / "map.toml")
    assert str(caught.value) == case["message"].replace("FOLDER", str(tmp_path))
