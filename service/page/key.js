// The field for the API key, shown when the service asks for one.

import { key, useKey } from "./api.js";
import { $, say } from "./dom.js";

export function setUpKey() {
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
