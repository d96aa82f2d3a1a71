// The dialog that shows a report in a frame in which nothing can run.

import { saveBlob } from "./api.js";
import { $ } from "./dom.js";
import { showIn } from "./embedded-documents.js";

let report = "";
let name = "";
let opener = null;

export function setUpReportDialog() {
  $("report-close").addEventListener("click", closeReport);
  $("report-save").addEventListener("click", () => saveBlob(new Blob([report], { type: "text/html" }), name));
  $("report-dialog").addEventListener("keydown", (event) => event.key === "Escape" && closeReport());
}

/** Show a report, which can be saved as `file`; the focus goes back to `button` afterwards. */
export function showReport(html, file, button) {
  [report, name, opener] = [html, file, button];
  $("report-dialog").show();
  showIn($("report"), report);
  $("report-close").focus();
}

export function closeReport() {
  if (!$("report-dialog").open) return;
  $("report-dialog").close();
  opener?.focus();
}
