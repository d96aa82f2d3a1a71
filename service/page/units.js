// SI on the wire; millimetres and degrees on the screen.

import { locale, t } from "./language.js";

const UNKNOWN = "–";
const DEGREE = 180 / Math.PI;

export const mm = (metres, digits = 0) => number(metres == null ? null : 1000 * metres, digits);
export const deg = (radians, digits = 2) => number(radians == null ? null : DEGREE * radians, digits);
export const metres = (millimetres) => Number((millimetres / 1000).toPrecision(12));
export const radians = (degrees) => degrees / DEGREE;

/** A number in the page's language; `signDisplay` as of Intl.NumberFormat. */
export function number(value, digits = 0, signDisplay = "negative") {
  if (value == null || !Number.isFinite(value)) return UNKNOWN;
  return format(digits, signDisplay).format(value).replace("-", "−");
}

const formats = new Map(); // an Intl.NumberFormat is slow to make

function format(digits, signDisplay) {
  const key = `${digits} ${signDisplay}`;
  if (!formats.has(key)) formats.set(key, new Intl.NumberFormat(locale, { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false, signDisplay }));
  return formats.get(key);
}

/** Millimetres with as many digits as their size deserves. */
export function size(length) {
  const value = 1000 * length;
  return `${number(value, Math.abs(value) >= 100 ? 0 : 1)} mm`;
}

const SHORT = new Intl.DateTimeFormat(locale, { dateStyle: "medium", timeStyle: "short" });
export const when = (seconds) => SHORT.format(new Date(1000 * seconds));

export function lasting(seconds) {
  const whole = Math.round(seconds);
  return whole < 60 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

export function bytes(count) {
  if (count < 1e3) return `${count} B`;
  return count < 1e6 ? `${number(count / 1e3)} kB` : `${number(count / 1e6, 1)} MB`;
}

export const recordingsCount = (count) => (count === 1 ? t("1 recording") : t("{count} recordings", { count }));

/** How often a job was attempted, where more than once. */
export const attempts = ({ attempts: count }) => (count > 1 ? t(", attempt {count}", { count }) : "");

/** The largest of 1, 2 or 5 times a power of ten that is not more than `most`. */
export function niceStep(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * ([5, 2].find((factor) => factor * power <= most) ?? 1);
}

/** -pi to pi. */
export const wrap = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

const SEPARATOR = new Intl.NumberFormat(locale).formatToParts(0.5).find(({ type }) => type === "decimal").value;

/** A number as it is typed into a field. A field of the type "number" has the separator of the browser's own language, not the page's. */
export const typed = (value) => String(value).replace(".", SEPARATOR);

/** The number that is typed into a field, with the page's separator or a point; null where it is empty, NaN where it is none. */
export function read(field) {
  const text = field.value.trim();
  return text === "" ? null : Number(text.replace(SEPARATOR, ".").replace("−", "-"));
}
