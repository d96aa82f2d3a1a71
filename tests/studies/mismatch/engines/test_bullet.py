"""Robots in PyBullet: their motion is that of their geometry, and labels say what the true motion shows."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="pybullet is not installed: the extra `bullet`")

from omnimate.files.recordings.folder import load_recording
from studies.mismatch.engines.bullet import cases, faults
from studies.mismatch.engines.bullet.cases import alike
from studies.mismatch.engines.bullet.chassis import ROBOTS
from studies.mismatch.engines.bullet.drive import CELL, Course, Floor, TippedError, drive
from studies.mismatch.engines.bullet.faults import Setting, with_treads
from studies.mismatch.engines.laws import altered
from studies.mismatch.engines.programmes import commands
from studies.mismatch.engines.strength import Noise, Ruler, residual
from studies.mismatch.engines.true_motion import Nominal, calibrate, residuals
from studies.mismatch.engines.writing import Measuring

PLANE = Floor(0.0)
BENDS = [("none", [(0.3, 0.0, 3.0), (0.3, 0.5, 3.0), (0.3, -0.4, 3.0)])]


def course(laps=BENDS, trucks=1):
    wanted, spans = commands(laps, 0.02, (0.5, 1.0))
    return Course(wanted, spans, 0.02, np.linspace(-1.0, 2.0, 2 * trucks))


def by_geometry(chassis):
    radii = np.array([wheel.radius for wheel in chassis.wheels.values()])
    return Nominal(radii, np.array(chassis.tracks), chassis.link)


@pytest.fixture(scope="module")
def tug():
    return ROBOTS["tug"](np.random.default_rng(1))


@pytest.fixture(scope="module")
def healthy(tug):
    return drive(tug, PLANE, course(), by_geometry(tug))


@pytest.fixture
def setting(tug, healthy):
    return Setting(np.random.default_rng(4), by_geometry(tug), healthy, 1000.0, tug)


def test_a_robot_that_rolls_moves_as_its_geometry_says(tug, healthy):
    nominal = calibrate(healthy, 0.0)
    assert nominal.radii == pytest.approx(by_geometry(tug).radii, rel=5e-4)
    assert nominal.tracks == pytest.approx(tug.tracks, rel=5e-4)
    assert np.abs(residuals(healthy, nominal, 1).cumsum(axis=0)[:, :2]).max() < 1e-3
    assert healthy.wheels[0] == pytest.approx([-1.0, 2.0])


def test_the_linkage_of_the_pair_reads_what_its_trucks_do():
    pair = ROBOTS["pair"](np.random.default_rng(1))
    driven = drive(pair, PLANE, course(trucks=2), by_geometry(pair))
    assert np.abs(residuals(driven, by_geometry(pair), 1)[:, 6:]).max() < 1e-4
    assert np.abs(driven.linkage[:, :2]).max() > 0.1


def test_a_robot_that_skids_turns_on_a_wider_base_than_its_wheels_have():
    husky = ROBOTS["husky"](np.random.default_rng(1))
    driven = drive(husky, PLANE, course(), by_geometry(husky))
    assert calibrate(driven, 0.0).tracks[0] > 1.3 * husky.tracks[0]


@pytest.mark.parametrize("build", [faults.wheel_diameter, faults.wheelbase, faults.tyre_loses_air])
def test_the_size_in_a_label_is_the_one_that_was_built_in(setting, build):
    fault = build(setting)
    built = drive(fault.build(setting.chassis), PLANE, course(), setting.nominal, fault.hooks)
    size = fault.measure(built)["ratio"]
    assert abs(size - 1.0) > 0.002
    assert fault.measure(setting.healthy)["ratio"] == pytest.approx(1.0, abs=1e-9)
    again = build(replace(setting, chance=np.random.default_rng(4)))
    known = calibrate(drive(again.build(setting.chassis), PLANE, course(), setting.nominal), 0.0)
    if fault.effect != "radius_step":  # before the tyre loses air, nothing is wrong
        values = [*known.radii / setting.nominal.radii, *known.tracks / setting.nominal.tracks]
        assert values[int(np.argmax(np.abs(np.array(values) - 1.0)))] == pytest.approx(size, abs=5e-4)


def test_a_tread_off_its_axle_rolls_a_wave_of_about_that_size(setting):
    fault = faults.wheel_eccentricity(setting)
    straight = course([("none", [(0.3, 0.0, 6.0)])])
    built = drive(fault.build(setting.chassis), PLANE, straight, setting.nominal)
    plain = drive(setting.chassis, PLANE, straight, setting.nominal)
    radius = setting.nominal.radii[0]
    assert 0.004 * radius < fault.measure(built)["amplitude"] < 0.017 * radius
    assert fault.measure(plain)["amplitude"] < 2e-4 * radius


def test_a_box_takes_some_way_of_the_wheel_that_meets_it_and_of_no_other(setting):
    fault = faults.bump(setting)
    built = drive(setting.chassis, replace(PLANE, boxes=fault.boxes), course(), setting.nominal)
    size = fault.measure(built)
    assert len(size["lost"]) == len(fault.boxes)
    assert min(size["lost"]) > 0.0
    other = "a.left" if fault.component == "a.right" else "a.right"
    boxes = tuple(replace(box, wheel=other) for box in fault.boxes)
    assert not drive(setting.chassis, replace(PLANE, boxes=boxes), course(), setting.nominal).crossings


def test_a_robot_that_falls_over_has_no_drive(tug):
    wheels = {channel: replace(wheel, radius=3.0 * wheel.radius) for channel, wheel in tug.wheels.items()}
    stilted = replace(with_treads(replace(tug, wheels=wheels), "a.left", 0.3), height=0.4)
    with pytest.raises(TippedError, match="tug fell over"):
        drive(stilted, PLANE, course(), by_geometry(tug))


def test_a_floor_is_as_rough_as_it_says():
    height = Floor(0.004, 3)._heights(200, 300)
    assert np.gradient(height, CELL, axis=1).std() == pytest.approx(0.004, rel=0.05)


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(cases, "DURATIONS", (8.0, 25.0))


def test_a_change_that_the_law_of_its_fault_does_not_explain_has_no_name(short):
    case = cases._case(np.random.default_rng(2), "tug", 1, 1)
    case = replace(case, measuring=Measuring((0.001, 0.001, 0.001), 0.1, both=False))
    healthy = case.seen(case.setting.healthy, [])
    noise = np.random.default_rng(1).normal(0.0, 1e-3, residual(healthy)["a"].shape)
    ruler = Ruler(Noise.of([{"a": noise}]), (residual(healthy),))
    change = ruler.change([altered(healthy, "wheel_diameter", "a.left", {"ratio": 1.05})])
    named, others = alike(change, "wheel_diameter", "a.left", {"ratio": 1.05}, healthy, ruler)
    assert named
    assert ("wheel_misalignment", "a") not in {(each["effect"], each["component"]) for each in others}
    named, others = alike(change, "wheel_misalignment", "a", {"angle": 0.01}, healthy, ruler)
    assert not named
    assert ("wheel_diameter", "a.left") in {(each["effect"], each["component"]) for each in others}


def test_a_case_depends_on_its_seed_and_number_alone_and_its_recording_loads(written_twice, short):
    first, folder = written_twice(cases.make, 5, 2)
    recording = load_recording(folder)
    assert len(recording.vehicle.trucks) == (2 if first["robot"] == "pair" else 1)
    assert recording.time[-1] - recording.time[0] == pytest.approx(first["seconds_of_driving"], abs=0.1)
    assert first["kind"] == "null" or first["effects"]
