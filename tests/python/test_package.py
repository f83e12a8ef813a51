"""The package itself: its type stub, its public names, and what is installed of it."""

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


def interface(*arguments):
    return subprocess.run([sys.executable, ROOT / "scripts/interface", *arguments], capture_output=True, text=True)


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


def test_nothing_public_was_removed_since_the_last_release(tmp_path):
    """The record is one of this minor version; a minor version has none until its first release."""
    minor = latelight.__version__.rsplit(".", 1)[0]
    records = sorted((ROOT / "tests/interface").glob(f"python-{minor}.*.txt"), key=lambda path: int(path.stem.split(".")[-1]))
    if not records:
        pytest.skip(f"there is no release of {minor} yet")
    now = tmp_path / "now.txt"
    now.write_text(interface("--python", PACKAGE).stdout)
    compared = interface("--compare", records[-1], now)
    assert compared.returncode == 0, compared.stdout


def test_removed_names_and_new_requirements_are_reported(tmp_path):
    before = "__all__ = ['scan']\nfrom .lidar import scan\n"
    folders = []
    for signature in ("(scene, rays=1, *, noise=0)", "(scene, rays=1, *, beam)", "(scene, rays=1, *, noise=0, seed=0)"):
        folder = tmp_path / str(len(folders))
        folder.mkdir()
        (folder / "__init__.py").write_text(before)
        (folder / "lidar.py").write_text(f"def scan{signature}:\n    pass\n")
        (folder / "text").write_text(interface("--python", folder).stdout)
        folders.append(folder / "text")
    whole, changed, extended = folders
    compared = interface("--compare", whole, changed)
    assert compared.returncode == 1
    assert compared.stdout.splitlines() == [
        "  missing: latelight.scan: keyword noise, optional",
        "  newly required: latelight.scan: keyword beam, required",
    ]
    assert interface("--compare", whole, extended).returncode == 0


def test_names_from_modules_in_folders_are_part_of_the_interface(tmp_path):
    (tmp_path / "__init__.py").write_text("__all__ = ['scan']\nfrom ._sensors.lidar import scan\n")
    (tmp_path / "_sensors").mkdir()
    (tmp_path / "_sensors" / "lidar.py").write_text("def scan(scene):\n    pass\n")
    lines = interface("--python", tmp_path).stdout.splitlines()
    assert lines == ["latelight.scan", "latelight.scan: parameter 0 scene, required"]


def test_modules_of_usd_import_only_from_those_listed_above():
    folder = PACKAGE / "_usd"
    page = ast.get_docstring(ast.parse((folder / "__init__.py").read_text()))
    order = re.findall(r"^ +(\w+)  ", page, re.MULTILINE)
    assert sorted(order) == sorted(path.stem for path in folder.glob("*.py") if path.stem != "__init__")
    for place, name in enumerate(order):
        tree = ast.parse((folder / f"{name}.py").read_text())
        nodes = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level == 1]
        imported = {item for node in nodes for item in ([node.module] if node.module else [a.name for a in node.names])}
        assert imported <= set(order[:place]), name


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
    for source in (ROOT / "python" / "latelight").rglob("*.py"):
        target = moved / "latelight" / source.relative_to(ROOT / "python" / "latelight")
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(source.read_bytes())
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
