// One robot of a fleet: its state, its numbers day by day, its recordings, and the finding's report.

import { call, get } from "./api.js";
import { VERDICTS } from "./diagnoses.js";
import { $, attempt, el, pages, row, say, showing } from "./dom.js";
import { address, STATES } from "./fleet.js";
import { historyPlot } from "./fleet-drawings.js";
import { numberName, robotSays } from "./fleet-words.js";
import { t } from "./language.js";
import { showReport } from "./report-dialog.js";
import { number } from "./units.js";

let shown = null; // [fleet, robot]

export function setUpFleetRobot() {
  $("fleet-robot-report").addEventListener("click", () => attempt($("fleet-robot-report"), $("fleet-robot-message"), async () => {
    const html = await (await call("GET", address(shown[0], "robots", shown[1], "report"))).text();
    showReport(html, `${shown[1]}.html`, $("fleet-robot-report"));
  }));
}

export async function openFleetRobot(fleet, robot) {
  shown = [fleet, robot];
  scrollTo(0, 0);
  $("fleet-robot-title").textContent = robot;
  $("fleet-back").href = `#fleet/${encodeURIComponent(fleet)}`;
  $("fleet-back").textContent = t("All robots of {fleet}", { fleet });
  await showing($("fleet-robot-message"), async () => {
    const { robot: about, courses } = await get(address(fleet, "robots", robot, "history"));
    say($("fleet-robot-message"));
    $("fleet-robot-state").textContent = STATES[about.state];
    $("fleet-robot-state").className = `chip ${about.state}`;
    $("fleet-robot-says").textContent = robotSays(about) || (about.kind ?? "");
    const since = about.state === "fine" ? null : about.change;
    $("fleet-history").replaceChildren(...courses.map((course) => el("figure", {}, historyPlot(course, since?.name === course.name ? since.since : null), el("figcaption", {}, numberName(course.name)))));
    if (!courses.length) $("fleet-history").replaceChildren(el("p", { class: "soft" }, t("No daily report judges this robot yet.")));
    await pages(address(fleet, "robots", robot, "recordings"), 20, $("fleet-recordings"), recordingRow, $("no-fleet-recordings"), $("more-fleet-recordings"));
  });
}

function recordingRow({ day, recording, way, triage, says, diagnosis, problem }) {
  const word = problem ? "failed" : triage;
  return row(el("b", {}, day), recording, way === null ? "–" : `${number(way)} m`, word ? el("span", { class: `chip ${word}` }, VERDICTS[word] ?? t("failed")) : "–", el("td", { class: "words" }, problem ?? diagnosis ?? says ?? ""));
}
