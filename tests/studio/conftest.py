"""Chromium, and a studio without a design, for all that drive the page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.studio.driving import CHROMIUM, FLAGS, Page, Server, browser_page, studio


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        found = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield found
        found.close()


@pytest.fixture(scope="package")
def gallery(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A studio that was opened without anything."""
    with studio(tmp_path_factory.mktemp("gallery")) as running:
        yield running
        assert "Traceback" not in running.log


@pytest.fixture
def page(browser: Any, gallery: Server) -> Iterator[Page]:
    """A tab of it in which nothing may go wrong."""
    tab = browser_page(browser)
    found = Page(tab, gallery.address)
    yield found
    assert found.errors == []
    tab.context.close()
