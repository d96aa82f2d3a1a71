"""The real part of the proof: tables and figures of what is there, and a line for what is not."""


def test_recordings_that_are_not_there_are_left_out_and_that_is_said(studies, tmp_path):
    result = studies("prove", "--real-only", "--data", tmp_path)
    assert result.code == 0
    said = " ".join(result.out.split())
    assert all(name in said for name in ("labyrinth_tuc", "drive_ugv"))
    assert said.count("left out") == 2


def test_a_robot_that_is_described_wrongly_is_shown_before_and_after_with_its_figure(
    studies, shared_data, tmp_path
):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "labyrinth_tuc").symlink_to(shared_data / "real/labyrinth_tuc")
    result = studies("prove", "--real-only", "--data", tmp_path, "--figures", tmp_path)
    assert result.code == 0
    assert "as described" in result.out
    assert "left and right are exchanged" in " ".join(result.out.split())
    assert (tmp_path / "labyrinth.png").read_bytes().startswith(b"\x89PNG")
