// Documents of the service (the plot, the report) shown inside the page although its policy forbids inline styles:
// their style sheets and style attributes are taken out of the text and handed over through the CSSOM.
// Nothing in them can run.

/** Parse an SVG into an element of this page. */
export function drawing(text) {
  const { sheet, bare } = undressed(text);
  const node = document.importNode(new DOMParser().parseFromString(bare, "image/svg+xml").documentElement, true);
  const rules = new CSSStyleSheet();
  rules.replaceSync(sheet);
  for (const { selectorText, style } of rules.cssRules) {
    const all = [node, ...node.querySelectorAll("*")].filter((each) => each.style); // metadata have none
    for (const one of all.filter((each) => each.matches(selectorText))) one.style.cssText += style.cssText;
  }
  dress(node);
  return node;
}

/** Show an HTML document in a frame of the same origin in which no script can run. */
export function showIn(frame, text) {
  const { sheet, bare } = undressed(text);
  const parsed = new DOMParser().parseFromString(bare, "text/html");
  const inside = frame.contentDocument;
  const rules = new frame.contentWindow.CSSStyleSheet();
  rules.replaceSync(sheet);
  inside.adoptedStyleSheets = [rules];
  const body = inside.importNode(parsed.body, true);
  inside.body.replaceWith(body);
  dress(body);
  inside.documentElement.lang = parsed.documentElement.lang;
}

function undressed(text) {
  const sheets = [];
  const bare = text
    .replace(/<style[^>]*>([\s\S]*?)<\/style>/gi, (_, sheet) => {
      sheets.push(sheet);
      return "";
    })
    .replace(/\sstyle=/gi, " data-style=");
  return { sheet: sheets.join("\n"), bare };
}

function dress(root) {
  for (const node of root.querySelectorAll("[data-style]")) {
    node.style.cssText += node.dataset.style;
    node.removeAttribute("data-style");
  }
}
