"""A real Chromium for the tests of pages, where one is installed; elsewhere these tests are skipped and say why."""

import os
import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

VARIABLE = "LCE_CHROMIUM"
"""Environment variable with the path of a Chromium that is not on PATH."""
NAMES = ("chromium", "chromium-browser", "google-chrome")
QUIET = ("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync")
"""No request of the browser's own may be taken for one of the page."""
SOFTWARE_WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SIZE_PX = {"width": 1280, "height": 800}


def chromium() -> str | None:
    """Return the path of an installed Chromium, None if there is none."""
    return os.environ.get(VARIABLE) or next(filter(None, map(shutil.which, NAMES)), None)


@pytest.fixture(scope="session")
def browser() -> Iterator["Browser"]:
    """Chromium without a window, with WebGL in software; each test opens contexts of its own."""
    path = chromium()
    if path is None:
        pytest.skip(f"no Chromium: none of {', '.join(NAMES)} is on PATH, and {VARIABLE} names none")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is absent: pip install '.[dev]'")
    # Chromium refuses its sandbox to root, as whom containers run.
    root = ("--no-sandbox",) if hasattr(os, "geteuid") and os.geteuid() == 0 else ()
    with playwright.sync_playwright() as driver:
        launched = driver.chromium.launch(executable_path=path, args=[*root, *QUIET, *SOFTWARE_WEBGL])
        yield launched
        launched.close()


@pytest.fixture
def page(browser: "Browser") -> Iterator["Page"]:
    """A page of its own, as on a laptop, with no memory of the pages before."""
    with browser.new_context(viewport=SIZE_PX) as context:  # pyright: ignore[reportArgumentType]
        yield context.new_page()
