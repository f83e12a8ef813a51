"""`latelight study --html` in a browser."""

import json

from browser import faults, latelight, screenshot

DEPTH = ["study", "depth", "--samples", "4000", "--device", "cpu"]


def tables_of(page):
    """The numbers and words of each table, by its caption, in full."""
    return page.evaluate(
        """() => Object.fromEntries([...document.querySelectorAll("table")].map((table) => [
            table.caption.textContent,
            [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => {
                const data = cell.querySelector("data");
                return data && isFinite(data.value) ? Number(data.value) : cell.textContent;
            }))]))"""
    )


def test_the_tables_are_those_of_the_study(page, tmp_path):
    file = tmp_path / "depth.html"
    study = json.loads(latelight(*DEPTH, "--json", "--html", file)[0])
    page.goto(file.as_uri())
    tables = tables_of(page)
    assert set(tables) == {"depth", "depth-packing"}
    for name, rows in tables.items():
        assert rows == [list(row.values()) for row in study[name]]
    assert faults(page) == []
    screenshot(page, "study-depth", full_page=True)


def test_curves_are_drawn(page, tmp_path):
    file = tmp_path / "lights.html"
    tiny = ["--lights", "1,10", "--triangles", "50k", "--sizes", "32x18", "--budget", "1e6"]
    latelight("study", "lights", *tiny, "--device", "cpu", "--html", file)
    page.goto(file.as_uri())
    listed = json.loads(latelight("list", "lighting", "--json")[0])["lighting"]
    techniques = [technique for technique in listed if technique["name"] != "reference"]  # which traces paths
    charts = page.locator(".chart")
    assert charts.count() == 3
    assert charts.first.locator("polyline").count() == len(techniques)
    assert faults(page) == []
    screenshot(page, "study-lights", full_page=True)


def test_a_full_disk_is_said(tmp_path):
    _, error = latelight(*DEPTH, "--html", "/dev/full", code=2)
    assert "/dev/full" in error and len(error.splitlines()) == 1
    _, error = latelight(*DEPTH, "--html", tmp_path / "nowhere" / "x.html", code=2)
    assert "nowhere" in error
    _, error = latelight(*DEPTH, "--json", "--html", "-", code=2)
    assert "--html" in error
