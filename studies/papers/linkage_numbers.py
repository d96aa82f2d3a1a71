"""Numbers of the linkage that need no chance: C Table I, C 5.2, and the OmniMate's equations in a turn."""

from __future__ import annotations

import math

import numpy as np

from omnimate.effects.crossing import cable_loss, edge_loss
from omnimate.ipec.corrections import advance_one
from omnimate.ipec.corrector import Corrector, correct
from omnimate.ipec.readings import ordered_counts
from omnimate.motion.paths import out_and_back, rounded_rectangle
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.linkage import link_heading, place_follower
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import Array, between, compose, wrap
from omnimate.vehicle.sonar import Sonar
from studies.papers.bumps import LINK, LOST, PERIOD, SPEED, bump_drive, bump_errors
from studies.papers.robots import clapper, fine
from studies.papers.rows import Row, judged, number

EXACT = Sonar(sigma=0.0)
_RADIUS, _HEIGHT, _WHEELBASE = 0.075, 0.010, 0.340  # [m] C 6


def linkage_numbers() -> tuple[Row, ...]:
    return (*bumps(), *biases(), *turns(), doubling(), unequal_wheels())


def bumps() -> tuple[Row, ...]:
    """Return C Table I and (6)-(8), and what the exact geometry makes of a bump."""
    errors = bump_errors(LOST, _WHEELBASE, SPEED * PERIOD, LINK)
    arc, cable = (math.degrees(loss(_RADIUS, _HEIGHT) / _WHEELBASE) for loss in (edge_loss, cable_loss))
    inside = math.floor(1e5 * errors.lateral_in_interval) / 100.0  # the print cuts off
    return (
        number("C", "Table I", "travel lost on a 10 mm bump [mm]", 2.63, 1e3 * LOST, 2),
        number("C", "Table I", "heading error [deg]", 0.44, math.degrees(errors.heading), 2),
        number("C", "Table I", "lateral error after 10 m [mm]", 77.0, 10e3 * errors.lateral, 0),
        number("C", "(6)", "lateral error in an interval, cut off [mm]", 0.15, inside, 2),
        number("C", "(7)", "misread [deg]", 0.01, math.degrees(errors.misread), 2),
        number("C", "(8)", "measured [deg]", 0.43, math.degrees(errors.measured), 2),
        number("C", "(1) exact arc", "travel lost [mm]", 3.51, 1e3 * edge_loss(_RADIUS, _HEIGHT), 2),
        number("C", "(1) exact arc", "heading error [deg]", 0.59, arc, 2),
        number("C", "(1) round cable", "heading error [deg]", 0.57, cable, 2),
        number("C", "6.1", "measured for each bump; round cable [deg]", 0.6, cable, 1),
    )


def biases() -> tuple[Row, ...]:
    """Return what biases of the joints and of the link do, C 5.2."""
    robot = fine()
    joints = linkage_biases(math.radians(1.0), math.radians(-1.0))
    truth = Truth(robot, effects=joints, floor=SMOOTH, sonar=EXACT)
    recording = simulate(robot, truth, out_and_back(6.0, 1, link_length=1.0))
    out = slice(0, int(np.argmax(recording.wheel_angle("a.left"))) + 1)
    path = correct(recording).pose_a[out]
    driven = float(np.hypot(*np.diff(path[:, :2], axis=0).T).sum())
    radius = driven / abs(float(path[-1, 2] - path[0, 2]))
    program = rounded_rectangle(6.0, 3.25, ["cw", "ccw"])
    headings = []
    for bias in (0.0, 0.001):
        truth = Truth(robot, effects=linkage_biases(link=bias), floor=SMOOTH, sonar=EXACT)
        drive = simulate(robot, truth, program)
        headings.append(np.degrees(lap_errors(drive, correct(drive).pose_a)[:, 2]))
    low, high = np.sort(np.abs(headings[1] - headings[0])).tolist()
    degrees = f"{low:.2f} to {high:.2f}"
    per_turn = judged(good=low > 0.33 and high < 0.37, verdict="misprint")
    near = judged(good=abs(radius - 28.6) < 0.5)
    return (
        Row("C", "5.2", "radius with joints off by +-1 degree [m]", "28.6", f"{radius:.1f}", near),
        Row("C", "5.2", "per turn with 1 mm of link bias [deg]", "roughly 1", degrees, per_turn),
    )


def turns() -> tuple[Row, ...]:
    """Return the OmniMate's equations in a car-like turn of 360 degrees, corrected and as printed."""
    robot = reference_vehicle()
    program = rounded_rectangle(6.0, 3.25, ["cw", "ccw"])
    drive = simulate(robot, Truth(robot, floor=SMOOTH, sonar=EXACT), program)
    good, bad = (
        np.abs(np.degrees(lap_errors(drive, path)[:, 2]))
        for path in (
            correct(drive, method="omnimate").pose_a,
            printed_omnimate(drive, np.zeros(3), previous_b=True),
        )
    )
    failed = judged(good=bool(((bad > 10.0) & (bad < 50.0)).all()), verdict="misprint")
    what, worst = "heading after a turn [deg]", f"{bad.min():.0f} to {bad.max():.0f}"
    return (
        Row("O", "(1)-(6), corrected", what, "< 0.01", f"{good.max():.4f}", judged(good=good.max() < 0.01)),
        Row("O", "(1), previous b", what, "10 to 50 off", worst, failed),
    )


def doubling() -> Row:
    """Return how an error grows from sample to sample with the printed sign of O (4)."""
    drive = bump_drive(fine(), 1e-4, after=0.1)
    path = printed_omnimate(drive.recording, drive.pose_a[0], printed_sign=True)
    error = np.abs(path[:, 2] - drive.pose_a[:, 2])
    grown = error[(error > 1e-3) & (error < 0.5)]
    factor = float(np.median(grown[1:] / grown[:-1]))
    verdict = judged(good=abs(factor - 2.0) < 0.1, verdict="misprint")
    return Row("O", "(4), printed sign", "growth in a sample", "doubles", f"x {factor:.2f}", verdict)


def printed_omnimate(
    recording: Recording, start: Array, *, previous_b: bool = False, printed_sign: bool = False
) -> Array:
    """Return the path `(N, 3)` of truck a by O (1)-(6) with one of the print's errors.

    `previous_b`: (1) uses truck b's pose before the sample; `printed_sign`: (2) to (4) add the error of the
    heading instead of removing it.
    """
    counts, present = ordered_counts(recording)
    corrector = Corrector(recording.vehicle, "plain")
    states = corrector.start(start).record.copy()
    state = states[0]
    path = np.empty((len(counts), 3))
    for sample in range(len(counts)):
        was_placed, behind = state["placed"], state["pose"][1].copy()
        advance_one(corrector.settings, states, counts[sample], present[sample])
        pose_a, pose_b = state["pose"]
        if was_placed:
            heading = link_heading(pose_a, behind if previous_b else pose_b)
            error = wrap(state["joint"][0] - (pose_a[2] - heading))
            pose_a[2] += -error if printed_sign else error
            place_follower(pose_b, pose_a, state["length"], heading)
            pose_b[2] = heading + state["joint"][1]
        path[sample] = pose_a
    return path


def unequal_wheels() -> Row:
    """Return the heading that unequal wheels leave after a straight drive and back: not C 6.1's -1.7."""
    robot = clapper()
    truth = Truth(with_errors(robot, {}, {"a": 1.0005, "b": 1.0005}), floor=SMOOTH, sonar=EXACT)
    drive = simulate(robot, truth, out_and_back(18.0, 1, speed=0.45, link_length=1.0))
    left = float(np.degrees(np.abs(lap_errors(drive, correct(drive, method="plain").pose_a)[0, 2])))
    verdict = judged(good=left < 0.1)
    return Row("C", "6.1", "unequal wheels, out and back [deg]", "cancel", f"{left:.2f}", verdict)


def lap_errors(recording: Recording, path: Array, fixes: Poses | None = None) -> Array:
    """Return absolute minus estimated return pose of each lap `(L, 3)`, U 3.1, for a path `(N, 3)`.

    Fixes of truck a are needed before each lap and after the last; None takes those of the recording.
    """
    assert recording.run is not None
    assert recording.poses is not None
    fixes = recording.poses.of("a") if fixes is None else fixes
    errors = []
    for lap in recording.run.laps:
        first, last = np.searchsorted(recording.time, [lap.start - 1e-6, lap.end - 1e-6])
        before = fixes.pose[np.searchsorted(fixes.time, lap.start) - 1]
        after = fixes.pose[np.searchsorted(fixes.time, lap.end)]
        error = after - compose(before, between(path[first], path[last]))
        errors.append([error[0], error[1], float(wrap(error[2]))])
    return np.array(errors)
