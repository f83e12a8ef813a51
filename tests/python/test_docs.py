"""The code of README.md, of the examples and of the pages below, run as it stands."""

import importlib.util
import json
import re
import runpy
import shutil
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import latelight
from test_worlds import finger

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
    # Built-in scenes have Y up: an eye 1.7 m above the hall's floor, whose images have the floor below their center.
    assert names["eye"].camera_to_world[1, 3] - latelight.Scene("builtin:hall").bounds[0][1] == pytest.approx(1.7, abs=0.01)
    assert (names["frames"]["depth"][:, -1].max(axis=1) < 5).all() and (names["frames"]["depth"][:, 60] > 5).any()
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
    assert names["world_labels"].amodal_masks.shape[:2] == names["world_keypoints"].visibility.shape[:2] == (3, 1)
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


def test_worlds_in_flight():
    names = run_all(blocks(ROOT / "docs" / "worlds.md")[:2], "worlds.md")
    last = np.from_dlpack(names["waiting"].take()["rgba"])
    expected = names["renderer"].render_worlds(
        3, names["scene"].default_camera(), (64, 64), "rgba", instances=names["moved"], transforms=names["transforms"])
    np.testing.assert_array_equal(last, expected["rgba"])


def test_rays_in_worlds():
    names = run_all(blocks(ROOT / "docs" / "worlds.md")[:4], "worlds.md")
    assert names["frames"]["rgba"].shape == (3, 1, 64, 64, 4)
    assert names["hits"]["distance"].shape == (3, 64) and np.isfinite(names["hits"]["distance"]).any()
    in_flight = blocks(ROOT / "docs" / "worlds.md")[4]
    run_all([in_flight], "worlds.md", **names)
    last = run_all([in_flight], "worlds.md", **names)["waiting"].take()["distance"]
    arrays = {"instances": names["moved"], "transforms": names["transforms"], "exists": names["exists"]}
    expected = names["renderer"].cast_worlds(3, names["origins"], names["directions"], outputs="distance", **arrays)
    np.testing.assert_array_equal(last, expected["distance"])


def test_joints_of_worlds(tmp_path, monkeypatch):
    finger(tmp_path / "figure.gltf")
    monkeypatch.chdir(tmp_path)
    poses = np.tile(np.eye(4), (2, 2, 1, 1))
    poses[:, 1, :2, 3] = ((0, 1), (0.3, 1))
    source = blocks(ROOT / "docs" / "worlds.md")[5]
    frames = run_all([f"import latelight\n{source}"], "worlds.md", poses=poses)["frames"]
    assert (frames[0][0]["rgba"] != frames[1][0]["rgba"]).any()


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
    of_mujoco = blocks(ROOT / "docs" / "worlds.md")[6]
    frames = run_all([f"import latelight\n{of_mujoco}"], "worlds.md", states=states, model=model)
    assert (frames["frames"][0][0]["rgba"] != frames["frames"][1][0]["rgba"]).any()


def test_the_notebook():
    cells = json.loads((EXAMPLES / "notebook.ipynb").read_text())["cells"]
    names = run_all(["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"], "notebook.ipynb")
    assert names["shown"].node
    np.testing.assert_allclose(names["transform"][:3, 3], (-3.25, 1.5, -1.25), atol=1e-6)  # 0.5 m above its position


def run_example(name, *arguments, cwd):
    return subprocess.run(
        [sys.executable, EXAMPLES / name, *map(str, arguments)], cwd=cwd, check=True, capture_output=True, text=True
    ).stdout


def test_dataset(tmp_path):
    run_example("dataset.py", "builtin:boxes", "out", 3, cwd=tmp_path)
    assert len(list((tmp_path / "out").glob("*.png"))) == 3
    assert len(json.loads((tmp_path / "out" / "cameras.json").read_text())) == 3


@pytest.fixture
def triangle(tmp_path):
    """A right triangle in the plane z = 0 of glTF's frame, 1 m wide and high, white."""
    (tmp_path / "triangle.obj").write_text("v -0.5 -0.5 0\nv 0.5 -0.5 0\nv -0.5 0.5 0\nf 1 2 3\n")
    return "triangle.obj"


def test_objaverse_views(tmp_path):
    """The matrix of each view projects a tetrahedron's corners, in Blender's world, to where the image shows them."""
    (tmp_path / "corner.obj").write_text(
        "v -0.5 -0.5 -0.5\nv 0.5 -0.5 -0.5\nv -0.5 0.5 -0.5\nv -0.5 -0.5 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    run_example(
        "objaverse_views.py", "--", "--object_path", "corner.obj", "--output_dir", "shell", "--num_renders", 3, cwd=tmp_path)
    corners = np.array([[-0.5, 0.5, -0.5, 1], [0.5, 0.5, -0.5, 1], [-0.5, 0.5, 0.5, 1], [-0.5, -0.5, -0.5, 1]])
    for number in range(3):
        matrix = np.load(tmp_path / "shell" / f"{number:03}.npy")
        points = corners @ matrix.T
        x, y = (256 + sign * 512 * 35 / 32 * points[:, i] / -points[:, 2] for i, sign in [(0, 1), (1, -1)])
        alpha = np.array(Image.open(tmp_path / "shell" / f"{number:03}.png"))[..., 3]
        rows, columns = np.nonzero(alpha)
        np.testing.assert_allclose([columns.min(), columns.max() + 1, rows.min(), rows.max() + 1],
                                   [x.min(), x.max(), y.min(), y.max()], atol=3)
    metadata = json.loads((tmp_path / "shell" / "metadata.json").read_text())
    assert metadata["poly_count"] == 4
    low, high = corners[:, :3].min(0).tolist(), corners[:, :3].max(0).tolist()
    assert metadata["scene_size"] == {"bbox_min": low, "bbox_max": high}
    run_example("objaverse_views.py", "--object_path", "corner.obj", "--output_dir", "ring", "--num_images", 4, cwd=tmp_path)
    assert sorted(path.name for path in (tmp_path / "ring" / "corner").iterdir()) == [f"{i:03}.png" for i in range(4)]


def test_examples_name_what_is_wrong(tmp_path):
    (tmp_path / "bad.yaml").write_text("a: 1")
    cases = [
        (3, "The scene file none.glb does not exist", "objaverse_views.py", "--object_path", "none.glb"),
        (2, "must be at least 1", "objaverse_views.py", "--object_path", "none.glb", "--num_renders", "0"),
    ]
    if importlib.util.find_spec("yaml"):
        cases += [
            (2, "cannot be read: No such file", "blenderproc_yaml.py", "none.yaml"),
            (2, "must have a list of modules", "blenderproc_yaml.py", "bad.yaml"),
        ]
    else:
        cases.append((2, "requires the package PyYAML", "blenderproc_yaml.py", "bad.yaml"))
    for exit_code, words, name, *arguments in cases:
        program = [sys.executable, str(EXAMPLES / name), *arguments]
        done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == exit_code and words in done.stderr and "Traceback" not in done.stderr, done.stderr


BLENDERPROC = """
modules:
- module: main.Initializer
  config: {global: {output_dir: "<args:1>"}}
- module: loader.ObjectLoader
  config: {path: "<args:0>"}
- module: lighting.LightLoader
  config: {lights: [{type: POINT, location: [0, -2, 0], energy: 100}]}
- module: camera.CameraLoader
  config:
    cam_poses:
    - {location: [0, -2, 0], rotation: {value: [1.5707963, 0, 0]}}
    - {location: [0.5, -3, 0.25], rotation: {format: look_at, value: [0, 0, 0]}}
    intrinsics: {cam_K: [64, 0, 31.5, 0, 64, 31.5, 0, 0, 1], resolution_x: 64, resolution_y: 64}
- module: renderer.RgbRenderer
  config: {render_depth: true, render_normals: true}
- module: renderer.SegMapRenderer
  config: {map_by: [instance, class]}
- module: writer.Hdf5Writer
"""


def test_blenderproc_yaml(tmp_path, triangle):
    pytest.importorskip("yaml", reason="the package pyyaml is not installed")
    h5py = pytest.importorskip("h5py", reason="the package h5py is not installed")
    (tmp_path / "config.yaml").write_text(BLENDERPROC)
    run_example("blenderproc_yaml.py", "config.yaml", triangle, "out", cwd=tmp_path)
    with h5py.File(tmp_path / "out" / "0.hdf5") as file:
        assert set(file) == {"colors", "depth", "normals", "instance_segmaps", "category_id_segmaps",
                             "instance_attribute_maps", "campose"}
        inside = file["instance_segmaps"][()] == 1
        # The legs of the triangle are 32 pixels long at a distance of 2 m.
        assert abs(inside.sum() - 32 * 32 / 2) < 20 and inside[47, 16] and not inside[17, 40]
        np.testing.assert_allclose(file["depth"][()][inside], 2, rtol=1e-6)
        np.testing.assert_allclose(file["normals"][()][inside], np.tile([0.5, 0.5, 1], (inside.sum(), 1)), atol=1e-6)
        # 100 W / (4 pi) per steradian at 2 m, on a white surface that faces the light: 0.63 before tone mapping.
        assert file["colors"][()][31, 25].min() > 128
        pose = np.array(json.loads(np.array(file["campose"]).tobytes())[0]["cam2world_matrix"])
        np.testing.assert_allclose(pose, [[1, 0, 0, 0], [0, 0, -1, -2], [0, 1, 0, 0], [0, 0, 0, 1]], atol=1e-6)


def test_reinforcement(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["reinforcement.py", "2", "16"])
    names = runpy.run_path(str(EXAMPLES / "reinforcement.py"))
    assert capsys.readouterr().out.count("views/s") == 2
    poses = np.array([camera.camera_to_world for camera in names["cameras"]()])
    np.testing.assert_allclose(poses[:, 1, 3], 1.7, atol=0.01, err_msg="eyes above the floor")
    np.testing.assert_allclose(poses[:, :3, 1], np.tile([0, -1, 0], (16, 1)), atol=1e-6, err_msg="upright images")


def test_cartpole(tmp_path):
    first, second = (run_example("cartpole.py", 2, 8, cwd=tmp_path) for _ in range(2))
    assert first == second, "the same run twice gives the same images"
    assert first.count("steps, images") == 2


def test_walkers(tmp_path):
    pytest.importorskip("mujoco")
    first, second = (run_example("walkers.py", 20, 4, cwd=tmp_path) for _ in range(2))
    assert first == second, "the same run twice gives the same images"
    steps = [line.split() for line in first.splitlines()]
    walked, images = [float(words[2]) for words in steps], [words[-1] for words in steps]
    assert walked[-1] > 0.2 and len(set(images)) == 20


def test_ray_views(tmp_path):
    pytest.importorskip("ray", reason="ray is not installed")
    assert run_example("ray_views.py", "builtin:boxes", "out", 70, cwd=tmp_path).splitlines()[-1] == "70 of 70 views"
    assert len(list((tmp_path / "out").glob("*.npz"))) == 70
    (tmp_path / "out" / "000003.npz").unlink()
    assert run_example("ray_views.py", "builtin:boxes", "out", 70, cwd=tmp_path) == "1 of 1 views\n"


def test_lidar_example(tmp_path):
    for sensor in ("vlp-16", "mid-40"):
        run_example("lidar.py", sensor, "--sensor", sensor, "--scans", 2, "--device", "cpu", cwd=tmp_path)
        assert sorted(path.name for path in (tmp_path / sensor).iterdir()) == ["0000.pcd", "0001.pcd", "range.png"]


def test_turntable(tmp_path):
    if not shutil.which("ffmpeg"):
        pytest.skip("ffmpeg is not installed")
    run_example("turntable.py", "builtin:boxes", "video.mp4", 5, cwd=tmp_path)
    assert (tmp_path / "video.mp4").stat().st_size > 1000
