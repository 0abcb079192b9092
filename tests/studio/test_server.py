"""Who is answered and who is not: the server as a hostile page, program or tab would meet it."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Awaitable, Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("starlette", reason="needs the extra studio")
httpx = pytest.importorskip("httpx")

from websockets.asyncio.client import connect  # noqa: E402
from websockets.exceptions import ConnectionClosed, InvalidStatus  # noqa: E402

from origami_lab.studio.messages import LARGEST_REQUEST  # noqa: E402
from origami_lab.studio.server import MOST_SESSIONS, TOO_MANY  # noqa: E402
from tests.studio.driving import Server, studio, wait_for  # noqa: E402

FILES = ("", "studio.js", "studio.css")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[Server]:
    with studio(folder, "target=pyramid") as running:
        yield running


def talk(server: Server, what: Callable[[Any], Awaitable[Any]], **settings: Any) -> Any:
    """Open a tab's web socket, and do something with it."""
    address = settings.pop("address", f"{server.address.replace('http', 'ws', 1)}session")
    settings.setdefault("origin", f"http://127.0.0.1:{server.port}")

    async def open_it() -> Any:
        async with connect(address, max_size=2**24, **settings) as tab:
            return await what(tab)

    return asyncio.run(open_it())


async def first(tab: Any) -> Any:
    return json.loads(await tab.recv())


def test_whoever_has_the_address_is_answered(server: Server) -> None:
    for name in FILES:
        answer = httpx.get(server.address + name)
        assert answer.status_code == 200
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'")
        assert "unsafe" not in policy
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["cache-control"] == "no-store"
        assert "server" not in answer.headers
    assert talk(server, first)["kind"] == "welcome"
    assert httpx.get(server.address.replace("127.0.0.1", "localhost")).status_code == 200


def test_the_page_is_small_and_loads_nothing_from_elsewhere(server: Server) -> None:
    texts = {name: httpx.get(server.address + name).text for name in FILES}
    assert sum(len(text.encode()) for text in texts.values()) < 2_000_000
    for name in ("", "studio.css"):
        assert "//" not in texts[name].replace("http://www.w3.org", "")
    assert "<script>" not in texts[""]
    assert " style=" not in texts[""]


@pytest.mark.parametrize("path", ["", "/", "/studio.js", "/wrong/", "/wrong/studio.js", "/%2e%2e/", "//"])
def test_without_the_token_nothing_is_said(server: Server, path: str) -> None:
    answer = httpx.get(f"http://127.0.0.1:{server.port}{path}")
    assert answer.status_code == 403
    assert server.token not in answer.text
    assert len(answer.text) < 40


@pytest.mark.parametrize("path", ["../messages.py", "%2e%2e/messages.py", "..%2fmessages.py", "page/index.html", "x"])
def test_there_are_no_other_files(server: Server, path: str) -> None:
    assert httpx.get(server.address + path).status_code in (403, 404)


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "evil.example:{port}", "[::1]:{port}", ""]
)
def test_a_wrong_host_is_refused(server: Server, host: str) -> None:
    """As it is sent by a page whose name was pointed at this machine."""
    name = host.format(port=server.port)
    assert httpx.get(server.address, headers={"host": name}).status_code in (400, 403)


def test_two_hosts_are_refused(server: Server) -> None:
    with socket.create_connection(("127.0.0.1", server.port)) as line:
        line.sendall(f"GET /{server.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nHost: evil\r\n\r\n".encode())
        assert line.recv(100).split()[1] in (b"400", b"403")


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1", None]
)
def test_a_wrong_origin_opens_no_session(server: Server, origin: str | None) -> None:
    named = None if origin is None else origin.format(port=server.port)
    with pytest.raises(InvalidStatus) as refused:
        talk(server, first, origin=named)
    assert refused.value.response.status_code == 403
    if named is not None:
        assert httpx.get(server.address, headers={"origin": named}).status_code == 403


def test_a_session_needs_the_token_and_the_host(server: Server) -> None:
    for address in (f"ws://127.0.0.1:{server.port}/session", f"ws://127.0.0.1:{server.port}/wrong/session"):
        with pytest.raises(InvalidStatus):
            talk(server, first, address=address)
    with pytest.raises(InvalidStatus):
        talk(server, first, additional_headers={"Host": "evil.example"})


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_nothing_can_be_sent_to_it(server: Server, method: str) -> None:
    answer = httpx.request(method, server.address, content=b"x" * 2_000_000 if method == "POST" else None)
    assert answer.status_code == 403


def test_an_oversized_message_ends_the_session_and_nothing_else(server: Server) -> None:
    async def flood(tab: Any) -> int:
        await first(tab)
        await tab.send("x" * (LARGEST_REQUEST + 1))
        try:
            while True:
                await tab.recv()
        except ConnectionClosed as closed:
            return int(closed.rcvd.code)

    assert talk(server, flood) == 1009
    assert talk(server, first)["kind"] == "welcome"


def test_malformed_messages_are_answered_with_a_refusal(server: Server) -> None:
    async def babble(tab: Any) -> list[str]:
        kinds: list[str] = []
        while "board" not in kinds:
            kinds.append((await first(tab))["kind"])
        said = []
        for text in ("", "{", "[]", '{"kind":"open","task":"/etc/passwd","start":"default"}', "\U0001f600" * 100):
            await tab.send(text)
            while (answer := await first(tab))["kind"] == "motion":
                pass
            said.append(answer["kind"])
        return said

    assert set(talk(server, babble)) == {"refused"}

    async def bytes_instead(tab: Any) -> int | None:
        await first(tab)
        await tab.send(b"\x00\xff")
        with suppress(ConnectionClosed):
            while True:
                await tab.recv()
        code: int | None = tab.close_code
        return code

    assert talk(server, bytes_instead) == 1003


def test_a_flood_of_sessions_is_refused_and_room_is_made_again(server: Server) -> None:
    async def crowd() -> list[str]:
        address = f"{server.address.replace('http', 'ws', 1)}session"
        origin: Any = f"http://127.0.0.1:{server.port}"
        tabs = [await connect(address, origin=origin, max_size=2**24) for _ in range(MOST_SESSIONS + 3)]
        kinds = [(await first(tab))["kind"] for tab in tabs]
        for tab in tabs[MOST_SESSIONS:]:
            with pytest.raises(ConnectionClosed) as closed:
                await tab.recv()
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == TOO_MANY
        for tab in tabs[:MOST_SESSIONS]:
            await tab.close()
        return kinds

    def there_is_room() -> bool:
        return bool(talk(server, first)["kind"] == "welcome")

    wait_for(there_is_room)
    assert asyncio.run(crowd()) == ["welcome"] * MOST_SESSIONS + ["refused"] * 3
    wait_for(there_is_room)


def test_it_listens_on_this_machine_alone(server: Server) -> None:
    name = socket.gethostbyname(socket.gethostname())
    if name.startswith("127."):
        pytest.skip("this machine has no other address")
    with pytest.raises(OSError):  # noqa: PT011 - refused or unreachable
        socket.create_connection((name, server.port), timeout=2).close()


def test_the_token_is_in_no_log_and_nothing_was_written(server: Server, folder: Path) -> None:
    httpx.get(f"http://127.0.0.1:{server.port}/wrong/")
    assert server.token not in server.log
    assert "Traceback" not in server.log
    assert sorted(file.name for file in folder.iterdir()) == ["studio.log"]
