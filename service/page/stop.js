// The STOP button, also S, or Escape twice within a second.

import { post } from "./api.js";
import { $ } from "./dom.js";

const TWICE = 1000; // [ms]
let escaped = -Infinity;
let hide = 0;

export function setUpStop() {
  $("stop").addEventListener("click", stop);
  addEventListener("keydown", (event) => {
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Escape") {
      if (performance.now() - escaped < TWICE) stop();
      escaped = performance.now();
    } else if (event.key.toLowerCase() === "s" && !writing(event.target)) stop();
  }, true);
}

async function stop() {
  tell("Stopping …", "");
  try {
    await post("/v1/robot/stop");
    tell("Stop sent: the robot stops.", "good");
    hide = setTimeout(() => ($("stop-message").hidden = true), 8000);
  } catch (problem) {
    tell(`The robot was NOT stopped from here: ${problem.message} Use the switch on the robot.`, "wrong");
  }
}

function tell(sentence, kind) {
  clearTimeout(hide);
  $("stop-message").hidden = false;
  $("stop-message").textContent = sentence;
  $("stop-message").dataset.kind = kind;
}

const writing = (target) => target.matches?.("input:not([type=radio],[type=checkbox]), textarea, select");
