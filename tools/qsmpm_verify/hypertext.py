"""Elements of the page that `report` writes: style, text, tables, commands and drawings as HTML."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

STYLE = """
body { font: 15px/1.45 sans-serif; color: #222; max-width: 1080px; margin: 2em auto; padding: 0 1em; overflow-wrap: anywhere; }
h1, h2 { line-height: 1.2; } h2 { border-bottom: 1px solid #ccc; margin-top: 2em; }
table { border-collapse: collapse; font-size: 13px; margin: .8em 0; }
th, td { padding: 2px 9px; border-bottom: 1px solid #e3e3e3; text-align: left; }
th { background: #f4f4f4; } td.n { text-align: right; white-space: nowrap; }
figure { margin: 1em 0; } figure svg, figure img { max-width: 100%; height: auto; }
.wide { overflow-x: auto; } .wide table { overflow-wrap: normal; } .wide svg { max-width: none; width: 100%; min-width: 640px; }
#tip { position: fixed; display: none; max-width: 21em; padding: 3px 8px; border-radius: 4px; background: #222; color: #fff;
  font-size: 12.5px; pointer-events: none; z-index: 9; } [data-tip] { cursor: crosshair; }
figcaption, .command { font-size: 12.5px; color: #555; } code { background: #f4f4f4; padding: 1px 4px; }
@media print { body { max-width: none; font-size: 10pt; margin: 0; } #tip, nav { display: none; } figure, tr { break-inside: avoid; }
  h2, h3, summary { break-after: avoid; } .wide { overflow: visible; } .wide svg { min-width: 0; } table { font-size: 8pt; } a { color: inherit; }
  figure { margin: 2mm 0; } figure img, figure svg { max-height: 95mm; width: auto; } p { margin: 1.5mm 0; } }
.missed { background: #f7c6c6; } .best { background: #e4f5e8; } details { margin: .6em 0; } summary { cursor: pointer; }
"""

# Values of the nearest mark in reach of the pointer; folded parts are printed too.
REACH = 14
SCRIPT = """
const tip = document.createElement("div"); tip.id = "tip"; document.body.append(tip);
const marks = new Map();
document.querySelectorAll("svg").forEach(svg => marks.set(svg, [...svg.querySelectorAll("[data-tip]")]));
function away(mark, x, y) {
  const r = mark.getBoundingClientRect();
  return Math.hypot(Math.max(r.left - x, 0, x - r.right), Math.max(r.top - y, 0, y - r.bottom))
    + 1e-3 * Math.hypot((r.left + r.right) / 2 - x, (r.top + r.bottom) / 2 - y);
}
function show(event) {
  const svg = event.target.closest ? event.target.closest("svg") : null;
  let best = null, least = REACH;
  for (const mark of (svg && marks.get(svg)) || []) {
    const far = away(mark, event.clientX, event.clientY);
    if (far < least) { best = mark; least = far; }
  }
  tip.style.display = best ? "block" : "none";
  if (!best) return;
  tip.textContent = best.dataset.tip;
  tip.style.left = Math.max(4, Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 4)) + "px";
  tip.style.top = Math.max(4, Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 4)) + "px";
}
addEventListener("pointermove", show); addEventListener("pointerdown", show);
addEventListener("scroll", () => { tip.style.display = "none"; });
let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")]; folded.forEach(d => { d.open = true; });
});
addEventListener("afterprint", () => { folded.forEach(d => { d.open = false; }); });
""".replace("REACH", str(REACH))

NUMBER = re.compile(r"(<= |>= )?-?\d[\d.]*(e[-+]?\d+)?$")


def text(value: object) -> str:
    """Text with the special characters of HTML escaped."""
    return html.escape(str(value))


def table(header: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """A table; every row has a class and its cells."""
    head = "".join(f"<th>{text(h)}</th>" for h in header)
    body = "".join(
        f"<tr{f' class={kind}' if kind else ''}>"
        + "".join(f"<td{' class=n' if NUMBER.match(cell) else ''}>{text(cell)}</td>" for cell in cells)
        + "</tr>\n"
        for kind, cells in rows
    )
    return f"<div class=wide><table><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table></div>\n"


def command(line: str) -> str:
    """The command that reproduces a result."""
    return f'<p class="command">Command: <code>{text(line)}</code></p>\n'


def inline_svg(path: Path) -> str:
    """A drawing as part of the page: without its head, with unique names of its parts."""
    drawing = path.read_text(encoding="utf-8")
    drawing = drawing[drawing.index("<svg") :]
    drawing = re.sub(r"<metadata>.*?</metadata>", "", drawing, flags=re.DOTALL)
    own = re.sub(r"\W", "_", path.stem)
    drawing = re.sub(r'\bid="([^"]+)"', rf'id="{own}_\1"', drawing)
    drawing = re.sub(r'(xlink:href="#|url\(#)', rf"\1{own}_", drawing)
    return drawing


def _group(drawing: str, name: str) -> slice | None:
    """Position of a named group in a drawing, with its parts."""
    hit = re.search(rf'<g id="(\w*_)?{re.escape(name)}">', drawing)
    if not hit:
        return None
    deep = 0
    for tag in re.finditer(r"<(/?)g\b", drawing[hit.start() :]):
        deep += -1 if tag[1] else 1
        if deep == 0:
            return slice(hit.start(), hit.start() + tag.end())
    return None


def with_tips(drawing: str, tips: Mapping[str, Sequence[str]]) -> str:
    """A drawing with tooltips: texts by the name of a group, one for each of its marks or one for the whole group."""
    for name, texts in tips.items():
        place = _group(drawing, name)
        if place is None:
            continue
        group = drawing[place]
        if group.count("<use") == len(texts) and texts:
            left = iter(texts)
            group = re.sub("<use", lambda _: f'<use data-tip="{text(next(left))}"', group)
        elif len(texts) == 1:
            group = group.replace(">", f' data-tip="{text(texts[0])}">', 1)
        drawing = drawing[: place.start] + group + drawing[place.stop :]
    return drawing


def figure(content: str, caption: str) -> str:
    """A figure with its caption."""
    return f"<figure><div class=wide>{content}</div><figcaption>{text(caption)}</figcaption></figure>\n"
