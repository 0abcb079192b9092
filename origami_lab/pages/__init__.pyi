from .page_folder import PageFolder
from .templates import page_text, script_json

__all__ = ["PageFolder", "page_text", "script_json"]
