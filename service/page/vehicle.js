// A vehicle: its parameters, how they became what they are, and its exports.

import { call, get, list, saveBlob } from "./api.js";
import { $, attempt, el, row, say, show, showing } from "./dom.js";
import { t } from "./language.js";
import { mm, read, when } from "./units.js";
import { setUpVehicleForm, showVehicleForm } from "./vehicle-edit.js";
import { differenceTable, SIZES, sizesOf } from "./vehicle-sizes.js";

const FILES = { toml: "vehicle.toml", ros2: "wheels.yaml", vda5050: "wheel-definitions.json" };
let shownVersions = [];

export function setUpVehicle() {
  setUpVehicleForm(showOne);
  for (const id of ["compare-old", "compare-new"]) $(id).addEventListener("change", compare);
  $("vehicle-name").addEventListener("change", () => showOne($("vehicle-name").value));
  for (const id of ["export-format", "wheel-width"]) $(id).addEventListener("change", showExport);
  $("export-save").addEventListener("click", () => saveBlob(new Blob([$("export-text").textContent]), FILES[$("export-format").value]));
  $("export-copy").addEventListener("click", () => attempt($("export-copy"), $("export-message"), copy));
}

export async function openVehicle() {
  await showing($("vehicle-message"), async () => {
    const items = await list("/v1/vehicles");
    const before = $("vehicle-name").value;
    $("vehicle-name").replaceChildren(...items.map(({ name }) => el("option", { value: name }, name)));
    $("vehicle-name").hidden = items.length < 2;
    if (!items.length) {
      say($("vehicle-message"), t("There is no vehicle yet."));
      return;
    }
    if (items.some(({ name }) => name === before)) $("vehicle-name").value = before;
    await showOne($("vehicle-name").value);
  });
}

const address = (name, ...more) => ["/v1/vehicles", encodeURIComponent(name), ...more].join("/");

async function showOne(name) {
  await showing($("vehicle-message"), async () => {
    const [vehicle, versions] = await Promise.all([get(address(name)), list(address(name, "versions"))]);
    say($("vehicle-message"));
    $("vehicle-title").textContent = t("{name}, version {version}", vehicle);
    showParameters(vehicle);
    showVehicleForm(vehicle);
    showHistory(versions, Object.keys(vehicle.trucks));
    showComparison(versions);
    await showExport();
  });
}

function showParameters({ trucks, link_length: link }) {
  const names = Object.keys(trucks);
  $("parameters").replaceChildren(
    el("thead", {}, row(el("th", { scope: "col" }, "mm"), ...names.map((name) => el("th", { scope: "col" }, t("truck {truck}", { truck: name }))))),
    el("tbody", {}, Object.entries(SIZES).map(([key, label]) => row(el("th", { scope: "row" }, label), ...names.map((name) => mm(trucks[name][key], key === "wheelbase" ? 2 : 3))))),
  );
  $("vehicle-more").textContent = link ? t("The linkage between the trucks' centres is {length} mm long.", { length: mm(link, 1) }) : "";
}

function showHistory(versions, trucks) {
  const columns = trucks.flatMap((truck) => Object.keys(SIZES).map((key) => [truck, key]));
  $("history-head").replaceChildren(row(...[t("Version"), t("Since"), t("By"), ...columns.map(([truck, key]) => `${truck} ${SIZES[key]} mm`)].map((word) => el("th", { scope: "col" }, word))));
  $("history").replaceChildren(...versions.map(({ version, created, origin, session, made_by: key, trucks: sizes }, index) => {
    const former = versions[index + 1]?.trucks;
    const source = session ? el("a", { href: `#calibrate/${session}` }, origin) : origin;
    return row(`${version}`, when(created), el("td", {}, source, key && t(", key {key}", { key })), ...columns.map(([truck, key]) => {
      const changed = former && former[truck]?.[key] !== sizes[truck]?.[key];
      return el(changed ? "b" : "span", {}, mm(sizes[truck]?.[key], key === "wheelbase" ? 2 : 3));
    }));
  }));
}

function showComparison(versions) {
  shownVersions = versions;
  $("compare").hidden = versions.length < 2;
  for (const [id, index] of [["compare-old", 1], ["compare-new", 0]]) {
    $(id).replaceChildren(...versions.map(({ version, created }, place) => el("option", { value: version, selected: place === index }, `${version}, ${when(created)}`)));
  }
  if (versions.length > 1) compare();
}

function compare() {
  const [old, now] = ["compare-old", "compare-new"].map((id) => shownVersions.find(({ version }) => version === Number($(id).value)));
  const heads = [old, now].map(({ version }) => t("Version {version}", { version }));
  const origins = [old, now].map(({ version, created, origin }) => t("Version {version}: {when}, by {origin}.", { version, when: when(created), origin }));
  $("comparison").replaceChildren(el("caption", {}, origins.join(" ")), ...differenceTable(sizesOf(old), sizesOf(now), heads));
}

async function showExport() {
  const format = $("export-format").value;
  $("wheel-width-row").hidden = format !== "vda5050";
  const width = format === "vda5050" ? `?wheel_width=${read($("wheel-width")) / 1000}` : "";
  try {
    const answer = await call("GET", address($("vehicle-name").value, "exports", format) + width);
    $("export-text").textContent = await answer.text();
    say($("export-message"));
  } catch (problem) {
    $("export-text").textContent = "";
    show($("export-message"), problem);
  }
}

async function copy() {
  if (!navigator.clipboard) throw new Error(t("This browser copies only over https or on this computer; mark the text instead."));
  await navigator.clipboard.writeText($("export-text").textContent);
  say($("export-message"), t("Copied."), "good");
}
