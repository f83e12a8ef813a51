"""The code of README.md, of the examples and of the pages below, run as it stands."""

import json
import re
import shutil
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples" / "python"


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


def run_all(sources, name, **given):
    """One after the other, in one module, which forked processes find by its name."""
    module = types.ModuleType(name)
    module.__dict__.update(given)
    sys.modules[name] = module
    for number, source in enumerate(sources):
        exec(compile(source, f"{name}, block {number + 1}", "exec"), module.__dict__)
    return module.__dict__


def test_the_page_of_sensors(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = run_all(blocks(ROOT / "docs" / "lidar.md"), "lidar")
    assert len(names["scan"]) > 10_000 and (tmp_path / "scan.pcd").stat().st_size > 10_000
    assert len(names["own"].rings) == 3 * 1000
    assert (names["frame"].depth > 0).any()


def test_the_tutorial(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = ROOT / "docs" / "python.md"
    names = run_all(blocks(page), page.stem)
    assert (tmp_path / "hall.png").read_bytes().startswith(b"\x89PNG")
    assert names["frames"]["depth"].shape == (3, 120, 160)
    assert (names["before"]["rgba"] != names["after"]["rgba"]).any()
    assert names["made"].textures() != [] and names["screen"] not in names["made"].textures()
    for index, depth in enumerate(names["depths"]):
        np.testing.assert_array_equal(depth, names["views"][index], "what a worker renders")
    with names["multiprocessing"].get_context("fork").Pool(2) as workers:  # now that this process has a renderer, too
        np.testing.assert_array_equal(workers.map(names["view"], range(4)), names["depths"])
    printed = capsys.readouterr().out.splitlines()
    said = re.findall(r"print\(.*\) +# (.*)", page.read_text())
    assert len(said) == 4
    for words in said:
        assert any(line and words.startswith(line) for line in printed), words


def test_the_readme(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (source,) = blocks(ROOT / "README.md")
    frame = run_all([source], "README.md")["frame"]
    assert frame["depth"].shape == (480, 640)


def test_labels():
    names = run_all(blocks(ROOT / "docs" / "labels.md"), "labels.md")
    labels, keypoints, match = names["labels"], names["keypoints"], names["match"]
    assert len(labels.nodes) > 1 and labels.amodal_masks.shape == (len(labels.nodes), 240, 320)
    assert keypoints.pixels.shape == (2, 2) and np.isfinite(keypoints.pixels).all()
    assert match.pixels.shape == (240, 320, 2) and match.visible.any() and not match.visible.all()


def test_embedding(tmp_path, monkeypatch, capsys):
    (source,) = blocks(ROOT / "docs" / "embed.md")
    frame = run_all([source], "embed.md")["frame"]
    assert capsys.readouterr().out == f"(180, 320, 4) {frame['depth'][90, 160]:.2f} m\n"


def test_worlds():
    source = blocks(ROOT / "docs" / "worlds.md")[0]
    frames = run_all([source], "worlds.md")["frames"]
    assert frames["depth"].shape == (3, 2, 64, 64)
    assert (frames[0][0]["depth"] != frames[1][0]["depth"]).any()
    assert len(np.setdiff1d(frames[1][0]["id"], frames[2][0]["id"])) == 1  # the second box is not in the last world


def test_worlds_of_mujoco():
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><light pos="0 0 3"/><camera name="eye" pos="0 0 3"/>
        <body><freejoint/><geom size="0.2"/></body></worldbody></mujoco>"""
    )
    states = [mujoco.MjData(model) for _ in range(2)]
    states[1].qpos[0] = 0.5
    for state in states:
        mujoco.mj_forward(model, state)
    of_mujoco = blocks(ROOT / "docs" / "worlds.md")[1]
    frames = run_all([f"import latelight\n{of_mujoco}"], "worlds.md", states=states, model=model)
    assert (frames["frames"][0][0]["rgba"] != frames["frames"][1][0]["rgba"]).any()


def test_the_notebook():
    cells = json.loads((EXAMPLES / "notebook.ipynb").read_text())["cells"]
    names = run_all(["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"], "notebook.ipynb")
    assert names["shown"].node


def run_example(name, *arguments, cwd):
    return subprocess.run(
        [sys.executable, EXAMPLES / name, *map(str, arguments)], cwd=cwd, check=True, capture_output=True, text=True
    ).stdout


def test_dataset(tmp_path):
    run_example("dataset.py", "builtin:boxes", "out", 3, cwd=tmp_path)
    assert len(list((tmp_path / "out").glob("*.png"))) == 3
    assert len(json.loads((tmp_path / "out" / "cameras.json").read_text())) == 3


def test_reinforcement(tmp_path):
    assert run_example("reinforcement.py", 2, 16, cwd=tmp_path).count("views/s") == 2


def test_cartpole(tmp_path):
    first, second = (run_example("cartpole.py", 2, 8, cwd=tmp_path) for _ in range(2))
    assert first == second, "the same run twice gives the same images"
    assert first.count("steps, images") == 2


def test_ray_views(tmp_path):
    pytest.importorskip("ray", reason="ray is not installed")
    assert run_example("ray_views.py", "builtin:boxes", "out", 70, cwd=tmp_path).splitlines()[-1] == "70 of 70 views"
    assert len(list((tmp_path / "out").glob("*.npz"))) == 70
    (tmp_path / "out" / "000003.npz").unlink()
    assert run_example("ray_views.py", "builtin:boxes", "out", 70, cwd=tmp_path) == "1 of 1 views\n"


def test_turntable(tmp_path):
    if not shutil.which("ffmpeg"):
        pytest.skip("ffmpeg is not installed")
    run_example("turntable.py", "builtin:boxes", "video.mp4", 5, cwd=tmp_path)
    assert (tmp_path / "video.mp4").stat().st_size > 1000
