// Diagnoses: jobs with their progress, what they found, and their report.

import { call, get, post } from "./api.js";
import { $, actionButton, announce, el, pages, showing } from "./dom.js";
import { componentName, effectName } from "./effect-words.js";
import { language, t } from "./language.js";
import { showReport } from "./report-dialog.js";
import { on } from "./stream.js";
import { attempts, number, recordingsCount, when } from "./units.js";

export const JOB_STATES = { queued: t("queued"), running: t("running"), done: t("done"), failed: t("failed"), cancelled: t("cancelled") };
export const VERDICTS = { agreement: t("agreement"), mismatch: t("mismatch"), insufficient: t("insufficient") };

export function setUpDiagnoses() {
  on("job", (job) => {
    const item = $("jobs").querySelector(`[data-job="${job.id}"]`);
    if (item) item.replaceWith(jobItem(job));
    if (job.says) announce(job.says);
  });
  on("link", ({ now }) => now === "live" && !$("recordings").hidden && listJobs());
}

export async function listJobs() {
  await showing($("jobs-message"), () => pages("/v1/diagnoses", 10, $("jobs"), jobItem, $("no-jobs"), $("more-jobs")));
}

function jobItem(job) {
  const going = job.state === "queued" || job.state === "running";
  return el("li", { "data-job": job.id, "data-testid": `job-${job.id}`, "data-state": job.state },
    el("p", {},
      el("span", { class: `chip ${job.verdict ?? job.state}` }, VERDICTS[job.verdict] ?? JOB_STATES[job.state]),
      el("span", { class: "soft" }, ` ${when(job.created)}, ${recordingsCount(job.recordings.length)}${attempts(job)}`)),
    going ? el("label", { class: "progress" }, el("progress", { value: job.progress, max: 1 }), ` ${job.doing || JOB_STATES[job.state]}`) : null,
    job.verdict === "mismatch" && language !== "en" ? named(job) : null,
    job.says ? el("p", { class: "says", lang: "en" }, job.says) : null,
    job.error ? el("p", { class: "message", "data-kind": "wrong" }, job.error) : null,
    el("div", { class: "buttons" },
      job.state === "done" ? actionButton(t("Report"), $("jobs-message"), (button) => open(job, button)) : null,
      going ? actionButton(t("Cancel"), $("jobs-message"), () => post(`/v1/diagnoses/${job.id}/cancel`)) : null));
}

/** What a diagnosis has found, by names: its sentence is English in any language. */
function named(job) {
  const names = el("p", { class: "found" });
  get(`/v1/diagnoses/${job.id}/result`).then(({ findings }) => {
    names.textContent = findings.map(({ effect, component, probability }) =>
      `${effectName(effect)}, ${componentName(component)} (${number(100 * probability)} %)`).join("; ");
  }).catch(({ message }) => { names.textContent = message; });
  return names;
}

async function open(job, button) {
  showReport(await (await call("GET", `/v1/diagnoses/${job.id}/report`)).text(), "diagnosis.html", button);
}
