"""A small report, made once."""

import pytest

from browser import latelight

SIZE = (96, 54)
SCENE = ["builtin:boxes", "--size", "96x54", "--device", "cpu"]


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="session")
def report(folder):
    path = folder / "report.html"
    latelight("report", *SCENE, "--runs", 2, "-o", path)
    return path


@pytest.fixture
def opened(report, context, page):
    """The report in a browser without a network, once its script is done. Nothing but the file itself is asked for."""
    context.set_offline(True)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(report.as_uri())
    page.locator("#left-values td").first.wait_for()
    page.locator("figcaption span:not(:empty)").first.wait_for()
    yield page
    assert [url for url in asked if not url.startswith("data:")] == [report.as_uri()]
