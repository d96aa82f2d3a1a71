// Calls of the service. A problem detail becomes a Problem, whose message is the detail.

import { t } from "./language.js";

const STORED = "omnimate-key";

export class Problem extends Error {
  constructor(status, body) {
    super(body.detail || body.title || t("The service answered {status}.", { status }));
    this.status = status;
    this.errors = body.errors ?? [];
  }
}

export const key = () => sessionStorage.getItem(STORED);

export function useKey(text) {
  sessionStorage.setItem(STORED, text);
  document.dispatchEvent(new Event("key-given"));
}

/** The answer to a call; throws a Problem, also where the service cannot be reached. */
export async function call(method, path, { body, type = "application/json", headers = {}, signal } = {}) {
  const allHeaders = { ...headers };
  if (key()) allHeaders.Authorization = `Bearer ${key()}`;
  if (method === "POST") allHeaders["Idempotency-Key"] ??= unique();
  if (body !== undefined) allHeaders["Content-Type"] = type;
  const encoded = body === undefined || type !== "application/json" ? body : JSON.stringify(body);
  const answer = await send(path, { method, headers: allHeaders, body: encoded, signal });
  if (answer.ok) return answer;
  const problem = new Problem(answer.status, await answer.json().catch(() => ({})));
  if (answer.status === 401) document.dispatchEvent(new CustomEvent("key-needed", { detail: problem.message }));
  throw problem;
}

export const get = async (path) => (await call("GET", path)).json();

/** All items of a short list, whether the service answers with a page or with a plain list. */
export async function list(path) {
  const answer = await get(path);
  return answer.items ?? answer;
}

export const post = async (path, body, more = {}) => (await call("POST", path, { body, ...more })).json();

export const remove = (path) => call("DELETE", path);

/** Save the answer to a call as a file. */
export async function save(path, name) {
  saveBlob(await (await call("GET", path)).blob(), name);
}

export function saveBlob(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = Object.assign(document.createElement("a"), { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Send a request, and repeat it once after a network failure; the Idempotency-Key keeps a POST from being carried out twice. */
async function send(path, request) {
  for (const last of [false, true]) {
    try {
      return await fetch(path, { cache: "no-store", ...request });
    } catch (error) {
      if (error.name === "AbortError") throw error;
      if (last) throw new Problem(0, { detail: t("The service cannot be reached; is it running, and this device in its network?") });
      await new Promise((done) => setTimeout(done, 400));
    }
  }
}

function unique() {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
