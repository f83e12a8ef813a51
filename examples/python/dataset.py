"""A small data set: pictures, depth, ids and poses of a scene from random places.

usage: dataset.py [SCENE] [FOLDER] [COUNT]
"""

import json
import sys
from pathlib import Path

import numpy as np

import latelight

source, folder, count = (sys.argv[1:] + ["builtin:spheres", "dataset", "20"][len(sys.argv) - 1 :])[:3]
out = Path(folder)
out.mkdir(exist_ok=True)
scene = latelight.Scene(source)
renderer = latelight.Renderer(scene)
low, high = np.array(scene.bounds)
radius = np.linalg.norm(high - low)
directions = np.random.default_rng(0).normal(size=(int(count), 3))
cameras = [scene.look_at((low + high) / 2 + radius * d / np.linalg.norm(d), (low + high) / 2) for d in directions]
for number, frame in enumerate(renderer.render(cameras, (320, 240), ("rgba", "depth", "id"))):
    (out / f"{number:04}.png").write_bytes(frame.png())
    np.savez_compressed(out / f"{number:04}.npz", depth=frame["depth"], id=frame["id"])
poses = [{"k": camera.k((320, 240)).tolist(), "camera_to_world": camera.camera_to_world.tolist()} for camera in cameras]
(out / "cameras.json").write_text(json.dumps(poses))
(out / "ids.json").write_text(json.dumps(scene.id_manifest()))
