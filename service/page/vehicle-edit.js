// The form that changes the sizes of a vehicle. It changes these numbers alone in the text of vehicle.toml, so that comments stay.

import { call, get } from "./api.js";
import { $, announce, el, onSubmit, say } from "./dom.js";
import { t } from "./language.js";
import { metres, read, typed } from "./units.js";
import { differenceTable, sizesOf } from "./vehicle-sizes.js";

const DIAMETER = [5, 3000];
const LIMITS = { wheelbase: [10, 10_000], wheel_diameter_left: DIAMETER, wheel_diameter_right: DIAMETER, length: [50, 20_000] }; // [mm], as in vehicle/parameters.py
let vehicle = null;
let fields = [];

/** `refresh` shows the newest version of a vehicle everywhere else on the page. */
export function setUpVehicleForm(refresh) {
  onSubmit("edit", () => send(refresh));
  $("edit-reset").addEventListener("click", () => showVehicleForm(vehicle));
}

/** Fill the form with a version; `drafts` are the texts of fields, by id, that a person has typed and that stay. */
export function showVehicleForm(newest, drafts = {}) {
  vehicle = newest;
  say($("edit-message"));
  fields = sizesOf(vehicle).map((size) => {
    const id = `edit-${size.table}-${size.key}`.replaceAll(/[._]/g, "-");
    const shown = Number((1000 * size.value).toFixed(4));
    const input = el("input", {
      id, inputmode: "decimal", autocomplete: "off", value: drafts[id] ?? typed(shown), required: true, "aria-describedby": `${id}-message`, "data-where": `${size.table}.${size.key}`, oninput: check,
    });
    return { ...size, id, shown, input, message: el("small", { id: `${id}-message`, class: "message", "aria-live": "polite" }) };
  });
  $("edit-fields").replaceChildren(...fields.map(({ id, label, input, message }) =>
    el("div", {}, el("label", { for: id }, label), el("span", { class: "unit", "data-unit": "mm" }, input), message)));
  $("edit-send").textContent = t("Save as version {version}", { version: vehicle.version + 1 });
  check();
}

const changed = () => fields.filter(({ input, shown }) => read(input) !== shown);

/** Check what is typed, and show the difference; returns the first wrong field. */
function check() {
  const wrong = fields.filter(({ input, key, message }) => {
    const [low, high] = LIMITS[key];
    const value = read(input);
    const good = value != null && low <= value && value <= high;
    if (good) input.removeAttribute("aria-invalid");
    else input.setAttribute("aria-invalid", "true");
    const sentence = good ? "" : t("Expected {low} to {high} mm.", { low, high });
    if (message.textContent !== sentence) say(message, sentence, good ? "" : "wrong");
    return !good;
  });
  const valid = changed().filter((field) => !wrong.includes(field));
  $("edit-difference-part").hidden = !valid.length;
  $("edit-difference").replaceChildren(...differenceTable(valid, valid.map((field) => ({ ...field, value: metres(read(field.input)) })), [t("Old"), t("New")]));
  return wrong[0];
}

async function send(refresh) {
  const wrong = check();
  if (wrong) {
    wrong.input.focus();
    return;
  }
  const changes = changed();
  if (!changes.length) throw new Error(t("Nothing is changed yet."));
  const { name, version, toml } = vehicle;
  const address = `/v1/vehicles/${encodeURIComponent(name)}`;
  const body = changes.reduce((text, { table, key, input }) => withNumber(text, table, key, metres(read(input))), toml);
  try {
    await call("PUT", address, { body, type: "application/toml", headers: { "If-Match": `"${version}"` } });
  } catch (problem) {
    if (problem.status !== 412) throw problem;
    const drafts = Object.fromEntries(changes.map(({ id, input }) => [id, input.value]));
    const newest = await get(address);
    await refresh(name);
    showVehicleForm(newest, drafts);
    throw new Error(t("Somebody else changed the vehicle meanwhile: version {version} is shown now. What you typed is still in the form; look at the difference, then save again.", newest));
  }
  await refresh(name);
  say($("edit-message"), t("Saved as version {version}.", vehicle), "good");
  announce(t("Saved as version {version}.", vehicle));
}

/** The text of a vehicle.toml with another number for a key of a table. Throws where the key is not on a line of its own in `[table]`. */
function withNumber(text, table, key, value) {
  const head = new RegExp(`^\\s*\\[\\s*${table.replace(".", "\\s*\\.\\s*")}\\s*\\]\\s*(#[^\\n]*)?$`);
  const assignment = new RegExp(`^(\\s*${key}\\s*=\\s*)[-+.\\w]+(?=\\s*(#[^\\n]*)?$)`);
  let [inside, found] = [false, 0];
  const lines = text.split("\n").map((line) => {
    if (/^\s*\[/.test(line)) inside = head.test(line);
    if (!inside || !assignment.test(line)) return line;
    found += 1;
    return line.replace(assignment, (_, start) => start + (Number.isInteger(value) ? value.toFixed(1) : value));
  });
  if (found !== 1) throw new Error(t("This vehicle.toml has no line '{key} = ...' below [{table}]. Save it under Exports, change it there, and PUT it.", { key, table }));
  return lines.join("\n");
}
