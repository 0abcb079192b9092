"""Checks of a glTF file before it is read: things that the reader would trip over, or pass over in silence."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from origami_lab.targets.mesh_formats.text_lines import text_of

_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
_FLOAT = 5126
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def whole_gltf(kind: str, data: bytes) -> bytes:
    """A file of a kind (glb or gltf) without a byte order mark and without what follows its end.

    Raises
    ------
    ValueError
        If it is cut off; if triangles in it would not be read, or not where they are: fans, compressed or quantized
        ones, sparse ones, those that stand in no scene.
    """
    if kind == "glb":
        if len(data) < 20 or data[:4] != b"glTF":
            raise ValueError("it does not begin as a GLB file does")
        length, chunk = (int.from_bytes(data[at : at + 4], "little") for at in (8, 12))
        if length > len(data) or 20 + chunk > length:
            raise ValueError(f"cut off: it promises {max(length, 20 + chunk)} bytes and has {len(data)}")
        data = data[:length]
        document = json.loads(data[20 : 20 + chunk])
    else:
        text = text_of(data)
        try:
            document, end = json.JSONDecoder().raw_decode(text, len(text) - len(text.lstrip()))
        except json.JSONDecodeError as error:
            cut = "cut off: " if error.pos >= len(text.rstrip()) or error.msg.startswith("Unterminated") else ""
            raise ValueError(f"{cut}{error.msg} in its line {error.lineno}") from None
        data = text[:end].encode()
    if not isinstance(document, Mapping):
        raise ValueError("it is no glTF document")
    _check(document)
    return data


def _check(document: Mapping[str, Any]) -> None:
    meshes = document.get("meshes", [])
    primitives = [part for mesh in meshes for part in mesh["primitives"]]
    named = {name for part in (*primitives, *document.get("bufferViews", [])) for name in part.get("extensions", ())}
    if compressed := sorted(named & set(_COMPRESSED)):
        raise ValueError(f"its meshes are compressed ({compressed[0]}): save it without compression")
    modes = {part.get("mode", _TRIANGLES) for part in primitives}
    if _FAN in modes:
        raise ValueError("it has triangle fans, which are not read: save it as triangles")
    if modes and not modes & {_TRIANGLES, _STRIP}:
        raise ValueError("it has points and lines, no triangles")
    accessors = document.get("accessors", [])
    for number in _used(part for part in primitives if part.get("mode", _TRIANGLES) in (_TRIANGLES, _STRIP)):
        if "sparse" in accessors[number]:
            raise ValueError("some of its vertices are sparse, which is not read: save it without morphing")
    for part in primitives:
        positions = accessors[part["attributes"]["POSITION"]]
        if positions.get("normalized") or positions["componentType"] != _FLOAT:
            raise ValueError("its vertices are quantized (KHR_mesh_quantization): save it without compression")
    if meshes and not any(scene.get("nodes") for scene in document.get("scenes", [])):
        raise ValueError("its meshes stand in no scene")


def _used(primitives: Iterator[Mapping[str, Any]]) -> Iterator[int]:
    """The accessors that say where triangles are."""
    for part in primitives:
        yield part["attributes"]["POSITION"]
        if "indices" in part:
            yield part["indices"]
