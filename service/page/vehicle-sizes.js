// The sizes of a vehicle, and the table of the difference between two of its versions.

import { el, row } from "./dom.js";
import { t } from "./language.js";
import { mm, number } from "./units.js";

export const SIZES = { wheelbase: t("wheelbase"), wheel_diameter_left: t("left wheel"), wheel_diameter_right: t("right wheel") };

/** All sizes of a version [m]: the table and the key in vehicle.toml, a label, and the value. */
export function sizesOf({ trucks, link_length: link }) {
  const sizes = Object.entries(trucks).flatMap(([truck, values]) =>
    Object.entries(SIZES).map(([key, name]) => ({ table: `truck.${truck}`, key, label: t("truck {truck}, {name}", { truck, name }), value: values[key] })));
  return link == null ? sizes : [...sizes, { table: "linkage", key: "length", label: t("link length"), value: link }];
}

/** The head and body of a table with two versions' sizes; `before` and `after` are lists of sizes, and `heads` their columns' heads. */
export function differenceTable(before, after, heads) {
  const same = (one) => (other) => one.table === other.table && one.key === other.key;
  const all = [...before, ...after.filter((size) => !before.some(same(size)))];
  return [
    el("thead", {}, row(...["mm", ...heads, t("Change"), "%"].map((head) => el("th", { scope: "col" }, head)))),
    el("tbody", {}, all.map((size) => {
      const [old, now] = [before, after].map((sizes) => sizes.find(same(size))?.value);
      return row(el("th", { scope: "row" }, size.label), mm(old, 3), mm(now, 3), signed(1000 * (now - old)), signed(100 * (now / old - 1)));
    })),
  ];
}

const signed = (value) => number(value, 3, "exceptZero");
