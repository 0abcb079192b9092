"""The page of the site that a link to a folder leads to, as a code host shows the folder itself."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = {
    "conf/search": "docs/settings",
    "results/paper/designs": "docs/gallery",
    "results/paper/report/figures": "results/paper/report/returns",
}
"""The pages of folders that have no README."""


def page_of(folder: Path) -> str | None:
    """The page that stands for a folder, from the root and without its suffix; None where there is none."""
    if (folder / "README.md").is_file():
        return (folder / "README").relative_to(ROOT).as_posix()
    return FOLDERS.get(folder.relative_to(ROOT).as_posix())
