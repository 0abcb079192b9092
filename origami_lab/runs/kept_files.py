"""What a trial's folder keeps when the trial is played again."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path

from origami_lab.files import remove_folder

_OF_A_TRIAL = re.compile(
    r"(best|motion|pattern|folded|polished|simplified)(_pattern)?\.[\w.]+|(result|actions|certificate)\.json|curve\.csv|search\.npz"
)
"""Names of what a trial has written, and of what was made of it later: exports, polished designs."""


def keep_others(old: Path, new: Path) -> None:
    """Take what is not ours over from a trial's earlier folder, and remove what is."""
    with suppress(OSError):
        for file in list(old.iterdir()):
            if not _OF_A_TRIAL.fullmatch(file.name) and not (new / file.name).exists():
                file.replace(new / file.name)
    remove_folder(old)
