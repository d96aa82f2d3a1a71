"""`python -m studies reproduce`: a table that fits a terminal, the figures, and an exit code that tells."""

import pytest

from studies.papers.command import run, stages, under_way
from studies.papers.linkage_numbers import linkage_numbers
from studies.papers.rows import Row


@pytest.fixture
def one_stage(monkeypatch):
    """Leave the command one stage."""

    def leave(rows):
        monkeypatch.setattr("studies.papers.command.stages", lambda **_: [("a stage", lambda: rows)])

    return leave


def test_every_line_fits_120_columns_and_each_verdict_is_one_word(studies, one_stage):
    rows = linkage_numbers()
    one_stage(rows)
    result = studies("reproduce", "--quick", "--jobs", 1)
    assert result.code == 0
    assert max(map(len, result.out.splitlines())) <= 120
    assert all(" " not in row.verdict for row in rows)
    assert "a stage" in result.out


def test_a_note_stands_below_its_row(studies, one_stage):
    one_stage((Row("C", "6.1", "worst [deg]", "< 1", "2.0", "missed", note="2.0, switching off: no x 0.4"),))
    lines = studies("reproduce", "--jobs", 1).out.splitlines()
    place = next(number for number, line in enumerate(lines) if "missed" in line)
    assert "no x 0.4" in lines[place + 1]


def test_a_number_that_nobody_expects_makes_the_exit_code_1(studies, one_stage):
    one_stage((Row("C", "(4)", "heading [deg]", "0.44", "0.60", "differs"),))
    result = studies("reproduce", "--jobs", 1)
    assert result.code == 1
    assert "printed 0.44, ours 0.60" in result.err


def test_a_folder_that_cannot_be_made_is_one_sentence(studies, one_stage, tmp_path):
    (tmp_path / "file").write_text("")
    one_stage(())
    result = studies("reproduce", "--jobs", 1, "--figures", tmp_path / "file" / "in")
    assert result.code == 1
    assert "cannot be made" in result.err


def test_stages_in_two_processes_give_what_one_gives():
    plan = [stage for stage in stages(quick=True) if stage[0] in {"U: equations", "C and O: equations"}]
    assert dict(run(plan, 2)) == dict(run(plan, 1))


def test_as_many_stages_are_under_way_as_there_are_processes_until_the_last_ones():
    plan = [("first", tuple), ("second", tuple), ("third", tuple)]
    assert under_way(plan, [], 2) == ["first", "second"]
    assert under_way(plan, ["first"], 2) == ["second", "third"]
    assert under_way(plan, ["first", "third"], 2) == ["second"]
