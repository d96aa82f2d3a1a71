"""What goes to stderr, and what makes the exit code 1."""

from omnimate.cli.console import print_error, report_problem, take_problems, warn


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
