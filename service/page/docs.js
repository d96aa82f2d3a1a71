// The description of the REST interface in /openapi.json, call by call.

import { get } from "./api.js";
import { $, el, row, show } from "./dom.js";
import { t } from "./language.js";

const METHODS = ["get", "post", "put", "delete"];
const DEEPEST = 5; // levels of a schema that are shown
let schemas = {};

try {
  const described = await get("/openapi.json");
  schemas = described.components?.schemas ?? {};
  $("about").textContent = described.info.description;
  $("calls").append(...sections(described.paths));
} catch (problem) {
  show($("message"), problem);
}

function sections(paths) {
  const calls = Object.entries(paths).flatMap(([path, item]) =>
    METHODS.filter((method) => item[method]).map((method) => ({ path, method, ...item[method] })));
  const tags = [...new Set(calls.map(({ tags: [tag] = ["others"] }) => tag))];
  return tags.map((tag) => el("section", { class: "card" },
    el("h2", {}, tag),
    calls.filter(({ tags: [callTag] = ["others"] }) => callTag === tag).map(callDetails)));
}

function callDetails({ path, method, description, summary, parameters = [], requestBody, responses }) {
  const answers = Object.entries(responses);
  const problems = answers.filter(([status]) => status >= 400).map(([status, answer]) => `${status} ${answer.description}`);
  return el("details", {},
    el("summary", {}, el("span", { class: `chip ${method}` }, method.toUpperCase()), el("code", {}, ` ${path} `), el("span", { class: "soft" }, description ?? summary)),
    parameters.length ? el("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": t("Parameters") }, el("table", {}, el("tbody", {}, parameters.map(parameterRow)))) : null,
    requestBody ? [el("h3", {}, t("What is sent")), bodies(requestBody.content)] : null,
    el("h3", {}, t("What is answered")),
    answers.filter(([status]) => status < 400).map(([status, answer]) => answerDetails(status, answer)),
    el("p", { class: "soft" }, t("Problems: {problems}.", { problems: problems.join(", ") || t("none") })));
}

function parameterRow({ name, in: where, required, schema, description }) {
  return row(el("code", {}, name), `${where}${required ? "" : `, ${t("optional")}`}`, el("code", {}, shape(schema)), description ?? "");
}

function answerDetails(status, { description, content }) {
  return el("div", {}, el("p", {}, `${status} ${description}`), content ? bodies(content) : null);
}

function bodies(kinds) {
  return Object.entries(kinds).map(([kind, { schema }]) =>
    el("div", {}, el("p", { class: "soft" }, kind), schema ? el("pre", { tabindex: "0" }, shape(schema)) : null));
}

/** A schema as the JSON that it describes. */
function shape(schema = {}, depth = 0) {
  if (schema.$ref) return shape(schemas[schema.$ref.split("/").at(-1)], depth);
  const choices = schema.anyOf ?? schema.oneOf;
  if (choices) return choices.map((choice) => shape(choice, depth)).join(` ${t("or")} `);
  if ("const" in schema) return JSON.stringify(schema.const);
  if (schema.enum) return schema.enum.map((value) => JSON.stringify(value)).join(" | ");
  if (schema.type === "array") return `[${shape(schema.items, depth)}, ...]`;
  if (schema.properties && depth < DEEPEST) return object(schema, depth);
  if (schema.additionalProperties?.$ref) return `{name: ${shape(schema.additionalProperties, depth + 1)}}`;
  return schema.type ?? t("anything");
}

function object({ properties, required = [] }, depth) {
  const inside = "  ".repeat(depth + 1);
  const lines = Object.entries(properties).map(([name, property]) => {
    const notes = [required.includes(name) ? "" : t("optional"), property.description ?? "", "default" in property ? t("default {value}", { value: JSON.stringify(property.default) }) : ""].filter(Boolean);
    return `${inside}${name}: ${shape(property, depth + 1)}${notes.length ? `  // ${notes.join("; ")}` : ""}`;
  });
  return `{\n${lines.join("\n")}\n${"  ".repeat(depth)}}`;
}
