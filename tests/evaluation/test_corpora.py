"""Corpora: written once, sealed, taken up again, and never mistaken for others."""

import json
from contextlib import contextmanager
from dataclasses import replace

import pytest

from omnimate.evaluation.corpora import Corpus, Request, seal, write_corpora
from omnimate.vehicle.errors import OmnimateError

REQUEST = Request(quick=True, contact=False, seed=1, part=1.0)
KINDS = "null", "single", "single", "multi"
LABELS = {f"own-{number}": {"kind": kind} for number, kind in enumerate(KINDS)}


@contextmanager
def silent(_doing):
    yield lambda _done, _total: None


@pytest.fixture
def write(monkeypatch):
    """Let nothing be driven; return a function that writes the corpora of a request and seals them."""

    def corpus(folder, _jobs, _report, **_kinds):
        folder.mkdir(parents=True)
        return LABELS

    def run(place, request=REQUEST):
        return [(corpus, seal(corpus)) for corpus in write_corpora(place, request, 1, silent)]

    monkeypatch.setattr("omnimate.proof.run.write_corpus", corpus)
    return run


def test_a_few_cases_are_the_first_of_each_of_three_kinds(tmp_path):
    assert list(Corpus(LABELS, tmp_path / "own").few().labels) == ["own-0", "own-1"]


def test_the_seal_is_the_same_when_a_study_goes_on(write, tmp_path):
    first, again = write(tmp_path), write(tmp_path)
    assert first == again
    assert json.loads((tmp_path / "own.json").read_text()) == LABELS


def test_another_request_needs_another_folder(write, tmp_path):
    write(tmp_path)
    with pytest.raises(OmnimateError, match="needs a folder of its own: --out FOLDER"):
        write(tmp_path, replace(REQUEST, seed=2))


def test_a_corpus_that_was_not_finished_is_refused(write, tmp_path):
    (tmp_path / "own").mkdir()
    with pytest.raises(OmnimateError, match="was not finished"):
        write(tmp_path)
