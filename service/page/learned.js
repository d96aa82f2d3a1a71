// What the filter has learned of a robot: its values, what contradicts them, and the button that takes them over.

import { post } from "./api.js";
import { actionButton, el, row, say } from "./dom.js";
import { t } from "./language.js";
import { deg, number } from "./units.js";

const UNITS = { m: ["mm", (value) => number(1000 * value, 3)], s: ["ms", (value) => number(1000 * value, 2)], rad: ["°", (value) => deg(value, 3)] };

/** Show what `GET path` answered in the node `holder`; `changed` is called when it was taken over. */
export function showLearned(holder, message, learned, path, changed) {
  const open = holder.querySelector("details")?.open ?? false;
  holder.replaceChildren(
    ...learned.advice.filter(({ severity }) => severity !== "note").map(said),
    el("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": t("Learned") }, el("table", { class: "numbers methods" },
      el("thead", {}, row(...[t("compared with the file"), t("change"), "±"].map((word) => el("th", { scope: "col" }, word)))),
      el("tbody", {}, learned.values.map(line)))),
    details(learned.advice.filter(({ severity }) => severity === "note"), open),
    el("div", { class: "buttons" }, take(message, learned, path, changed)),
  );
}

function line({ name, unit, described, value, sigma }) {
  const [word, shown] = UNITS[unit];
  const shownRow = row(el("th", { scope: "row" }, name, " ", el("small", {}, word)), shown(value - described), shown(sigma));
  shownRow.classList.toggle("chosen", Math.abs(value - described) > 2 * sigma);
  return shownRow;
}

const said = ({ severity, what, do: todo }) => el("p", { class: `advice ${severity}` }, `${what}: ${todo}.`);

function details(notes, open) {
  const node = el("details", {}, el("summary", {}, t("What encoders have not shown")), ...notes.map(said));
  node.open = open;
  return node;
}

function take(message, { vehicle, vehicle_version: version }, path, changed) {
  const word = version === null ? t("{vehicle} is not known here", { vehicle }) : t("Take over as version {version}", { version: version + 1 });
  return actionButton(word, message, async () => {
    const made = await post(`${path}/accept`, undefined, { headers: { "If-Match": `"${version}"` } });
    say(message, t("{name} is now at version {version}.", made), "good");
    await changed();
  }, { class: "quiet", disabled: version === null });
}
