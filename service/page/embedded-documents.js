// Documents of the service (plot, report) shown inside the page, whose content security policy forbids inline styles:
// style sheets and style attributes are taken out of the text and applied through the CSSOM. No script in them runs.

/** Parse an SVG into an element of this page. */
export function drawing(text) {
  const { sheet, bare } = separated(text);
  const node = document.importNode(new DOMParser().parseFromString(bare, "image/svg+xml").documentElement, true);
  const rules = new CSSStyleSheet();
  rules.replaceSync(sheet);
  for (const { selectorText, style } of rules.cssRules) {
    const all = [node, ...node.querySelectorAll("*")].filter((each) => each.style); // metadata have none
    for (const element of all.filter((each) => each.matches(selectorText))) element.style.cssText += style.cssText;
  }
  applyStyles(node);
  return node;
}

/** Show an HTML document in a frame of the same origin in which no script can run. */
export function showIn(frame, text) {
  const { sheet, bare } = separated(text);
  const parsed = new DOMParser().parseFromString(bare, "text/html");
  const inside = frame.contentDocument;
  const rules = new frame.contentWindow.CSSStyleSheet();
  rules.replaceSync(sheet);
  inside.adoptedStyleSheets = [rules];
  const body = inside.importNode(parsed.body, true);
  inside.body.replaceWith(body);
  applyStyles(body);
  inside.documentElement.lang = parsed.documentElement.lang;
}

function separated(text) {
  const sheets = [];
  const bare = text
    .replace(/<style[^>]*>([\s\S]*?)<\/style>/gi, (_, sheet) => {
      sheets.push(sheet);
      return "";
    })
    .replace(/\sstyle=/gi, " data-style=");
  return { sheet: sheets.join("\n"), bare };
}

function applyStyles(root) {
  for (const node of root.querySelectorAll("[data-style]")) {
    node.style.cssText += node.dataset.style;
    node.removeAttribute("data-style");
  }
}
