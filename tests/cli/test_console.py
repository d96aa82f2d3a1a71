"""What goes to stderr, and what makes the exit code 1."""

from types import SimpleNamespace

from omnimate.cli.console import (
    print_error,
    progress_bar,
    report_problem,
    status_line,
    take_problems,
    warn,
)


def test_only_a_reported_problem_is_kept_and_it_is_kept_until_it_is_taken(capsys):
    take_problems()
    warn("a note")
    report_problem("can.log:3: skipped")
    print_error("no such file")
    assert capsys.readouterr().err == "warning: a note\nwarning: can.log:3: skipped\nerror: no such file\n"
    assert take_problems() == ["can.log:3: skipped"]
    assert take_problems() == []


def test_brackets_in_a_sentence_are_printed_as_they_are(capsys):
    warn("[bold]counts[/bold] of a.left")
    assert capsys.readouterr().err == "warning: [bold]counts[/bold] of a.left\n"


def test_without_a_terminal_progress_is_a_line_now_and_then(capsys, monkeypatch):
    monkeypatch.setattr("omnimate.cli.console.PROGRESS_PERIOD", 10.0)
    now = iter([0.0, 1.0, 10.0, 10.0, 11.0, 90.0, 90.0])
    monkeypatch.setattr("omnimate.cli.console.time", SimpleNamespace(monotonic=lambda: next(now)))
    with progress_bar("reading") as progress:
        progress(1, 100)
        progress(20, 100)
        progress(30, 100, "fitting")
        progress(7, 0, "fitting")
    assert capsys.readouterr().err == "reading: 20%\nfitting ...\n"


def test_without_a_terminal_a_status_line_is_printed_now_and_then(capsys, monkeypatch):
    monkeypatch.setattr("omnimate.cli.console.PROGRESS_PERIOD", 10.0)
    now = iter([0.0, 1.0, 10.0, 10.0, 19.0, 20.0, 20.0])
    monkeypatch.setattr("omnimate.cli.console.time", SimpleNamespace(monotonic=lambda: next(now)))
    with status_line() as show:
        for count in range(4):
            show(lambda count=count: f"{count} samples")
    assert capsys.readouterr().err == "1 samples\n3 samples\n"
