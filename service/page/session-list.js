// UMBmark sessions: the form that starts a session, and the list of all sessions.

import { get, list, post } from "./api.js";
import { $, el, onSubmit, pages, row, say, showing } from "./dom.js";
import { squareDrawing } from "./drawings.js";
import { t } from "./language.js";
import { on } from "./stream.js";
import { number, read, when } from "./units.js";

export const STATES = {
  collecting: t("collecting runs"), driving: t("driving"), measuring: t("waits to be measured"), interrupted: t("interrupted"),
  solved: t("solved"), accepted: t("accepted"), aborted: t("aborted"), failed: t("failed"), expired: t("expired"),
};

export function setUpSessionList() {
  $("squares").append(squareDrawing("cw"), squareDrawing("ccw"));
  onSubmit("start", begin);
  on("session", () => $("calibrate").hidden || listSessions());
}

export async function openSessionList() {
  await showing($("start-message"), async () => {
    const [items, { vehicle }] = await Promise.all([list("/v1/vehicles"), get("/v1/robot")]);
    $("start-vehicle").replaceChildren(...items.map(({ name, version }) => el("option", { value: name }, t("{name} (version {version})", { name, version }))));
    $("start-vehicle").value = vehicle;
    say($("start-message"));
  });
  await listSessions();
}

async function begin() {
  const how = new FormData($("start")).get("how");
  const session = await post("/v1/umbmark/sessions", {
    vehicle: $("start-vehicle").value,
    side: read($("start-side")),
    runs: read($("start-runs")),
    how,
  });
  location.hash = `#calibrate/${session.id}`;
}

async function listSessions() {
  await showing($("sessions-message"), async () => {
    await pages("/v1/umbmark/sessions", 10, $("sessions"), sessionRow, $("no-sessions"), $("more-sessions"));
    say($("sessions-message"));
  });
}

function sessionRow(session) {
  const { counts, runs } = session;
  const going = ["collecting", "driving", "measuring", "interrupted", "solved"].includes(session.state);
  return row(
    when(session.created),
    t("{name}, version {version}", { name: session.vehicle, version: session.vehicle_version }),
    `${number(session.side, session.side % 1 ? 2 : 0)} m`,
    t("cw {cw}, ccw {ccw} of {runs}", { ...counts, runs }),
    el("span", { class: `chip ${session.state}` }, STATES[session.state]),
    el("a", { href: `#calibrate/${session.id}`, class: "open", "data-testid": `open-${session.id}` }, going ? t("Go on") : t("Look"), el("span", { class: "unseen" }, t(": session of {when}", { when: when(session.created) }))),
  );
}
