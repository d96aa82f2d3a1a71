"""The frame of a report: head, verdict, explanation, and a style sheet for light, dark, phone and paper."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

# The figures of the page have the colours of `:root` by their names: `omnimate.figures.page.VARIABLES`.
# The colours of the path go from grey to dark red through yellow, in order of lightness, so that people who
# see no red and green still see the order.
CSS = """
:root{--ink:#1b1f24;--soft:#57606a;--paper:#fff;--card:#f6f8fa;--line:#d0d7de;--accent:#0b5cad;
--good:#1a7f37;
--before:#b35900;--after:#0b5cad;--band:#f2cc6055;--c0:#8c959f;--c1:#d9b44a;--c2:#e08e2b;--c3:#cf5b24;
--c4:#a82a26;--c5:#6b0f1a}
@media (prefers-color-scheme:dark){:root{--ink:#e6edf3;--soft:#9da7b1;--paper:#0d1117;--card:#161b22;
--line:#30363d;
--accent:#6cb6ff;--good:#57ab5a;--before:#f0a04b;--after:#6cb6ff;--band:#bb800933;--c0:#57606a;--c1:#8a6d1f;
--c2:#c77f1b;--c3:#e8702a;--c4:#ff7b72;--c5:#ffc1ba}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1120px;padding:1.2rem;background:var(--paper);color:var(--ink);
font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
h1{font-size:1.5rem;line-height:1.3;margin:.2rem 0 .6rem}h2{font-size:1.15rem;margin:2rem 0 .6rem}
h3{font-size:1rem;margin:1rem 0 .4rem;color:var(--soft)}
p{max-width:72ch}.verdict{display:inline-block;padding:.1rem .7rem;border-radius:1rem;font-weight:600;
border:1.5px solid currentColor;font-size:.9rem}
.mismatch{color:var(--before)}.agreement{color:var(--good)}.insufficient{color:var(--soft)}
.lead{font-size:1.1rem}.soft{color:var(--soft);font-size:.9rem}
.card{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:1rem 1.2rem;
margin:.8rem 0;
break-inside:avoid}.card h3{margin-top:0;color:var(--ink);font-size:1.05rem}
.bar{display:flex;align-items:center;gap:.6rem;margin:.25rem 0}.bar span:first-child{min-width:15rem}
.bar i{flex:1;height:.6rem;background:var(--line);border-radius:.3rem;overflow:hidden;max-width:22rem}
.bar i b{display:block;height:100%;background:var(--accent)}
table{border-collapse:collapse;margin:.5rem 0;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .9rem .25rem 0;text-align:right;border-bottom:1px solid var(--line)}
th:first-child,td:first-child{text-align:left}th{font-weight:600;color:var(--soft);font-size:.9rem}
.scroll{overflow-x:auto}.pair,.grid2{display:grid;grid-template-columns:1fr 1fr;gap:1rem}
.card figure{max-width:36rem}
figure{margin:0;break-inside:avoid}figcaption{color:var(--soft);font-size:.85rem;text-align:center}
svg{width:100%;height:auto;display:block;stroke-linejoin:round}
.key{display:flex;gap:.4rem;align-items:center;flex-wrap:wrap;color:var(--soft);font-size:.85rem;
margin:.3rem 0}
.key i{display:inline-block;width:1.6rem;height:.45rem;border-radius:.2rem}
@media (max-width:640px){.pair,.grid2{grid-template-columns:1fr}.bar span:first-child{min-width:9rem}
body{padding:.8rem}}
@media print{body{max-width:none;font-size:11pt;padding:0}.card{background:none}}
"""


class Head(NamedTuple):
    """Head of a report, as plain text."""

    kind: str  # kind of report: the title is `<kind> of <name>`
    name: str  # name of the robot
    verdict: str  # the verdict in a word
    colour: str  # class of the verdict's colour: mismatch, agreement or insufficient
    lead: str  # the result in a sentence
    note: str  # source of the data


def html_report(head: Head, sections: Iterable[str], how_to_read: str) -> str:
    """Return a report of sections in HTML, and of plain text on how to read it, as one page of its own."""
    kind, name, verdict, colour, lead, note = (escape(text) for text in head)
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{kind} of {name}</title><style>{CSS}</style></head><body>"
        f"<header><span class='verdict {colour}'>{verdict}</span>"
        f"<h1>{name}</h1><p class=lead>{lead}</p><p class=soft>{note}</p></header>"
        f"{''.join(sections)}<h2>How to read this</h2><p class=soft>{escape(how_to_read)}</p></body></html>\n"
    )
