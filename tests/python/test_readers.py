"""Data sets read by the programs whose formats they are: nerfstudio's data parsers, BlenderProc's `vis hdf5`,
bop_toolkit and SceneZoo.

None is installed for every test, because they require PyTorch or Open3D, or are not on PyPI; docs/formats.md states the
versions that read the sets. LeRobot is in test_lerobot.py."""

import json
import os
import shutil
import subprocess
import zipfile

import numpy as np
import pytest

LENSES = {
    "pinhole": {"fov": 50},
    "opencv": {"model": "opencv", "K": [[90, 0, 50], [0, 91, 35], [0, 0, 1]], "distortion": [-0.2, 0.05, 0.001, -0.002]},
    "fisheye": {"model": "fisheye", "K": [[40, 0, 48], [0, 41, 32], [0, 0, 1]], "distortion": [-0.02, 0.005, 0.001]},
    "equirectangular": {"model": "equirectangular"},
}

VIEWS = [{"eye": [3, 2, 6], "target": [0, 1, 0]}, {"eye": [-4, 1, 5], "target": [0, 1, 0]}]


def batch(folder, lens):
    hdf5 = [{"format": "hdf5", "keys": ["colors", "depth", "normals", "instance_segmaps", "forward_flow"]}]
    job = {
        "scenes": "builtin:boxes",
        "output": "set",
        "cameras": {"type": "list", "cameras": VIEWS, **LENSES[lens]},
        "formats": [
            {"format": "transforms", "points": 8 if lens == "pinhole" else 0},
            {"format": "files", "outputs": ["position", "distance"], "pattern": "raw/{name}.npy", "side-file": False},
            *(hdf5 if lens == "pinhole" else []),
        ],
        "options": {"size": "96x64", "axes": "z-up"},
    }
    return run(folder, job)


def run(folder, job):
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
    pytest.importorskip("cv2", reason="opencv-python is not installed, which BlenderProc requires for flow")
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


def objects_set(folder, name):
    """A set in the format `name`, and its depth, positions and ids by frame."""
    job = {
        "scenes": "builtin:boxes",
        "output": "set",
        "cameras": {"type": "list", "cameras": VIEWS, "fov": 50},
        "formats": [
            name,
            {"format": "files", "outputs": ["depth", "position", "id"], "pattern": "raw/{name}.npy", "side-file": False},
        ],
        "options": {"size": "96x64", "axes": "z-up"},
    }
    made = run(folder, job)
    raw = lambda frame, output: np.load(made / f"raw/{frame:06}.{output}.npy")
    return made, [{output: raw(frame, output) for output in ("depth", "position", "id")} for frame in range(2)]


def same_regions(first, second):
    """Whether two images of labels have the same regions, whatever their numbers are."""
    pairs = {(int(a), int(b)) for a, b in zip(first.flat, second.flat)}
    return len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})


def test_nerfstudio_scannet(tmp_path):
    """nerfstudio's rays through the poses and the intrinsics, times the depth, are the rendered positions."""
    parser = pytest.importorskip(
        "nerfstudio.data.dataparsers.scannet_dataparser", reason="the package nerfstudio is not installed"
    )
    image, torch = pytest.importorskip("PIL.Image"), pytest.importorskip("torch")
    made, raw = objects_set(tmp_path, "scannet")
    config = parser.ScanNetDataParserConfig(
        data=made / "scans/scene0000_00",
        center_method="none",
        auto_scale_poses=False,
        train_split_fraction=1.0,
        load_3D_points=False,
    )
    outputs = config.setup().get_dataparser_outputs("train")
    assert [path.name for path in outputs.image_filenames] == ["0.jpg", "1.jpg"]
    scale = outputs.metadata["depth_unit_scale_factor"]
    x, y = np.meshgrid(np.arange(96.0), np.arange(64.0))  # ScanNet's pixel centers are whole numbers
    coordinates = torch.tensor(np.stack([y, x], axis=-1), dtype=torch.float32)
    for i, path in enumerate(outputs.metadata["depth_filenames"]):
        rays = outputs.cameras.generate_rays(camera_indices=i, coords=coordinates)
        forward = -outputs.cameras.camera_to_worlds[i, :, 2].numpy()
        depth = np.asarray(image.open(path)).astype(np.float64) * scale
        directions = rays.directions.numpy()
        points = rays.origins.numpy() + directions * (depth / (directions @ forward))[..., None]
        seen = depth > 0
        assert seen.sum() > 1000 and np.abs(depth[seen] - raw[i]["depth"].reshape(64, 96)[seen]).max() < 6e-4
        assert np.abs(points - raw[i]["position"])[seen].max() < 2e-3


def test_scenezoo_scannet(tmp_path):
    """The objects and categories, which SceneZoo reads from archives of ScanNet's names."""
    adapter = pytest.importorskip("scenezoo.dataset.scene.scannet", reason="the package scenezoo is not installed")
    made, raw = objects_set(tmp_path, "scannet")
    scan = made / "scans/scene0000_00"
    for kind in ("instance", "label"):
        with zipfile.ZipFile(scan / f"scene0000_00_2d-{kind}.zip", "w") as archive:
            for path in (scan / kind).iterdir():
                archive.write(path, f"{kind}/{path.name}")
    reader = adapter.ScanNet(made, label_mapping_file=scan / "labels.tsv", offline=True)
    maps = {
        kind: reader._read_projection_maps("scene0000_00", [0, 1], kind=kind, variant="raw")
        for kind in ("instance", "semantic")
    }
    names = {row["id"]: name for name, row in reader.metadata["label_mapping"].items()}
    for i in range(2):
        ids = raw[i]["id"].reshape(64, 96)
        assert same_regions(maps["instance"][i], ids)
        np.testing.assert_array_equal(maps["instance"][i] == -1, ids == 0)
        assert {int(label) for label in np.unique(maps["semantic"][i])} - {0} <= set(names)


def test_bop_toolkit(tmp_path):
    """Surfaces lie in the box of their model, by the pose and the depth that the toolkit reads."""
    toolkit = pytest.importorskip(
        "bop_toolkit_lib.dataset.bop_scenewise", reason="the package bop_toolkit_lib is not installed"
    )
    made, raw = objects_set(tmp_path, "bop")
    scene = made / "train/000000"
    infos = toolkit.read_scene_infos(scene, read_image_ids=True)
    assert infos["image_ids"] == [0, 1] and all(infos[f"has_{name}"] for name in ("rgb", "depth", "mask", "gt", "gt_info"))
    models = toolkit.inout.load_json(made / "models/models_info.json", keys_to_int=True)
    for frame in range(2):
        data = toolkit.load_image_data(scene, frame, load_mask=True, load_gt=True, load_gt_info=True)
        depth, k = data["im_depth"], data["camera"]["cam_K"]
        seen = depth > 0
        assert seen.sum() > 1000 and np.abs(depth - raw[frame]["depth"].reshape(64, 96) * 1000)[seen].max() < 0.6
        assert data["im_rgb"].shape == (64, 96, 3)
        assert len(data["gt"]) == len(data["gt_info"]) == len(data["mask"]) == len(data["mask_visib"]) > 5
        y, x = np.mgrid[:64, :96]
        camera = np.stack([(x - k[0, 2]) / k[0, 0], (y - k[1, 2]) / k[1, 1], np.ones_like(x)], -1) * depth[..., None]
        ids = raw[frame]["id"].reshape(64, 96)
        for gt, info, visible in zip(data["gt"], data["gt_info"], data["mask_visib"] > 0):
            assert info["px_count_visib"] == visible.sum()
            if not visible.any():
                continue
            assert len(np.unique(ids[visible])) == 1
            model = models[gt["obj_id"]]
            low = np.array([model[f"min_{axis}"] for axis in "xyz"])
            size = np.array([model[f"size_{axis}"] for axis in "xyz"])
            points = (camera[visible] - gt["cam_t_m2c"].T) @ gt["cam_R_m2c"]
            assert (points >= low - 2).all() and (points <= low + size + 2).all()  # millimeters
        rotation, translation = data["camera"]["cam_R_w2c"], data["camera"]["cam_t_w2c"]
        world = (camera[seen] - translation.T) @ rotation
        np.testing.assert_allclose(world, raw[frame]["position"][seen] * 1000, atol=2)
