// Uploads of zips that are chosen or dropped.

import { $, say } from "./dom.js";
import { t } from "./language.js";

/** Upload what is chosen or dropped in the elements whose ids have a prefix; `send` uploads a file and returns what to say, `after` follows. */
export function setUpUpload(prefix, send, after = () => {}) {
  const [input, drop, progress, message] = ["upload", "drop", "upload-progress", "upload-message"].map((id) => $(prefix + id));
  const upload = async (files) => {
    for (const file of files) {
      progress.hidden = false;
      say(message, t("Uploading {name} …", file));
      try {
        say(message, await send(file), "good");
      } catch (problem) {
        say(message, `${file.name}: ${problem.message}`, "wrong");
        return;
      } finally {
        progress.hidden = true;
        await after();
      }
    }
  };
  input.addEventListener("change", () => {
    upload([...input.files]);
    input.value = "";
  });
  for (const kind of ["dragover", "dragleave", "drop"]) {
    drop.addEventListener(kind, (event) => {
      event.preventDefault();
      drop.classList.toggle("over", kind === "dragover");
      if (kind === "drop") upload([...event.dataTransfer.files]);
    });
  }
}
