"""Names and texts as MLflow takes them: what a user chose is refused before a run, what we make is cut to fit."""

from __future__ import annotations

import hashlib
import posixpath
import re
from collections.abc import Iterable

from origami_lab.errors import InputError

LONGEST_NAME = 250
"""Characters of the name of a run, a parameter or a tag."""
LONGEST_PARAMETER, LONGEST_TAG = 6000, 8000
"""Characters of their values."""
_LONGEST_FOLDER = 120
"""Characters of a folder's name, of which each may take two bytes; file systems take 255 of them."""


def check_names(keys: Iterable[str]) -> None:
    """Raise InputError if MLflow cannot take the keys of a configuration as names of parameters."""
    for key in keys:
        known = re.fullmatch(r"[\w.\- :/]*", key) and posixpath.normpath(key) == key and not key.startswith(("/", ".."))
        if not known or len(key) > LONGEST_NAME:
            expected = f"is no name of a parameter for MLflow: letters, digits and . _ - : /, at most {LONGEST_NAME}"
            raise InputError("tracking", key, f"{expected}; tracking=none does without")


def fitting(text: str, longest: int) -> str:
    """A text with its middle left out where it is too long; parts of files' names that are no letters are replaced."""
    text = text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
    half = longest // 2 - 2
    return text if len(text) <= longest else f"{text[:half]} … {text[-half:]}"


def artifact_folder(experiment: str) -> str:
    """The name of the folder for an experiment's files: like the experiment's, as far as that can name a folder."""
    plain = re.sub(r"[^\w .+=@()-]", "_", experiment).strip(" .")[:_LONGEST_FOLDER]
    return plain if plain == experiment else f"{plain}-{hashlib.sha256(experiment.encode()).hexdigest()[:8]}"
