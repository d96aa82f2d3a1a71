"""A small part of `python -m studies prove`: concealed by one engine, found by another."""

import pytest

from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch import diagnose
from studies.mismatch.engines.scene import Case, make
from studies.mismatch.scoring.judging import first_right
from studies.mismatch.scoring.score import rows

PART = {
    "healthy": Case("null", (), "squares", "none"),
    "healthy, frames dropped": Case("null", (), "eights", "mocap", note="dropped frames"),
    "worn": Case("single", (("wheel_diameter", "a.left"),), "squares", "sonar"),
    "turned": Case("single", (("joint_bias", "joint_b"),), "slalom", "mocap"),
    "pushed": Case("unknown", (("unknown", "a"),), "slalom", "mocap", note="pushes"),
    "warming": Case("unknown", (("unknown", "a.left"),), "slalom", "mocap", note="warming"),
    "strange": Case("unknown", (("unknown", "link"),), "slalom", "mocap", note="sag"),
}


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """Return labels and answers of a few cases."""
    folder = tmp_path_factory.mktemp("proof")
    labels = {
        name: make(folder / name, case, 40 + number) for number, (name, case) in enumerate(PART.items())
    }
    return labels, {name: diagnose([load_recording(folder / name / "1")]).as_json() for name in labels}


@pytest.mark.slow
def test_healthy_robots_raise_no_alarm(proved):
    labels, answers = proved
    table = {row.name: row for row in rows(labels, answers)}
    assert table["false alarm on a null"].value == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["worn", "turned"])
def test_what_is_concealed_is_named_first(proved, name):
    labels, answers = proved
    assert first_right(labels[name], answers[name])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "component", "least"),
    [("strange", "link", 0.9), ("pushed", "a", 0.9), ("warming", "a.left", 0.5)],
)
def test_physics_without_a_word_is_unknown(proved, name, component, least):
    """A tyre that has warmed up is a larger tyre for most of the drive, so that this is not certain."""
    _, answers = proved
    first = answers[name]["findings"][0]
    assert (first["effect"], first["component"]) == ("unknown", component)
    assert first["probability"] > least
