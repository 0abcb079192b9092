"""origami-lab: search for crease patterns that fold rigidly, with one degree of freedom, into a shape.

``origami_lab.run([...])`` does what the command does and ``origami_lab.load(DIR)`` reads a finished run; both return
a :class:`Result`. ``origami_lab.export_design(...)`` writes a design in other formats, ``origami_lab.show(...)`` shows
one in a notebook, ``origami_lab.verify(FILE)`` returns its :class:`Certificate`. They are imported when first used, so
that ``import origami_lab`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from origami_lab.errors import InputError as InputError
    from origami_lab.experiment.api import run as run
    from origami_lab.experiment.result import Result as Result
    from origami_lab.experiment.result import load as load
    from origami_lab.reporting.exporting import export_design as export_design
    from origami_lab.reporting.notebook import show as show
    from origami_lab.verification.certificate import Certificate as Certificate
    from origami_lab.verification.checking import verify as verify

__version__ = "0.1.0"

_HOMES = {
    "run": "origami_lab.experiment.api",
    "load": "origami_lab.experiment.result",
    "Result": "origami_lab.experiment.result",
    "export_design": "origami_lab.reporting.exporting",
    "show": "origami_lab.reporting.notebook",
    "InputError": "origami_lab.errors",
    "verify": "origami_lab.verification.checking",
    "Certificate": "origami_lab.verification.certificate",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
