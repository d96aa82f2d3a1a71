// Recordings: list, upload by choosing or dropping, download, delete; choose some to diagnose.

import { call, get, post, remove, save } from "./api.js";
import { $, attempt, el, pages, row, say, show } from "./dom.js";
import { listJobs } from "./diagnoses.js";
import { t } from "./language.js";
import { showLearned } from "./learned.js";
import { bytes, lasting, recordingsCount, when } from "./units.js";

const chosen = new Set();

export function setUpRecordings() {
  $("upload").addEventListener("change", () => {
    upload([...$("upload").files]);
    $("upload").value = "";
  });
  for (const kind of ["dragover", "dragleave", "drop"]) {
    $("drop").addEventListener(kind, (event) => {
      event.preventDefault();
      $("drop").classList.toggle("over", kind === "dragover");
      if (kind === "drop") upload([...event.dataTransfer.files]);
    });
  }
  $("diagnose").addEventListener("click", () => attempt($("diagnose"), $("recordings-message"), async () => {
    await post("/v1/diagnoses", { recordings: [...chosen] });
    chosen.clear();
    await Promise.all([listRecordings(), listJobs()]);
  }));
}

export async function openRecordings() {
  await Promise.all([listRecordings(), listJobs()]);
}

async function upload(files) {
  for (const file of files) {
    $("upload-progress").hidden = false;
    say($("upload-message"), t("Uploading {name} …", file));
    try {
      const name = encodeURIComponent(file.name.replace(/\.zip$/i, ""));
      await call("POST", `/v1/recordings?name=${name}`, { body: file, type: "application/zip" });
      say($("upload-message"), t("{name} is stored.", file), "good");
    } catch (problem) {
      say($("upload-message"), `${file.name}: ${problem.message}`, "wrong");
      return;
    } finally {
      $("upload-progress").hidden = true;
      await listRecordings();
    }
  }
}

async function listRecordings() {
  try {
    await pages(
      (after) => get(`/v1/recordings?limit=20${after ? `&after=${encodeURIComponent(after)}` : ""}`),
      $("recording-list"), recordingRow, $("no-recordings"), $("more-recordings"),
    );
  } catch (problem) {
    show($("recordings-message"), problem);
  }
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
    box, el("b", {}, name), recording.vehicle, lasting(recording.seconds), counted(recording.laps, t("lap"), t("laps")), counted(recording.poses, t("fix"), t("fixes")),
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

function action(word, name, work) {
  const button = el("button", { type: "button", class: "quiet small", "aria-label": `${word} ${name}` }, word);
  button.addEventListener("click", () => attempt(button, $("recordings-message"), work));
  return button;
}

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
