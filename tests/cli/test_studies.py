"""Studies run from a checkout: elsewhere their verbs say so in one sentence."""

import pytest

from omnimate.cli import studies


@pytest.mark.parametrize("verb", ["prove", "reproduce"])
def test_a_study_in_an_installed_package_says_where_it_runs(omnimate, monkeypatch, verb):
    monkeypatch.setattr(studies, "find_spec", lambda _name: None)
    result = omnimate(verb, "--quick")
    assert result.code == 1
    assert result.err == (
        f"error: omnimate {verb} is a study, which runs from a checkout of the source; "
        "the installed package does not hold it\n"
    )


@pytest.mark.parametrize("room", ["evaluation", "reproduction"])
def test_in_a_checkout_a_study_is_there(room):
    studies.check_checkout("any", room)
