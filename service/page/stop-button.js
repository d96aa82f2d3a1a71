// The STOP button, also S, or Escape twice within a second.

import { post } from "./api.js";
import { $ } from "./dom.js";
import { t } from "./language.js";

const DOUBLE_PRESS = 1000; // [ms]
let escapedAt = -Infinity;
let hide = 0;

export function setUpStopButton() {
  $("stop").addEventListener("click", stop);
  addEventListener("keydown", (event) => {
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Escape") {
      if (performance.now() - escapedAt < DOUBLE_PRESS) stop();
      escapedAt = performance.now();
    } else if (event.key.toLowerCase() === "s" && !isTextField(event.target)) stop();
  }, true);
}

async function stop() {
  showMessage(t("Stopping …"), "");
  try {
    await post("/v1/robot/stop");
    showMessage(t("Stop sent: the robot stops."), "good");
    hide = setTimeout(() => ($("stop-message").hidden = true), 8000);
  } catch (problem) {
    showMessage(t("The robot was NOT stopped from here: {problem} Use the switch on the robot.", { problem: problem.message }), "wrong");
  }
}

function showMessage(sentence, kind) {
  clearTimeout(hide);
  $("stop-message").hidden = false;
  $("stop-message").textContent = sentence;
  $("stop-message").dataset.kind = kind;
}

const isTextField = (target) => target.matches?.("input:not([type=radio],[type=checkbox]), textarea, select");
