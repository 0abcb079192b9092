"""Pages from templates: each package has its own beside its code, and all extend ``base.html.jinja``."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

HERE = Path(__file__).parent
COLOURS, PATTERN = HERE / "colours.css", HERE / "pattern.css"
"""Of all pages, light and dark; and of crease patterns drawn on them."""
STYLE = "base.css"
PARTS = "page_parts.css", "page_parts.js"
"""The style and the script that pages share whose data is beside them."""


def page_text(
    package: str,
    template: str,
    values: Mapping[str, Any],
    *,
    styles: Sequence[Path] = (),
    scripts: Sequence[Path] = (),
    filters: Mapping[str, Callable[..., Any]] | None = None,
) -> str:
    """The text of a page that loads nothing from elsewhere; every value is escaped where it stands.

    Parameters
    ----------
    package
        The one whose folder holds the template.
    styles, scripts
        Files of ours that stand in the page as they are, after the style that all pages share; a page with a script
        gets the parts, too, that such pages have in common.
    filters
        Further ones for the template.
    """
    pages = Environment(
        loader=ChoiceLoader([PackageLoader(package, "."), PackageLoader(__package__, ".")]),
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    pages.filters |= {"script_json": lambda value: Markup(script_json(value)), **(filters or {})}
    style, script = [COLOURS, HERE / STYLE, *styles], list(scripts)
    if scripts:
        style, script = [COLOURS, HERE / STYLE, HERE / PARTS[0], *styles], [HERE / PARTS[1], *scripts]
    return pages.get_template(template).render(**values, style=_joined(style), script=_joined(script))


def script_json(value: Any) -> str:
    """A value as JSON for a script: nothing in it can end the script's element, or its line."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)  # pure ASCII
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _joined(files: Sequence[Path]) -> Markup:
    return Markup("\n".join(file.read_text(encoding="utf-8") for file in files))
