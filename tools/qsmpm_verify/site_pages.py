"""Pages of the site: links that leave docs/ are replaced by names, because the site contains no sources; every page must be in the table of contents."""

from __future__ import annotations

import re
import sys
from pathlib import Path

LINK = re.compile(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)")
CODE = re.compile(r"(```.*?^```|`[^`\n]*`)", re.M | re.S)


def without_outer_links(text: str, page: Path, root: Path) -> str:
    """The page with links out of its folder tree replaced by their text."""

    def kept(link: re.Match[str]) -> str:
        path = link[2].partition("#")[0]
        if re.match(r"[a-z]+:", link[2]) or not path:
            return link[0]
        target = (page.parent / path).resolve()
        return link[0] if root.resolve() in target.parents else link[1]

    parts = CODE.split(text)
    return "".join(part if i % 2 else LINK.sub(kept, part) for i, part in enumerate(parts))


def left_out(pages: list[Path], root: Path, contents: str) -> list[str]:
    """Pages that are missing in the table of contents."""
    named = set(re.findall(r"[\w/]+\.md", contents))
    return sorted(name for name in (str(page.relative_to(root)) for page in pages) if name not in named)


def main(words: list[str]) -> int:
    """Rewrite the pages; exit code 1 if a page is missing in the table of contents."""
    pages = [Path(word) for word in words]
    root = Path("build/pages")
    for page in pages:
        page.write_text(without_outer_links(page.read_text(encoding="utf-8"), page, root), encoding="utf-8")
    missing = left_out(pages, root, Path("mkdocs.yml").read_text(encoding="utf-8"))
    print("".join(f"mkdocs.yml: {name} is not in the navigation of the site\n" for name in missing), end="")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
