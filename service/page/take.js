// Runs of a session that come from uploaded recordings.

import { get, post } from "./api.js";
import { $, attempt, el, say, show } from "./dom.js";
import { lasting } from "./units.js";

let session;
let changed;

/** `current` gives the session that is shown; `after` is called when it has more runs. */
export function setUpTake(current, after) {
  session = current;
  changed = after;
}

export async function showTake({ how, possible, samples }) {
  const shown = how === "recordings" && possible.includes("sample");
  const before = $("take").hidden;
  $("take").hidden = !shown;
  if (!shown) return;
  const taken = new Set(samples.map(({ recording }) => recording));
  try {
    const { items } = await get("/v1/recordings?limit=200");
    $("take-list").replaceChildren(...items.map((one) => recordingLine(one, taken.has(one.id))));
    if (before || items.length === 0) say($("take-message"), items.length ? "" : "There are no recordings yet: upload one under Recordings.");
  } catch (problem) {
    show($("take-message"), problem);
  }
}

function recordingLine(recording, taken) {
  const button = el("button", { type: "button", class: "quiet small", "data-testid": `take-${recording.id}`, disabled: taken, "aria-label": `Take the runs of ${recording.name}` }, taken ? "Taken" : "Take its runs");
  button.addEventListener("click", () => attempt(button, $("take-message"), async () => {
    await post(`/v1/umbmark/sessions/${session().id}/samples`, { recording: recording.id });
    await changed();
  }));
  return el("li", {}, el("span", {}, el("b", {}, recording.name), ` ${recording.vehicle}, ${lasting(recording.seconds)}`), button);
}
