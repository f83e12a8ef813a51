"""latelight.ray on a cluster of four nodes on this machine, some of which are killed. Skips without the package ray."""

import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

os.environ.setdefault("RAY_raylet_start_wait_time_s", "300")  # a busy machine starts nodes slowly
ray = pytest.importorskip("ray", reason="the package ray is not installed")
from ray.cluster_utils import Cluster  # noqa: E402

PROGRAM = os.environ["LATELIGHT_PROGRAM"]
FRAMES = 48
JOB = {
    "scenes": "builtin:boxes",
    "output": "set",
    "repeat": FRAMES,
    "formats": ["files", {"format": "webdataset", "frames": 20}],
    "options": {"size": "64x48"},
}


def files_of(folder):
    """The hashes of a set's files, except those that describe its creation."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".latelight" not in path.parts
    }


@pytest.fixture
def job(tmp_path):
    path = tmp_path / "job.json"
    path.write_text(json.dumps(JOB))
    subprocess.run(
        [PROGRAM, "batch", "job.json", "-o", "whole", "--devices", "cpu"], cwd=tmp_path, check=True, capture_output=True
    )
    return path


@pytest.fixture
def cluster():
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "num_gpus": 0, "include_dashboard": False})
    for _ in range(4):
        cluster.add_node(num_cpus=1, num_gpus=0)
    yield cluster
    cluster.shutdown()


def start(folder, address, *more):
    command = [
        sys.executable,
        "-m",
        "latelight.ray",
        "job.json",
        "--address",
        address,
        "--program",
        PROGRAM,
        "--devices",
        "cpu",
    ]
    return subprocess.Popen([*command, *more], cwd=folder, stderr=subprocess.PIPE, text=True)


def finished_frames(folder):
    return sum(log.read_text().count('{"frame"') for log in (folder / "set" / ".latelight").glob("shard-*.jsonl"))


def test_killed_nodes(job, cluster, tmp_path):
    """The set is that of one process, although two of four nodes die while they render."""
    process = start(tmp_path, cluster.address, "--shards", "8", "--retries", "10")
    for killed in range(2):
        deadline = time.monotonic() + 300
        while finished_frames(tmp_path) < 6 * (killed + 1):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.02)
        cluster.remove_node(sorted(cluster.worker_nodes, key=lambda node: node.unique_id)[0], allow_graceful=False)
    assert finished_frames(tmp_path) < FRAMES, "the nodes were killed too late"
    messages = process.communicate(timeout=600)[1]
    assert process.returncode == 0, messages
    assert files_of(tmp_path / "set") == files_of(tmp_path / "whole")
    assert (
        f"{FRAMES} of {FRAMES} frames are finished"
        in subprocess.run(
            [PROGRAM, "batch", "status", "set"], cwd=tmp_path, check=True, capture_output=True, text=True
        ).stdout
    )
    assert "shard 7-of-8 ends: 6 of 6 frames are finished" in messages

    again = start(tmp_path, cluster.address)
    assert "already contains a data set: add --resume" in again.communicate()[1]
    assert again.returncode == 2
    (tmp_path / "set" / "000003.png").unlink()
    resumed = start(tmp_path, cluster.address, "--resume", "--shards", "2")
    assert resumed.communicate()[0] is None and resumed.returncode == 0
    assert files_of(tmp_path / "set") == files_of(tmp_path / "whole")
    wrong = start(tmp_path, cluster.address, "-o", "other", "--exposure", "bright")
    assert "exposure" in wrong.communicate()[1]
    assert wrong.returncode == 2
