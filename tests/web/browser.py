"""For tests of pages: Debian's Chromium by Playwright, accessibility by axe-core, and the program that makes the pages."""

import os
import subprocess
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

PROGRAM = os.environ["LATELIGHT_PROGRAM"]
HANGS = 30 * 60 * 1000  # milliseconds: on a busy machine everything may take long
RUNS_ALL = os.environ.get("LATELIGHT_TEST_ALL", "0") not in ("", "0")  # see tests/long_tests.h
SCREENSHOTS = os.environ.get("LATELIGHT_SCREENSHOTS")  # a folder, for those who want to look


def pytest_collection_modifyitems(items):
    """Keeps every Nth test, where `./dev test` runs them in part (tests/in_part)."""
    items[:] = items[int(os.environ.get("GTEST_SHARD_INDEX", 0)) :: int(os.environ.get("GTEST_TOTAL_SHARDS", 1))]


@pytest.fixture(scope="session")
def chromium():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", timeout=HANGS)
        yield browser
        browser.close()


@pytest.fixture
def context(chromium):
    """A window of its own; the test fails where a page in it reports an error."""
    context = chromium.new_context(viewport={"width": 1280, "height": 800})
    context.set_default_timeout(HANGS)
    errors = []
    context.on("weberror", lambda error: errors.append(str(error.error)))
    context.on("console", lambda message: message.type == "error" and errors.append(message.text))
    yield context
    context.close()
    assert errors == []


@pytest.fixture
def page(context):
    return context.new_page()


def faults(page):
    """What axe-core calls serious or critical, a line each."""
    violations = Axe().run(page).response["violations"]
    return [
        f"{fault['id']}: {fault['help']}: {node['html'][:200]}"
        for fault in violations
        if fault["impact"] in ("serious", "critical")
        for node in fault["nodes"]
    ]


def screenshot(page, name, **options):
    """Into the folder LATELIGHT_SCREENSHOTS, where it is given."""
    if SCREENSHOTS:
        page.screenshot(path=Path(SCREENSHOTS) / f"{name}.png", **options)


def latelight(*arguments, code=0, **options):
    """Runs the program under validation on the CPU, and gives its standard output and error."""
    environment = {**os.environ, "LATELIGHT_VALIDATION": "1"}
    command = [PROGRAM, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, **options)
    assert done.returncode == code, f"{command} ended with {done.returncode}: {done.stderr}"
    return done.stdout, done.stderr
