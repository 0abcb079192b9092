"""The site of the documentation: `sphinx-build -W -n -c docs . build/site`, from the project's root.

The root is the source, so that a link from docs/ to results/ or benchmarks/ is the same link here and on a code host.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from origami_lab.about import __version__  # noqa: E402 (it is found by the line above)

project = "origami-lab"
author = "The origami-lab developers"
project_copyright = author
version = release = __version__

root_doc = "docs/index"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton", "tools.site"]
include_patterns = [
    "docs/**",
    "results/*/README.md",
    "results/paper/report/*.md",
    "results/sweeps/*/summary.md",
    "benchmarks/*.md",
    "benchmarks/parts/*.md",
    "sweeps/README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
]
exclude_patterns = ["build", "dist", "viewer", ".*", "venv", "origami_lab", "tests", "docs/tools"]
suppress_warnings = [
    "myst.header",  # tables of reports begin at the second level
]

source_suffix = {".md": "myst-nb"}
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_mime_priority_overrides = [("html", "text/html", 0)]

nitpicky = True
nitpick_ignore_regex = [
    # names of other projects: a reader without a network has nowhere to go
    (r"py:.*", r"(?!origami_lab).*"),
    # what is between our packages, and in none's list of public names
    (r"py:.*", r"origami_lab\.(?!\w+$).*"),
]
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
add_module_names = False
toc_object_entries = False
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"origami-lab {__version__}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options: dict[str, object] = {"top_of_page_buttons": []}
html_last_updated_fmt = None
copybutton_exclude = ".linenos, .gp, .go, .c, .c1"
