"""The schema of the messages as TypeScript: what the page is checked against.

``python -m origami_lab.studio.message_types`` prints it; ``npm run types`` in ``viewer/`` writes it where it belongs.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from origami_lab.studio.messages import REQUESTS
from origami_lab.studio.replies import REPLIES

_HEAD = "// Made of origami_lab/studio/messages.py and replies.py by `npm run types`: not to be changed by hand.\n"
_PLAIN = {"integer": "number", "number": "number", "string": "string", "boolean": "boolean", "null": "null"}


def typescript() -> str:
    """The types of all messages, one interface each, and the unions ``Request`` and ``Reply``."""
    parts = [_HEAD]
    for name, adapter in (("Request", REQUESTS), ("Reply", REPLIES)):
        schema = adapter.json_schema(mode="validation" if name == "Request" else "serialization")
        for title, model in schema["$defs"].items():
            parts.append(_interface(title, model))
        union = " | ".join(_type(option) for option in schema["oneOf"])
        parts.append(f"export type {name} = {union};\n")
    return "\n".join(parts)


def _interface(title: str, model: dict[str, Any]) -> str:
    said = model.get("description", "").partition("\n")[0]
    lines = [f"// {said}", f"export interface {title} {{"]
    required = set(model.get("required", ()))
    for name, field in model["properties"].items():
        lines.append(f"  {name}{'' if name in required else '?'}: {_type(field)};")
    return "\n".join([*lines, "}\n"])


def _type(schema: dict[str, Any]) -> str:
    """One schema as a type."""
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if "const" in schema:
        return json.dumps(schema["const"])
    if "enum" in schema:
        return " | ".join(json.dumps(value) for value in schema["enum"])
    if "anyOf" in schema:
        return " | ".join(_type(option) for option in schema["anyOf"])
    kind = schema["type"]
    if kind == "array" and "prefixItems" in schema:
        return f"[{', '.join(_type(item) for item in schema['prefixItems'])}]"
    if kind == "array":
        inner = _type(schema["items"])
        return f"({inner})[]" if "|" in inner else f"{inner}[]"
    if kind == "object":
        return f"Record<string, {_type(schema['additionalProperties'])}>"
    return _PLAIN[kind]


if __name__ == "__main__":
    sys.stdout.write(typescript())
