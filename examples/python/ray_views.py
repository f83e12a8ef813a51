"""Views of a scene by all GPUs of a Ray cluster: an actor for each, with a renderer of its own. Without GPUs, one on
the CPU.

usage: ray_views.py [SCENE] [FOLDER] [COUNT]      (pip install ray; the folder is one that all machines see)
"""

import sys
from pathlib import Path

import numpy as np
import ray
from ray.util import ActorPool

import latelight


@ray.remote
class Views:
    def __init__(self, source):
        gpus = ray.get_gpu_ids()
        self.scene = latelight.Scene(source)
        self.renderer = latelight.Renderer(self.scene, device=str(gpus[0]) if gpus else "cpu")

    def render(self, numbers, eyes, target, out):
        """Pictures and depths of some views, as files that appear whole or not at all: Ray may ask for them again."""
        cameras = [self.scene.look_at(eye, target) for eye in eyes]
        for number, frame in zip(numbers, self.renderer.render(cameras, (320, 240), ("rgba", "depth"))):
            part = Path(out) / f".{number:06}.npz"
            np.savez_compressed(part, rgba=frame["rgba"], depth=frame["depth"])
            part.rename(Path(out) / f"{number:06}.npz")
        return len(numbers)


source, folder, count = (sys.argv[1:] + ["builtin:spheres", "views", "256"][len(sys.argv) - 1 :])[:3]
out = Path(folder).resolve()
out.mkdir(parents=True, exist_ok=True)
low, high = np.array(latelight.Scene(source).bounds)
center = (low + high) / 2
directions = np.random.default_rng(0).normal(size=(int(count), 3))
eyes = center + np.linalg.norm(high - low) * directions / np.linalg.norm(directions, axis=1, keepdims=True)

ray.init(log_to_driver=False)
gpus = int(ray.cluster_resources().get("GPU", 0))
remote = Views.options(num_gpus=1 if gpus else 0, max_restarts=2, max_task_retries=2)
pool = ActorPool([remote.remote(source) for _ in range(max(gpus, 1))])
missing = [number for number in range(int(count)) if not (out / f"{number:06}.npz").exists()]
parts = [missing[at : at + 64] for at in range(0, len(missing), 64)]
done = 0
for finished in pool.map_unordered(lambda views, part: views.render.remote(part, eyes[part], center, str(out)), parts):
    done += finished
    print(f"{done} of {len(missing)} views")
