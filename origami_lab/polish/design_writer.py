"""The files of a design that was made from another one: the pattern, its figures, its certificate, its pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from origami_lab.drawing.scene import TargetSurface
from origami_lab.files import write_whole
from origami_lab.fold_format.writer import as_fold_file, write_fold
from origami_lab.game.crease_pattern import CreasePattern
from origami_lab.verification.certificate import Certificate


def write_design(
    folder: Path,
    stem: str,
    design: CreasePattern,
    certificate: Certificate,
    figures: Mapping[str, Any],
    target: TargetSurface | None,
    *,
    pictures: bool = True,
) -> tuple[tuple[Path, ...], tuple[str, ...]]:
    """Write ``STEM.fold``, ``STEM.json``, ``STEM.certificate.json``, and with ``pictures`` ``STEM.png`` (folded),
    ``STEM_pattern.png`` and ``STEM.html``, each of them whole.

    Returns
    -------
    The files, and warnings: pictures that could not be drawn.

    Raises
    ------
    OSError
        If one cannot be written.
    """
    from dataclasses import replace

    fold = as_fold_file(design)
    certificate = replace(certificate, name=f"{stem}.fold")
    files = {name: folder / f"{stem}{name}" for name in (".fold", ".json", ".certificate.json")}
    write_fold(files[".fold"], fold)
    write_whole(files[".json"], json.dumps(figures, indent=1) + "\n")
    write_whole(files[".certificate.json"], certificate.json_text())
    written, warnings = list(files.values()), []
    if pictures:
        from origami_lab.drawing import draw_folded, draw_pattern
        from origami_lab.drawing.viewer import write_viewer

        drawn: tuple[tuple[str, Callable[[Path], None]], ...] = (
            (f"{stem}.png", lambda file: draw_folded(fold, file, target)),
            (f"{stem}_pattern.png", lambda file: draw_pattern(fold, file)),
            (f"{stem}.html", lambda file: write_viewer(fold, file, target)),
        )
        for name, draw in drawn:
            try:
                draw(folder / name)
                written.append(folder / name)
            except Exception as error:
                warnings.append(f"no {name}: {type(error).__name__}: {error}")
    return tuple(written), tuple(warnings)
