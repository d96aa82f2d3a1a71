"""Stages that are computed in several processes."""

from studies.papers.command import run, stages, under_way


def test_stages_in_two_processes_give_what_one_gives():
    plan = [stage for stage in stages(quick=True) if stage[0] in {"U: equations", "C and O: equations"}]
    assert dict(run(plan, 2)) == dict(run(plan, 1))


def test_as_many_stages_are_under_way_as_there_are_processes_until_the_last_ones():
    plan = [("first", tuple), ("second", tuple), ("third", tuple)]
    assert under_way(plan, [], 2) == ["first", "second"]
    assert under_way(plan, ["first"], 2) == ["second", "third"]
    assert under_way(plan, ["first", "third"], 2) == ["second"]
