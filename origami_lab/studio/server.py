"""The studio's server: one page and one web socket, on this machine only, for whoever has the address.

The address holds a random token, without which nothing is answered. A request must name this server as its host, and a
page that asks must be this server's own: so no other page in the browser, wherever its name points, gets at a design.
"""

from __future__ import annotations

import asyncio
import hmac
import logging
import secrets
import socket
from collections.abc import Awaitable, Callable, Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from origami_lab.errors import InputError
from origami_lab.pages import COLOURS, PATTERN
from origami_lab.studio.loading import Loading
from origami_lab.studio.messages import LARGEST_REQUEST, Message
from origami_lab.studio.opening import Opened, open_settings
from origami_lab.studio.replies import TellRefused
from origami_lab.studio.session import Session

HOST, PORT = "127.0.0.1", 8642
MOST_SESSIONS = 6
"""Tabs at a time: each has a process of its own."""
MOST_WAITING = 64
"""Messages to a page that are not taken; one that takes none is left."""
TOO_MANY, GONE = 4008, 4009
"""Codes that a web socket is closed with: all tabs are taken; the page takes no messages."""
PAGE = Path(__file__).with_name("page")
FILES = {
    "": ("text/html", (PAGE / "index.html",)),
    "studio.js": ("text/javascript", (PAGE / "studio.js",)),
    "studio.css": ("text/css", (COLOURS, PATTERN, PAGE / "studio.css")),
}
"""By their names below the token: what the files of the page are, and what they are put together from."""
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: blob:;"
        " base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class StudioServer:
    """What all tabs have in common: what was opened, where designs are saved, and who may come in.

    Parameters
    ----------
    opened
        What each tab begins with; None for the gallery.
    output
        The folder that designs are saved below; None for a fresh one below ``results/studio``. It is made when the
        first one is saved.
    port
        Of the server, for the names that it goes by.
    own
        A folder with options of the user's own.
    """

    def __init__(self, opened: Opened | None, output: Path | None, port: int, own: Path | None = None) -> None:
        self.opened, self.own = opened, own
        self.output = output or Path("results") / "studio" / datetime.now().strftime("%Y-%m-%d_%H-%M-%S")
        self.token = secrets.token_urlsafe(24)
        self.hosts = {f"{name}:{port}" for name in (HOST, "localhost")}
        self.loading = Loading()
        self.sessions: set[Session] = set()
        self._given: set[Path] = set()
        routes = [
            WebSocketRoute("/{token}/session", self._session),
            *(Route(f"/{{token}}/{name}", self._file(kind, sources)) for name, (kind, sources) in FILES.items()),
        ]
        self.app: ASGIApp = _Guarded(Starlette(routes=routes), self)

    async def load(self) -> None:
        """Bring what a design needs into memory while the page is on its way."""
        with suppress(InputError):  # a configuration of the user's that is wrong: whoever opens a task is told
            first = self.opened
            if first is None:
                first = await asyncio.to_thread(open_settings, ["target=cube"])
            await self.loading.begin(first)

    @property
    def address(self) -> str:
        """What to open in a browser; its last part is the token."""
        port = next(iter(self.hosts)).rpartition(":")[2]
        return f"http://{HOST}:{port}/{self.token}/"

    def refuses(self, connection: HTTPConnection) -> str:
        """Why a request is not answered; empty if it is."""
        hosts = connection.headers.getlist("host")
        if len(hosts) != 1 or hosts[0].lower() not in self.hosts:
            return "wrong host"
        origin = connection.headers.get("origin")
        own = {f"http://{host}" for host in self.hosts}
        if (origin is not None or connection.scope["type"] == "websocket") and origin not in own:
            return "wrong origin"
        token = connection.scope["path"].split("/")[1]
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return "wrong address"
        return ""

    def folder(self, task: str) -> Path:
        """A folder for one design, that no other one has."""
        for number in range(1, 10_000):
            path = self.output / f"{task}-{number}"
            if path not in self._given and not path.exists():
                self._given.add(path)
                return path
        raise InputError("output", self.output, "holds ten thousand designs already")

    def _file(self, kind: str, sources: Sequence[Path]) -> Callable[[Any], Awaitable[Response]]:
        async def answer(request: Any) -> Response:
            content = b"\n".join(source.read_bytes() for source in sources)
            return Response(content, media_type=kind, headers=HEADERS)

        return answer

    async def _session(self, ws: WebSocket) -> None:
        """One tab, from its first message to its last."""
        await ws.accept()
        if len(self.sessions) >= MOST_SESSIONS:
            says = f"{MOST_SESSIONS} tabs are open already: close one, and load this page again"
            await ws.send_text(TellRefused(says=says).model_dump_json())
            await ws.close(TOO_MANY)
            return
        told: asyncio.Queue[Message | None] = asyncio.Queue()
        session = Session(self.opened, self.folder, self.loading, told.put_nowait, self.own)
        self.sessions.add(session)
        writes = asyncio.create_task(_write(ws, told))
        try:
            await session.begin()
            while True:
                text = await ws.receive_text()
                await session.take(text)
                if told.qsize() > MOST_WAITING:
                    await ws.close(GONE)
                    return
                await asyncio.sleep(0)  # other tabs have their turn
        except KeyError:  # it has sent something that is no text
            with suppress(RuntimeError):
                await ws.close(1003)
        except (WebSocketDisconnect, RuntimeError):  # gone
            pass
        finally:
            self.sessions.discard(session)
            writes.cancel()
            session.close()

    def close(self) -> None:
        """End what works for the tabs."""
        for session in list(self.sessions):
            session.close()


async def _write(ws: WebSocket, told: asyncio.Queue[Message | None]) -> None:
    while (message := await told.get()) is not None:
        await ws.send_text(message.model_dump_json())


class _Guarded:
    """Answers nobody who does not have the address, or comes from another page."""

    def __init__(self, app: ASGIApp, studio: StudioServer) -> None:
        self._app, self._studio = app, studio

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        why = self._studio.refuses(HTTPConnection(scope))
        if not why and scope["type"] == "http" and scope["method"] not in ("GET", "HEAD"):
            why = "wrong method"
        if not why:
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            await PlainTextResponse(f"{why}\n", status_code=403, headers=HEADERS)(scope, receive, send)


def listen(port: int | None) -> socket.socket:
    """A socket on this machine alone: the usual port, or any free one where that is taken.

    Raises
    ------
    InputError
        If ``port`` was asked for and cannot be had.
    """
    for wanted in (PORT, 0) if port is None else (port,):
        found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((HOST, wanted))
        except OSError as error:
            found.close()
            if wanted == PORT and port is None:
                continue
            raise InputError("--port", wanted, f"cannot be listened on ({error.strerror})") from error
        return found
    raise AssertionError


def serve_studio(studio: StudioServer, listening: socket.socket, ready: Callable[[], None]) -> None:
    """Serve until the process is told to end; ``ready`` is called once the page can be opened."""
    logging.getLogger("websockets").setLevel(logging.CRITICAL)  # a tab that is closed is nothing to report
    config = uvicorn.Config(
        studio.app,
        log_level="warning",
        access_log=False,
        ws="websockets-sansio",
        ws_max_size=LARGEST_REQUEST,
        ws_per_message_deflate=False,
        server_header=False,
        proxy_headers=False,
        lifespan="off",
        limit_concurrency=64,
        timeout_graceful_shutdown=1,
    )
    server = uvicorn.Server(config)

    async def serve() -> None:
        serving, loading = asyncio.create_task(server.serve([listening])), None
        while not server.started and not serving.done():
            await asyncio.sleep(0.01)
        if server.started:
            ready()
            loading = asyncio.create_task(studio.load())
        try:
            await serving
        finally:
            if loading is not None:
                loading.cancel()
            studio.close()

    asyncio.run(serve())
