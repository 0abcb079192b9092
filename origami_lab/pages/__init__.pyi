from .page_folder import PageFolder
from .templates import COLOURS, PATTERN, page_text, script_json

__all__ = ["COLOURS", "PATTERN", "PageFolder", "page_text", "script_json"]
