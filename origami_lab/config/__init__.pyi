"""Public names, and the modules that they live in; each is imported when it is first used."""

from .compose import compose_settings
from .instantiate import Parts, build_parts
from .seeds import format_seeds, parse_seeds
from .settings import Settings, read_settings

__all__ = [
    "Parts",
    "Settings",
    "build_parts",
    "compose_settings",
    "format_seeds",
    "parse_seeds",
    "read_settings",
]
