"""latelight.lerobot: its data sets by pyarrow and ffmpeg, and by LeRobot itself if that is installed."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pq = pytest.importorskip("pyarrow.parquet", reason="the package pyarrow is not installed")
if not shutil.which("ffmpeg"):
    pytest.skip("ffmpeg is not installed", allow_module_level=True)

JOB = {
    "scenes": "builtin:boxes",
    "output": "set",
    "repeat": 2,
    "formats": ["transforms"],
    "options": {"size": "63x48", "axes": "z-up"},
    "cameras": {"type": "stereo", "baseline": 0.5, "cameras": {"type": "orbit", "count": 4}},
}


def lerobot(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "latelight.lerobot", *arguments], cwd=folder, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lerobot")
    (folder / "job.json").write_text(json.dumps(JOB))
    subprocess.run(
        [os.environ["LATELIGHT_PROGRAM"], "batch", "job.json", "--devices", "cpu"],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    done = lerobot(folder, "set", "-o", "out", "--fps", "10", "--task", "orbit")
    assert done.returncode == 0, done.stderr
    return folder


def poses(folder):
    """By episode: of each frame the poses of both cameras, (4, 4), from OpenCV's camera frame."""
    files = [folder / "set" / name for name in ("transforms.json", "transforms-1.json")]
    frames = [frame for file in files for frame in json.loads(file.read_text())["frames"]]
    matrices = np.array([frame["transform_matrix"] for frame in frames]) @ np.diag([1, -1, -1, 1])
    return matrices.reshape(2, 4, 2, 4, 4)


def test_the_rows(folder):
    table = pq.read_table(folder / "out/data/chunk-000/file-000.parquet")
    rows = table.to_pydict()
    assert rows["index"] == list(range(8)) and rows["frame_index"] == [0, 1, 2, 3] * 2
    assert rows["episode_index"] == [0] * 4 + [1] * 4 and rows["task_index"] == [0] * 8
    np.testing.assert_allclose(rows["timestamp"], np.tile(np.arange(4) / 10, 2), rtol=1e-6)
    assert str(table.schema.field("observation.state").type) == "fixed_size_list<element: float>[14]"
    states = np.array(rows["observation.state"]).reshape(2, 4, 2, 7)
    for state, pose in zip(states.reshape(-1, 7), poses(folder).reshape(-1, 4, 4)):
        np.testing.assert_allclose(state[:3], pose[:3, 3], atol=1e-5)
        x, y, z, w = state[3:]
        rotation = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        np.testing.assert_allclose(rotation, pose[:3, :3], atol=1e-5)
    actions = np.array(rows["action"]).reshape(2, 4, 2, 7)
    np.testing.assert_array_equal(actions[:, :-1], states[:, 1:])
    np.testing.assert_array_equal(actions[:, -1], states[:, -1])


def test_the_episodes(folder):
    rows = pq.read_table(folder / "out/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [row["length"] for row in rows] == [4, 4]
    assert [(row["dataset_from_index"], row["dataset_to_index"]) for row in rows] == [(0, 4), (4, 8)]
    for camera in ("left", "right"):
        key = f"videos/observation.images.{camera}"
        np.testing.assert_allclose([row[f"{key}/from_timestamp"] for row in rows], [0, 0.4])
        np.testing.assert_allclose([row[f"{key}/to_timestamp"] for row in rows], [0.4, 0.8])
    assert pq.read_table(folder / "out/meta/tasks.parquet").to_pydict() == {"task_index": [0], "task": ["orbit"]}
    info = json.loads((folder / "out/meta/info.json").read_text())
    assert (info["codebase_version"], info["total_episodes"], info["total_frames"], info["fps"]) == ("v3.0", 2, 8, 10)
    assert info["features"]["observation.images.left"]["shape"] == [48, 64, 3]
    stats = json.loads((folder / "out/meta/stats.json").read_text())
    states = np.array(pq.read_table(folder / "out/data/chunk-000/file-000.parquet")["observation.state"].to_pylist())
    np.testing.assert_allclose(stats["observation.state"]["mean"], states.mean(0), atol=1e-6)
    np.testing.assert_allclose(stats["observation.state"]["std"], states.std(0), atol=1e-6)


def test_the_videos(folder):
    """Frames are the images over black, as ffmpeg decodes them, with a padded column."""
    for camera in ("left", "right"):
        video = folder / f"out/videos/observation.images.{camera}/chunk-000/file-000.mp4"
        raw = subprocess.run(
            ["ffmpeg", "-loglevel", "error", "-i", str(video), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
            capture_output=True,
            check=True,
        ).stdout
        frames = np.frombuffer(raw, np.uint8).reshape(8, 48, 64, 3)
        entries = "stream=color_range,color_space,color_transfer,color_primaries"
        tags = subprocess.run(
            ["ffprobe", "-v", "error", "-show_entries", entries, "-of", "csv=p=0", str(video)],
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        assert tags.strip() == "tv,bt709,iec61966-2-1,bt709"
        assert (frames[:, :, 63] < 24).all()
        assert len({frame.tobytes() for frame in frames}) >= 4


def test_errors(folder):
    again = lerobot(folder, "set", "-o", "out")
    assert again.returncode == 2 and "'out' exists already" in again.stderr
    missing = lerobot(folder, "nothing", "-o", "new")
    assert missing.returncode == 3 and "is not a complete data set" in missing.stderr
    pictures = lerobot(folder, "set", "-o", "new", "--picture", "rgb/{name}.png")
    assert pictures.returncode == 3 and "has no image" in pictures.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["job.json", "out", "set"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_leave_nothing(folder, tmp_path, number):
    (tmp_path / "ffmpeg").write_text(f"#!/bin/sh\n: >'{tmp_path}/started'\nexec sleep 60\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    process = subprocess.Popen(
        [sys.executable, "-m", "latelight.lerobot", folder / "set", "-o", tmp_path / "out"],
        env=os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"},
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # background jobs ignore SIGINT
    )
    while not (tmp_path / "started").exists():
        assert process.poll() is None
        time.sleep(0.01)
    assert list(tmp_path.glob(".out.*"))
    process.send_signal(number)
    assert process.communicate(timeout=300)[1] == "" and process.returncode == -number
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ffmpeg", "started"]


def test_side_files_in_folders(tmp_path):
    formats = [{"format": "files", "outputs": ["color", "depth"]}, "boxes"]
    job = JOB | {"repeat": 1, "formats": formats, "cameras": poses_at("a", "b"), "options": {"size": "16x16"}}
    for pattern in ("rgb/{name}.png", "{aov}/{name}.png"):
        formats[0]["pattern"] = pattern
        shutil.rmtree(tmp_path / "set", ignore_errors=True)
        (tmp_path / "job.json").write_text(json.dumps(job))
        program = [os.environ["LATELIGHT_PROGRAM"], "batch", "job.json", "--devices", "cpu"]
        subprocess.run(program, cwd=tmp_path, check=True, capture_output=True)
        picture = pattern.replace("{aov}", "color")
        done = lerobot(tmp_path, "set", "-o", pattern[1:4], "--picture", picture)
        assert done.returncode == 0, done.stderr
        rows = pq.read_table(tmp_path / pattern[1:4] / "data/chunk-000/file-000.parquet").to_pydict()
        positions = np.array(rows["observation.state"])[:, :3]
        np.testing.assert_allclose(positions, [[0, 0, 9], [0, 1, 9]], atol=1e-6)


def cameras_of(folder, name, cameras):
    """The cameras of the videos that are made of the job's set, and the frames of each episode."""
    job = JOB | {"output": name, "repeat": 1, "cameras": cameras, "options": {"size": "16x16"}}
    (folder / "other").mkdir(exist_ok=True)
    (folder / "other/job.json").write_text(json.dumps(job))
    program = [os.environ["LATELIGHT_PROGRAM"], "batch", "job.json", "--devices", "cpu"]
    subprocess.run(program, cwd=folder / "other", check=True, capture_output=True)
    done = lerobot(folder / "other", name, "-o", f"{name}-out")
    assert done.returncode == 0, done.stderr
    info = json.loads((folder / f"other/{name}-out/meta/info.json").read_text())
    keys = [key.removeprefix("observation.images.") for key in info["features"] if "images" in key]
    return sorted(keys), info["total_frames"]


def poses_at(*names):
    return {"type": "list", "cameras": [{"name": name, "eye": [0, i, 9]} for i, name in enumerate(names)]}


def test_quaternions_keep_their_sign(tmp_path):
    """A camera that turns twice about its vertical axis: half of its angle, from 0 to 360 degrees, is in the quaternion,
    whose w = cos(angle / 2) is negative in the second half. Each of two variations starts with w = 1."""
    angles = np.radians(np.arange(0, 720, 30))
    cameras = [
        {"name": f"p{i:02}", "pose": [[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 9], [0, 0, 0, 1]]}
        for i, (c, s) in enumerate(zip(np.cos(angles), np.sin(angles)))
    ]
    job = JOB | {"cameras": {"type": "list", "fov": 50, "cameras": cameras}, "options": {"size": "16x16"}}
    (tmp_path / "job.json").write_text(json.dumps(job))
    program = [os.environ["LATELIGHT_PROGRAM"], "batch", "job.json", "--devices", "cpu"]
    subprocess.run(program, cwd=tmp_path, check=True, capture_output=True)
    done = lerobot(tmp_path, "set", "-o", "out")
    assert done.returncode == 0, done.stderr
    rows = pq.read_table(tmp_path / "out/data/chunk-000/file-000.parquet").to_pydict()
    zero = np.zeros_like(angles)
    expected = np.stack([zero, np.sin(angles / 2), zero, np.cos(angles / 2)], 1)
    states = np.array(rows["observation.state"]).reshape(2, 24, 7)
    for episode in states:
        np.testing.assert_allclose(episode[:, 3:], expected, atol=1e-6)
    actions = np.array(rows["action"]).reshape(2, 24, 7)
    np.testing.assert_array_equal(actions[:, :-1], states[:, 1:])


def test_only_members_of_pairs_and_rigs_have_their_own_videos(tmp_path):
    frames = [f"frame-{i:06}" for i in range(3)]
    assert cameras_of(tmp_path, "frames", poses_at(*frames)) == (["camera"], 3)
    assert cameras_of(tmp_path, "passes", poses_at("a-1", "a-2", "b-1", "b-2")) == (["camera"], 4)
    assert cameras_of(tmp_path, "views", poses_at("hall-front", "hall-back")) == (["camera"], 2)
    pair = {"type": "stereo", "baseline": 0.1}
    assert cameras_of(tmp_path, "one", pair | {"cameras": poses_at("hall")}) == (["left", "right"], 1)
    offsets = [{"name": str(i), "translation": [i, 0, 0]} for i in range(2)]
    numbers = {"type": "rig", "offsets": offsets, "cameras": pair | {"cameras": poses_at("a", "b")}}
    expected = ["left-0", "left-1", "right-0", "right-1"]
    assert cameras_of(tmp_path, "numbers", numbers) == (expected, 2)


def test_members_of_older_manifests(folder):
    """Version 0.2.0 recorded no members, and names tell them."""
    shutil.copytree(folder / "set", folder / "older")
    manifest = json.loads((folder / "older/manifest.json").read_text())
    assert [frame.pop("member") for frame in manifest["frames"]] == ["left", "right"] * 8
    (folder / "older/manifest.json").write_text(json.dumps(manifest))
    done = lerobot(folder, "older", "-o", "older-out", "--fps", "10", "--task", "orbit")
    assert done.returncode == 0, done.stderr
    files = [path.relative_to(folder / "out") for path in (folder / "out").rglob("*.*") if path.is_file()]
    for file in files:
        assert (folder / "older-out" / file).read_bytes() == (folder / "out" / file).read_bytes(), file
    shutil.rmtree(folder / "older")
    shutil.rmtree(folder / "older-out")


def test_lerobot_itself(folder):
    """All columns of all items, the videos, and items with frames of other times, in batches."""
    datasets = pytest.importorskip("lerobot.datasets.lerobot_dataset", reason="the package lerobot is not installed")
    torch, image = pytest.importorskip("torch"), pytest.importorskip("PIL.Image")
    data = datasets.LeRobotDataset("latelight/set", root=folder / "out")
    assert len(data) == 8 and data.num_episodes == 2 and data.fps == 10
    states = np.array(pq.read_table(folder / "out/data/chunk-000/file-000.parquet")["observation.state"].to_pylist())
    assert set(data.features) == {
        *(f"observation.images.{camera}" for camera in ("left", "right")),
        *("observation.state", "action", "timestamp", "frame_index", "episode_index", "index", "task_index"),
    }

    def shown(frame, camera):  # over black
        number = 2 * frame + (camera == "right")
        rgba = np.asarray(image.open(folder / f"set/images/{number:06}.png").convert("RGBA"), np.float64) / 255
        return rgba[..., :3] * rgba[..., 3:]

    for i in range(8):
        item, episode, frame = data[i], i // 4, i % 4
        numbers = {name: int(item[name]) for name in ("index", "episode_index", "frame_index", "task_index")}
        assert numbers == {"index": i, "episode_index": episode, "frame_index": frame, "task_index": 0}
        assert item["task"] == "orbit" and float(item["timestamp"]) == pytest.approx(frame / 10)
        for camera, pose in zip((0, 1), poses(folder)[episode, frame]):
            np.testing.assert_allclose(item["observation.state"][7 * camera :][:3], pose[:3, 3], atol=1e-5)
        np.testing.assert_allclose(item["action"], states[min(i + 1, 4 * episode + 3)], atol=1e-6)
        for camera in ("left", "right"):
            picture = item[f"observation.images.{camera}"]
            assert tuple(picture.shape) == (3, 48, 64)
            assert np.abs(picture.numpy().transpose(1, 2, 0)[:, :63] - shown(i, camera)).mean() < 0.02, (i, camera)
    stats = data.meta.stats["observation.state"]
    np.testing.assert_allclose(stats["min"], states.min(0), atol=1e-6)
    np.testing.assert_allclose(stats["max"], states.max(0), atol=1e-6)

    deltas = {"observation.images.left": [-0.1, 0], "action": [0, 0.1, 0.2]}
    windows = datasets.LeRobotDataset("latelight/set", root=folder / "out", delta_timestamps=deltas)
    batch = next(iter(torch.utils.data.DataLoader(windows, batch_size=8)))
    assert tuple(batch["observation.images.left"].shape) == (8, 2, 3, 48, 64)
    assert tuple(batch["action"].shape) == (8, 3, 14)
    assert batch["action_is_pad"].tolist() == [[False, i > 2, i > 1] for i in (0, 1, 2, 3)] * 2
    before = batch["observation.images.left"][6, 0].numpy().transpose(1, 2, 0)[:, :63]
    assert np.abs(before - shown(5, "left")).mean() < 0.02


def test_a_full_disk_leaves_no_data_set(folder, tmp_path):
    """A disk that is too small for the videos, or for everything but the last files."""
    needed = sum(-(-path.stat().st_size // 4096) * 4096 for path in (folder / "out").rglob("*") if path.is_file())
    for share in (0.3, 0.7, 0.95):
        disk = tmp_path / f"disk{int(100 * share)}"
        disk.mkdir()
        mounted = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={int(share * needed)}", "tmpfs", disk], capture_output=True
        )
        if mounted.returncode != 0:
            pytest.skip("no right to mount")
        try:
            failed = lerobot(folder, "set", "-o", str(disk / "out"), "--fps", "10")
            assert failed.returncode == 2, failed.stderr
            assert failed.stderr.startswith("latelight.lerobot: ") and failed.stderr.count("\n") == 1, failed.stderr
            assert not list(disk.iterdir()), failed.stderr
        finally:
            subprocess.run(["umount", "-l", disk], check=True)
