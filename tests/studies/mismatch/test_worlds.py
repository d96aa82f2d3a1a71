"""Worlds: labelled cases of one form, written once, taken up again, and left out where they are not here."""

import json
from contextlib import contextmanager

import pytest

from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.errors import OmnimateError
from studies.mismatch.worlds.registry import chosen, worlds
from studies.mismatch.worlds.world import AbsentError, LabelledWorld, Request, WrittenWorld, drawn
from tests.studies.mismatch.answers import label

LABELS = {f"case-{number}": label("null") for number in range(10)}


@contextmanager
def silent(_doing):
    yield lambda _done, _total: None


ALL = Request()


def corpus(world, place, request=ALL):
    return world.corpus(place, request, 1, silent)


def written(calls):
    def write(_folder, request, _jobs, _report):
        calls.append(request)
        return drawn(LABELS, request)

    return WrittenWorld("made", "made", write)


def test_a_world_is_written_once_and_taken_up_again_with_the_same_seal(tmp_path):
    calls = []
    first, again = (corpus(written(calls), tmp_path) for _ in range(2))
    assert first.digest == again.digest
    assert again.labels == LABELS
    assert calls == [Request()]


def test_a_world_that_was_not_written_to_its_end_goes_on(tmp_path):
    def stopped(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        corpus(WrittenWorld("made", "made", stopped), tmp_path)
    assert corpus(written([]), tmp_path).labels == LABELS


def test_a_smaller_number_of_cases_is_drawn_by_the_seed():
    first, again, other = (drawn(LABELS, Request(seed, cases=4)) for seed in (1, 1, 2))
    assert len(first) == 4
    assert first == again != other
    assert drawn(LABELS, Request(cases=99)) == LABELS


def test_a_world_whose_engine_is_not_installed_is_left_out_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("studies.mismatch.worlds.registry.find_spec", lambda _name: None)
    (world,) = chosen(tmp_path, ["bullet"])
    with pytest.raises(AbsentError, match="pybullet is not installed"):
        corpus(world, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_name_that_no_world_has_is_refused_with_the_names_that_they_have(tmp_path):
    with pytest.raises(OmnimateError, match="no world 'husky'; expected engine, wide, nameless, mujoco"):
        chosen(tmp_path, ["husky"])


@pytest.mark.parametrize("name", ["concealed", "concealed2", "contact"])
def test_the_recordings_of_a_labelled_set_are_where_its_labels_say(shared_data, tmp_path, name):
    found = corpus(worlds(shared_data)[name], tmp_path)
    assert len(found.labels) >= 13
    folder, label = found.question(next(iter(found.labels)))
    assert len(load_recording(folder / label["recordings"][0])) > 100


def test_healthy_robots_alone_can_be_asked_for(tmp_path):
    """Of a set with labels, those without a fault; of an engine, as many as are wanted."""
    labels = LABELS | {f"fault-{number}": label("single") for number in range(5)}
    (tmp_path / "labels.json").write_text(json.dumps(labels), encoding="utf-8")
    found = corpus(LabelledWorld("made", "made", tmp_path), tmp_path, Request(healthy=True))
    assert set(found.labels) == set(LABELS)
    (wide,) = chosen(tmp_path, ["wide"])
    found = corpus(wide, tmp_path / "wide", Request(seed=1, cases=2, healthy=True))
    assert [each["kind"] for each in found.labels.values()] == ["null", "null"]
    assert [each["effects"] for each in found.labels.values()] == [[], []]


def test_the_nameless_world_conceals_nothing_else(tmp_path):
    (nameless,) = chosen(tmp_path, ["nameless"])
    found = corpus(nameless, tmp_path, Request(seed=1, cases=1))
    assert [effect["effect"] for label in found.labels.values() for effect in label["effects"]] == ["unknown"]
