"""What the site adds to the pages: public names with their docstrings, viewers of designs, links to folders."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

from origami_lab.drawing import TargetSurface, viewer_page
from origami_lab.drawing.viewer import viewer_script
from origami_lab.fold_format import read_fold
from tools.folder_pages import page_of
from tools.gallery import target_of_design

ROOT = Path(__file__).parents[2]
VIEWERS = "viewers"
ACCESSIBLE = {
    'class="caption" role="heading">': 'class="caption" role="heading" aria-level="2">',
    '<div class="highlight"><pre>': '<div class="highlight"><pre tabindex="0">',
    '<div class="table-wrapper colwidths-auto docutils container">': (
        '<div class="table-wrapper colwidths-auto docutils container" tabindex="0">'
    ),
}
"""What Sphinx and its theme write, and what axe asks for."""
NOT_YET = ("docs/studio",)
"""Pages that the first page has a place for before they are there."""
_LINK = re.compile(r"\]\(([^)\s]+\.fold)\)")
_FOLDER = re.compile(r"\]\(([\w./-]+)\)")
_COLON = "\ue000"
_ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], "
    r"~?(?:numpy\.)?dtype\[~?(?:numpy\.)?(\w+)\]\]"
)
_BARS = re.compile(r"\|([^|\s][^|]*)\|")


def exported(package: str) -> dict[str, str]:
    """Public names of a package, and the module in which each is defined, in the order of the modules."""
    stub = ROOT.joinpath(*package.split(".")) / "__init__.pyi"
    if not stub.is_file():
        return {}
    found: dict[str, str] = {}
    for node in ast.parse(stub.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            module = f"{package}.{node.module}" if node.level else str(node.module)
            found |= {alias.name: module for alias in node.names}
    return found


class PublicNames(SphinxDirective):
    """``{public-names} origami_lab.game``: each public name of a package with its docstring."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        package = self.arguments[0]
        module = __import__(package, fromlist=["_"])
        lines = []
        names = exported(package)
        for name in names or module.__all__:
            value = getattr(module, name)
            kind = "class" if isinstance(value, type) else "function" if callable(value) else "data"
            home = names.get(name, package) if kind == "data" else package  # where the comment of a value stands
            lines += [f".. auto{kind}:: {home}.{name}", *(["   :members:"] if kind == "class" else [])]
            lines += ["   :no-index:", ""] if package == "origami_lab" else [""]  # they have a page of their package's
        text = ["```{eval-rst}", *lines, "```"]
        parent = nodes.section()
        self.state.nested_parse(StringList(text, source=self.get_source_info()[0]), self.content_offset, parent)
        return list(parent.children)


def adapt(app: Sphinx, docname: str, source: list[str]) -> None:
    """Beside each link to a FOLD file a link to a page to turn and fold it; links to folders lead to a page."""
    up = "../" * docname.count("/")

    def both(link: re.Match[str]) -> str:
        file = (ROOT / docname).parent.joinpath(link[1]).resolve()
        if not file.is_file() or not file.is_relative_to(ROOT):
            return link[0]
        return f'{link[0]} (<a href="{up}{VIEWERS}/{viewer_name(file)}">turn and fold it</a>)'

    def page(link: re.Match[str]) -> str:
        folder = (ROOT / docname).parent.joinpath(link[1]).resolve()
        known = page_of(folder) if folder.is_dir() else None
        return f"](/{known}.md)" if known else link[0]

    source[0] = _FOLDER.sub(page, _LINK.sub(both, source[0]))
    for missing in NOT_YET:
        if docname == app.config.root_doc and not (ROOT / f"{missing}.md").is_file():
            source[0] = source[0].replace(f"\n{Path(missing).name}\n", "\n")


def viewer_name(file: Path) -> str:
    """The name of the page of a FOLD file."""
    return "-".join(file.relative_to(ROOT).with_suffix(".html").parts)


def write_viewers(app: Sphinx, error: Exception | None) -> None:
    """Write the page of every committed design, and send the site's root to its first page."""
    if error is not None or app.builder.format != "html":
        return
    out = Path(app.outdir)
    (out / VIEWERS).mkdir(exist_ok=True)
    (out / VIEWERS / "viewer.js").write_text(viewer_script(), encoding="utf-8")
    for file in sorted((ROOT / "results").glob("*/designs/**/*.fold")):
        shape = target_of_design(file)
        target = None if shape is None else TargetSurface(shape.vertices, shape.faces)
        page = viewer_page(read_fold(file), target, script="viewer.js")
        (out / VIEWERS / viewer_name(file)).write_text(page, encoding="utf-8")
    first = f"{app.config.root_doc}.html"
    (out / "index.html").write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{app.config.html_title}</title>'
        f'<meta http-equiv="refresh" content="0; url={first}"></head>'
        f'<body><a href="{first}">{first}</a></body></html>\n',
        encoding="utf-8",
    )


def make_accessible(app: Sphinx, error: Exception | None) -> None:
    """Captions of the contents get their level, and what scrolls sideways can be reached by keyboard."""
    if error is not None or app.builder.format != "html":
        return
    for file in Path(app.outdir).rglob("*.html"):
        if file.parent.name != VIEWERS:
            text = file.read_text(encoding="utf-8")
            for plain, told in ACCESSIBLE.items():
                text = text.replace(plain, told)
            file.write_text(text, encoding="utf-8")


def resolve(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement) -> nodes.Node | None:
    """Names of the code by the module that they are defined in, which is between us and Python."""
    module, _, name = str(node["reftarget"]).rpartition(".")
    package = ".".join(module.split(".")[:2])
    if node.get("refdomain") != "py" or exported(package).get(name) != module:
        return None
    python: Any = env.get_domain("py")
    found = python.objects.get(f"{package}.{name}")
    if found is None:
        return None
    uri = f"{app.builder.get_relative_uri(node['refdoc'], found.docname)}#{package}.{name}"
    return nodes.reference("", "", content, refuri=uri, internal=True)


def hide_colons(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """Before Napoleon, which takes what is before a colon in an attribute's docstring for its type."""
    if what in ("attribute", "data", "property"):
        lines[:] = [line.replace(":", _COLON) for line in lines]


def finish_docstring(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """After Napoleon: colons come back, and |x|, a length in docstrings, is no substitution."""
    lines[:] = [_BARS.sub(r"\\|\1\\|", line.replace(_COLON, ":")) for line in lines]


def shorten_arrays(
    app: Sphinx, what: str, name: str, value: object, options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """NDArray[float64] is written out by NumPy in four brackets."""
    texts = [text if text is None else _ARRAY.sub(r"NDArray[\1]", text) for text in (signature, returned)]
    return texts[0], texts[1]


def setup(app: Sphinx) -> dict[str, object]:
    """Called by Sphinx."""
    app.add_directive("public-names", PublicNames)
    app.connect("source-read", adapt)
    app.connect("missing-reference", resolve)
    app.connect("autodoc-process-signature", shorten_arrays)
    app.connect("autodoc-process-docstring", hide_colons, priority=400)
    app.connect("autodoc-process-docstring", finish_docstring, priority=600)
    app.connect("build-finished", write_viewers)
    app.connect("build-finished", make_accessible)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
