"""Data sets read by the programs whose formats they are: nerfstudio's data parser and BlenderProc's `vis hdf5`.

Neither is installed for every test, because they require PyTorch; docs/formats.md states the versions that read the
sets. LeRobot is in test_lerobot.py."""

import json
import os
import shutil
import subprocess

import numpy as np
import pytest

LENSES = {
    "pinhole": {"fov": 50},
    "opencv": {"model": "opencv", "K": [[90, 0, 50], [0, 91, 35], [0, 0, 1]], "distortion": [-0.2, 0.05, 0.001, -0.002]},
    "fisheye": {"model": "fisheye", "K": [[40, 0, 48], [0, 41, 32], [0, 0, 1]], "distortion": [-0.02, 0.005, 0.001]},
    "equirectangular": {"model": "equirectangular"},
}


def batch(folder, lens):
    views = [{"eye": [3, 2, 6], "target": [0, 1, 0]}, {"eye": [-4, 1, 5], "target": [0, 1, 0]}]
    hdf5 = [{"format": "hdf5", "keys": ["colors", "depth", "normals", "instance_segmaps", "forward_flow"]}]
    job = {
        "scenes": "builtin:boxes",
        "output": "set",
        "cameras": {"type": "list", "cameras": views, **LENSES[lens]},
        "formats": [
            {"format": "transforms", "points": 8 if lens == "pinhole" else 0},
            {"format": "files", "outputs": ["position", "distance"], "pattern": "raw/{name}.npy", "side-file": False},
            *(hdf5 if lens == "pinhole" else []),
        ],
        "options": {"size": "96x64", "axes": "z-up"},
    }
    (folder / "job.json").write_text(json.dumps(job))
    program = [os.environ["LATELIGHT_PROGRAM"], "batch", "job.json", "--devices", "cpu"]
    subprocess.run(program, cwd=folder, check=True, capture_output=True)
    return folder / "set"


@pytest.mark.parametrize("lens", LENSES)
def test_nerfstudio(tmp_path, lens):
    """nerfstudio's rays times the rendered distance are the rendered positions, through each lens."""
    parser = pytest.importorskip(
        "nerfstudio.data.dataparsers.nerfstudio_dataparser", reason="the package nerfstudio is not installed"
    )
    torch = pytest.importorskip("torch")
    folder = batch(tmp_path, lens)
    config = parser.NerfstudioDataParserConfig(
        data=folder,
        orientation_method="none",
        center_method="none",
        auto_scale_poses=False,
        eval_mode="all",
        load_3D_points=True,
    )
    outputs = config.setup().get_dataparser_outputs("train")
    assert [path.name for path in outputs.image_filenames] == ["000000.png", "000001.png"]
    assert all(path.is_file() for path in outputs.image_filenames + outputs.metadata["depth_filenames"])
    x, y = np.meshgrid(np.arange(96) + 0.5, np.arange(64) + 0.5)
    coordinates = torch.tensor(np.stack([y, x], axis=-1), dtype=torch.float32)
    for i in range(2):
        rays = outputs.cameras.generate_rays(camera_indices=i, coords=coordinates)
        distance = np.load(folder / f"raw/00000{i}.distance.npy").reshape(64, 96)
        position = np.load(folder / f"raw/00000{i}.position.npy")
        seen = np.isfinite(distance)
        assert seen.sum() > 1000
        directions = rays.directions.numpy()[seen]
        found = rays.origins.numpy()[seen] + distance[seen, None] * directions
        error = np.linalg.norm(found - position[seen], axis=-1) / distance[seen]
        # nerfstudio removes distortion by ten steps of Newton's method in floats.
        assert np.quantile(error, 0.99) < 1e-4 and error.max() < 2e-3, (np.quantile(error, 0.99), error.max())
    if lens == "pinhole":
        points = outputs.metadata["points3D_xyz"].numpy()
        assert len(points) > 20 and len(points) == len(outputs.metadata["points3D_rgb"])
        surfaces = np.concatenate([np.load(path).reshape(-1, 3) for path in sorted(folder.glob("raw/*.position.npy"))])
        nearest = [np.linalg.norm(surfaces - point, axis=-1).min() for point in points]
        assert max(nearest) < 0.02


def test_blenderproc(tmp_path):
    program = shutil.which("blenderproc")
    if not program:
        pytest.skip("the package blenderproc is not installed")
    h5py = pytest.importorskip("h5py")
    image = pytest.importorskip("PIL.Image")
    folder = batch(tmp_path, "pinhole")
    shown = subprocess.run(
        [program, "vis", "hdf5", str(folder / "0.hdf5"), "--save", str(tmp_path / "shown")],
        env={**os.environ, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
    )
    assert shown.returncode == 0, shown.stderr
    names = ["colors", "depth", "forward_flow", "instance_segmaps", "normals"]
    assert sorted(path.name for path in (tmp_path / "shown").iterdir()) == [f"0_{name}.png" for name in names]
    with h5py.File(folder / "0.hdf5") as file:
        colors = np.asarray(image.open(tmp_path / "shown/0_colors.png"))[..., :3]
        np.testing.assert_array_equal(colors, file["colors"][()])
