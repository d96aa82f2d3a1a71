// Making and finding elements, showing messages, and carrying out actions.

import { get } from "./api.js";

export const $ = (id) => document.getElementById(id);

export function el(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

export function svg(name, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);
}

function filled(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value != null) node.setAttribute(key, value);
  }
  node.append(...children.flat(Infinity).filter((child) => child != null));
  return node;
}

export function row(...cells) {
  return el("tr", {}, cells.map((cell) => (cell instanceof Element && /^T[DH]$/.test(cell.tagName) ? cell : el("td", {}, cell))));
}

/** Show a message in a node; kind is "wrong", "good" or "". */
export function say(node, sentence = "", kind = "") {
  node.textContent = sentence;
  node.dataset.kind = kind;
}

/** Announce a change to users of screen readers. */
export function announce(sentence) {
  $("said").textContent = sentence;
}

/** Carry out an action that may fail. Its button is busy meanwhile, and a problem is shown in the node `message`. */
export async function attempt(button, message, work) {
  if (button.getAttribute("aria-busy")) return;
  button.setAttribute("aria-busy", "true");
  say(message);
  for (const field of button.form?.querySelectorAll("[aria-invalid]") ?? []) field.removeAttribute("aria-invalid");
  try {
    await work();
  } catch (problem) {
    show(message, problem, button.form);
  } finally {
    button.removeAttribute("aria-busy");
  }
}

/** Carry out an action when a form is sent; its button and its message have its id with `-send` and `-message`. */
export function onSubmit(id, work) {
  $(id).addEventListener("submit", (event) => {
    event.preventDefault();
    attempt($(`${id}-send`), $(`${id}-message`), work);
  });
}

/** Carry out an action that may fail; a problem is shown in the node `message`. */
export async function showing(message, work) {
  try {
    await work();
  } catch (problem) {
    show(message, problem);
  }
}

/** Show a problem in the node `message`, and focus the field that it names. */
export function show(message, problem, form = null) {
  say(message, problem.message, "wrong");
  const wrong = (problem.errors ?? [])
    .map(({ where }) => [...(form?.querySelectorAll("[data-where]") ?? [])].find((field) => named(where, field.dataset.where)))
    .filter(Boolean);
  for (const field of wrong) field.setAttribute("aria-invalid", "true");
  wrong[0]?.focus();
}

const named = (where, name) => where === name || where.endsWith(`.${name}`);

/** A button that carries out an action, which is called with the button; see `attempt`. */
export function actionButton(word, message, work, attributes = {}) {
  const button = el("button", { type: "button", class: "quiet small", ...attributes }, word);
  button.addEventListener("click", () => attempt(button, message, () => work(button)));
  return button;
}

/** Fill a list that is read in pages of `limit` items from `path`; `more` is its button for the next page. */
export async function pages(path, limit, body, item, none, more) {
  const add = async (after) => {
    const { items, next } = await get(`${path}?limit=${limit}${after ? `&after=${encodeURIComponent(after)}` : ""}`);
    if (!after) body.replaceChildren();
    body.append(...items.map(item));
    none.hidden = body.childElementCount > 0;
    more.hidden = !next;
    more.onclick = () => add(next);
  };
  await add(null);
}

/** A colour of the style sheet, resolved for drawing on a canvas. */
export function colour(name) {
  const probe = $("said");
  probe.style.color = `var(--${name})`;
  return getComputedStyle(probe).color;
}
