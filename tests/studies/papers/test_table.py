"""The papers' numbers: what needs no chance agrees to the digits given, and the protocols have their rows."""

import pickle

import pytest

from studies.papers.command import stages
from studies.papers.linkage_numbers import linkage_numbers
from studies.papers.protocols import omnimate_laps, straight_line
from studies.papers.squares import square_numbers, statistics


@pytest.mark.parametrize("rows", [square_numbers, linkage_numbers])
def test_every_number_without_chance_agrees_or_is_a_known_error_of_the_print(rows):
    for row in rows():
        assert row.verdict in {"agrees", "misprint"}, row


def test_the_method_leaves_what_its_scatter_makes_of_it():
    by_what = {row.what: row for row in statistics(400)}
    assert all(row.verdict != "differs" for row in by_what.values())
    assert by_what["mean E_max after, 25 mm of scatter [mm]"].verdict == "agrees"
    assert by_what["5 to 95 % of it [mm]"].verdict == "agrees"
    assert by_what["variance of E_b, E_d over the bound, true weights"].verdict == "agrees"


@pytest.mark.slow
def test_the_omnimate_with_bumps_keeps_the_papers_bounds():
    rows = {row.what: row for row in omnimate_laps(2)}
    assert rows["worst |heading|, bumps [deg], OmniMate"].verdict == "agrees"
    assert rows["mean |heading|, bumps [deg], without / with IPEC"].verdict == "agrees"


def test_a_bound_that_is_not_kept_says_where_the_error_comes_from():
    rows = (*straight_line(1), *omnimate_laps(2))
    for row in rows:
        assert bool(row.note) == (row.verdict in {"missed", "unsure"}), row


def test_the_full_table_has_every_experiment_of_table_i():
    names = [name for name, _ in stages(quick=False)]
    assert sum(name.startswith("U: Table I") for name in names) == 8
    assert len(stages(quick=True)) < len(names)


def test_every_stage_can_be_sent_to_another_process():
    for name, stage in stages(quick=False):
        assert pickle.loads(pickle.dumps(stage)), name
