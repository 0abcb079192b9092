"""Pages that are made from the code are what the code makes; links lead somewhere, also on a code host."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from origami_lab.about import __version__
from tests.docs.page_blocks import PAGES, ROOT

sys.path.append(str(ROOT / "docs"))
from tools import folder_pages, gallery, glossary, settings

DOCS = ROOT / "docs"
REFERENCE = DOCS / "reference"
MORE_PAGES = [  # of the site
    *ROOT.glob("*.md"),
    *ROOT.glob("benchmarks/**/*.md"),
    *ROOT.glob("results/**/*.md"),
    *ROOT.glob("sweeps/*.md"),
]
SITE = sorted({*PAGES, *MORE_PAGES})


def text_of(page: Path) -> str:
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def anchors(page: Path) -> set[str]:
    """The anchors that code hosts, and the site, give to the headings of a page."""
    found = set()
    for heading in re.findall(r"^#{1,6} (.+)$", text_of(page), re.M):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
        found.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


def test_the_page_of_settings_is_what_conf_says() -> None:
    committed = settings.PAGE.read_text(encoding="utf-8")
    assert committed == settings.page(), "make it anew: cd docs && PYTHONPATH=.. python -m tools.settings"


def test_the_page_of_settings_has_every_key_and_option() -> None:
    page = settings.PAGE.read_text(encoding="utf-8")
    root = yaml.safe_load((ROOT / "conf" / "config.yaml").read_text(encoding="utf-8"))
    for key in root.keys() - {"defaults", "hydra", "driving_angle", "report_order"}:
        assert f"`{key}=" in page, key
    for file in (ROOT / "conf").rglob("*.yaml"):
        group, *rest = file.relative_to(ROOT / "conf").with_suffix("").parts
        if rest and group != "hydra" and not rest[0].startswith("_"):
            assert f"### {group}={'/'.join(rest)}\n" in page, file


def test_the_gallery_shows_every_committed_design() -> None:
    assert gallery.PAGE.read_text(encoding="utf-8") == gallery.page()
    committed = {file for file in (ROOT / "results").rglob("*.fold") if "designs" in file.parts}
    assert {entry.path for entry in gallery.entries()} == committed
    assert len(committed) >= 20


@pytest.mark.slow
@pytest.mark.parametrize("name", ["board", "leaf", "reach"])
def test_a_picture_of_the_glossary_is_what_the_game_draws(name: str) -> None:
    with Image.open(glossary.FOLDER / f"{name}.png") as image:
        committed = np.asarray(image.convert("RGB"), float)
    drawn = np.asarray(glossary.PICTURES[name](), float)
    assert committed.shape == drawn.shape
    assert np.abs(committed - drawn).mean() < 2.0, "draw it anew: cd docs && PYTHONPATH=.. python -m tools.glossary"
    assert np.abs(committed - 255).mean() > 2.0


def test_the_glossary_shows_every_picture() -> None:
    shown = re.findall(r"\(images/glossary/([\w-]+)\.png\)", (DOCS / "glossary.md").read_text(encoding="utf-8"))
    assert sorted(shown) == sorted(glossary.PICTURES) == sorted(file.stem for file in glossary.FOLDER.glob("*.png"))


def test_every_package_has_a_page_of_reference() -> None:
    packages = {".".join(stub.parent.relative_to(ROOT).parts) for stub in (ROOT / "origami_lab").rglob("__init__.pyi")}
    shown = re.findall(r"\{public-names\} (\S+)", "".join(file.read_text("utf-8") for file in REFERENCE.glob("*.md")))
    assert packages <= set(shown)
    assert len(shown) == len(set(shown))


@pytest.mark.parametrize("page", SITE, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        if re.match(r"https?://|mailto:", link):
            continue
        path, _, fragment = link.partition("#")
        place = (page.parent / path).resolve() if path else page
        assert place.exists(), link
        assert place.is_relative_to(ROOT), link
        if place.is_dir():
            on_site = folder_pages.page_of(place)
            assert on_site is not None, f"{link}: the site has no page of it"
            assert (ROOT / f"{on_site}.md").is_file(), on_site
        assert not fragment or fragment in anchors(place), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_picture_is_said_in_words(page: Path) -> None:
    for words in re.findall(r"!\[([^]]*)\]\(", text_of(page)):
        assert len(words.split()) > 1, page


def test_the_version_is_one() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    newest = re.search(r"^## (\d\S*)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert newest is not None
    assert project["version"] == __version__ == str(citation["version"]) == newest[1]
