// Documents of the service (the plot, the report) shown inside the page although its policy forbids inline styles:
// their style sheets and style attributes are handed over through the CSSOM. Nothing in them can run.

/** Parse an SVG into an element of this page. */
export function drawing(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  const sheet = parsed.querySelector("style")?.textContent ?? "";
  const node = document.importNode(parsed.documentElement, true);
  for (const rule of rules(sheet)) {
    const styled = rule.selectorText === "*" ? [node, ...node.querySelectorAll("*")] : node.querySelectorAll(rule.selectorText);
    for (const one of styled) one.style.cssText += rule.style.cssText;
  }
  handOver(node, parsed.documentElement);
  return node;
}

/** Show an HTML document in a frame of the same origin in which no script can run. */
export function showIn(frame, text) {
  const parsed = new DOMParser().parseFromString(text, "text/html");
  const inside = frame.contentDocument;
  const sheet = new frame.contentWindow.CSSStyleSheet();
  sheet.replaceSync([...parsed.querySelectorAll("style")].map((one) => one.textContent).join("\n"));
  inside.adoptedStyleSheets = [sheet];
  const body = inside.importNode(parsed.body, true);
  inside.body.replaceWith(body);
  handOver(body, parsed.body);
  inside.documentElement.lang = parsed.documentElement.lang;
}

function rules(text) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  return [...sheet.cssRules].filter((rule) => rule.selectorText);
}

/** Set the style attributes of `from` on its copy `to`, the way the policy allows. */
function handOver(to, from) {
  const copies = [to, ...to.querySelectorAll("*")];
  [from, ...from.querySelectorAll("*")].forEach((original, index) => {
    const text = original.getAttribute("style");
    if (!text) return;
    copies[index].removeAttribute("style");
    copies[index].style.cssText += text;
  });
}
