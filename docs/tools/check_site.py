"""Checks a built site without a network: ``python -m tools.check_site build/site`` in docs/, or with its full path.

Every link and picture of every page leads to a file of the site, every anchor to an element of its page, and nothing
is loaded from elsewhere. With ``--axe FILE`` (axe-core's axe.min.js) pages are opened in Chromium and looked at by it.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADS = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("source", "src"), ("video", "src")}
"""Attributes whose file a browser loads by itself."""
AXED = (
    *("docs/index", "docs/gallery", "docs/glossary", "docs/settings", "docs/which-searcher", "docs/reference/game"),
    *("docs/notebooks/first-design", "docs/own-parts", "results/paper/README", "docs/how-it-works"),
)
"""Pages that axe looks at: one of each kind."""
WIDTHS = 1280, 500
"""A desk's, and the narrowest that Chromium opens without a device of its own."""
SERIOUS = {"serious", "critical"}


LOOK = """
addEventListener("load", async () => {
  const done = await axe.run({exclude: [["iframe"]]}, {iframes: false});
  const told = document.createElement("script");
  told.id = "axe-told";
  told.type = "application/json";
  const found = done.violations.map((one) => ({
    id: one.id, impact: one.impact, nodes: one.nodes.map((node) => node.target.join(" ")).slice(0, 3),
  }));
  told.textContent = JSON.stringify(found).replaceAll("<", " ");
  document.body.append(told);
});
"""
"""Runs axe in a page and leaves there what it found; frames are pages of their own."""


class Page(HTMLParser):
    """The links and anchors of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what the element leads to, and by what name it is reached."""
        for name, value in attrs:
            if value is None:
                continue
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif (tag, name) in LOADS:
                self.loaded.append(value)
            elif tag == "a" and name == "href":
                self.links.append(value)


def faults(site: Path) -> list[str]:
    """What is wrong with the links of a site, a line each."""
    pages = {file: Page(file.read_text(encoding="utf-8")) for file in sorted(site.rglob("*.html"))}
    found = []
    for file, page in pages.items():
        name = file.relative_to(site)
        for link in page.loaded:
            if urlsplit(link).scheme not in ("", "data") or link.startswith("//"):
                found.append(f"{name} loads {link[:90]}")
        for link in page.links + [link for link in page.loaded if not urlsplit(link).scheme]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            place = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            if not place.is_file():
                found.append(f"{name}: there is no {link[:90]}")
            elif parts.fragment and place in pages and not known(parts.fragment, pages[place].anchors):
                found.append(f"{name}: {link[:90]} has no such anchor")
    return found


def known(fragment: str, anchors: set[str]) -> bool:
    """Whether an anchor is there; ``angle=45`` and the like are words to the viewer's script."""
    return unquote(fragment) in anchors or re.fullmatch(r"\w+=[\d.]+", fragment) is not None


def look_with_axe(site: Path, axe: Path, width: int, names: tuple[str, ...] = AXED) -> tuple[int, list[str]]:
    """How many pages axe has looked at, and its serious findings on them, a line each."""
    found = []
    looked = 0
    for name in names:
        page = site / f"{name}.html"
        script = f"<script>{axe.read_text(encoding='utf-8')}</script><script>{LOOK}</script>"
        text = page.read_text(encoding="utf-8").replace("</body>", f"{script}</body>")
        beside = page.with_name(f"axe-{page.name}")  # beside it, so that its files are found
        beside.write_text(text, encoding="utf-8")
        try:
            with tempfile.TemporaryDirectory() as profile:
                dom = subprocess.run(
                    [
                        *("chromium", "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}"),
                        *("--virtual-time-budget=30000", f"--window-size={width},900", "--dump-dom", beside.as_uri()),
                    ],
                    capture_output=True,
                    text=True,
                    check=True,
                    timeout=180,
                ).stdout
        finally:
            beside.unlink()
        told = re.search(r'<script id="axe-told"[^>]*>(.*?)</script>', dom, re.DOTALL)
        if told is None:
            found.append(f"{name}: axe has not come to its end")
            continue
        looked += 1
        for one in json.loads(told[1]):
            if one["impact"] in SERIOUS:
                found.append(f"{name}: {one['impact']}: {one['id']}: {', '.join(one['nodes'])}")
    return looked, found


def main() -> int:
    """Print what is wrong; the exit code says whether anything is."""
    reader = argparse.ArgumentParser(description="Check a built site.")
    reader.add_argument("site", type=Path)
    reader.add_argument("--axe", type=Path)
    given = reader.parse_args()
    found = faults(given.site.resolve())
    if given.axe is not None:
        for width in WIDTHS:
            looked, more = look_with_axe(given.site.resolve(), given.axe.resolve(), width)
            found += more
            sys.stdout.write(f"axe looked at {looked} pages, {width} pixels wide\n")
    sys.stdout.write("".join(f"{line}\n" for line in found) or "links and anchors of all pages lead somewhere\n")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
