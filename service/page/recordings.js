// Recordings: list, upload by choosing or dropping, download, delete; choose some to diagnose.

import { call, get, post, remove, save } from "./api.js";
import { $, actionButton, attempt, el, pages, row, showing } from "./dom.js";
import { listJobs } from "./diagnoses.js";
import { t } from "./language.js";
import { showLearned } from "./learned.js";
import { bytes, lasting, recordingsCount, when } from "./units.js";
import { setUpUpload } from "./upload.js";

const chosen = new Set();

export function setUpRecordings() {
  setUpUpload("", upload, listRecordings);
  $("diagnose").addEventListener("click", () => attempt($("diagnose"), $("recordings-message"), async () => {
    await post("/v1/diagnoses", { recordings: [...chosen] });
    chosen.clear();
    await Promise.all([listRecordings(), listJobs()]);
  }));
}

export async function openRecordings() {
  await Promise.all([listRecordings(), listJobs()]);
}

async function upload(file) {
  const name = encodeURIComponent(file.name.replace(/\.zip$/i, ""));
  await call("POST", `/v1/recordings?name=${name}`, { body: file, type: "application/zip" });
  return t("{name} is stored.", file);
}

async function listRecordings() {
  await showing($("recordings-message"), () => pages("/v1/recordings", 20, $("recording-list"), recordingRow, $("no-recordings"), $("more-recordings")));
  showChosen();
}

function recordingRow(recording) {
  const { id, name } = recording;
  const box = el("input", { type: "checkbox", "aria-label": t("Choose {name}", { name }), "data-testid": `choose-${id}` });
  box.checked = chosen.has(id);
  box.addEventListener("change", () => {
    if (box.checked) chosen.add(id);
    else chosen.delete(id);
    showChosen();
  });
  return row(
    box, el("b", { class: "name" }, name), el("span", { class: "name" }, recording.vehicle), lasting(recording.seconds), counted(recording.laps, t("lap"), t("laps")), counted(recording.poses, t("fix"), t("fixes")),
    bytes(recording.size), when(recording.created),
    el("span", { class: "buttons" },
      action(t("Learned"), name, () => showRecordingLearned(id, name)),
      action(t("Download"), name, () => save(`/v1/recordings/${id}/download`, `${name}.zip`)),
      erase(id, name)),
  );
}

/** Show what the filter has learned by the end of a recording. */
async function showRecordingLearned(id, name) {
  const path = `/v1/recordings/${id}/learned`;
  const refresh = async () => showLearned($("learned-recording"), $("recording-learned-message"), await get(path), path, refresh);
  await refresh();
  $("recording-learned-title").textContent = t("Learned in {name}", { name });
  $("recording-learned").hidden = false;
}

const counted = (count, one, several) => el("td", { "data-word": count === 1 ? one : several }, String(count));

const action = (word, name, work) => actionButton(word, $("recordings-message"), work, { "aria-label": `${word} ${name}` });

/** Deleting wants a second click. */
function erase(id, name) {
  const button = el("button", { type: "button", class: "quiet small", "aria-label": t("Delete {name}", { name }), "data-testid": `delete-${id}` }, t("Delete"));
  button.addEventListener("blur", () => (button.textContent = t("Delete")));
  button.addEventListener("click", () => {
    if (button.textContent === t("Delete")) {
      button.textContent = t("Really?");
      return;
    }
    attempt(button, $("recordings-message"), async () => {
      await remove(`/v1/recordings/${id}`);
      chosen.delete(id);
      await listRecordings();
    });
  });
  return button;
}

function showChosen() {
  const count = chosen.size;
  $("diagnose").disabled = count === 0;
  $("diagnose").textContent = count ? t("Diagnose {recordings}", { recordings: recordingsCount(count) }) : t("Diagnose");
}
