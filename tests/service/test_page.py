"""The page in a real browser: what a person can do by clicking, with the service and its simulated robot."""

import itertools
import math
import os
import re
import shutil
import subprocess
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from omnimate.calib.umbmark.exact import square_returns
from omnimate.fleet.report_store import write_report
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import format_vehicle
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.sonar import Sonar
from studies.benchmark import OMNIMATE
from studies.speed import service_process
from tests.service.conftest import biased_zip, day_zip
from tests.service.hall_results import ASKED, FAULTY, report_of_two_floors, write_results

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")
expect = playwright.expect

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine: the page is not tested in a browser"
)
ARGUMENTS = [
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
SOON, LATER = 120_000, 600_000  # [ms] for an answer, and for a drive or a diagnosis on a slow machine
METHODS = ("get", "post", "put", "delete")
WIDE, PHONE = {"width": 1440, "height": 900}, {"width": 375, "height": 760}


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as running:
        chromium = running.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Of a service that several tests share."""
    with serving(tmp_path_factory.mktemp("service")) as url:
        yield url


@contextmanager
def serving(folder):
    with service_process.serving(folder, f"sqlite:///{folder}/omnimate.db") as service:
        yield service.url


@contextmanager
def opened(browser, address, locale="en-US"):
    """A page of the service; afterwards, nothing on it may have failed or broken its policy."""
    with browser.new_context(
        viewport=WIDE, color_scheme="light", reduced_motion="reduce", locale=locale
    ) as context:
        context.set_default_timeout(SOON)
        page = context.new_page()
        faults = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda line: "Content Security Policy" in line.text and faults.append(line.text))
        page.goto(address)
        yield page
    assert faults == []


@pytest.fixture
def page(browser, address):
    with opened(browser, address) as opened_page:
        yield opened_page


@pytest.fixture
def robot_page(browser, tmp_path):
    """A page of a service whose robot has not moved yet."""
    with serving(tmp_path) as address, opened(browser, address) as opened_page:
        yield opened_page


@pytest.fixture
def picture(tmp_path):
    folder = Path(os.environ.get("OMNIMATE_SCREENSHOTS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)

    def take(page, name):
        page.screenshot(path=folder / f"{name}.png")

    return take


def live(page):
    """Wait until the robot's stream is there."""
    expect(page.locator("#lamp")).to_have_text("live", timeout=LATER)
    expect(page.get_by_test_id("node-1")).to_have_count(1, timeout=LATER)


def start(page, how, runs, side=4):
    page.locator("#tab-calibrate").click()
    page.locator(f"#start input[value={how}]").check()
    page.locator("#start-side").fill(str(side))
    page.locator("#start-runs").fill(str(runs))
    expect(page.locator("#start-vehicle option")).not_to_have_count(0, timeout=SOON)
    page.locator("#start-send").click()
    expect(page.locator("#session-title")).to_contain_text("UMBmark", timeout=SOON)


def accept(page):
    """Solve, accept, and see the vehicle's next version."""
    page.locator("#solve").click()
    expect(page.locator("#plot svg")).to_be_visible(timeout=LATER)
    page.locator("#accept").click()
    expect(page.locator("#session-state")).to_have_text("accepted", timeout=SOON)
    page.locator("#tab-vehicle").click()
    expect(page.locator("#vehicle-title")).to_have_text("omnimate, version 2", timeout=SOON)


def add_run(page, direction, error):
    """Type a run that ends `error` (x, y [m], theta [rad]) beside where odometry believes it is."""
    page.locator("#sample label", has=page.locator(f"input[value={direction}]")).click()
    believed = (12.0, -7.0, 0.25)
    for name, value, calculated in zip(("x", "y", "theta"), in_screen_units(error), believed, strict=True):
        page.get_by_test_id(f"after.{name}").fill(f"{value + calculated:.4f}")
        page.get_by_test_id(f"calculated.{name}").fill(f"{calculated}")
    page.locator("#sample-send").click()


def show_fleet(page, name):
    page.locator("#tab-fleet").click()
    page.locator("#fleet-new").fill(name)
    page.locator("#fleet-start-send").click()


@contextmanager
def hall_page(browser, folder, report=None, locale="en-US"):
    """A page that shows a hall's fleet; its latest report may be another one."""
    files = write_results(str(folder / "fleets" / "hall-3" / "results"))
    if report is not None:
        write_report(files, report)
    with serving(folder) as address, opened(browser, address, locale) as page:
        show_fleet(page, "hall-3")
        yield page


def wheelbase_field(page):
    page.locator("#tab-vehicle").click()
    field = page.get_by_label("truck a, wheelbase")
    expect(field).not_to_have_value("", timeout=SOON)
    return field


def send_key(page, key):
    page.locator("#key").fill(key)
    page.locator("#key-send").click()


def file_of(name, content):
    """Return a zip as a person chooses it."""
    return {"name": f"{name}.zip", "mimeType": "application/zip", "buffer": content}


def in_screen_units(pose):
    return 1e3 * pose[0], 1e3 * pose[1], math.degrees(pose[2])


def number_in(text):
    return float(re.search(r"\d+(\.\d+)?", text)[0])


def test_a_calibration_typed_in_millimetres_finds_the_robot_that_made_the_numbers(page, picture):
    believed, actual = reference_vehicle().trucks["a"], Truck(0.3362, 0.14994, 0.15006)
    returns = dict(zip(("cw", "ccw"), square_returns(believed, actual, 4.0), strict=True))
    scatter = np.random.default_rng(4).normal(0.0, [0.004, 0.004, 0.001], (2, 3, 3))
    start(page, "manual", runs=3)
    for direction, deviations in zip(("cw", "ccw"), scatter, strict=True):
        for number, deviation in enumerate(deviations, start=1):
            add_run(page, direction, returns[direction] + deviation)
            marks = page.get_by_test_id("clusters-a").locator(f".run.{direction}")
            expect(marks).to_have_count(number, timeout=SOON)
    picture(page, "manual-runs")
    page.locator("#solve").click()
    result = page.get_by_test_id("result-a")
    wheelbase = number_in(result.locator(".headline strong").nth(1).inner_text())
    assert wheelbase == pytest.approx(1e3 * actual.wheelbase, abs=0.5)
    expect(result.locator(".methods tbody tr")).not_to_have_count(1)
    picture(page, "manual-result")
    accept(page)
    picture(page, "vehicle")
    page.locator("#history a").click()
    expect(page.locator("#session-state")).to_have_text("accepted", timeout=SOON)


def test_a_run_left_out_leaves_the_clusters(page):
    start(page, "manual", runs=2)
    for error in ((0.10, -0.02, 0.01), (0.11, -0.03, 0.01)):
        add_run(page, "cw", error)
        expect(page.locator("#sample-message")).to_contain_text("Added", timeout=SOON)
    marks = page.get_by_test_id("clusters-a").locator(".run")
    expect(marks).to_have_count(2)
    page.get_by_test_id("leave-out-1").click()
    expect(marks).to_have_count(1, timeout=SOON)
    expect(page.locator("#runs")).to_contain_text("110.0")


def test_three_distances_give_the_same_run_as_coordinates(page):
    after = np.array([0.030, -0.020, math.radians(1.5)])
    distances = [Sonar().ranges(pose) for pose in (np.zeros(3), after)]
    start(page, "manual", runs=1)
    page.locator("#sample label", has=page.locator("input[value=walls]")).click()
    for when, ranges in zip(("before", "after"), distances, strict=True):
        for name, value in zip(("right_front", "right_rear", "behind"), ranges, strict=True):
            page.get_by_test_id(f"{when}.walls.{name}").fill(f"{1e3 * value:.4f}")
    for name in ("x", "y", "theta"):
        page.get_by_test_id(f"calculated.{name}").fill("0")
    page.locator("#sample-send").click()
    cells = page.locator("#runs td")
    expect(cells.nth(2)).to_have_text("30.0", timeout=SOON)
    expect(cells.nth(3)).to_have_text("\N{MINUS SIGN}20.0")
    expect(cells.nth(4)).to_have_text("1.50")


def test_what_the_service_refuses_is_said_where_it_was_typed(page):
    start(page, "manual", runs=1)
    add_run(page, "cw", (29.0, 0.0, 0.0))
    expect(page.locator("#sample-message")).to_contain_text("no error of odometry", timeout=SOON)
    expect(page.locator("#sample-message")).to_have_attribute("data-kind", "wrong")


@pytest.mark.slow
def test_a_robot_that_drives_by_itself_is_calibrated_while_one_looks_on(robot_page, picture):
    page = robot_page
    live(page)
    start(page, "drive", runs=2)
    expect(page.get_by_test_id("laps-cw")).to_contain_text("1 of 2", timeout=LATER)
    page.locator("#tab-floor").click()
    expect(page.locator("#where tr")).not_to_have_count(0)
    picture(page, "floor")
    page.locator("#theme").click()
    picture(page, "floor-dark")
    page.set_viewport_size(PHONE)
    picture(page, "floor-phone-dark")
    page.locator("#theme").click()
    page.set_viewport_size(WIDE)
    page.locator("#tab-calibrate").click()
    page.locator("#sessions a").first.click()
    for direction in ("cw", "ccw"):
        expect(page.get_by_test_id(f"laps-{direction}")).to_contain_text("2 of 2", timeout=LATER)
    expect(page.locator("#session-state")).to_have_text("collecting runs", timeout=LATER)
    picture(page, "drive-runs")
    page.locator("#solve").click()
    for truck in ("a", "b"):
        headline = page.get_by_test_id(f"result-{truck}").locator(".headline strong").first
        before, after = map(number_in, headline.inner_text().split("→"))
        assert after < before
    picture(page, "drive-result")
    accept(page)


def test_s_stops_the_robot_and_the_session_says_so(robot_page, picture):
    page = robot_page
    live(page)
    start(page, "drive", runs=50, side=50)  # a drive that lasts until it is stopped
    expect(page.locator("#mode")).to_contain_text("drives", timeout=SOON)
    page.locator("#session-title").press("s")
    expect(page.locator("#stop-message")).to_contain_text("Stop sent", timeout=SOON)
    expect(page.locator("#session-state")).to_have_text("interrupted", timeout=SOON)
    expect(page.locator("#resume")).to_be_visible()
    picture(page, "stopped")


@pytest.mark.slow
def test_a_recording_is_uploaded_and_diagnosed_by_clicking(page, tmp_path, picture):
    folder = tmp_path / "straight"
    drive = [*OMNIMATE, "simulate", str(folder), "--protocol", "straight", "--side", "2", "--runs", "1"]
    subprocess.run(drive, check=True, capture_output=True)
    archive = shutil.make_archive(str(folder), "zip", folder)
    page.locator("#tab-recordings").click()
    page.locator("#upload").set_input_files(archive)
    expect(page.locator("#upload-message")).to_have_text("straight.zip is stored.", timeout=SOON)
    page.get_by_label("Choose straight").check()
    page.locator("#diagnose").click()
    job = page.locator("#jobs li").first
    expect(job).to_have_attribute("data-state", "done", timeout=LATER)
    expect(job.locator(".says")).to_contain_text("cannot show the wheelbase")
    picture(page, "recordings")
    job.get_by_role("button", name="Report").click()
    report = page.frame_locator("#report")
    expect(report.locator("h1")).to_have_text("omnimate", timeout=SOON)
    picture(page, "report")
    page.locator("#report-close").click()
    page.get_by_role("button", name="Delete straight").dblclick()
    expect(page.locator("#no-recordings")).to_be_visible(timeout=SOON)


def test_what_the_filter_learned_is_shown_and_taken_over_by_clicking(robot_page, picture):
    page = robot_page
    live(page)
    expect(page.locator("#learned tbody tr")).to_have_count(11, timeout=LATER)
    page.locator("#learned summary").click()
    expect(page.locator("#learned")).to_contain_text("drive rounded corners to both sides")
    picture(page, "learned-live")
    page.locator("#tab-recordings").click()
    page.locator("#upload").set_input_files(file_of("biased", biased_zip()))
    page.get_by_role("button", name="Learned biased").click()
    learned = page.locator("#recording-learned")
    expect(learned.locator(".chosen")).to_contain_text("joint_a bias", timeout=LATER)
    expect(learned.locator(".advice.warning")).to_contain_text("an axle that is turned")
    picture(page, "learned-recording")
    learned.get_by_role("button", name="Take over as version 2").click()
    expect(page.locator("#recording-learned-message")).to_have_text(
        "omnimate is now at version 2.", timeout=SOON
    )
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
    picture(page, "phone-learned-recording")


@pytest.mark.slow
def test_a_fleet_is_shown_at_a_glance_with_its_floor_a_robots_history_and_report(browser, tmp_path, picture):
    with hall_page(browser, tmp_path) as page:
        expect(page.get_by_test_id("state-sick")).to_have_text("1 faulty", timeout=SOON)
        expect(page.get_by_test_id("state-drift")).to_have_text("2 drift")
        expect(page.get_by_test_id("state-fine")).to_have_text("37 fine")
        expect(page.locator("#robot-dots a")).to_have_count(41)
        expect(page.get_by_test_id("floor-map").locator(".place")).to_have_count(2)
        picture(page, "fleet")
        page.locator("#theme").click()
        picture(page, "fleet-dark")
        page.locator("#theme").click()
        page.get_by_test_id(f"dot-{FAULTY}").click()
        expect(page.locator("#fleet-robot-state")).to_have_text("faulty", timeout=SOON)
        expect(page.locator("#fleet-robot-says")).to_contain_text("\N{MINUS SIGN}0.760 ± 0.020 %")
        wheelbase = page.get_by_test_id("history-wheelbase")
        expect(wheelbase.locator(".point")).to_have_count(30)
        expect(wheelbase.locator(".since")).to_have_count(1)
        expect(page.locator(".since")).to_have_count(1)
        expect(page.locator("#fleet-recordings tr")).to_have_count(20)
        picture(page, "fleet-robot")
        page.locator("#more-fleet-recordings").click()
        expect(page.locator("#fleet-recordings tr")).to_have_count(30, timeout=SOON)
        page.locator("#fleet-robot-report").click()
        expect(page.frame_locator("#report").locator("h1")).to_have_text(FAULTY, timeout=LATER)
        picture(page, "fleet-report")
        page.locator("#report-close").click()
        page.set_viewport_size(PHONE)
        assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
        picture(page, "phone-fleet-robot")
        page.locator("#fleet-back").click()
        expect(page.get_by_test_id("state-sick")).to_be_visible(timeout=SOON)
        expect(page.locator("#tab-fleet")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
        picture(page, "phone-fleet")


def test_a_days_recordings_are_uploaded_and_worked_on_by_clicking(page, picture):
    show_fleet(page, "small")
    expect(page.locator("#fleet-title")).to_have_text("Fleet small", timeout=SOON)
    page.locator("#fleet-upload").set_input_files(file_of("day", day_zip()))
    expect(page.locator("#fleet-upload-message")).to_contain_text("2 recordings of 2 robots", timeout=SOON)
    page.locator("#fleet-diagnose").uncheck()
    page.locator("#batch-start").click()
    batch = page.locator("#batches li").first
    expect(batch).to_have_attribute("data-state", "done", timeout=LATER)
    expect(batch.locator(".says")).to_have_text("2 recordings worked on, 0 known before")
    expect(page.locator("#fleet-night")).to_have_text("report of 2026-03-02", timeout=SOON)
    expect(page.get_by_test_id("state-unjudged")).to_have_text("2 not judged")
    picture(page, "fleet-batch")


@pytest.fixture(scope="module")
def keyed(tmp_path_factory):
    """The address of a service with two keys, and these by their names; `visitor` only reads."""
    folder, keys = tmp_path_factory.mktemp("keyed"), {}
    for name, role in (("shop floor", "operate"), ("visitor", "read")):
        call = [*OMNIMATE, "key", "add", name, "--role", role]
        made = subprocess.run(call, cwd=folder, check=True, capture_output=True, text=True)
        keys[name] = made.stdout.split()[-1]
    with serving(folder) as url:
        yield url, keys


def test_a_key_that_only_reads_changes_no_vehicle_and_the_service_says_why(browser, keyed):
    address, keys = keyed
    with opened(browser, address) as page:
        expect(page.locator("#key-dialog")).to_be_visible(timeout=SOON)
        send_key(page, keys["visitor"])
        field = wheelbase_field(page)
        field.fill("500")
        field.press("Enter")
        expect(page.locator("#edit-message")).to_contain_text("read", timeout=SOON)
        expect(page.locator("#vehicle-title")).to_have_text("omnimate, version 1")


def test_a_service_with_keys_asks_for_one_and_names_it_at_the_versions_that_it_made(browser, keyed, picture):
    address, key = keyed[0], keyed[1]["shop floor"]
    with opened(browser, address) as page:
        expect(page.locator("#key-dialog")).to_be_visible(timeout=SOON)
        picture(page, "key")
        send_key(page, f"{key[:-4]}xxxx")
        expect(page.locator("#key-message")).not_to_be_empty(timeout=SOON)
        send_key(page, key)
        live(page)
        expect(page.locator("#key-dialog")).to_be_hidden()
        field = wheelbase_field(page)
        field.fill("350")
        field.press("Enter")
        expect(page.locator("#history tr")).to_have_count(2, timeout=SOON)
        expect(page.locator("#history tr").first).to_contain_text("sent, key shop floor")


def test_a_vehicle_is_changed_and_its_versions_are_compared(robot_page, picture):
    page = robot_page
    for version, width in enumerate((1440, 390), start=2):
        page.set_viewport_size({"width": width, "height": 1600})
        field = wheelbase_field(page)
        former = float(field.input_value())
        field.fill("5")
        expect(field).to_have_accessible_description("Expected 10 to 10000 mm.")
        field.fill(f"{former + 1:g}")
        expect(page.locator("#edit-difference")).to_contain_text("+1.000")
        for scheme in ("dark", "light"):
            page.emulate_media(color_scheme=scheme)
            picture(page, f"vehicle-change-{width}-{scheme}")
        field.press("Enter")
        expect(page.locator("#edit-message")).to_have_text(f"Saved as version {version}.", timeout=SOON)
        expect(page.locator("#comparison caption")).to_contain_text(f"Version {version}")
        expect(page.locator("#comparison tbody tr").first).to_contain_text("+1.000")
        assert page.evaluate("document.documentElement.scrollWidth") == width
        page.locator("#comparison").scroll_into_view_if_needed()
        for scheme in ("dark", "light"):
            page.emulate_media(color_scheme=scheme)
            picture(page, f"vehicle-compare-{width}-{scheme}")


def test_a_vehicle_that_somebody_else_changed_is_shown_and_its_comments_stay(robot_page):
    page = robot_page
    field = wheelbase_field(page)
    address = f"{page.url.partition('#')[0]}v1/vehicles/omnimate"
    text = page.request.get(address).json()["toml"].replace("wheelbase = 0.34", "wheelbase = 0.34  # by hand")
    headers = {"If-Match": '"1"', "Content-Type": "application/toml"}
    assert page.request.put(address, data=text, headers=headers).ok
    field.fill("500")
    field.press("Enter")
    expect(page.locator("#edit-message")).to_contain_text("version 2 is shown now", timeout=SOON)
    expect(page.locator("#vehicle-title")).to_have_text("omnimate, version 2")
    expect(field).to_have_value("500")
    field.press("Enter")
    expect(page.locator("#edit-message")).to_have_text("Saved as version 3.", timeout=SOON)
    saved = page.request.get(address).json()
    assert saved["trucks"]["a"]["wheelbase"] == 0.5
    assert saved["toml"] == text.replace("0.34 ", "0.5 ", 1)


def test_docs_show_every_call_of_the_interface(page, address, picture):
    described = page.request.get(f"{address}/openapi.json").json()
    calls = sum(method in item for item in described["paths"].values() for method in METHODS)
    page.goto(f"{address}/docs")
    expect(page.locator("details")).to_have_count(calls, timeout=SOON)
    page.locator("summary").nth(1).click()
    expect(page.locator("details pre").nth(2)).to_contain_text("side: number", timeout=SOON)
    expect(page.locator("#calls")).not_to_contain_text("[object HTML")
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
    picture(page, "docs")


@pytest.mark.parametrize("locale", ["en-US", "de-DE"])
@pytest.mark.parametrize("view", ["floor", "calibrate", "recordings", "vehicle", "fleet"])
def test_no_view_is_wider_than_a_phone(browser, address, view, locale, picture):
    with opened(browser, address, locale) as page:
        page.set_viewport_size(PHONE)
        page.locator(f"#tab-{view}").click()
        expect(page.locator(f"#{view}")).to_be_visible()
        assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
        for part in ("#stop", "#tab-floor", "#tab-fleet"):
            expect(page.locator(part)).to_be_in_viewport(ratio=1)
        picture(page, f"phone-{view}-{locale}")


def test_a_long_name_makes_no_title_wider_than_a_phone(robot_page):
    robot_page.set_viewport_size(PHONE)
    name = "F" * 64
    robot_page.request.post(f"{robot_page.url}v1/fleets", data={"name": name})
    robot_page.evaluate(f"location.hash = '#fleet/{name}'")
    expect(robot_page.locator("#fleet-title")).to_contain_text(name, timeout=SOON)
    right = robot_page.locator("#fleet-title").evaluate("title => title.getBoundingClientRect().right")
    assert right <= PHONE["width"]


def test_a_session_is_started_for_the_robot_on_the_bus_where_there_are_others(robot_page):
    """The first name was chosen: that robot cannot drive here, and by hand another one was calibrated."""
    text = format_vehicle(replace(reference_vehicle(), name="another"))
    headers = {"Content-Type": "application/toml"}
    assert robot_page.request.post(f"{robot_page.url}v1/vehicles", data=text, headers=headers).status == 201
    robot_page.locator("#tab-calibrate").click()
    expect(robot_page.locator("#start-vehicle option")).to_have_count(2, timeout=SOON)
    expect(robot_page.locator("#start-vehicle")).to_have_value("omnimate")


def test_the_page_is_in_the_browsers_language_until_another_one_is_chosen(browser, address):
    with opened(browser, f"{address}/#vehicle", "de-DE") as page:
        sizes = page.locator("#parameters")
        expect(sizes).to_contain_text(re.compile(r"Radstand\d+,\d\d"), timeout=SOON)
        expect(page).to_have_title("omnimate: Kalibrierung", timeout=SOON)
        page.get_by_role("button", name="English").click()
        expect(sizes).to_contain_text(re.compile(r"wheelbase\d+\.\d\d"), timeout=SOON)
        page.reload()
        expect(sizes).to_contain_text(re.compile(r"wheelbase\d+\.\d\d"), timeout=SOON)
        expect(page.locator("html")).to_have_attribute("lang", "en")


def test_findings_are_in_the_pages_language_and_those_of_one_floor_are_chosen(browser, tmp_path):
    with hall_page(browser, tmp_path, report_of_two_floors(), "de-DE") as page:
        faulty, asked = (page.get_by_test_id(f"finding-{robot}") for robot in (FAULTY, ASKED))
        expect(faulty).to_contain_text(
            "Radstand: Änderung um \N{MINUS SIGN}0,760 ± 0,020 % seit 2026-03-23 "
            "(2026-03-22 bis 2026-03-24), \N{MINUS SIGN}0,040 % je Tag",
            timeout=SOON,
        )
        expect(asked).to_contain_text(
            "die Triage verlangt seit 2026-03-28 dieselbe Diagnose: Getriebespiel, linkes Rad von Wagen a"
        )
        expect(page.locator("#fleet-places")).to_have_text(
            "Boden north, bei x 16,00 m, y 12,10 m: Schlupf, 23,6 mm je Überfahrt, 62 Überfahrten"
        )
        page.get_by_test_id("floor-name").select_option("south")
        expect(page.locator("#fleet-places")).to_contain_text("Roboter driften seitlich in Richtung 63 Grad")
        expect(page.locator("#fleet-places")).to_contain_text("Boden south")
        expect(page.locator("#fleet-places li")).to_have_count(1)
        page.get_by_test_id(f"dot-{ASKED}").click()
        expect(page.locator("#fleet-robot-says")).to_contain_text("die Triage verlangt", timeout=SOON)


def test_what_a_diagnosis_found_has_names_in_the_pages_language(browser, address, picture):
    job = {"id": "1", "recordings": ["1"], "state": "done", "verdict": "mismatch", "says": "It differs.",
           "progress": 1.0, "doing": "", "error": None, "attempts": 1, "created": 1.7e9}  # fmt: skip
    result = {"findings": [
        {"effect": "wheel_diameter", "component": "a.left", "probability": 0.98},
        {"effect": "unknown", "component": "b", "probability": 0.5},
    ]}  # fmt: skip
    with opened(browser, address, "de-DE") as page:
        page.route("**/v1/diagnoses?*", lambda route: route.fulfill(json={"items": [job], "next": None}))
        page.route("**/v1/diagnoses/1/result", lambda route: route.fulfill(json=result))
        page.locator("#tab-recordings").click()
        expect(page.locator("#jobs .found")).to_have_text(
            "Raddurchmesser, linkes Rad von Wagen a (98 %); Fehler ohne Namen, Wagen b (50 %)", timeout=SOON
        )
        expect(page.locator("#jobs .says")).to_have_attribute("lang", "en")
        picture(page, "diagnosis-german")


def test_fields_of_the_german_page_show_a_comma_and_take_a_comma_or_a_point(browser, address):
    with opened(browser, f"{address}/#vehicle", "de-DE") as page:
        field = page.locator("#edit-truck-a-wheelbase")
        for text, shown in (("341,25", "341,25"), ("341.25", "341,25"), ("341,2x", None)):
            field.fill(text)
            if shown is None:
                expect(field).to_have_attribute("aria-invalid", "true")
            else:
                expect(page.locator("#edit-difference")).to_contain_text(shown)
        field.fill("341,25")
        page.locator("#edit-send").click()
        expect(page.locator("#edit-message")).to_have_attribute("data-kind", "good", timeout=SOON)
        expect(field).to_have_value("341,25")
        start(page, "manual", runs=1, side="2,5")
        for name, value in (
            ("after.x", "30,5"),
            ("after.y", "-20.25"),
            ("after.theta", "x"),
            ("calculated.x", "0"),
            ("calculated.y", "0"),
        ):
            page.get_by_test_id(name).fill(value)
        page.locator("#sample-send").click()
        expect(page.get_by_test_id("after.theta")).to_have_attribute("aria-invalid", "true")
        page.get_by_test_id("after.theta").fill("1,5")
        page.get_by_test_id("calculated.theta").fill("0")
        page.locator("#sample-send").click()
        cells = page.locator("#runs td")
        expect(cells.nth(2)).to_have_text("30,5", timeout=SOON)
        expect(cells.nth(4)).to_have_text("1,50")


def violations(page):
    """Return what axe finds on the page as it is shown now: the rule and the element."""
    rules = axe.Axe().run(page).response["violations"]
    return [f"{rule['id']}: {node['html']}" for rule in rules for node in rule["nodes"]]


def assert_accessible(page, view):
    """Fail where axe finds a violation in a view: wide or narrow, light or dark."""
    for width, scheme in itertools.product((1440, 390), ("light", "dark")):
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(color_scheme=scheme)
        assert violations(page) == [], f"{view}, {width} px, {scheme}"
    page.set_viewport_size(WIDE)


@pytest.mark.slow
@pytest.mark.parametrize("locale", ["en-US", "de-DE"])
def test_axe_finds_no_violation_in_any_view(browser, tmp_path, locale):
    write_results(str(tmp_path / "fleets" / "hall-3" / "results"))
    with serving(tmp_path) as address, opened(browser, address, locale) as page:
        live(page)
        expect(page.locator("#learned tbody tr")).to_have_count(11, timeout=LATER)
        assert_accessible(page, "floor")
        page.locator("#tab-recordings").click()
        page.locator("#upload").set_input_files(file_of("drive", biased_zip()))
        expect(page.locator("#recording-list input")).to_have_count(1, timeout=SOON)
        page.locator("#recording-list .buttons button").first.click()
        expect(page.locator("#recording-learned")).to_be_visible(timeout=LATER)
        assert_accessible(page, "recordings")
        page.locator("#tab-vehicle").click()
        page.locator("#edit-fields input").first.fill("5")
        page.locator("#edit-fields input").last.fill("999")
        assert_accessible(page, "vehicle, changed")
        page.locator("#edit-fields input").first.fill("341")
        page.locator("#edit-send").click()
        expect(page.locator("#compare")).to_be_visible(timeout=SOON)
        assert_accessible(page, "vehicle, compared")
        show_fleet(page, "hall-3")
        page.get_by_test_id(f"dot-{FAULTY}").wait_for(timeout=SOON)
        assert_accessible(page, "fleet")
        page.get_by_test_id(f"dot-{FAULTY}").click()
        expect(page.locator("#fleet-recordings tr")).to_have_count(20, timeout=SOON)
        assert_accessible(page, "fleet's robot")
        page.locator("#fleet-robot-report").click()
        page.frame_locator("#report").locator("h1").wait_for(timeout=LATER)
        assert_accessible(page, "report")
        page.locator("#report-close").click()
        start(page, "manual", runs=1)
        page.locator("#sample label", has=page.locator("input[value=walls]")).click()
        assert_accessible(page, "session, three distances")
        page.locator("#sample label", has=page.locator("input[value=coordinates]")).click()
        for direction in ("cw", "ccw"):
            add_run(page, direction, (0.1, -0.02, 0.01))
            marks = page.get_by_test_id("clusters-a").locator(f".run.{direction}")
            expect(marks).to_have_count(1, timeout=SOON)
        page.locator("#solve").click()
        page.locator("#plot svg").wait_for(timeout=LATER)
        assert_accessible(page, "session, solved")
        page.locator("#tab-calibrate").click()
        expect(page.locator("#sessions tr")).to_have_count(1, timeout=SOON)
        assert_accessible(page, "calibrate")
        page.goto(f"{address}/docs")
        page.locator("summary").nth(1).click()
        assert_accessible(page, "docs")
