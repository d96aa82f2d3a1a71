// Diagnoses: jobs with their progress, what they found, and their report.

import { call, get, post, saveBlob } from "./api.js";
import { $, announce, attempt, el, pages, show } from "./dom.js";
import { showIn } from "./embedded-documents.js";
import { on } from "./stream.js";
import { when } from "./units.js";

let report = "";
let opener = null;

export function setUpDiagnoses() {
  on("job", (job) => {
    const item = $("jobs").querySelector(`[data-job="${job.id}"]`);
    if (item) item.replaceWith(jobItem(job));
    if (job.says) announce(job.says);
  });
  on("link", ({ now }) => now === "live" && !$("recordings").hidden && listJobs());
  $("report-close").addEventListener("click", close);
  $("report-save").addEventListener("click", () => saveBlob(new Blob([report], { type: "text/html" }), "diagnosis.html"));
  $("report-dialog").addEventListener("keydown", (event) => event.key === "Escape" && close());
}

export async function listJobs() {
  try {
    await pages(
      (after) => get(`/v1/diagnoses?limit=10${after ? `&after=${encodeURIComponent(after)}` : ""}`),
      $("jobs"), jobItem, $("no-jobs"), $("more-jobs"),
    );
  } catch (problem) {
    show($("jobs-message"), problem);
  }
}

function jobItem(job) {
  const going = job.state === "queued" || job.state === "running";
  const count = job.recordings.length;
  return el("li", { "data-job": job.id, "data-testid": `job-${job.id}`, "data-state": job.state },
    el("p", {},
      el("span", { class: `chip ${job.verdict ?? job.state}` }, job.verdict ?? job.state),
      el("span", { class: "soft" }, ` ${when(job.created)}, ${count} recording${count > 1 ? "s" : ""}${job.attempts > 1 ? `, attempt ${job.attempts}` : ""}`)),
    going ? el("label", { class: "progress" }, el("progress", { value: job.progress, max: 1 }), ` ${job.doing || job.state}`) : null,
    job.says ? el("p", { class: "says" }, job.says) : null,
    job.error ? el("p", { class: "message", "data-kind": "wrong" }, job.error) : null,
    el("div", { class: "buttons" },
      job.state === "done" ? action("Report", (button) => open(job, button)) : null,
      going ? action("Cancel", () => post(`/v1/diagnoses/${job.id}/cancel`)) : null));
}

function action(word, work) {
  const button = el("button", { type: "button", class: "quiet small" }, word);
  button.addEventListener("click", () => attempt(button, $("jobs-message"), () => work(button)));
  return button;
}

/** The report in a frame in which nothing can run. */
async function open(job, button) {
  report = await (await call("GET", `/v1/diagnoses/${job.id}/report`)).text();
  opener = button;
  $("report-dialog").show();
  showIn($("report"), report);
  $("report-close").focus();
}

function close() {
  $("report-dialog").close();
  opener?.focus();
}
