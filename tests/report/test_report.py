"""`latelight report` in a browser: its values, its controls, and who can use it."""

import html
import json
import os
import re
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from browser import PROGRAM, RUNS_ALL, faults, latelight, screenshot
from conftest import SCENE, SIZE

PIXELS = [(0, 0), (20, 40), (48, 27), (61, 33), (95, 53)]


def choose(page, side, group, name):
    """A picture by the beginning of its name."""
    number = page.evaluate(
        """([group, name]) => JSON.parse(document.getElementById("data").textContent).views
            .findIndex((view) => view.group === group && view.name.startsWith(name))""",
        [group, name],
    )
    assert number >= 0, (group, name)
    page.locator(f"#{side}").select_option(str(number))


def values_at(page, side, x, y):
    """What the table says of a pixel: {"normal.x": "0.5", ...}"""
    page.locator("#x").fill(str(x))
    page.locator("#y").fill(str(y))
    page.locator("#y").press("Enter")
    table = page.locator(f"#{side}-values")
    table.locator("caption", has_text=f" at {x}, {y}").wait_for()
    names, texts = table.locator("th").all_text_contents(), table.locator("td").all_text_contents()
    return dict(zip(names, texts, strict=True))


@pytest.fixture(scope="session")
def rendered(folder):
    """The outputs of `latelight render`, by name."""
    names = ["depth", "normal", "position", "albedo", "id", "roughness"]
    latelight("render", *SCENE, "--axes", "z-up", "--aov", ",".join(names), "-o", folder / "{aov}.npy")
    return {name: np.load(folder / f"{name}.npy") for name in names}


@pytest.mark.parametrize(
    "picture, channels, output",
    [
        ("depth", ["depth, meters"], "depth"),
        ("normal.", ["normal.x", "normal.y", "normal.z"], "normal"),
        ("normal.", ["normal.w"], "roughness"),
        ("position.", ["position.x", "position.y", "position.z"], "position"),
        ("albedo.", ["albedo.r", "albedo.g", "albedo.b"], "albedo"),
        ("ids.r", ["ids.r"], "id"),
    ],
)
def test_targets_have_the_values_of_render(opened, rendered, picture, channels, output):
    choose(opened, "left", "Layout exact", picture)
    expected = rendered[output].reshape(SIZE[1], SIZE[0], -1)
    drawn = 0
    for x, y in PIXELS:
        if not np.isfinite(rendered["depth"][y, x]):
            continue  # targets hold nothing there
        drawn += 1
        shown = values_at(opened, "left", x, y)
        assert [expected.dtype.type(shown[name]) for name in channels] == list(expected[y, x])
    assert drawn >= 3


@pytest.mark.parametrize("technique", ["clustered", "tiled", "forward"])
def test_heat_maps_have_the_counts_of_render(opened, folder, technique):
    names = ["lights-tested", "lights-used"]
    latelight("render", *SCENE, "--lighting", technique, "--aov", ",".join(names), "-o", folder / f"{technique}-{{aov}}.npy")
    row = opened.locator("section[aria-labelledby=lighting] tbody tr", has=opened.locator(f"th:text-is('{technique}')"))
    numbers = [float(number) for number in row.locator("data").evaluate_all("all => all.map((d) => d.value)")]
    for i, name in enumerate(names):
        counts = np.load(folder / f"{technique}-{name}.npy")
        choose(opened, "right", f"Lighting {technique}", name)
        for x, y in PIXELS:
            assert float(values_at(opened, "right", x, y)[name]) == counts[y, x]
        assert numbers[2 * i] == pytest.approx(counts.mean(dtype=float), rel=1e-12)
        assert numbers[2 * i + 1] == counts.max()


def test_pictures_have_the_bytes_of_render(opened, folder):
    for layout in ["compact", "killzone2"]:
        latelight("render", *SCENE, "--layout", layout, "-o", folder / "picture.png")
        picture = np.asarray(Image.open(folder / "picture.png"))
        choose(opened, "left", f"Layout {layout}", "picture")
        for x, y in PIXELS:
            (text,) = values_at(opened, "left", x, y).values()
            assert [int(byte) for byte in text.split()] == list(picture[y, x])


def test_parts_are_those_of_the_manual(opened):
    manual = (Path(__file__).resolve().parents[2] / "docs" / "report.md").read_text()
    (table,) = re.findall(r"^\| part \|.*\n\|---.*\n((?:\|.*\n)+)", manual, re.MULTILINE)
    parts = [row.split("|")[1].strip() for row in table.splitlines()]
    assert opened.locator("section h2").all_text_contents() == [part for part in parts if part]


def test_introduction_counts_in_words(opened):
    # Eight boxes of twelve triangles, and a sun.
    assert "96 triangles and 1 light, 96x54," in opened.locator("body").inner_text()


def test_what_is_typed_stays_while_a_picture_arrives(opened):
    caption = opened.locator("#left-values caption")
    before = caption.text_content()
    opened.evaluate(
        """() => {
            const left = document.getElementById("left");
            left.value = 5;
            left.dispatchEvent(new Event("change"));
            document.getElementById("x").value = 7;
        }"""
    )
    opened.wait_for_function("(before) => document.querySelector('#left-values caption').textContent !== before", arg=before)
    assert opened.locator("#x").input_value() == "7"


def test_bytes_are_those_of_the_list(opened):
    layouts = json.loads(latelight("list", "layouts", "--json", "--size", "96x54")[0])["layouts"]
    table = opened.locator("table", has=opened.locator("caption", has_text="Bytes of each layout"))
    rows = table.locator("tbody tr")
    assert rows.count() == len(layouts)
    for row, layout in zip(rows.all(), layouts, strict=True):
        numbers = [float(number) for number in row.locator("data").evaluate_all("all => all.map((d) => d.value)")]
        sizes = layout["bytes"]
        assert numbers == [sizes["targets"], sizes["depth"], sizes["light"], sizes["total"], sizes["picture"] / 1e6]


def test_commands_state_the_raster_and_the_samples(folder):
    """A page of options that affect the memory and the times of passes."""
    path = folder / "options.html"
    options = ["builtin:boxes", "--size", "64x36", "--device", "cpu", "--shadows", "none"]
    latelight("report", *options, "--raster", "rays", "--aa", "msaa4", "--runs", 1, "-o", path)
    page = path.read_text()
    commands = [html.unescape(command) for command in re.findall(r'class="command"><code>latelight (.*?)</code>', page)]

    (listed,) = (command for command in commands if command.startswith("list layouts"))
    assert shlex.split(listed) == ["list", "layouts", "--size", "64x36", "--samples", "4"]
    table = re.search(r"Bytes of each layout.*?</table>", page, re.DOTALL)[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)
    sizes = {}
    for row in rows:
        if found := re.findall(r'<data value="([^"]*)"', row):
            *_, total, megabytes = (float(number) for number in found)
            sizes[total] = megabytes
    assert sizes
    for total, megabytes in sizes.items():
        assert megabytes == pytest.approx(total * 64 * 36 * 4 / 1e6, rel=1e-12)

    timed = [command for command in commands if command.startswith("bench frame")]
    assert timed and all("--raster rays" in command for command in timed)
    report = json.loads(latelight(*shlex.split(timed[0]), "--json")[0])
    assert {row["raster"] for row in report["frame"]} == {"rays"}


def target(page, layout, begin):
    """All values of a layout's target, as the page has them: height, width, channels."""
    words = page.evaluate(
        """async ([group, begin]) => {
            const view = data.views.find((view) => view.group === group && view.name.startsWith(begin));
            return Promise.all(view.values.map(async (value) => [...await plane(value.plane)]));
        }""",
        [f"Layout {layout}", begin],
    )
    return np.stack([np.array(channel, np.uint32).view(np.float32) for channel in words], -1).reshape(SIZE[1], SIZE[0], -1)


def test_errors_of_layouts_are_those_of_their_targets(opened, rendered):
    table = opened.locator("table", has=opened.locator("caption", has_text="Errors of each layout"))
    rows = {
        row.locator("th").text_content(): [float(n) for n in row.locator("data").evaluate_all("all => all.map((d) => d.value)")]
        for row in table.locator("tbody tr").all()
    }
    assert rows["exact"] == [0] * 8
    assert rows["plain"][:4] == [0] * 4  # normals and positions as they are
    assert rows["plain"][5] < 1e-6 and 1e-4 < rows["engine"][5] < 0.02  # floats, and eight bits that are sRGB
    drawn = np.isfinite(rendered["depth"])
    stored = target(opened, "engine", "normal.")[drawn][:, :3].astype(float) * 2 - 1  # ten bits each
    stored /= np.linalg.norm(stored, axis=-1, keepdims=True)
    exact = rendered["normal"][drawn].astype(float)
    angles = np.degrees(2 * np.arctan2(np.linalg.norm(stored - exact, axis=-1), np.linalg.norm(stored + exact, axis=-1)))
    mean, most, *_ = rows["engine"]
    assert 0.01 < most < 0.5
    assert mean == pytest.approx(angles.mean(), rel=1e-3) and most == pytest.approx(angles.max(), rel=1e-3)


def test_every_number_and_picture_has_a_command_that_works(opened, folder):
    own, *commands = opened.locator(".command code").all_text_contents()
    assert own.startswith("latelight report ")  # test_the_same_but_for_times runs that again
    kinds = {}
    for command in commands:  # one of each form
        kinds.setdefault(re.sub(r"(--layout|--lighting|-o) \S+", r"\1", command), command)
    assert len(commands) > 40 and len(kinds) >= 7
    environment = {**os.environ, "PATH": f"{os.path.dirname(PROGRAM)}:{os.environ['PATH']}"}
    for command in kinds.values():
        subprocess.run(command, shell=True, check=True, cwd=folder, env=environment, stdout=subprocess.DEVNULL)


def samples(page):
    """Colours of the canvas, away from the divider and the pixel that is read."""
    return page.evaluate(
        """() => {
            const canvas = document.getElementById("canvas"), context = canvas.getContext("2d");
            return [0.2, 0.35, 0.65, 0.8].map((x) =>
                [...context.getImageData(canvas.width * x, canvas.height * 0.55, 1, 1).data]);
        }"""
    )


def test_the_divider_parts_two_pictures(opened):
    choose(opened, "left", "Layout exact", "position.")
    choose(opened, "right", "Layout exact", "depth")
    values_at(opened, "right", 3, 3)

    def at(divider):
        opened.locator("#divider").fill(str(divider))
        return samples(opened)

    left, right, both = at(100), at(0), at(50)
    assert all(a != b for a, b in zip(left, right, strict=True))
    assert both == left[:2] + right[2:]


def test_the_keyboard_is_enough(opened):
    reached = []
    for _ in range(30):
        opened.keyboard.press("Tab")
        reached.append(opened.evaluate("document.activeElement.id || document.activeElement.tagName"))
    expected = ["left", "right", "divider", "zoom", "x", "y", "stage"]
    assert [name for name in reached if name in expected] == expected

    stage = opened.locator("#stage")
    opened.locator("#x").fill("10")
    opened.locator("#y").fill("20")
    opened.locator("#y").press("Enter")
    stage.focus()
    for key in ["ArrowRight", "ArrowRight", "ArrowUp", "Shift+ArrowDown"]:
        stage.press(key)
    assert (opened.locator("#x").input_value(), opened.locator("#y").input_value()) == ("12", "29")
    for key in ["+", "+", "+", "-", "]"]:
        stage.press(key)
    assert opened.locator("#zoom-text").text_content() == "4x"
    assert opened.locator("#divider").input_value() == "52"
    opened.locator("#left-values caption", has_text="12, 29").wait_for()


def test_the_pointer_reads_pixels_and_zooms(opened):
    box = opened.locator("#stage").bounding_box()
    opened.mouse.move(box["x"] + box["width"] * 30.5 / SIZE[0], box["y"] + box["height"] * 10.5 / SIZE[1])
    opened.locator("#left-values caption", has_text="30, 10").wait_for()
    before = samples(opened)
    opened.mouse.wheel(0, -100)
    opened.locator("#zoom-text", has_text="2x").wait_for()
    assert samples(opened) != before


def test_spheres_turn_and_have_the_errors_of_the_study(opened):
    pictures = "all => all.map((canvas) => canvas.toDataURL())"
    before = opened.locator(".sphere").evaluate_all(pictures)
    opened.locator("#sphere-turn").press("ArrowRight")
    after = opened.locator(".sphere").evaluate_all(pictures)
    assert len(before) > 5 and all(a != b for a, b in zip(before, after, strict=True))

    opened.locator("#sphere-bits").select_option(label="12")
    opened.locator("figcaption span", has_text="12+12").first.wait_for()
    captions = opened.locator(".spheres figcaption").all_text_contents()
    (command,) = (c for c in opened.locator(".command code").all_text_contents() if "study normals" in c)
    rows = json.loads(latelight(*shlex.split(command)[1:], "--json")[0])["normals"]
    for row in rows:
        if row["region"] == "sphere" and row["bits"] == "12+12" and row["encoding"] == "octahedral":
            (caption,) = (text for text in captions if text.startswith("octahedral "))
            mean, most = map(float, re.findall(r"([\d.e-]+)°", caption))
            assert mean == pytest.approx(row["mean deg"], rel=5e-3)
            assert most == pytest.approx(row["max deg"], rel=5e-3)


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [360, 768, 1280])
def test_everybody_can_use_it(opened, width, theme):
    opened.set_viewport_size({"width": width, "height": 900})
    opened.emulate_media(color_scheme=theme)
    assert faults(opened) == []
    assert opened.evaluate("document.documentElement.scrollWidth <= innerWidth")
    screenshot(opened, f"report-{width}-{theme}", full_page=True)


def test_each_label_has_one_control(opened):
    """As HTML requires: the control that it is `for`, or the only one that it contains (html-validate)."""
    counts = opened.evaluate(
        """() => [...document.querySelectorAll("label")].map((label) =>
            label.querySelectorAll("button, input, meter, output, progress, select, textarea").length
            + (label.htmlFor ? 1 : 0))"""
    )
    assert len(counts) > 5 and set(counts) == {1}


def test_opens_at_once(opened, report):
    assert report.stat().st_size < 20e6
    assert opened.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd") < 2000


def test_prints_without_controls(opened, folder):
    opened.emulate_media(media="print")
    assert not opened.locator(".controls:visible, .command button:visible").count()
    assert opened.locator("table:visible").count() >= 5
    pdf = opened.pdf(format="A4")
    assert pdf.startswith(b"%PDF") and pdf.count(b"/Type /Page\n") >= 4


@pytest.mark.skipif(not RUNS_ALL, reason="left to ./dev test --all: a second report")
def test_the_same_but_for_times(report, folder):
    again = folder / "again.html"
    latelight("report", *SCENE, "--runs", 2, "-o", again)

    def without_times(path):
        text = path.read_text().replace(str(path), "")
        assert text.count('<section aria-labelledby="times">') == 1
        return re.sub(r'<section aria-labelledby="times">.*?</section>', "", text, flags=re.DOTALL)

    assert without_times(report) == without_times(again)


def test_techniques_without_an_option_are_left_out(folder):
    latelight("report", "builtin:boxes", "--size", "33x17", "--runs", 1, "--shadows", "rays", "--sun", "30,40",
              "-o", folder / "rays.html")
    page = (folder / "rays.html").read_text()
    assert "<h3>clustered</h3>" in page and "<h3>forward</h3>" not in page


@pytest.mark.parametrize(
    "arguments, code, words",
    [
        (["builtin:boxes"], 2, "--out"),
        (["builtin:boxes", "--aov", "depth", "-o", "x.html"], 2, "--aov"),
        (["builtin:boxes", "--labels", "x.json", "-o", "x.html"], 2, "--labels"),
        (["builtin:boxes", "--keypoints", "[]", "-o", "x.html"], 2, "--keypoints"),
        (["builtin:boxes", "--correspond", "x.npz", "-o", "x.html"], 2, "--correspond"),
        (["builtin:boxes", "--axes", "z-up", "-o", "x.html"], 2, "omit --axes"),
        (["builtin:boxes", "--normal-frame", "opencv", "-o", "x.html"], 2, "omit --normal-frame"),
        (["builtin:boxes", "--data-surfaces", "any", "-o", "x.html"], 2, "omit --data-surfaces"),
        (["builtin:boxes", "--position-origin", "1,2,3", "-o", "x.html"], 2, "omit --position-origin"),
        (["builtin:boxes", "--fps", "25", "-o", "x.html"], 2, "no motion for --fps"),
        (["builtin:boxes", "--lens", "equirectangular", "-o", "x.html"], 2, "one layout only: omit --lens"),
        (["builtin:boxes", "--to-camera", "main", "-o", "x.html"], 2, "--to-camera"),
        (["builtin:boxes", "-o", "nowhere/x.html"], 2, "nowhere"),
        (["builtin:boxes", "-o", "x.png"], 2, "ends in .html"),
        (["builtin:boxes", "--runs", "0", "-o", "x.html"], 2, "--runs"),
        (["absent.glb", "-o", "x.html"], 3, "absent.glb"),
        (["absent.glb", "-o", "X.HTML"], 3, "absent.glb"),
        (["builtin:boxes", "--device", "no such device", "-o", "x.html"], 4, "no such device"),
    ],
)
def test_what_is_wrong_is_said(folder, arguments, code, words):
    _, error = latelight("report", *arguments, code=code, cwd=folder)
    assert words in error and len(error.splitlines()) == 1
    assert not (folder / "x.html").exists()


@pytest.mark.skipif(not RUNS_ALL, reason="left to ./dev test --all: large images")
def test_large_pages_end_before_they_are_complete(folder):
    """A page has about 100 images. The positions of all pixels have 29 MB, and hardly compress."""
    _, error = latelight("report", "builtin:triangles,count=200k,size=100", "--size", "2000x1200", "--device", "cpu",
                         "-o", "x.html", code=2, cwd=folder)
    images = int(re.search("first ([0-9]+) images and their values have", error)[1])
    assert images < 30 and "smaller --size than 2000x1200" in error
    assert not (folder / "x.html").exists()
