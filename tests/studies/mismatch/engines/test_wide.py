"""The wide world: it holds the foreign sets, its labels are measured, its unnamed physics is no curve."""

import json
from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.recordings.folder import load_recording
from studies.mismatch.engines.engine import Floor
from studies.mismatch.engines.faults import ConcealedFault, felt
from studies.mismatch.engines.laws import altered
from studies.mismatch.engines.programmes import PROGRAMMES, commands, wide_programme
from studies.mismatch.engines.scene import Scene, drawn_parameters
from studies.mismatch.engines.strength import Noise, Ruler, residual
from studies.mismatch.engines.vocabulary import VOCABULARY
from studies.mismatch.engines.wide import cases, robots
from studies.mismatch.engines.wide.cases import outside
from studies.mismatch.engines.wide.robots import secondary, wide_measuring
from studies.mismatch.engines.writing import Measuring

SETS = ("concealed", "concealed2", "contact")
DENSE = Measuring((0.001, 0.001, 0.001), 0.1, both=True)


def inside(value, bounds):
    return 0.999 * bounds[0] <= value <= 1.001 * bounds[1]


@pytest.mark.parametrize("name", SETS)
def test_the_robots_of_the_labelled_sets_lie_within_what_is_drawn(shared_data, name):
    for case, label in json.loads((shared_data / name / "labels.json").read_text()).items():
        robot = load_recording(shared_data / name / case / label["recordings"][0]).vehicle
        assert robot.bus.sync_period in robots.PERIODS
        for wheel in robot.wheels:
            assert inside(0.5 * robot.wheel_diameter(wheel), robots.RADII)
            assert inside(abs(robot.metres_per_count(wheel)), robots.COUNTS)
        assert all(inside(truck.wheelbase, robots.BASES) for truck in robot.trucks.values())
        if robot.linkage is not None:
            assert inside(robot.linkage.length, robots.LENGTHS)
            assert inside(robot.encoder("link").counts_per_metre, robots.METRES)
            assert inside(robot.encoder("joint_a").counts_per_turn, (min(robots.JOINTS), max(robots.JOINTS)))


@pytest.mark.parametrize("name", SETS[1:2])
def test_the_noise_of_the_labelled_sets_lies_within_what_is_drawn(shared_data, name):
    for label in json.loads((shared_data / name / "labels.json").read_text()).values():
        noise = label["noise"]
        assert inside(noise["rough"], cases.ROUGHNESS)
        assert inside(noise["rough_length"], cases.WAVES)
        assert noise["joint_counts_rms"] <= robots.JITTER


@pytest.mark.parametrize("kind", PROGRAMMES)
@pytest.mark.parametrize("trucks", [1, 2])
def test_drives_last_minutes_and_stay_within_the_samples_that_are_wanted(kind, trucks):
    for seed in range(6):
        laps = wide_programme(np.random.default_rng(seed), kind, trucks, 0.02)
        driven, spans = commands(laps, 0.02, (0.5, 1.2))
        assert 40.0 < 0.02 * len(driven) < 700.0
        assert len(spans) >= 2 or len(laps) == 1


def test_robots_with_one_truck_are_always_measured_and_two_trucks_not_always():
    chance = np.random.default_rng(1)
    alone = [wide_measuring(chance, 1) for _ in range(50)]
    pairs = [wide_measuring(chance, 2) for _ in range(50)]
    assert None not in alone
    assert None in pairs
    assert {each.period == 0.0 for each in alone} == {True, False}


def test_late_poses_may_be_named_and_need_not_be():
    named = {(each["effect"], each["component"]) for each in secondary(replace(DENSE, delay=0.05))}
    assert ("latency", "poses") in named
    assert secondary(DENSE) == secondary(None) == []


@pytest.fixture(scope="module")
def setting():
    """Return a robot with two trucks on a smooth floor, its encoders fine and without jitter."""
    chance = np.random.default_rng(11)
    drawn = robots.wide_robot(chance, 2)
    fine = tuple(replace(device, resolution=10_000_000) for device in drawn.devices)
    robot = replace(drawn, period=0.02, jitter=0.0, devices=fine)
    laps = wide_programme(chance, "free", 2, 0.1)[:3]
    scene = Scene(robot, laps, (), (), Floor(0.0, 0.0), 1000.0, np.random.default_rng(12))
    return cases._Setting(scene, DENSE, "free")


@pytest.fixture(scope="module")
def healthy(setting):
    return cases.seen(setting.robot, setting.scene.driven([]), DENSE, None)


@pytest.fixture(scope="module")
def ruler(healthy):
    """Return a ruler of white noise, far above the rounding of the encoders."""
    chance = np.random.default_rng(13)
    missed = residual(healthy)
    noise = [{part: 1e-3 * chance.normal(size=each.shape) for part, each in missed.items()} for _ in range(5)]
    return Ruler(Noise.of(noise), (missed,))


def test_dead_reckoning_of_a_healthy_robot_on_a_smooth_floor_misses_next_to_nothing(healthy):
    missed = residual(healthy)
    assert set(missed) == {"linkage", "a", "b"}
    assert all(np.abs(each).max() < 5e-5 for each in missed.values())  # [rad, m] of integration


@pytest.mark.parametrize(
    ("effect", "component", "parameters"),
    [
        ("wheel_diameter", "b.left", {"ratio": 1.02}),
        ("wheelbase", "a", {"ratio": 1.05}),
        ("wheel_misalignment", "b", {"angle": 0.03}),
        ("lateral_slip", "a", {"compliance": 0.1}),
        ("floor_slope", "a", {"rate": 0.03, "direction": 1.0}),
        ("joint_eccentricity", "joint_b", {"amplitude": 0.05, "phase": 0.5}),
        ("link_scale", "link", {"ratio": 1.3}),
        ("latency", "joint_a", {"delay": 0.1}),
        ("traction_slip", "a.right", {"compliance": 0.2}),
    ],
)  # fmt: skip
def test_the_laws_change_a_recording_as_the_engine_does(
    setting, healthy, ruler, effect, component, parameters
):
    fault = setting.scene.fault(effect, component, parameters)
    driven = residual(cases.seen(setting.robot, setting.scene.driven([fault]), DENSE, None))
    (before,) = ruler.untouched
    engine = ruler.noise.whitened([{part: driven[part] - before[part] for part in before}])
    law = ruler.change([altered(healthy, effect, component, parameters)])
    smoothed = 0.4 if effect == "traction_slip" else 0.15  # the law's acceleration is that over 0.2 s
    assert np.linalg.norm(engine - law) < smoothed * np.linalg.norm(engine)


@pytest.mark.parametrize("effect", VOCABULARY)
def test_every_effect_of_the_vocabulary_has_a_law_on_every_component_that_it_may_be_put_into(
    setting, healthy, effect
):
    for component in cases._places(effect, "", setting):
        drawn = drawn_parameters(np.random.default_rng(1), effect, healthy.time[0], 50.0, "")
        changed = residual(altered(healthy, effect, component, drawn))
        assert all(np.isfinite(each).all() for each in changed.values())


@pytest.mark.slow
def test_a_curve_in_one_quantity_is_not_outside_and_a_product_of_two_is(healthy, ruler):
    way = healthy.way[:, 0]
    steps, speed = np.diff(way), np.gradient(way, healthy.time)[1:]
    turn = np.gradient(healthy.path(0)[:, 2], healthy.time)[1:]
    place = healthy.path(0)[1:, 0]

    def left(factor):
        bent = healthy.with_way(0, way[0] + np.concatenate(([0.0], np.cumsum(steps * (1.0 + 0.01 * factor)))))
        return outside(ruler.change([bent]), healthy, ruler)

    assert left(np.abs(speed)) < 0.1
    assert left(turn * np.cos(5.0 * place)) > 0.3


def test_a_link_goes_on_swinging_after_the_robot_has_stopped():
    fault = ConcealedFault("unknown", "link", {"kind": "swing", "size": 0.01, "pitch": 1.0})
    for _ in range(100):
        felt(fault, 0.5, 0.005)
    after = []
    for _ in range(400):
        felt(fault, 0.0, 0.005)
        after.append(fault.memory["swing"])
    assert np.count_nonzero(np.diff(np.sign(after))) >= 3
    assert np.abs(after[-100:]).max() < np.abs(after[:100]).max()


def test_a_case_is_the_same_for_the_same_seed_and_says_how_strong_it_is(written_twice):
    label, folder = written_twice(cases.make, 1, 1)
    (effect,) = label["effects"]
    assert effect["sigmas_above_noise"] > 0.0
    assert len(load_recording(folder)) > 300


def test_a_change_without_a_law_holds_no_rounding_of_the_counts():
    """Two drives round differently: against their noise, that was most of what a warm tyre changed."""
    setting = cases._setting(np.random.default_rng(3), 1, 3, dense=True)
    coarse = tuple(replace(device, resolution=device.resolution // 50) for device in setting.robot.devices)
    robot = replace(setting.robot, devices=coarse)
    blunt = replace(setting, scene=replace(setting.scene, robot=robot))
    for part, fine in cases._smooth(setting, []).items():
        assert np.abs(cases._smooth(blunt, [])[part] - fine).max() < 1e-5
