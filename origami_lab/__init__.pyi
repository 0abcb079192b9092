"""Public names, and the modules that they live in; each is imported when it is first used."""

from .about import __version__
from .drawing.notebook import show
from .errors import InputError
from .experiment.api import run
from .export.formats import export_design
from .runs.result import Result, load
from .verification.certificate import Certificate
from .verification.verify_design import verify

__all__ = [
    "Certificate",
    "InputError",
    "Result",
    "__version__",
    "export_design",
    "load",
    "run",
    "show",
    "verify",
]
