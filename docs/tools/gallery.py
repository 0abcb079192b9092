"""The page of all designs that are committed below results/: ``python -m tools.gallery`` in docs/ writes it.

It draws two small pictures of each design into docs/images/gallery. A design's command is the one that its folder's
README names; its target is the one of that command.
"""

from __future__ import annotations

import functools
import io
import shlex
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from PIL import Image

from origami_lab.config import build_parts, compose_settings
from origami_lab.drawing import TargetSurface, draw_folded, draw_pattern
from origami_lab.fold_format import FoldFile, read_fold
from origami_lab.targets import Target

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "gallery.md"
PICTURES = ROOT / "docs" / "images" / "gallery"
SIDE = 440


@dataclass(frozen=True)
class Entry:
    """One design: its file below results/, what it shows, and the command that found it."""

    file: str
    title: str
    command: str

    @property
    def path(self) -> Path:
        """Where its FOLD file is."""
        return ROOT / "results" / self.file

    @property
    def name(self) -> str:
        """The first part of its pictures' names."""
        return self.file.removesuffix(".fold").replace("/designs/", "-").replace("/", "-")


_MESH = "target=mesh target.path=results/beyond/meshes/{}.obj 'target.translate=[0,0,0]' max_crease_length=2.9"
BEYOND = (
    Entry("beyond/designs/bowl/best.fold", "bowl", "target=bowl seed=107"),
    Entry("beyond/designs/bowl/polished.fold", "bowl, polished", "target=bowl seed=101 polish=60000"),
    Entry("beyond/designs/face/best.fold", "face", "target=face budget=5_000_000 seed=103"),
    Entry("beyond/designs/face/polished.fold", "face, polished", "target=face budget=5_000_000 seed=105 polish=60000"),
    Entry(
        "beyond/designs/vault/best.fold",
        "vault",
        f"{_MESH.format('vault')} symmetry=y objective.distance=vertex seed=103",
    ),
    Entry(
        "beyond/designs/dome/best.fold",
        "dome",
        f"{_MESH.format('dome')} symmetry=y objective.distance=vertex seed=107",
    ),
    Entry("beyond/designs/saddle/best.fold", "saddle", f"{_MESH.format('saddle')} symmetry=xy seed=101"),
    Entry("beyond/designs/chair/best.fold", "chair", "objective=chair seed=109"),
    Entry("beyond/designs/shelf/best.fold", "shelf", "objective=shelf seed=107"),
)
"""Of ``search=lns``."""


def entries() -> list[Entry]:
    """All committed designs: those of lns, then the best of each task of the paper."""
    paper = []
    for path in sorted((ROOT / "results" / "paper" / "designs").glob("*.fold")):
        task, search, seed = path.stem.rsplit("-", 2)
        command = f"+experiment=paper/{task} search={search} seed={seed.removeprefix('seed')}"
        paper.append(Entry(f"paper/designs/{path.name}", f"{task}, {search}", command))
    return [*BEYOND, *paper]


@functools.cache
def _target(command: str) -> Target | None:
    words = [word for word in shlex.split(command) if not word.startswith(("polish", "search", "seed"))]
    words = [word.replace("=results/", f"={ROOT}/results/") for word in words]
    return build_parts(compose_settings([*words, "tracking=none"])).target


def target_of_design(file: Path) -> Target | None:
    """The target of a committed design; None where its objective needs none."""
    for entry in entries():
        if entry.path == file:
            return _target(entry.command)
    return None


def facts(fold: FoldFile) -> str:
    """Return, driving angle and size of a design, in words."""
    known = fold.metadata
    value = f"return {known['return']:.3f}".replace("-", "−")
    creases = sum(letter != "B" for letter in fold.assignments)
    return f"{value} · driving angle {known['driving_angle']:.1f}° · {creases} creases, {len(fold.panels)} panels"


def draw(entry: Entry, folder: Path) -> list[Path]:
    """Draw the folded sheet in its target, and the crease pattern."""
    fold = read_fold(entry.path)
    shape = target_of_design(entry.path)
    target = None if shape is None else TargetSurface(shape.vertices, shape.faces)
    files = [folder / f"{entry.name}-folded.png", folder / f"{entry.name}-pattern.png"]
    draw_folded(fold, files[0], target, size=2 * SIDE)
    draw_pattern(fold, files[1], size=2 * SIDE)
    for file in files:
        with Image.open(io.BytesIO(file.read_bytes())) as image:
            image.convert("RGB").reduce(2).quantize(96, dither=Image.Dither.NONE).save(file, optimize=True)
    return files


HEAD = """# Gallery

Every design that is committed below [`results/`](../results/beyond/README.md), with the command that found it and its
FOLD file. On the site a page to turn and fold each design is beside its file; from the file such a page comes by
`origami-lab export FILE --to html`. `origami-lab verify FILE` certifies each. All commands are typed in the project's
root; version 0.2.0 finds the design's return by each, to the last digit.
"""
SECTIONS = {
    "beyond": """
## What lns designs

By the default searcher, 500,000 interactions a trial where the command says no other budget;
[measured](../results/beyond/README.md) over ten seeds a task.
""",
    "paper": """
## The best of the paper's tasks

The best trial of each task by the paper's searchers ([all of them](../results/paper/README.md)), ten seeds of 500,000
interactions each; of equally good ones that of the first in the table's order.
""",
}


def page() -> str:
    """The whole page as Markdown."""
    parts = [HEAD]
    told = ""
    for entry in entries():
        folder = entry.file.partition("/")[0]
        if folder != told:
            parts.append(SECTIONS[folder])
            told = folder
        picture = f"images/gallery/{entry.name}"
        parts.append(
            f"\n### {entry.title[0].upper()}{entry.title[1:]}\n\n"
            f"![The folded sheet of {entry.title}]({picture}-folded.png) "
            f"![Its crease pattern]({picture}-pattern.png)\n\n"
            f"{facts(read_fold(entry.path))} · [{entry.path.name}](../results/{entry.file})\n\n"
            f"```\norigami-lab {entry.command}\n```\n"
        )
    return "".join(parts)


def main() -> None:
    """Write the page and its pictures."""
    mpl.use("Agg")
    PICTURES.mkdir(parents=True, exist_ok=True)
    for entry in entries():
        draw(entry, PICTURES)
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
