#!/usr/bin/env python3
"""The report in a real browser: no sideways scrolling at three widths, values at the pointer, folded parts printed.

    verification/browser.py [--install] [REPORT.html] [--shots FOLDER]

Without a file a small report is made. `--shots` keeps a picture of the page at each width. Closes with N passed, M failed;
where there is no chromium (Debian package chromium) it is skipped; `--install` installs one first (tools/setup --long).
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
from pathlib import Path

TOP = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.tests import test_document  # noqa: E402

WIDTHS = (360, 800, 1400)
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
    for name, held in results:
        print(("ok     " if held else "FAILED ") + name)
    failed = sum(not held for _, held in results)
    print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
