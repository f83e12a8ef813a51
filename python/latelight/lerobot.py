"""Converts a data set of ``latelight batch`` to a LeRobot data set, version 3.0::

    python -m latelight.lerobot set -o dataset --fps 30 --task "look around the hall"

The set must be complete and have an image per frame and the cameras' poses: by the format ``transforms``, or by side
files of the format ``files``. Each variation of a scene is an episode, whose frames are the images of a camera path in
their order. The members of pairs and rigs (``path0-left``, ``path0-right``) are different videos. All other cameras are
frames of one video.

``observation.state`` is the pose of each camera: its position in meters and its rotation as a quaternion x, y, z, w,
from the camera's frame (X right, Y down, Z forward) to the scene's. A rotation has two quaternions of opposite sign:
the first frame of an episode has the one with w >= 0, and each other frame the one nearer to that of the frame before.
``action`` is the state of the next frame, and that of the last frame is its own.

Requires the package ``pyarrow`` and the program ``ffmpeg``. The folder appears whole or not at all.

Specification: https://huggingface.co/docs/lerobot/lerobot-dataset-v3
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import itertools
import json
import math
import os
import shutil
import signal
import struct
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

_VERSION = "v3.0"
_CHUNK = 1000  # files per folder
_FRAMES_PER_FILE = 100_000  # of data and videos; a file ends with an episode
_SAMPLES = 20  # images per episode and camera from which statistics are computed
_QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)
_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"


class SetError(Exception):
    """Ends the program with its exit code and a sentence."""

    code = 3


class OutputError(SetError):
    """The output cannot be written."""

    code = 2


class _Stopped(BaseException):
    """A signal ends the program."""


class Episode(NamedTuple):
    """Frames of one variation of a scene: by camera, the images in their order, and the states, (frames, values)."""

    pictures: dict[str, list[Path]]
    states: np.ndarray

    @property
    def length(self) -> int:
        return len(self.states)

    @property
    def actions(self) -> np.ndarray:
        return np.concatenate([self.states[1:], self.states[-1:]])


# --- the data set of latelight ----------------------------------------------------------------------------------------


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SetError(f"can't read '{path}': {error}") from None


def _picture_of(folder: Path, frame: dict[str, Any], pattern: str | None) -> Path:
    names = {file["file"] for file in frame["files"]}
    for candidate in [pattern] if pattern else ["images/{name}.png", "{name}.png"]:
        name = candidate.replace("{name}", frame["name"])
        if name in names:
            return folder / name
    raise SetError(
        f"the frame \"{frame['name']}\" of '{folder}' has no image: render the set with the format transforms "
        "or files, and name its images with --picture if they are elsewhere"
    )


def _side_file_cameras(folder: Path, frame: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The cameras of the frame's side files. The pattern of the format files, which the manifest does not record,
    determines their names; other formats write JSON files without cameras."""
    for file in frame["files"]:
        if not file["file"].endswith(".json"):
            continue
        document = _read_json(folder / file["file"])
        camera = document.get("camera") if isinstance(document, dict) else None
        if isinstance(camera, dict) and {"cameraToWorld", "convention"} <= camera.keys():
            yield camera


def _pose_of(folder: Path, frame: dict[str, Any]) -> np.ndarray:
    """From OpenCV's camera frame, (4, 4)."""
    for entry in frame["entries"]:
        matrix = entry.get("frame", {}).get("transform_matrix") if isinstance(entry, dict) else None
        if matrix:
            return np.array(matrix) @ np.diag([1.0, -1, -1, 1])
    for camera in _side_file_cameras(folder, frame):
        pose = np.array(camera["cameraToWorld"])
        return pose @ np.diag([1.0, -1, -1, 1]) if camera["convention"] == "opengl" else pose
    raise SetError(
        f"'{folder}' has no poses of cameras: add the format transforms to the job, and run it with --resume"
    )


def _state_of(pose: np.ndarray) -> list[float]:
    """Position and quaternion x, y, z, w with w >= 0 (Shepperd 1978, "Quaternion from Rotation Matrix")."""
    r = pose[:3, :3]
    squares = np.array(
        [
            1 + r[0, 0] - r[1, 1] - r[2, 2],
            1 - r[0, 0] + r[1, 1] - r[2, 2],
            1 - r[0, 0] - r[1, 1] + r[2, 2],
            1 + np.trace(r),
        ]
    )
    largest = int(squares.argmax())
    row = {
        0: [squares[0], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
        1: [r[1, 0] + r[0, 1], squares[1], r[2, 1] + r[1, 2], r[0, 2] - r[2, 0]],
        2: [r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], squares[2], r[1, 0] - r[0, 1]],
        3: [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], squares[3]],
    }[largest]
    quaternion = np.array(row) / np.linalg.norm(row)
    return [*pose[:3, 3], *(quaternion if quaternion[3] >= 0 else -quaternion)]


def _continued(states: list[list[float]]) -> np.ndarray:
    """The states of a camera's frames, (frames, values), without changes of the quaternions' signs from frame to frame,
    which statistics and policies would take for fast rotations."""
    values = np.array(states)
    quaternions = values[:, 3:]
    changes = np.where((quaternions[1:] * quaternions[:-1]).sum(1) < 0, -1, 1)
    quaternions[1:] *= np.cumprod(changes)[:, None]
    return values


def _members_by_name(cameras: Sequence[str]) -> list[str]:
    """The member of a pair or rig that each camera is, by names such as path0-left and path0-right; "" for none. At
    least two poses must have the same members, and numbers are those of poses, as in frame-000000."""
    bases: dict[str, list[str]] = {}
    for camera in cameras:
        base, _, member = camera.rpartition("-")
        bases.setdefault(member, []).append(base)
    poses = next(iter(bases.values()))
    is_rig = len(bases) > 1 and len(poses) > 1 and "" not in poses and all(each == poses for each in bases.values())
    if not is_rig or any(member.isdigit() for member in bases):
        return [""] * len(cameras)
    return [camera.rpartition("-")[2] for camera in cameras]


def _videos_of(frames: Sequence[dict[str, Any]]) -> list[str]:
    """The video of each frame of an episode: its camera's member of a pair or rig, or "camera". Manifests record
    members, except those of 0.2.0, whose members are found by name."""
    members = [frame.get("member", "") for frame in frames]
    if not any(members):
        members = _members_by_name([frame["camera"] for frame in frames])
    return [member or "camera" for member in members]


def read_set(folder: Path, pattern: str | None = None) -> list[Episode]:
    """The episodes of a complete data set. Raises SetError if it lacks images or poses."""
    if not (folder / "manifest.json").is_file():
        raise SetError(f"'{folder}' is not a complete data set: it has no manifest.json (latelight batch merge)")
    manifest = _read_json(folder / "manifest.json")
    episodes = []
    groups = itertools.groupby(manifest["frames"], key=lambda frame: (frame["scene"], frame["variation"]))
    for (scene, variation), group in groups:
        frames = list(group)
        pictures: dict[str, list[Path]] = {}
        poses: dict[str, list[list[float]]] = {}
        for frame, camera in zip(frames, _videos_of(frames)):
            pictures.setdefault(camera, []).append(_picture_of(folder, frame, pattern))
            poses.setdefault(camera, []).append(_state_of(_pose_of(folder, frame)))
        if len({len(images) for images in pictures.values()}) != 1:
            raise SetError(
                f"variation {variation} of '{scene}' has different numbers of frames by camera: "
                f"{', '.join(f'{name}: {len(images)}' for name, images in pictures.items())}"
            )
        cameras = sorted(pictures)
        states = np.concatenate([_continued(poses[name]) for name in cameras], axis=1).astype(np.float32)
        episodes.append(Episode({name: pictures[name] for name in cameras}, states))
    if not episodes:
        raise SetError(f"'{folder}' has no frames")
    for episode in episodes:
        if list(episode.pictures) != list(episodes[0].pictures):
            raise SetError(
                f"all scenes of '{folder}' must have the same cameras, not {list(episodes[0].pictures)} and "
                f"{list(episode.pictures)}"
            )
    return episodes


# --- videos and statistics -------------------------------------------------------------------------------------------


def _png_size(path: Path) -> tuple[int, int]:
    """Width and height, by the file's header."""
    with path.open("rb") as file:
        header = file.read(24)
    if len(header) < 24 or header[12:16] != b"IHDR":
        raise SetError(f"'{path}' is not a PNG file")
    return struct.unpack(">II", header[16:24])


def _ffmpeg(arguments: Sequence[str], pictures: Sequence[Path], rate: float) -> bytes:
    """Feeds PNG files to ffmpeg, and returns what it writes to standard output."""
    # A list of inputs would need files, and writing to its input while it writes to its output needs a thread.
    from concurrent.futures import ThreadPoolExecutor

    command = [
        "ffmpeg",
        "-nostdin",
        "-loglevel",
        "error",
        "-y",
        "-f",
        "image2pipe",
        "-framerate",
        f"{rate:g}",
        "-c:v",
        "png",
        "-i",
        "pipe:0",
        *arguments,
    ]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:

        def feed() -> None:
            try:
                for picture in pictures:
                    process.stdin.write(picture.read_bytes())
            except BrokenPipeError:
                pass  # ffmpeg says why
            finally:
                try:
                    process.stdin.close()
                except BrokenPipeError:
                    pass

        with ThreadPoolExecutor(2) as threads:
            try:
                fed, errors = threads.submit(feed), threads.submit(process.stderr.read)
                output = process.stdout.read()
                fed.result()
                message = errors.result().decode(errors="replace").strip()
            except BaseException:
                process.kill()  # otherwise the threads wait until it has encoded everything
                raise
    if process.returncode != 0:
        error = OutputError if os.strerror(errno.ENOSPC) in message else SetError
        raise error(f"ffmpeg failed: {message.splitlines()[-1] if message else process.returncode}")
    return output


def _encode(path: Path, pictures: Sequence[Path], fps: float) -> None:
    """An H.264 video with a key frame every other frame, so that readers find any frame quickly.

    The stream states its color space, which readers otherwise guess: BT.709 with sRGB's transfer function.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    _ffmpeg(
        [
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
            "-c:v",
            "libx264",
            "-pix_fmt",
            "yuv420p",
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "iec61966-2-1",
            "-color_range",
            "tv",
            "-crf",
            "18",
            "-g",
            "2",
            "-threads",
            "4",
            "-fflags",
            "+bitexact",
            "-flags:v",
            "+bitexact",
            "-map_metadata",
            "-1",
            str(path),
        ],
        pictures,
        fps,
    )


def _statistics(values: np.ndarray, count: int) -> dict[str, list[float]]:
    """Statistics of (samples, values), per value, as LeRobot's compute_stats.py defines them."""
    values = values.astype(np.float64)
    stats = {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}
    for share in _QUANTILES:
        stats[f"q{round(100 * share):02d}"] = np.quantile(values, share, axis=0)
    return {**{name: numbers.tolist() for name, numbers in stats.items()}, "count": [count]}


def _sampled_colors(pictures: Sequence[Path]) -> np.ndarray:
    """Colors from 0 to 1 of some images, (pixels, 3)."""
    picked = [pictures[i] for i in np.unique(np.linspace(0, len(pictures) - 1, _SAMPLES).round().astype(int))]
    # At most about 150 pixels a side, as LeRobot samples images.
    step = max(1, min(_png_size(picked[0])) // 150)
    scale = f"scale=iw/{step}:-2:flags=neighbor" if step > 1 else "null"
    raw = _ffmpeg(["-vf", scale, "-f", "rawvideo", "-pix_fmt", "rgb24", "pipe:1"], picked, 1)
    return np.frombuffer(raw, np.uint8).reshape(-1, 3) / 255


def _image_statistics(colors: np.ndarray, count: int) -> dict[str, Any]:
    """Statistics per channel, of shape (3, 1, 1) each, except the count."""
    return {
        name: values if name == "count" else [[[value]] for value in values]
        for name, values in _statistics(colors, count).items()
    }


# --- LeRobot's files -------------------------------------------------------------------------------------------------


def _video_key(camera: str) -> str:
    return f"observation.images.{camera}"


def _features(episode: Episode, fps: float) -> dict[str, Any]:
    cameras = list(episode.pictures)
    names = [f"{camera}.{part}" for camera in cameras for part in _POSE] if len(cameras) > 1 else list(_POSE)
    vector = {"dtype": "float32", "shape": [len(names)], "names": names}
    features: dict[str, Any] = {"observation.state": vector, "action": vector}
    for camera, pictures in episode.pictures.items():
        width, height = (2 * math.ceil(size / 2) for size in _png_size(pictures[0]))  # as the videos are padded
        features[_video_key(camera)] = {
            "dtype": "video",
            "shape": [height, width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": height,
                "video.width": width,
                "video.codec": "h264",
                "video.pix_fmt": "yuv420p",
                "video.is_depth_map": False,
                "video.fps": fps,
                "video.channels": 3,
                "has_audio": False,
            },
        }
    for name in ("timestamp", "frame_index", "episode_index", "index", "task_index"):
        features[name] = {"dtype": "float32" if name == "timestamp" else "int64", "shape": [1], "names": None}
    return features


def _files_of(episodes: Sequence[Episode]) -> Iterator[tuple[dict[str, int], int, int]]:
    """The episodes of each file, as its chunk and number, and the range of episodes."""
    begin = 0
    for number in itertools.count():
        end, frames = begin, 0
        while end < len(episodes) and (end == begin or frames + episodes[end].length <= _FRAMES_PER_FILE):
            frames += episodes[end].length
            end += 1
        if begin == end:
            return
        yield {"chunk_index": number // _CHUNK, "file_index": number % _CHUNK}, begin, end
        begin = end


def _write_table(path: Path, columns: dict[str, Any], metadata: dict[bytes, bytes] | None = None) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    path.parent.mkdir(parents=True, exist_ok=True)
    table = pa.table(columns)
    pq.write_table(table.replace_schema_metadata(metadata) if metadata else table, path, compression="snappy")


def _numeric_columns(
    episodes: Sequence[Episode], begin: int, end: int, first: int, fps: float
) -> dict[str, np.ndarray]:
    """The rows of the data of some episodes; `first` is the index of their first frame."""
    lengths = [episode.length for episode in episodes[begin:end]]
    frames = np.concatenate([np.arange(length) for length in lengths])
    return {
        "observation.state": np.concatenate([episode.states for episode in episodes[begin:end]]),
        "action": np.concatenate([episode.actions for episode in episodes[begin:end]]),
        "timestamp": (frames / fps).astype(np.float32),
        "frame_index": frames,
        "episode_index": np.repeat(np.arange(begin, end), lengths),
        "index": first + np.arange(len(frames)),
        "task_index": np.zeros(len(frames), np.int64),
    }


def _write_data(path: Path, columns: dict[str, np.ndarray]) -> None:
    import pyarrow as pa

    _write_table(
        path,
        {
            name: pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])
            if values.ndim == 2
            else pa.array(values)
            for name, values in columns.items()
        },
    )


def _write_tasks(path: Path, task: str) -> None:
    """With pandas' metadata, because LeRobot looks tasks up by the index of the table."""
    column = {
        "field_name": "task_index",
        "name": "task_index",
        "pandas_type": "int64",
        "numpy_type": "int64",
        "metadata": None,
    }
    index = {"field_name": "task", "name": "task", "pandas_type": "unicode", "numpy_type": "object", "metadata": None}
    pandas = {"index_columns": ["task"], "column_indexes": [], "columns": [column, index], "pandas_version": "2.0.0"}
    _write_table(path, {"task_index": [0], "task": [task]}, {b"pandas": json.dumps(pandas).encode()})


def _by_column(stats: dict[str, dict[str, Any]]) -> dict[str, Any]:
    return {f"stats/{name}/{stat}": values for name, each in stats.items() for stat, values in each.items()}


def _stats_of(columns: dict[str, np.ndarray], colors: dict[str, np.ndarray], length: int) -> dict[str, dict[str, Any]]:
    """Statistics of some frames by feature. `colors`: those of sampled images by camera."""
    stats = {name: _statistics(values.reshape(length, -1), length) for name, values in columns.items()}
    return stats | {_video_key(camera): _image_statistics(samples, length) for camera, samples in colors.items()}


def _episode_row(
    index: int, episode: Episode, file: dict[str, int], first: int, offset: int, fps: float, task: str
) -> dict[str, Any]:
    """The row of the table of episodes, without statistics. The episode begins at the frame `offset` of its file, whose
    first frame has the index `first`."""
    row: dict[str, Any] = {
        "episode_index": index,
        "tasks": [task],
        "length": episode.length,
        "data/chunk_index": file["chunk_index"],
        "data/file_index": file["file_index"],
        "dataset_from_index": first + offset,
        "dataset_to_index": first + offset + episode.length,
    }
    for camera in episode.pictures:
        key = _video_key(camera)
        row |= {
            f"videos/{key}/chunk_index": file["chunk_index"],
            f"videos/{key}/file_index": file["file_index"],
            f"videos/{key}/from_timestamp": offset / fps,
            f"videos/{key}/to_timestamp": (offset + episode.length) / fps,
        }
    return row


def _info(episodes: Sequence[Episode], frames: int, fps: float, robot: str) -> dict[str, Any]:
    return {
        "codebase_version": _VERSION,
        "robot_type": robot,
        "total_episodes": len(episodes),
        "total_frames": frames,
        "total_tasks": 1,
        "chunks_size": _CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": f"0:{len(episodes)}"},
        "data_path": _DATA_PATH,
        "video_path": _VIDEO_PATH,
        "features": _features(episodes[0], fps),
    }


def _write(root: Path, episodes: list[Episode], fps: float, task: str, robot: str) -> None:
    rows: list[dict[str, Any]] = []  # of the table of episodes
    colors: dict[str, list[np.ndarray]] = {camera: [] for camera in episodes[0].pictures}
    numbers: list[dict[str, np.ndarray]] = []
    first = 0
    for file, begin, end in _files_of(episodes):
        columns = _numeric_columns(episodes, begin, end, first, fps)
        numbers.append(columns)
        _write_data(root / _DATA_PATH.format(**file), columns)
        for camera in episodes[0].pictures:
            pictures = [picture for episode in episodes[begin:end] for picture in episode.pictures[camera]]
            _encode(root / _VIDEO_PATH.format(video_key=_video_key(camera), **file), pictures, fps)
        offset = 0
        for index in range(begin, end):
            episode = episodes[index]
            part = {name: values[offset : offset + episode.length] for name, values in columns.items()}
            sampled = {camera: _sampled_colors(pictures) for camera, pictures in episode.pictures.items()}
            for camera, samples in sampled.items():
                colors[camera].append(samples)
            row = _episode_row(index, episode, file, first, offset, fps, task)
            row |= _by_column(_stats_of(part, sampled, episode.length))
            rows.append(row | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
            offset += episode.length
        first += offset
    _write_table(
        root / _EPISODES_PATH.format(chunk_index=0, file_index=0),
        {name: [row[name] for row in rows] for name in rows[0]},
    )
    _write_tasks(root / "meta/tasks.parquet", task)
    all_numbers = {name: np.concatenate([columns[name] for columns in numbers]) for name in numbers[0]}
    stats = _stats_of(all_numbers, {camera: np.concatenate(samples) for camera, samples in colors.items()}, first)
    for name, value in [("info", _info(episodes, first, fps, robot)), ("stats", stats)]:
        (root / f"meta/{name}.json").write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")


def convert(
    folder: Path,
    output: Path,
    fps: int = 30,
    task: str = "camera path",
    robot: str = "camera",
    pattern: str | None = None,
) -> None:
    """Writes a LeRobot data set into a new folder. Raises SetError if the set does not allow it, and OutputError if the
    folder exists or cannot be written."""
    if output.exists():
        raise OutputError(f"'{output}' exists already; choose another folder")
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise SetError("latelight.lerobot requires the package pyarrow: pip install pyarrow") from None
    if not shutil.which("ffmpeg"):
        raise SetError("latelight.lerobot requires ffmpeg: install it (Debian's package is ffmpeg)")
    episodes = read_set(folder, pattern)
    sizes = {
        camera: {_png_size(p) for episode in episodes for p in episode.pictures[camera]}
        for camera in episodes[0].pictures
    }
    for camera, different in sizes.items():
        if len(different) != 1:
            raise SetError(f"all images of the camera {camera} must have the same size, not {sorted(different)}")
    unfinished = output.with_name(f".{output.name}.{os.getpid()}.latelight-tmp")
    try:
        _write(unfinished, episodes, fps, task, robot)
        unfinished.rename(output)
    except OSError as error:
        raise OutputError(f"can't write '{output}': {error.strerror or error}") from None
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


@contextlib.contextmanager
def _stopped_by_signals() -> Iterator[None]:
    """Lets a signal end the program after unfinished files are removed, with the exit status of that signal."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def stop(number: int, _: object) -> None:
        for other in numbers:
            signal.signal(other, signal.SIG_IGN)  # a second signal must not interrupt the removal
        raise _Stopped(number)

    before = {number: signal.signal(number, stop) for number in numbers if signal.getsignal(number) != signal.SIG_IGN}
    try:
        yield
    except _Stopped as stopped:
        signal.signal(stopped.args[0], signal.SIG_DFL)
        signal.raise_signal(stopped.args[0])
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m latelight.lerobot", description="Converts a data set to LeRobot's."
    )
    parser.add_argument("set", type=Path, help="folder of a complete data set of latelight batch")
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument("--fps", type=int, default=30, help="frames per second (default: 30)")
    parser.add_argument("--task", default="camera path", help="text of the task of all episodes")
    parser.add_argument("--robot-type", default="camera", help='robot_type of the data set (default: "camera")')
    parser.add_argument("--picture", metavar="PATTERN", help='images of the set, as in "images/{name}.png"')
    options = parser.parse_args(arguments)
    if options.fps < 1:
        parser.error(f"--fps takes a whole number from 1, not {options.fps}")
    try:
        with _stopped_by_signals():
            convert(options.set, options.output, options.fps, options.task, options.robot_type, options.picture)
    except SetError as error:
        print(f"latelight.lerobot: {error}", file=sys.stderr)
        sys.exit(error.code)


if __name__ == "__main__":
    main()
