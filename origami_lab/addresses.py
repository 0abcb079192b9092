"""Addresses of stores and databases without what is secret in them, and where the secrets are kept meanwhile.

Everything that is written, shown or handed to another program holds an address without its password, token and query.
What was typed or read whole is noted in this process's environment, which the processes that it starts inherit, and
is looked up where a connection is made. Users may give whole addresses there themselves, by MLflow's and Optuna's own
variables.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, MutableMapping
from urllib.parse import unquote

NOTED = "ORIGAMI_LAB_ADDRESSES"
"""The variable for whole addresses that a command was given, one a line."""
GIVEN = ("MLFLOW_TRACKING_URI", "OPTUNA_STORAGE")
"""Variables in which users may give them."""
_FILES = ("sqlite", "file", "memory")
_WITH_USER = ("postgresql", "postgres", "mysql", "mariadb", "mssql", "oracle")
"""Databases, whose user is no secret and belongs to the address: the password may be elsewhere."""
_HOST = re.compile(r"(\[[\da-fA-F:.]+\]|[\w.-]*)(:\d+)?(/[^@]*)?")
_ADDRESS = re.compile(r"([A-Za-z][\w+.-]*)://(.*)", re.DOTALL)
_SECRET_WORD = r"[\w-]*(?:password|passwd|passphrase|pwd|token|secret|api_?key|access_?key|credential|signature)[\w-]*"
_IN_TEXTS = (
    # with whatever typing error before the name of the user; a password may hold anything, so all up to the last @ goes
    (re.compile(r"([A-Za-z][\w+.-]*:/{0,2}|//)[^\s'\"]*@"), r"\1"),
    (re.compile(r"[\w.%+-]+:[^\s'\"]*@"), ""),
    (re.compile(r"((?<!sqlite)(?<!file):/[^\s?#'\"]*)[?#][^\s'\"]*"), r"\1"),
    (re.compile(rf"(?i)\b({_SECRET_WORD}=)[^&\s'\"]+"), r"\1..."),
)
_SHORTEST = 3
"""Letters of a secret that is looked for in texts."""


def without_secrets(address: str) -> str:
    """An address as it may be written down: the scheme, the host and the path, of a database also the user."""
    found = _ADDRESS.fullmatch(address.strip())
    if found is None or found[1].partition("+")[0].lower() in _FILES:
        return address
    scheme, rest = found.groups()
    head = re.split(r"[?#]", rest, maxsplit=1)[0]
    if "@" in rest and "@" not in head and not _HOST.fullmatch(head):  # the password holds a question mark
        head = rest
    user, at, place = head.rpartition("@")
    name = user.partition(":")[0] if scheme.partition("+")[0].lower() in _WITH_USER else ""
    return f"{scheme}://{name}{at if name else ''}{place}"


def keep(address: str, environment: MutableMapping[str, str] | None = None) -> str:
    """Note a whole address, if it holds secrets, for this process and those it starts; returns it without them."""
    environment = os.environ if environment is None else environment
    written = without_secrets(address)
    if written != address and "\n" not in address and "\0" not in address:
        others = [known for known in environment.get(NOTED, "").splitlines() if without_secrets(known) != written]
        environment[NOTED] = "\n".join([*others, address])
    return written


def whole(address: str) -> str:
    """An address with the secrets that are known for it, to connect with."""
    return next((known for known in _known() if without_secrets(known) == address), address)


def hidden(text: str) -> str:
    """A text for people and records: without secrets in what may be addresses, also wrongly typed ones."""
    for secret in sorted({part for known in _known() for part in _secrets(known)}, key=len, reverse=True):
        text = text.replace(secret, "...")
    # every second piece is an address as it should be
    pieces = re.split(r"([A-Za-z][\w+.-]*://[^\s'\"]+)", text)
    for place, piece in enumerate(pieces):
        if place % 2:
            pieces[place] = without_secrets(piece)
        elif "@" in piece or "=" in piece or "?" in piece:
            for pattern, instead in _IN_TEXTS:
                pieces[place] = pattern.sub(instead, pieces[place])
    return "".join(pieces)


def hidden_word(word: str) -> str:
    """An argument of a command without secrets; a whole address in it is noted."""
    key, equals, value = word.partition("=") if re.match(r"[+~\w./@-]+=", word) else ("", "", word)
    quote = value[:1] if len(value) > 1 and value[0] in "'\"" and value[-1] == value[0] else ""
    inner = value[1:-1] if quote else value
    if _ADDRESS.fullmatch(inner) and len(re.findall(r"://", inner)) == 1:
        address = re.sub(r"\\(.)", r"\1", inner) if not quote else inner.replace(f"\\{quote}", quote)
        written = keep(address)
        return word if written == address else f"{key}{equals}{quote}{written}{quote}"
    return re.sub(r"[A-Za-z][\w+.-]*://[^\s'\"{}\[\],]*", lambda found: keep(found[0]), word)


def _known() -> Iterator[str]:
    yield from reversed(os.environ.get(NOTED, "").splitlines())
    yield from filter(None, (os.environ.get(name) for name in GIVEN))


def _secrets(address: str) -> Iterator[str]:
    """The secret parts of a whole address, as they are written and decoded."""
    found = _ADDRESS.fullmatch(address)
    written = without_secrets(address)
    if found is None or written == address:
        return
    place = written.partition("://")[2].rpartition("@")[2]
    user, at, behind = found[2].partition(f"@{place}")
    behind = behind if at else found[2].removeprefix(place)
    if at:
        yield from _both(user)
        yield from _both(user.partition(":")[2])
        if found[1].partition("+")[0].lower() not in _WITH_USER:
            yield from _both(user.partition(":")[0])
    for pair in re.split(r"[?#&]", behind):
        name, equals, value = pair.partition("=")
        value = value if equals else name
        if len(value) > 7 or re.match(_SECRET_WORD, name, re.IGNORECASE):
            yield from _both(value)


def _both(text: str) -> Iterator[str]:
    yield from (part for part in {text, unquote(text)} if len(part) >= _SHORTEST)
