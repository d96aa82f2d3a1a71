// Runs of a session that come from uploaded recordings.

import { get, post } from "./api.js";
import { $, actionButton, el, say, showing } from "./dom.js";
import { t } from "./language.js";
import { lasting } from "./units.js";

/** `added` is called when runs were added. */
export async function showRecordedRuns({ id, how, possible, samples }, added) {
  const shown = how === "recordings" && possible.includes("sample");
  const before = $("recorded-runs").hidden;
  $("recorded-runs").hidden = !shown;
  if (!shown) return;
  const taken = new Set(samples.map(({ recording }) => recording));
  await showing($("recorded-runs-message"), async () => {
    const { items } = await get("/v1/recordings?limit=200");
    $("recorded-runs-list").replaceChildren(...items.map((recording) => recordingLine(id, recording, taken.has(recording.id), added)));
    if (before || items.length === 0) say($("recorded-runs-message"), items.length ? "" : t("There are no recordings yet: upload one under Recordings."));
  });
}

function recordingLine(session, recording, taken, added) {
  const button = actionButton(taken ? t("Taken") : t("Take its runs"), $("recorded-runs-message"), async () => {
    await post(`/v1/umbmark/sessions/${session}/samples`, { recording: recording.id });
    await added();
  }, { "data-testid": `take-${recording.id}`, disabled: taken, "aria-label": t("Take the runs of {name}", recording) });
  return el("li", {}, el("span", {}, el("b", {}, recording.name), ` ${recording.vehicle}, ${lasting(recording.seconds)}`), button);
}
