// The language of the page, English or German. English texts stand in HTML and code, and are the keys of german.json.
// Importing this module translates the document.

const LANGUAGES = { de: "Deutsch", en: "English" };

/** That which was chosen on the page, or else the browser's first one that the page has. */
export const language = localStorage.getItem("language")
  ?? navigator.languages.map((tag) => tag.split("-")[0]).find((tag) => tag in LANGUAGES) ?? "en";

/** For numbers and dates: the language with the browser's region. */
export const locale = navigator.languages.find((tag) => tag.split("-")[0] === language) ?? language;

const german = language === "de" ? await (await fetch("/page/german.json")).json() : {};

/** A text in the page's language, with `values` in the place of their {names}. */
export function t(text, values = {}) {
  return (german[text] ?? text).replaceAll(/\{(\w+)\}/g, (_, name) => values[name]);
}

function translateDocument() {
  document.documentElement.lang = language;
  const texts = document.createTreeWalker(document.documentElement, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) texts.currentNode.data = texts.currentNode.data.replace(/\S(.*\S)?/, (text) => t(text));
  for (const name of ["aria-label", "title"]) {
    for (const node of document.querySelectorAll(`[${name}]`)) node.setAttribute(name, t(node.getAttribute(name)));
  }
}

/** Changing the language reloads the page. */
function setUpLanguageButton() {
  const other = language === "de" ? "en" : "de";
  const button = document.getElementById("language");
  Object.assign(button, { lang: other, title: LANGUAGES[other], ariaLabel: LANGUAGES[other], textContent: other.toUpperCase() });
  button.addEventListener("click", () => {
    localStorage.setItem("language", other);
    location.reload();
  });
}

translateDocument();
setUpLanguageButton();
