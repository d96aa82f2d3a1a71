// The dialog that asks for the API key when the service needs it.

import { key, useKey } from "./api.js";
import { $, say } from "./dom.js";

export function setUpKeyDialog() {
  document.addEventListener("key-needed", ({ detail }) => {
    if ($("key-dialog").open) return;
    say($("key-message"), key() ? detail : "", "wrong");
    $("key-dialog").show();
    $("key").focus();
  });
  $("key-form").addEventListener("submit", () => {
    useKey($("key").value.trim());
    $("key").value = "";
  });
}
