"""The package itself: its type stub, and what is installed of it."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import latelight

ROOT = Path(__file__).parents[2]
PACKAGE = Path(latelight.__file__).parent


def stub_classes():
    tree = ast.parse((PACKAGE / "_core.pyi").read_text())
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def methods(name, method):
    return [node for node in stub_classes()[name].body if isinstance(node, ast.FunctionDef) and node.name == method]


def members_of_options_def():
    text = (ROOT / "include/latelight/options.def").read_text().split("\nOPTION_GROUP(", 1)[1]
    plain = r"OPTION_(?:FLAG|ANGLE|SUN|EXPOSURE)\((\w+),"
    typed = r"OPTION_(?:NUMBER|OPTIONAL|CHOICE|ENTRY|TEXT)\([\w:]+, (\w+),"
    return re.findall(plain, text) + re.findall(typed, text)


@pytest.mark.parametrize(
    "method, count, own",
    [("render", 3, {"on_device", "out"}), ("submit", 1, {"on_device", "out"}), ("pick", 1, set())],
)
def test_the_stub_has_every_option(method, count, own):
    expected = {re.sub("([A-Z])", r"_\1", member).lower() for member in members_of_options_def()}
    assert len(expected) > 40
    found = methods("Renderer", method)
    assert len(found) == count
    for function in found:
        keywords = {argument.arg for argument in function.args.kwonlyargs}
        beside = {"previous_cameras", "next_cameras", "continues", "formats", "channels_first"}
        assert keywords == expected | beside | own


def test_the_stub_knows_the_names_that_options_take():
    (submit,) = methods("Renderer", "submit")
    types = {argument.arg: ast.unparse(argument.annotation) for argument in submit.args.kwonlyargs}
    assert types["tonemap"] == "Literal['khronos', 'aces', 'agx', 'reinhard', 'none']"
    assert types["exposure"] == "float | str"
    assert types["bloom"] == "float"
    assert types["anisotropy"] == "int | None"
    assert types["loop"] == "bool"


def test_everything_public_is_documented():
    for name in latelight.__all__:
        if not name.startswith("_"):
            assert getattr(latelight, name).__doc__, name
    assert (PACKAGE / "py.typed").exists()


def test_what_is_installed_needs_no_build_folder(tmp_path):
    build = os.environ.get("LATELIGHT_BUILD")
    if not build:
        pytest.skip("LATELIGHT_BUILD names no build folder to install from")
    subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", tmp_path / "made"], check=True)
    moved = (tmp_path / "made").rename(tmp_path / "moved")
    for source in (ROOT / "python" / "latelight").glob("*.py"):
        (moved / "latelight" / source.name).write_bytes(source.read_bytes())
    program = (
        "import latelight; scene = latelight.Scene('builtin:boxes')\n"
        "print(latelight.Renderer(scene, 'cpu').render(scene.default_camera(), (8, 8))['rgba'].shape)\n"
        "print(*[line.split()[-1] for line in open('/proc/self/maps') if 'liblatelight' in line])"
    )
    environment = {**os.environ, "PYTHONPATH": str(moved), "LATELIGHT_VALIDATION": "0"}
    run = subprocess.run(
        [sys.executable, "-c", program], env=environment, cwd="/", check=True, capture_output=True, text=True
    )
    shape, libraries = run.stdout.splitlines()
    assert shape == "(8, 8, 4)"
    assert {Path(library).parent for library in libraries.split()} == {moved / "latelight"}
