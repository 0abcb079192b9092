"""A search that is saved on the way, so that one that is killed goes on from there."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Arrays = Mapping[str, NDArray[Any]]

_FACTS = "facts"


class Checkpoints(Protocol):
    """Where a search is saved: what is given last is what is found."""

    @property
    def due(self) -> bool:
        """Whether it is time to save again."""
        ...

    def write(self, content: bytes) -> None:
        """Keep this instead of what was kept before."""
        ...

    def read(self) -> bytes | None:
        """What was kept last; None if nothing was."""
        ...


def pack(facts: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Facts, as JSON knows them, and arrays of numbers as one file's content."""
    content = io.BytesIO()
    text = np.frombuffer(json.dumps(facts).encode(), dtype=np.uint8)
    np.savez(content, allow_pickle=False, **{_FACTS: text}, **arrays)
    return content.getvalue()


def unpack(content: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]] | None:
    """The facts and arrays that were packed; None if it cannot be read. Nothing in it is executed."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(arrays.pop(_FACTS).tobytes()), arrays
    except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile):
        return None
