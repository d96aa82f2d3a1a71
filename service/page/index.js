// The page: the view that is shown, and the header above all views.

import { get } from "./api.js";
import { $, say } from "./dom.js";
import { setUpDiagnoses } from "./diagnoses.js";
import { openFleet, setUpFleet } from "./fleet.js";
import { openFleetRobot, setUpFleetRobot } from "./fleet-robot.js";
import { setUpFloor, showVehicle } from "./floor.js";
import { setUpKeyDialog } from "./key-dialog.js";
import { t } from "./language.js";
import { openRecordings, setUpRecordings } from "./recordings.js";
import { closeReport, setUpReportDialog } from "./report-dialog.js";
import { openSession, setUpSession } from "./session.js";
import { setUpStopButton } from "./stop-button.js";
import { on, start } from "./stream.js";
import { openVehicle, setUpVehicle } from "./vehicle.js";
import { openSessionList, setUpSessionList } from "./session-list.js";

const VIEWS = { floor: showRobot, calibrate: openSessionList, recordings: openRecordings, vehicle: openVehicle, fleet: openFleet };
const MODES = { simulated: t("simulated"), bus: t("on its bus") };

/** Show the view of the address: #floor, #calibrate, #calibrate/ID, #recordings, #vehicle, #fleet, #fleet/NAME or #fleet/NAME/ROBOT. */
function route() {
  const [name, id, robot] = location.hash.slice(1).split("/").map(decodeURIComponent);
  const tab = name in VIEWS ? name : "floor";
  const view = tab === "calibrate" && id ? "session" : tab === "fleet" && robot ? "fleet-robot" : tab;
  closeReport();
  for (const section of document.querySelectorAll("main > section")) section.hidden = section.id !== view;
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash === `#${tab}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  if (view === "session") openSession(id);
  else if (view === "fleet-robot") openFleetRobot(id, robot);
  else VIEWS[tab](id);
}

/** Show the robot's name, and draw it in its size. */
async function showRobot() {
  try {
    const { vehicle } = await get("/v1/robot");
    $("robot-name").textContent = vehicle;
    document.title = t("{vehicle}: calibration", { vehicle });
    showVehicle(await get(`/v1/vehicles/${encodeURIComponent(vehicle)}`));
  } catch {
    // The lamp shows that the service cannot be reached; the key dialog asks for a missing key.
  }
}

function showLink({ now, wait }) {
  const words = { connecting: t("connecting"), live: t("live"), key: t("needs a key"), lost: t("lost, again in {wait} s", { wait }) };
  $("lamp").dataset.now = now;
  $("lamp").textContent = words[now];
  document.body.classList.toggle("stale", now !== "live");
  if (now === "live") showRobot();
}

function showState({ mode, driving, problem }) {
  const words = MODES[mode] + (driving ? t(", drives") : "");
  if ($("mode").textContent !== words) {
    $("mode").hidden = false;
    $("mode").textContent = words;
  }
  document.body.classList.toggle("drives", Boolean(driving));
  $("robot-problem").hidden = !problem;
  if ($("robot-problem").textContent !== (problem ?? "")) say($("robot-problem"), problem ?? "", "warning");
}

setUpStopButton();
setUpKeyDialog();
setUpFloor();
setUpSessionList();
setUpSession();
setUpRecordings();
setUpDiagnoses();
setUpReportDialog();
setUpVehicle();
setUpFleet();
setUpFleetRobot();
on("link", showLink);
on("state", showState);
on("session", ({ state }) => state === "accepted" && showRobot());
addEventListener("hashchange", route);
document.addEventListener("key-given", route);
route();
start();
