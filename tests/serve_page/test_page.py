"""`latelight serve` and its page in a browser: every control changes the picture as the command line does."""

import base64
import json
import os
import re
import shlex
import signal
import socket
import subprocess
import time

import numpy
import pytest
from browser import HANGS, PROGRAM, RUNS_ALL, faults, latelight, screenshot

SCENE = "builtin:boxes"
SIZES = {"phone": (360, 740), "laptop": (1280, 800), "large": (3840, 2160)}


class Server:
    """The program under validation; its own words are in `log`."""

    def __init__(self, folder, scene=SCENE, options=("--validate",), **environment):
        self.log = folder / "log"
        command = [PROGRAM, "serve", scene, "--port", "0", "--device", "cpu", *options]
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=log, text=True, env={**os.environ, **environment}
            )
        text = ""
        while not (found := re.search(r"http://\S+", text)):
            line = self.process.stdout.readline()
            assert line, self.log.read_text()
            text += line
        self.url = found[0]

    def end(self, by=signal.SIGTERM):
        self.process.send_signal(by)
        assert self.process.wait(HANGS / 1000) == 0, self.log.read_text()


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    server = Server(tmp_path_factory.mktemp("serve"))
    yield server
    server.end()


@pytest.fixture
def view(page, server):
    page.set_viewport_size({"width": 760, "height": 300})
    page.goto(server.url)
    settle(page)
    return page


def settle(page):
    """Until the final picture of everything that was asked for is shown; moves leave with the display's frames."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.wait_for_selector("#stage[aria-busy=false]", timeout=HANGS)


# A canvas's pixels as text, which travels faster than numbers.
TEXT = """(canvas) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return [canvas.width, canvas.height, btoa(Array.from(data, (byte) => String.fromCharCode(byte)).join(""))];
}"""


def rgb(width, height, text):
    values = numpy.frombuffer(base64.b64decode(text), numpy.uint8)
    return values.reshape(height, width, 4)[..., :3].astype(float)


def pixels(page):
    """Of the picture as it is shown."""
    return rgb(*page.evaluate(f"({TEXT})(document.getElementById('picture'))"))


def rendered(page, folder):
    """What the page's command writes: the file, and its pixels over the page's ground."""
    command = shlex.split(page.inner_text("#command"))
    assert command[0] == "latelight" and command[-2:] == ["-o", "picture.png"]
    latelight(*command[1:-1], folder / "picture.png")
    file = (folder / "picture.png").read_bytes()
    drawn = page.evaluate(
        f"""async (text) => {{
          const picture = await createImageBitmap(new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]));
          const canvas = new OffscreenCanvas(picture.width, picture.height);
          const context = canvas.getContext("2d");
          context.fillStyle = "rgb(24 26 30)";
          context.fillRect(0, 0, picture.width, picture.height);
          context.drawImage(picture, 0, 0);
          return ({TEXT})(canvas);
        }}""",
        base64.b64encode(file).decode(),
    )
    return file, rgb(*drawn)


def check_as_command(page, folder):
    """The picture shown is that of the command line, but for JPEG."""
    settle(page)
    shown = pixels(page)
    _, exact = rendered(page, folder)
    error = numpy.sqrt(numpy.mean((shown - exact) ** 2))
    assert error < 5, f"{page.inner_text('#command')}: {error}"
    return shown


def open_options(page):
    page.evaluate("document.querySelectorAll('#options details').forEach((each) => (each.open = true))")


CONTROLS = [
    lambda page: page.click("#frame"),
    lambda page: page.fill("#option-background", "#336699"),
    lambda page: page.fill("#option-exposure", "1.5"),
    lambda page: page.select_option("#option-tonemap", "aces"),
    lambda page: page.fill("#option-sun", "30,40,3"),
    lambda page: page.select_option("#environment", "studio"),
    lambda page: page.fill("#option-fog", "0.05"),
    lambda page: page.select_option("#output", "normal"),
]


def test_controls_change_the_picture_as_their_options_do(view, tmp_path):
    before = pixels(view)
    open_options(view)
    for i, control in enumerate(CONTROLS):
        control(view)
        view.keyboard.press("Tab")  # a field's text counts once it is left
        settle(view)
        after = pixels(view)
        assert numpy.abs(after - before).mean() > 0.2, i
        before = after
        if i in (3, 6):
            check_as_command(view, tmp_path)
    check_as_command(view, tmp_path)
    assert view.is_hidden("#error")


TEXTS = {
    "exposure": "auto",
    "aperture": "f/2.8",
    "vignetting": "cos4",
    "white-balance": "2,1,1.5",
    "response": "gamma:2.2",
    "background": "#336699",
    "aa": "fxaa",
    "shadow-lights": "all",
    "sun": "30,40,3",
    "fog-color": "#102030",
    "position-origin": "1,2,3",
}


COMMAND_HAS = """([text, all]) => {
  const shown = document.getElementById("command").innerText;
  return all ? shown === text : ` ${shown} `.includes(` ${text} `);
}"""


def another_value(row):
    if row["type"] == "flag":
        return "true"
    if row["type"] == "name":
        return [name for name in row["names"] if name != row["default"]][-1]
    if row["type"] == "text":
        return TEXTS[row["name"].lstrip("-")]
    return f"{max(min(3, row.get('most', 6) / 2), row.get('least', 0)):g}"


# Returns every row, or for a short run every fourth of each type, so that each type of control is tried. Each row is
# a picture with shaders of its own, for which lavapipe compiles two seconds.
def tried(rows):
    if RUNS_ALL:
        return rows
    types = {}
    for key, row in rows.items():
        types.setdefault(row["type"], []).append(key)
    return {key: rows[key] for keys in types.values() for key in keys[::4]}


# What the picture then is, tests/view compares with the command line for each option.
def test_every_option_has_a_control_that_sets_it(view):
    table = json.loads(latelight("list", "options", "--json")[0])["options"]
    rows = {row["name"].lstrip("-"): row for row in table if "member" in row and row["name"] != "--size"}
    shown = set(view.evaluate("[...document.querySelectorAll('[id^=option-]')].map((each) => each.id.slice(7))"))
    assert rows.keys() == shown
    del rows["animation"]  # the scene has none
    open_options(view)
    view.fill("#option-time", "1")  # or --loop would mean nothing
    view.keyboard.press("Tab")
    view.wait_for_function(COMMAND_HAS, arg=["--time=1", False], timeout=HANGS)
    for key, row in tried(rows).items():
        before, value = view.inner_text("#command"), another_value(row)
        control = view.locator(f"#option-{key}")
        is_list = control.evaluate("(each) => each.tagName === 'SELECT'")
        is_flag = row["type"] == "flag"
        word = f"--{key}" if is_flag else shlex.quote(f"--{key}={value}")
        normal = "1" if key == "time" else ""
        for wanted, expected in ((value, word), (normal, before)):
            if is_flag:
                control.set_checked(wanted == "true")
            elif is_list:
                control.select_option(wanted or row["default"])
            else:
                control.fill(wanted)
                control.press("Tab")  # a field's text counts once it is left
            view.wait_for_function(COMMAND_HAS, arg=[expected, wanted == normal], timeout=HANGS)
            assert view.is_hidden("#error"), key


def test_mouse_keys_and_touch_move_the_camera(view, tmp_path):
    seen = [view.inner_text("#command")]

    def moved():
        check_as_command(view, tmp_path)
        command = view.inner_text("#command")
        assert command not in seen
        seen.append(command)

    view.mouse.move(150, 200)
    view.mouse.down()
    view.mouse.move(200, 220, steps=4)
    view.mouse.up()
    moved()
    view.mouse.wheel(0, -240)
    moved()
    view.focus("#picture")
    view.keyboard.press("ArrowLeft")
    moved()
    view.keyboard.press("Shift+ArrowUp")
    moved()


def test_cameras_are_selected_by_index(page, tmp_path):
    """Names that are numbers or equal do not select another camera."""
    names = ["1", "cam", "cam"]
    scene = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"name": name, "camera": 0} for name in names],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
    }
    (tmp_path / "scene.gltf").write_text(json.dumps(scene))
    server = Server(tmp_path, tmp_path / "scene.gltf")
    page.goto(server.url)
    settle(page)
    labels = page.eval_on_selector_all("#camera option", "(options) => options.map((each) => each.textContent)")
    assert labels == ["the scene's first", "1", "cam (#1)", "cam (#2)"]
    for index, word in enumerate(["--camera=1", "--camera=cam", "--camera=#2"]):
        page.select_option("#camera", index=index + 1)
        settle(page)
        assert word in shlex.split(page.inner_text("#command"))
        assert page.eval_on_selector("#camera", "(list) => list.selectedIndex") == index + 1
    server.end()


def test_a_second_button_ends_no_drag_and_begins_none(view):
    view.mouse.move(150, 200)
    view.mouse.down()
    view.mouse.down(button="right")
    view.mouse.move(190, 210)
    settle(view)
    dragged = view.inner_text("#command")
    assert "--eye" in dragged
    view.mouse.up()
    for act in (lambda: None, lambda: view.mouse.up(button="right")):
        act()
        view.mouse.move(230, 230)
        view.mouse.move(200, 220)
        settle(view)
        assert view.inner_text("#command") == dragged


def test_points_and_picks(view):
    view.mouse.move(210, 230)
    view.wait_for_selector("#probe dd")
    settle(view)
    assert "material" in view.inner_text("#probe")
    view.focus("#picture")
    view.keyboard.press("Enter")
    view.wait_for_selector("#selection dd")
    assert "node" in view.inner_text("#selected")
    view.keyboard.press("Escape")
    view.wait_for_selector("#selection", state="hidden")


def test_times_are_told_as_lines(view):
    view.click("summary:has-text('Device passes')")
    for times in (1, 2, 3):
        rows = view.locator("#passes tr").all()
        assert rows
        for row in rows:
            name, milliseconds = row.locator("td").all_inner_texts()[:2]
            assert name and float(milliseconds) >= 0
            points = row.locator("polyline").get_attribute("points").split()
            assert 1 <= len(points) <= times
            assert all(0 <= float(y) <= 48 for _, y in (point.split(",") for point in points))
        view.focus("#picture")
        view.keyboard.press("ArrowLeft")
        settle(view)
    assert len(rows[0].locator("polyline").get_attribute("points").split()) > 1
    view.locator("#passes").scroll_into_view_if_needed()
    screenshot(view, "passes")


def test_keys_point_at_pixels(view):
    view.focus("#picture")
    view.keyboard.press("p")
    view.wait_for_selector("#crosshair:visible")
    before = pixels(view)
    for key in ("Shift+ArrowLeft", "ArrowDown", "ArrowDown", "ArrowLeft"):
        view.keyboard.press(key)
    settle(view)
    height, width = before.shape[:2]
    view.get_by_text(f"{width // 2 - 11}, {height // 2 + 2}", exact=True).wait_for()
    assert numpy.array_equal(pixels(view), before), "the camera stays"
    cross, picture = view.locator("#crosshair").bounding_box(), view.locator("#picture").bounding_box()
    assert abs(cross["x"] + cross["width"] / 2 - picture["x"] - (width // 2 - 10.5)) < 1
    assert abs(cross["y"] + cross["height"] / 2 - picture["y"] - (height // 2 + 2.5)) < 1
    screenshot(view, "crosshair")
    shown = view.inner_text("#probe dt:has-text('node') + dd")
    view.keyboard.press("Enter")
    view.wait_for_selector("#selection dd")
    assert view.inner_text("#selected dt:has-text('node') + dd") == shown
    view.keyboard.press("Escape")
    view.wait_for_selector("#crosshair", state="hidden")
    view.keyboard.press("Escape")
    view.wait_for_selector("#selection", state="hidden")


# What Tab goes to; of radio buttons to the chosen one, from which arrows go on.
CONTROLS_OF_KEYS = """[...document.querySelectorAll("button, input, select, summary, [tabindex='0']")].filter(
  (each) => each.checkVisibility({ visibilityProperty: true }) && !each.disabled && (each.type !== "radio" || each.checked))"""


def test_tab_goes_to_every_control(view):
    open_options(view)
    view.select_option("#split", "slider")
    settle(view)
    wanted = view.evaluate(f"{CONTROLS_OF_KEYS}.map((each, i) => each.dataset.place = i).length")
    assert wanted > 70
    seen = []
    view.evaluate("document.activeElement.blur()")
    for _ in range(wanted):
        view.keyboard.press("Tab")
        seen.append(view.evaluate("document.activeElement.dataset.place"))
        assert view.evaluate("getComputedStyle(document.activeElement).outlineStyle !== 'none' || document.activeElement.id === 'divider'")
    assert sorted(map(int, seen)) == list(range(wanted))
    view.focus("[name=side][value=left]")
    view.keyboard.press("ArrowRight")
    assert view.is_checked("[name=side][value=right]")


def test_the_sun_is_moved(view):
    before = pixels(view)
    view.locator("#sun-elevation").fill("60")
    settle(view)
    assert "--sun=30,60" in view.inner_text("#command")
    assert numpy.abs(pixels(view) - before).mean() > 0.2
    view.click("#sun-off")
    settle(view)
    assert "--sun" not in view.inner_text("#command")


def triangle(**more):
    """A scene of glTF with one triangle; `more` replaces its keys."""
    corners = numpy.array([[-1, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(corners).decode()
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 1, 0]}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": uri}],
        **more,
    }


def test_lights_are_moved_by_their_handles(page, tmp_path):
    light = {"type": "point", "name": "lamp", "intensity": 20}
    scene = triangle(
        extensionsUsed=["KHR_lights_punctual"],
        extensions={"KHR_lights_punctual": {"lights": [light]}},
        scenes=[{"nodes": [0, 1]}],
        nodes=[{"mesh": 0}, {"translation": [0, 0.4, 0.5], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
    )
    (tmp_path / "scene.gltf").write_text(json.dumps(scene))
    server = Server(tmp_path, tmp_path / "scene.gltf")
    page.set_viewport_size({"width": 760, "height": 300})
    page.goto(server.url)
    settle(page)
    page.click("#lights")
    handle = page.locator(".handle:visible").first
    handle.wait_for()
    assert handle.get_attribute("aria-label") == "Light lamp, point"
    place = handle.bounding_box()
    handle.press("ArrowRight")
    page.wait_for_selector("#command-note:visible")
    settle(page)
    assert handle.bounding_box()["x"] == pytest.approx(place["x"] + 8, abs=0.1)
    handle.press("Shift+ArrowDown")
    page.wait_for_function("top => document.querySelector('.handle').getBoundingClientRect().y > top + 0.5", arg=place["y"])
    assert handle.bounding_box()["y"] == pytest.approx(place["y"] + 1, abs=0.1)
    assert faults(page) == []
    screenshot(page, "handles")
    page.close()
    server.end()


def panorama(width, height):
    """A Radiance picture: red above, blue below."""
    rows = [bytes((200, 20, 20, 130) if y < height / 2 else (20, 20, 200, 130)) * width for y in range(height)]
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + b"".join(rows)


def test_an_environment_is_sent(view, tmp_path):
    open_options(view)
    view.fill("#option-background", "hdri")
    view.keyboard.press("Tab")
    settle(view)
    before = pixels(view)
    (tmp_path / "sky.hdr").write_bytes(panorama(128, 64))
    view.set_input_files("#environment-file", tmp_path / "sky.hdr")
    view.wait_for_selector("#command:has-text('--hdri=sky.hdr')")
    settle(view)
    assert view.input_value("#environment") == "sky.hdr"
    assert numpy.abs(pixels(view) - before).mean() > 5
    (tmp_path / "sky.txt").write_text("no picture")
    view.set_input_files("#environment-file", tmp_path / "sky.txt")
    view.get_by_text("sky.txt is not a .hdr or .exr file").wait_for()


def drop(view, name, content):
    """Drops a file on the picture."""
    files = view.evaluate_handle(
        """([name, bytes]) => {
          const files = new DataTransfer();
          files.items.add(new File([new Uint8Array(bytes)], name));
          return files;
        }""", [name, list(content)])
    view.dispatch_event("#stage", "dragover", {"dataTransfer": files})
    view.dispatch_event("#stage", "drop", {"dataTransfer": files})


def test_an_environment_is_dropped(view):
    open_options(view)
    view.fill("#option-background", "hdri")
    view.keyboard.press("Tab")
    settle(view)
    before = pixels(view)
    drop(view, "DROPPED.HDR", panorama(64, 32))
    view.wait_for_selector("#command:has-text('--hdri=DROPPED.HDR')")
    settle(view)
    assert view.input_value("#environment") == "DROPPED.HDR"
    assert numpy.abs(pixels(view) - before).mean() > 5
    drop(view, "scene.glb", b"glTF")
    view.get_by_text("scene.glb is not a .hdr or .exr file").wait_for()


def test_a_sent_environment_does_not_replace_the_servers_own(page, tmp_path, monkeypatch):
    (tmp_path / "sky.hdr").write_bytes(panorama(64, 32))
    monkeypatch.chdir(tmp_path)
    server = Server(tmp_path, options=("--validate", "--hdri", "sky.hdr", "--background", "hdri"))
    page.set_viewport_size({"width": 760, "height": 300})
    page.goto(server.url)
    settle(page)
    before = pixels(page)
    green = panorama(64, 32).replace(bytes((200, 20, 20, 130)), bytes((20, 200, 20, 130)))
    drop(page, "sky.hdr", green)
    page.wait_for_selector("#command:has-text('--hdri=sent-sky.hdr')")
    settle(page)
    assert page.input_value("#environment") == "sent-sky.hdr"
    assert numpy.abs(pixels(page) - before).mean() > 5
    page.select_option("#environment", "sky.hdr")
    page.wait_for_selector("#command:has-text('--hdri=sky.hdr')")
    settle(page)
    assert numpy.abs(pixels(page) - before).mean() < 2
    page.select_option("#environment", "sent-sky.hdr")
    page.wait_for_selector("#command:has-text('--hdri=sent-sky.hdr')")
    settle(page)
    assert numpy.abs(pixels(page) - before).mean() > 5
    page.close()
    server.end()


def test_a_split_shows_two_choices(view, tmp_path):
    left = pixels(view)
    view.select_option("#split", "slider")
    settle(view)
    view.check("[name=side][value=right]")
    view.select_option("#output", "normal")
    settle(view)
    both, middle = pixels(view), left.shape[1] // 2
    assert numpy.abs(both[:, : middle - 8] - left[:, : middle - 8]).mean() < 3
    assert numpy.abs(both[:, middle + 8 :] - left[:, middle + 8 :]).mean() > 10
    assert "--debug=normal" in view.inner_text("#command")
    view.focus("#divider")
    view.keyboard.press("ArrowRight")
    view.wait_for_selector("#divider[aria-valuenow='52']")
    view.focus("#picture")
    for key in ("[", "[", "]", "["):
        view.keyboard.press(key)
    view.wait_for_selector("#divider[aria-valuenow='48']")
    view.select_option("#split", "difference")
    settle(view)
    assert view.is_visible("#amplification")


# Keeps the page's sockets in `sockets`, so that tests can close them, and closes the next `unlucky` ones when their
# second message arrives, the first one with the state of the session.
KEEP_SOCKETS = """window.sockets = [];
window.unlucky = 0;
window.WebSocket = class extends WebSocket {
  constructor(address) {
    super(address);
    sockets.push(this);
    let messages = 0;
    if (unlucky-- > 0) this.addEventListener("message", () => ++messages === 2 && this.close());
  }
};"""


def reconnect(page, unlucky=0):
    """Closes the page's connection and as many after it, and returns after the next session has executed all that the
    page sent."""
    count = page.evaluate("unlucky => (window.unlucky = unlucky, sockets.at(-1).close(), sockets.length)", unlucky)
    page.wait_for_function(
        "count => sockets.length > count && !document.getElementById('status').innerText.startsWith('Not connected')",
        arg=count + unlucky,
    )
    settle(page)


def commands(page):
    """Those of both sides of a comparison."""
    both = []
    for side in ("right", "left"):
        page.check(f"[name=side][value={side}]")
        settle(page)
        both.append(page.inner_text("#command"))
    return both


def test_a_reconnected_page_restores_its_options(page, tmp_path):
    primitive = {
        "attributes": {"POSITION": 0},
        "material": 0,
        "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}},
    }
    scene = triangle(
        extensionsUsed=["KHR_materials_variants"],
        extensions={"KHR_materials_variants": {"variants": [{"name": "other"}]}},
        meshes=[{"primitives": [primitive]}],
        materials=[{}, {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
    )
    (tmp_path / "scene.gltf").write_text(json.dumps(scene))
    options = ("--validate", "--sun=30,40", "--variant=other", "--shadows=rays", "--hdri=none")
    server = Server(tmp_path, tmp_path / "scene.gltf", options)
    page.add_init_script(KEEP_SOCKETS)
    page.set_viewport_size({"width": 760, "height": 300})
    page.goto(server.url)
    settle(page)
    open_options(page)
    page.click("#sun-off")
    page.select_option("#variant", "")
    page.select_option("#environment", "studio")
    page.fill("#option-background", "hdri")  # which conflicts with --hdri=none of the command line
    page.press("#option-background", "Enter")
    page.select_option("#option-shadows", "d32")
    page.select_option("#option-lighting", "forward")  # which conflicts with --shadows=rays of the command line
    page.select_option("#split", "slider")
    page.select_option("#option-shadows", "none")
    settle(page)
    right, left = commands(page)
    for word in ("--lighting=forward", "--background=hdri", "--hdri=studio"):
        assert word in right
    for word in ("--sun", "--variant", "--shadows"):
        assert word not in right
    assert left == right.replace("--lighting=forward", "--lighting=forward --shadows=none")
    for unlucky in 0, 2:
        reconnect(page, unlucky)
        assert commands(page) == [right, left]
        assert page.input_value("#split") == "slider"
        assert page.is_hidden("#error")
    page.close()
    server.end()


def test_the_time_slider_moves_both_sides(page, tmp_path):
    values = numpy.array([0, 2, *[-1, 0, 0, 1, 0, 0, 0, 1, 0], *[0, 0, 0, 0.5, 0, 0]], "<f4").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(values).decode()
    sampler = {"input": 1, "output": 2}
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    scene = triangle(
        animations=[{"samplers": [sampler], "channels": [channel]}],
        accessors=[
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [2]},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
        ],
        bufferViews=[
            {"buffer": 0, "byteLength": 8},
            {"buffer": 0, "byteOffset": 8, "byteLength": 36},
            {"buffer": 0, "byteOffset": 44, "byteLength": 24},
        ],
        buffers=[{"byteLength": 68, "uri": uri}],
    )
    (tmp_path / "scene.gltf").write_text(json.dumps(scene))
    server = Server(tmp_path, tmp_path / "scene.gltf")
    page.set_viewport_size({"width": 760, "height": 300})
    page.goto(server.url)
    settle(page)
    page.select_option("#split", "slider")
    settle(page)
    for time in ("1.5", "0.5"):
        page.locator("#time").fill(time)
        settle(page)
        for command in commands(page):
            assert f"--time={time}" in command
    page.close()
    server.end()


def test_downloads_what_the_command_writes(view, tmp_path):
    with view.expect_download() as download:
        view.click("#screenshot")
    file, _ = rendered(view, tmp_path)
    assert download.value.path().read_bytes() == file


def test_errors_are_sentences(view):
    open_options(view)
    view.fill("#option-background", "nothing")
    view.keyboard.press("Tab")
    view.wait_for_selector("#error:visible")
    assert "--background" in view.inner_text("#error")


def test_nothing_leaves_the_page(context, page, server):
    asked = []
    context.on("request", lambda request: asked.append(request.url))
    page.goto(server.url)
    settle(page)
    assert asked and all(address.startswith((server.url, "blob:")) for address in asked)


@pytest.mark.parametrize("size", SIZES)
def test_is_accessible(chromium, server, size):
    width, height = SIZES[size]
    context = chromium.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce")
    context.set_default_timeout(HANGS)
    page = context.new_page()
    page.goto(server.url)
    settle(page)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        screenshot(page, f"{size}-{scheme}-begin")
    if page.get_attribute("#panel-toggle", "aria-expanded") == "false":
        page.click("#panel-toggle")
    open_options(page)
    if size != "large":  # which takes long on a CPU, and shows nothing else
        page.select_option("#split", "slider")
        settle(page)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        screenshot(page, f"{size}-{scheme}")
        assert faults(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    context.close()


def test_a_killed_browser_ends_its_session(server):
    before = server.log.read_text().count("has left")
    script = (
        "import sys; from playwright.sync_api import sync_playwright\n"
        "with sync_playwright() as playwright:\n"
        "    browser = playwright.chromium.launch(executable_path='/usr/bin/chromium')\n"
        "    page = browser.new_page(); page.goto(sys.argv[1]); page.wait_for_selector('#stage[aria-busy=false]', timeout=0)\n"
        "    print('ready', flush=True); page.wait_for_timeout(600000)\n"
    )
    child = subprocess.Popen(
        [os.sys.executable, "-c", script, server.url], stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    assert child.stdout.readline() == "ready\n"
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    until = time.monotonic() + 60
    while server.log.read_text().count("has left") <= before:
        assert time.monotonic() < until
        time.sleep(0.1)


def test_a_lost_device_is_a_sentence(context, tmp_path):
    layer = {
        "VK_LAYER_PATH": os.environ["LATELIGHT_LOST_DEVICE"],
        "VK_INSTANCE_LAYERS": "VK_LAYER_LATELIGHT_lose_device",
        "LATELIGHT_LOSE_SUBMISSION": "1",
    }
    server = Server(tmp_path, SCENE, (), **layer)
    unlucky, other = context.new_page(), context.new_page()
    for page in (unlucky, other):
        page.set_viewport_size({"width": 760, "height": 300})
        page.goto(server.url)
        settle(page)
    assert "The device was lost" in unlucky.inner_text("#error")
    assert unlucky.is_hidden("#waiting")
    assert other.is_hidden("#error")
    for page in (unlucky, other):
        page.bring_to_front()
        page.focus("#picture")
        page.keyboard.press("ArrowLeft")
        check_as_command(page, tmp_path)
        assert page.is_hidden("#error")
    server.end()


def test_a_taken_port_is_one_sentence():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        _, error = latelight("serve", SCENE, "--port", port, code=2)
    assert error == (
        f"latelight: port {port} of 127.0.0.1 is in use; choose another with --port, or any free one with --port 0\n"
    )


def test_ctrl_c_ends_it_while_pages_are_open(chromium, tmp_path):
    server = Server(tmp_path)
    page = chromium.new_page()
    page.set_default_timeout(HANGS)
    page.goto(server.url)
    settle(page)
    server.end(by=signal.SIGINT)
    page.get_by_text("the server was stopped").wait_for()
    page.close()
    assert server.url.split("/")[3] not in server.log.read_text()
