// The light or the dark theme: that of the system until the user chooses the other. Runs before the first paint.
"use strict";
(() => {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const now = () => root.dataset.theme || (system.matches ? "dark" : "light");
  const notify = () => document.dispatchEvent(new CustomEvent("theme", { detail: now() }));
  const chosen = localStorage.getItem("theme");
  if (chosen) root.dataset.theme = chosen;
  system.addEventListener("change", notify);
  addEventListener("DOMContentLoaded", () => {
    document.getElementById("theme").addEventListener("click", () => {
      const other = now() === "dark" ? "light" : "dark";
      if (other === (system.matches ? "dark" : "light")) {
        delete root.dataset.theme;
        localStorage.removeItem("theme");
      } else {
        root.dataset.theme = other;
        localStorage.setItem("theme", other);
      }
      notify();
    });
  });
})();
