// Runs of a session that come from uploaded recordings.

import { get, post } from "./api.js";
import { $, actionButton, el, say, show } from "./dom.js";
import { t } from "./language.js";
import { lasting } from "./units.js";

let currentSession;
let added;

/** `current` returns the session that is shown; `afterAdding` is called when runs were added. */
export function setUpRecordedRuns(current, afterAdding) {
  currentSession = current;
  added = afterAdding;
}

export async function showRecordedRuns({ how, possible, samples }) {
  const shown = how === "recordings" && possible.includes("sample");
  const before = $("recorded-runs").hidden;
  $("recorded-runs").hidden = !shown;
  if (!shown) return;
  const taken = new Set(samples.map(({ recording }) => recording));
  try {
    const { items } = await get("/v1/recordings?limit=200");
    $("recorded-runs-list").replaceChildren(...items.map((recording) => recordingLine(recording, taken.has(recording.id))));
    if (before || items.length === 0) say($("recorded-runs-message"), items.length ? "" : t("There are no recordings yet: upload one under Recordings."));
  } catch (problem) {
    show($("recorded-runs-message"), problem);
  }
}

function recordingLine(recording, taken) {
  const button = actionButton(taken ? t("Taken") : t("Take its runs"), $("recorded-runs-message"), async () => {
    await post(`/v1/umbmark/sessions/${currentSession().id}/samples`, { recording: recording.id });
    await added();
  }, { "data-testid": `take-${recording.id}`, disabled: taken, "aria-label": t("Take the runs of {name}", recording) });
  return el("li", {}, el("span", {}, el("b", {}, recording.name), ` ${recording.vehicle}, ${lasting(recording.seconds)}`), button);
}
