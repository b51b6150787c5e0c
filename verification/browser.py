#!/usr/bin/env python3
"""The report in a real browser: no sideways scrolling at three widths, values at the pointer, folded parts printed; and the report of a
run on paper, page by page.

    verification/browser.py [--install] [REPORT.html] [--shots FOLDER]

Without a file a small report is made. `--shots` keeps a picture of the page at each width. Closes with N passed, M failed;
where there is no chromium (Debian package chromium) it is skipped; `--install` installs one first (tools/setup --long). Pages are looked at
by poppler-utils: without them, or without a program that makes a run, that part is skipped.
"""

from __future__ import annotations

import argparse
import html
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

TOP = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.places import PROGRAM  # noqa: E402
from qsmpm_verify.tests import test_document, test_run_report  # noqa: E402

WIDTHS = (360, 800, 1400)
PARTS = ("Phases", "Factor of safety", "Warnings", "Curves", "Pictures", "Deck", "Run")
"""Of the report of a run, in order."""
INK, EMPTY, EDGE = 200, 0.002, 0.02
"""Grey below which a dot is ink, share of dots that no page may be below, and share of the paper at its edges where none may be."""
# The page in a frame of each width; what it is like is written into the page around it.
PROBE = """<!doctype html><meta charset=utf-8><body><script>
const told = {};
async function look(width) {
  const frame = document.createElement("iframe");
  frame.width = width; frame.height = 900; frame.src = "report.html";
  const ready = new Promise(go => { frame.onload = go; });
  document.body.append(frame);
  await ready;
  const page = frame.contentDocument, view = frame.contentWindow, root = page.documentElement;
  const facts = { scroll: root.scrollWidth, inside: root.clientWidth, tips: 0, shown: 0, wrong: [] };
  for (const mark of page.querySelectorAll("[data-tip]")) {
    facts.tips += 1;
    if (facts.tips % 7 != 1) continue;
    mark.scrollIntoView({ block: "center", inline: "center" });
    const box = mark.getBoundingClientRect();
    const event = new view.PointerEvent("pointermove", { bubbles: true, clientX: (box.left + box.right) / 2, clientY: (box.top + box.bottom) / 2 });
    mark.dispatchEvent(event);
    const tip = page.getElementById("tip"), at = tip.getBoundingClientRect();
    const there = tip.style.display == "block" && at.left >= 0 && at.right <= view.innerWidth;
    const same = [...page.querySelectorAll("[data-tip]")].some(m => m.dataset.tip == tip.textContent
      && m.getBoundingClientRect().left < box.right + 15 && m.getBoundingClientRect().right > box.left - 15);
    if (there && same) facts.shown += 1; else facts.wrong.push(mark.dataset.tip);
  }
  facts.asked = Math.ceil(facts.tips / 7);
  view.dispatchEvent(new Event("beforeprint"));
  facts.folded = page.querySelectorAll("details:not([open])").length;
  facts.details = page.querySelectorAll("details").length;
  facts.opened = root.scrollWidth;
  facts.widest = [...page.querySelectorAll("body *")].filter(e => !e.closest(".wide") && !e.closest("svg")
    && e.getBoundingClientRect().right > root.clientWidth + 1).map(e => e.tagName + "." + e.className).slice(0, 5);
  view.dispatchEvent(new Event("afterprint"));
  told[width] = facts;
}
(async () => {
  for (const width of WIDTHS) await look(width);
  const out = document.createElement("pre"); out.id = "told"; out.textContent = JSON.stringify(told);
  document.body.append(out);
})();
</script>"""


def browse(browser: str, folder: Path, *words: str) -> str:
    """What the browser prints, without a network and with a profile of its own."""
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--disable-extensions",
               "--disable-background-networking", "--allow-file-access-from-files", f"--user-data-dir={folder / 'profile'}", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=300).stdout


def make_report(folder: Path) -> Path:
    """A report of a tree with a program whose outcome is known, as the tests of the report make it."""
    test = test_document.Report()
    test.setUp()
    try:
        test.call()
        return Path(shutil.copy(test.folder / "o" / "qsmpm_report.html", folder / "report.html"))
    finally:
        test.doCleanups()


def check_all(told: dict, pages: int) -> list[tuple[str, bool]]:
    """Every demand at every width."""
    found = []
    for width in WIDTHS:
        facts = told.get(str(width), {})
        at = f"at {width} px"
        found += [
            (f"no sideways scrolling {at}, closed or open {facts}", bool(facts) and max(facts["scroll"], facts["opened"]) <= facts["inside"]),
            (f"nothing but wide tables and drawings reaches out {at} {facts.get('widest')}", bool(facts) and not facts["widest"]),
            (f"marks tell their values {at}: {facts.get('shown')} of {facts.get('asked')} {facts.get('wrong', [])[:3]}",
             bool(facts) and facts["tips"] > 0 and facts["shown"] == facts["asked"]),
            (f"folded parts open for the printer {at}", bool(facts) and facts["details"] > 0 and facts["folded"] == 0),
        ]  # fmt: skip
    return [*found, (f"it prints, {pages} pages", pages > 0)]


def print_run(browser: str, folder: Path) -> list[tuple[str, bool]]:
    """The report of a run on paper, as the tests of it make one: what is on each page."""
    test_run_report.RunReport.setUpClass()
    try:
        page = Path(shutil.copy(test_run_report.RunReport.folder / "out" / "report.html", folder / "run.html"))
    finally:
        test_run_report.RunReport.doClassCleanups()
    browse(browser, folder, f"--print-to-pdf={folder / 'run.pdf'}", "--no-pdf-header-footer", f"file://{page}")
    return check_pages(folder, page.read_text(encoding="utf-8"))


def check_pages(folder: Path, page_text: str) -> list[tuple[str, bool]]:
    """Every demand on the pages of run.pdf, printed of a page."""
    pictures = page_text.count("<img")
    deck = html.unescape(re.search(r"<pre>(.*?)</pre>", page_text, re.DOTALL)[1]).split()
    boxes = tool("pdftotext", "-bbox", folder / "run.pdf", "-")
    pages = re.findall(r'<page width="([\d.]+)" height="([\d.]+)">(.*?)</page>', boxes, re.DOTALL)
    words = [re.findall(r'xMin="([-\d.]+)" yMin="[-\d.]+" xMax="([-\d.]+)" yMax="[-\d.]+">(.*?)<', page[2]) for page in pages]
    margin = min((float(word[0]) for page in words for word in page), default=0.0)
    out = [word[2] for page, (wide, _, _) in zip(words, pages, strict=True) for word in page if float(word[1]) > float(wide) - margin + 1.0]
    texts = [" ".join(html.unescape(word[2]) for word in page) for page in words]
    whole, places = " ".join(texts), [0]
    cut = list((Counter(deck) - Counter(whole.split())).elements())
    for part in PARTS:
        places.append(whole.find(part, places[-1] + 1))
    tool("pdftoppm", "-r", "40", "-gray", folder / "run.pdf", folder / "page")
    dots = [grey(path) for path in sorted(folder.glob("page-*.pgm"))]
    shares = [float((page < INK).mean()) for page in dots]
    edges = [float((np.concatenate([page[:, : edge(page)], page[:, -edge(page) :]], axis=1) < INK).mean()) for page in dots]
    shown = [line.split()[0] for line in tool("pdfimages", "-list", folder / "run.pdf").splitlines()[2:] if line.split()[2] == "image"]
    return [
        (f"the report of a run has 3 to 8 pages: {len(pages)}", 3 <= len(pages) <= 8),
        (f"no page is blank {[round(share, 4) for share in shares]}", bool(shares) and min(shares) > EMPTY),
        (f"no word is cut by the margin {out[:3]}", not out),
        ("nothing is drawn at the edges of the paper", not any(edges)),
        (f"all parts are there, in order {places[1:]}", places[1:] == sorted(places[1:]) and min(places[1:]) > 0),
        (f"no page ends with a heading {[text.split()[-1] for text in texts]}", not any(text.endswith(PARTS[:-1]) for text in texts)),
        (f"every picture is whole on one page: {len(shown)} of {pictures}", len(shown) == pictures > 0),
        (f"every word of the deck is printed {cut[:3]}", bool(deck) and not cut),
    ]  # fmt: skip


def tool(name: str, *words: object) -> str:
    """What a tool of poppler-utils prints."""
    return subprocess.run([name, *map(str, words)], capture_output=True, text=True, timeout=300, check=True).stdout


def grey(path: Path) -> np.ndarray:
    """A portable grey map, (rows, columns)."""
    kind, size, most, dots = path.read_bytes().split(b"\n", 3)
    columns, rows = map(int, size.split())
    assert (kind, most) == (b"P5", b"255")
    return np.frombuffer(dots, dtype=np.uint8).reshape(rows, columns)


def edge(page: np.ndarray) -> int:
    """Dots of the edge at a side."""
    return max(1, round(EDGE * page.shape[1]))


def find_browser() -> str | None:
    """A browser of this machine."""
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def main() -> int:
    """Look at one report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", nargs="?", type=Path)
    parser.add_argument("--shots", type=Path)
    parser.add_argument("--install", action="store_true", help="install a browser where there is none")
    words = parser.parse_args()
    browser = find_browser()
    if browser is None and words.install:
        subprocess.run([TOP / "tools" / "setup", "--long"], check=True)
        browser = find_browser()
    if browser is None:
        print("skipped: no chromium here, the report was not looked at; --install installs it\n0 passed, 0 failed, 1 skipped")
        return 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        page = Path(shutil.copy(words.report, folder / "report.html")) if words.report else make_report(folder)
        (folder / "probe.html").write_text(PROBE.replace("WIDTHS", json.dumps(WIDTHS)))
        said = browse(browser, folder, "--window-size=1500,1000", "--virtual-time-budget=60000", "--dump-dom", f"file://{folder}/probe.html")
        hit = re.search(r'<pre id="told">(.*?)</pre>', said, re.DOTALL)
        told = json.loads(html.unescape(hit[1])) if hit else {}
        browse(browser, folder, f"--print-to-pdf={folder / 'page.pdf'}", "--no-pdf-header-footer", f"file://{page}")
        printed = (folder / "page.pdf").read_bytes() if (folder / "page.pdf").is_file() else b""
        if words.shots:
            words.shots.mkdir(parents=True, exist_ok=True)
            (words.shots / "page.pdf").write_bytes(printed)
            for width in WIDTHS:
                # A window is at least 500 wide: narrower pages are shown in a frame.
                (folder / "shot.html").write_text(f'<body style="margin:0"><iframe src="report.html" width={width} height=2400 frameborder=0>')
                browse(browser, folder, f"--window-size={max(width, 500)},2400", f"--screenshot={words.shots / f'{width}.png'}",
                       f"file://{folder}/shot.html")
        results = check_all(told, len(re.findall(rb"/Type\s*/Page\b", printed)))
        if not words.report and PROGRAM.is_file() and all(map(shutil.which, ("pdftotext", "pdftoppm", "pdfimages"))):
            results += print_run(browser, folder)
            if words.shots and (folder / "run.pdf").is_file():
                shutil.copy(folder / "run.pdf", words.shots / "run.pdf")
    for name, held in results:
        print(("ok     " if held else "FAILED ") + name)
    failed = sum(not held for _, held in results)
    print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
