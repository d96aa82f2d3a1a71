import numpy as np

from omnimate.figures.fleet import MapPlace, plot_floor_map, plot_history


def test_a_floor_map_names_what_happens_on_the_places(tmp_path):
    path, round_spread = tmp_path / "floor.svg", 0.01 * np.eye(2)
    places = [
        MapPlace("loss", 2.0, 3.0, 0.5, round_spread, "12.0 mm"),
        MapPlace("creep", 5.0, 6.0, 0.8, round_spread, "7.0 mm", np.array([0.005, -0.005])),
    ]
    driven = np.array([[1.0, 1.0, 5.0], [2.0, 3.0, 1.0]])
    plot_floor_map(places, driven, path, title="a night")
    text = path.read_text(encoding="utf-8")
    for words in ("a night", "travel is lost", "robots creep", "12.0 mm", "7.0 mm"):
        assert f"<!-- {words} -->" in text


def test_a_history_has_its_number_and_the_robots_name(tmp_path):
    path = tmp_path / "robot.svg"
    days = np.arange(5.0)
    plot_history(days, days, 0.1 + 0.0 * days, path, since=2.0, label="wheelbase [%]", title="tug-0000")
    text = path.read_text(encoding="utf-8")
    assert "<!-- wheelbase [%] -->" in text
    assert "<!-- tug-0000 -->" in text
