"""Sessions with faults: they repeat exactly, keep the laws, and are found where they do not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from omnimate.driver.robot.drives import Drives
from omnimate.driver.robot.events import EventLog
from omnimate.driver.robot.supervision import Supervision
from omnimate.files.logs.formats.candump_writer import CandumpWriter
from omnimate.files.recordings.folder import load_recording
from studies.faults import session
from studies.faults.script import (
    BUS_FAULTS,
    DISK_FAULTS,
    LENGTH,
    NODE_FAULTS,
    QUIET,
    Fault,
    Script,
    draw,
    shrink,
)
from studies.faults.session import run

REBOOT, TRIP = Fault("reboot", 2.0, 0.3, node=1), Fault("trip", 4.0, node=11)
SHORT = Script("single", 1, (REBOOT, TRIP), length=8.0)


def test_the_same_seed_gives_the_same_trace_and_another_seed_another():
    first, second, other = run(SHORT), run(SHORT), run(replace(SHORT, seed=2))
    assert first.digest == second.digest != other.digest
    assert first.violations == []
    assert sum(first.expected.values()) == sum(first.reported.values()) == 2


@pytest.mark.parametrize("robot", ["single", "double"])
def test_without_a_fault_the_pose_is_true_and_nothing_is_reported(robot):
    outcome = run(Script(robot, 3, (), length=5.0))
    assert outcome.violations == []
    assert 0.0 < outcome.worst < 3e-5


@pytest.mark.parametrize("kind", BUS_FAULTS)
def test_a_fault_of_the_bus_keeps_the_laws(kind):
    assert run(Script("single", 4, (Fault(kind, 3.0, 0.5),), length=8.0)).violations == []


def test_a_node_that_restarted_unheard_is_configured_again_though_it_has_no_heartbeat_any_more():
    """Its boot-up is lost: the driver sees a heartbeat that ends, as where a node has lost its power."""
    lost, reboot = Fault("loss", 6.526, 3.64), Fault("reboot", 6.572, 0.933, node=2)
    assert run(Script("single", 946, (lost, reboot), QUIET, restarts=(6.44,))).violations == []


def test_drives_may_reset_their_lost_heartbeat_late_where_a_fault_delays_the_next_driver():
    silence, stop = Fault("silence", 6.036, 0.036, node=3), Fault("nmt stop", 6.106, node=14)
    assert run(Script("double", 517, (silence, stop), length=9.0, restarts=(6.0,))).violations == []


def test_a_node_that_loses_its_power_while_it_is_configured_again_is_configured_once_more():
    """The adapter is away meanwhile, so that its boot-up is unheard."""
    faults = Fault("nmt communication", 14.876, node=2), Fault("power", 14.919, 0.019)
    assert run(Script("single", 932, faults, length=32.0, restarts=(14.796,))).violations == []


def test_a_report_that_is_left_out_breaks_a_law_and_the_script_shrinks_to_its_fault(monkeypatch):
    monkeypatch.setattr(Supervision, "emergency", lambda *_frame: True)
    emergency = Fault("emcy", 6.0, 0.5, node=2)
    script = replace(SHORT, faults=(REBOOT, emergency, Fault("burst", 9.0, 0.02)), length=11.0)
    assert [line for line in run(script).violations if "emcy" in line]
    assert shrink(script, lambda shorter: bool(run(shorter).violations)).faults == (emergency,)


def test_a_driver_that_does_not_stop_the_wheels_breaks_a_law(monkeypatch):
    monkeypatch.setattr(Drives, "halt", lambda *_trouble: None)
    violations = run(replace(SHORT, faults=(TRIP,))).violations
    assert any("not commanded to stop" in line for line in violations)


def test_a_script_has_each_kind_of_fault_and_ends_in_quiet():
    scripts = [draw(1, number) for number in range(100)]
    assert scripts == [draw(1, number) for number in range(100)]
    faults = [fault for script in scripts for fault in script.faults]
    assert {fault.kind for fault in faults} == {*NODE_FAULTS, *BUS_FAULTS, *DISK_FAULTS}
    assert max(fault.at + fault.duration for fault in faults) < LENGTH - QUIET + 2.0


FULL, CUT = Fault("disk full", 3.0, 2.0), Fault("torn write", 6.8)
DISK = Script("single", 4, (FULL, CUT), length=14.0, restarts=(12.0,))


def test_a_full_disk_and_a_power_cut_keep_the_laws_and_the_full_disk_is_reported():
    outcome = run(DISK)
    assert outcome.violations == []
    assert outcome.expected == outcome.reported == {("disk full", "running"): 1}


def test_a_full_disk_that_is_not_reported_breaks_a_law(monkeypatch):
    monkeypatch.setattr(EventLog, "unrecorded", lambda *_frame: None)
    assert any("disk full" in line for line in run(DISK).violations)


def test_a_log_that_is_never_synced_breaks_a_law_at_a_power_cut(monkeypatch):
    monkeypatch.setattr(CandumpWriter, "sync", lambda _self: None)
    script = replace(DISK, faults=(CUT,))
    assert any("recording" in line for line in run(script).violations)


CLOSE = Script("single", 240, (), length=9.557, restarts=(6.804, 8.057))  # two SYNCs in 2.5 ms after `enable`


def test_a_recording_of_two_syncs_that_are_close_together_is_compared_with_the_sample_of_each():
    assert run(CLOSE).violations == []


def test_a_recording_with_another_count_in_one_sample_breaks_a_law(monkeypatch):
    def load_altered(folder):
        recording = load_recording(folder)
        counts = recording.counts.copy()
        counts[-1, 0] += 1
        return replace(recording, counts=counts)

    monkeypatch.setattr(session, "load_recording", load_altered)
    assert any("the recording differs" in line for line in run(CLOSE).violations)


def test_what_a_frozen_encoder_has_lost_is_in_doubt_also_for_the_next_driver():
    frozen = Fault("frozen", 5.28, 3.601, node=2)
    assert run(Script("double", 650, (frozen,), length=12.0, restarts=(6.854,))).violations == []


def test_a_counter_that_restarts_unheard_begins_again_though_its_node_booted_while_it_was_configured():
    faults = Fault("reboot", 0.05, 0.015, node=2), Fault("power", 6.0, 0.277)
    assert run(Script("single", 1, faults, length=10.0)).violations == []


def test_a_counter_that_restarts_unheard_in_a_dialogue_begins_again():
    faults = (
        Fault("nmt reset", 13.743, node=2),
        Fault("nmt stop", 49.19, node=2),
        Fault("power", 49.867, 0.014),
    )
    assert run(Script("single", 543, faults, length=65.0, restarts=(49.104,))).violations == []


def test_a_recording_may_hold_frames_of_before_the_first_sample_of_the_driver():
    """They come in a late burst; the node restarts after them, so that the log bridges from another count."""
    faults = Fault("adapter", 69.272, 0.652), Fault("burst", 69.689, 3.048), Fault("torn write", 75.002)
    restarts = 5.219, 69.231, 73.926
    assert run(Script("single", 487, faults, length=76.0, restarts=restarts)).violations == []


def test_a_restart_may_be_bridged_otherwise_in_a_log_that_has_other_readings():
    faults = (
        Fault("torn write", 3.387),
        Fault("loss", 33.323, 3.746),
        Fault("nmt communication", 33.942, node=2),
    )
    assert run(Script("single", 670, faults, length=60.0, restarts=(40.508,))).violations == []


def test_an_answer_that_comes_a_period_late_may_be_in_another_sample_of_the_log():
    """Two nodes that babble fill the bus."""
    faults = (
        Fault("nmt stop", 0.037, node=13),
        Fault("torn write", 1.896),
        Fault("trip", 26.953, node=12),
        Fault("babbling", 44.472, 0.107, 7),
        Fault("babbling", 44.51, 0.145, 6),
    )
    assert run(Script("double", 102, faults, length=60.0, restarts=(36.086,))).violations == []


def test_a_recording_that_begins_when_the_disk_has_space_again_knows_no_restart_from_before():
    """Its counts differ by what the driver has bridged; its times are those of the samples."""
    full, restart = Fault("disk full", 0.5, 4.0), Fault("nmt communication", 4.0, node=2)
    assert run(Script("single", 2, (full, restart), length=7.0)).violations == []
