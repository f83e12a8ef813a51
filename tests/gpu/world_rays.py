"""Rays through worlds from arrays of torch in CUDA's memory.

Checks that hits are those of the same rays from the host, that distances to a moved box have their closed form, and
that images with rays from tensors are those from arrays of the host. Then measures steady calls. Requires an NVIDIA
GPU. Not part of the test suite, which has none.

usage: world_rays.py SCENE
"""

import sys
import time

import latelight
import numpy as np
import torch

WORLDS, RAYS = 4096, 256
FACES = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
         [1, 3, 7], [1, 7, 5]]


def on_gpu(array):
    return torch.from_numpy(np.ascontiguousarray(array)).cuda()


def closed_form():
    scene = latelight.Scene()
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
    box = scene.add_instance(scene.add_mesh(corners, FACES), scene.add_material(latelight.Material()))
    renderer = latelight.Renderer(scene, device="cuda:0")
    heights = torch.linspace(-3, 3, WORLDS, device="cuda", dtype=torch.float64)
    transforms = torch.eye(4, device="cuda", dtype=torch.float64).repeat(WORLDS, 1, 1, 1)
    transforms[:, 0, 2, 3] = heights
    origins = torch.tensor([0.25, -0.5, 10.0], device="cuda").repeat(WORLDS, 3, 1)
    directions = torch.tensor([0.0, 0.0, -1.0], device="cuda").repeat(WORLDS, 3, 1)
    before = renderer.copied_bytes
    hits = renderer.cast_worlds(WORLDS, origins, directions, instances=[box], transforms=transforms, on_device=True)
    distance = torch.from_dlpack(hits["distance"])
    assert distance.is_cuda and distance.shape == (WORLDS, 3)
    error = ((distance - (9 - heights[:, None])).abs() / 9).max().item()
    expected = sum(t.numel() * t.element_size() for t in (transforms, origins, directions))
    assert renderer.copied_bytes - before == expected, (renderer.copied_bytes - before, expected)
    assert error < 2e-7, error
    print(f"closed form: {WORLDS} worlds, largest relative error {error:.1e}")


def given(scene, seed):
    rng = np.random.default_rng(seed)
    instances = scene.instances()
    transforms = np.stack([scene.instance(i).transform for i in instances])[None].repeat(WORLDS, 0)
    transforms[:, :, :3, 3] += rng.uniform(-0.2, 0.2, (WORLDS, len(instances), 3))
    exists = rng.uniform(size=(WORLDS, len(instances))) > 0.1
    origins = rng.uniform(-3, 3, (WORLDS, RAYS, 3)).astype(np.float32)
    directions = rng.normal(size=(WORLDS, RAYS, 3)).astype(np.float32)
    return {"transforms": transforms.astype(np.float32), "exists": exists}, origins, directions, instances


def compare(name):
    scene = latelight.Scene(name)
    renderer, other = latelight.Renderer(scene, device="cuda:0"), latelight.Renderer(scene, device="cuda:0")
    arrays, origins, directions, instances = given(scene, 1)
    host = renderer.cast_worlds(WORLDS, origins, directions, instances=instances, **arrays)
    tensors = {key: on_gpu(value) for key, value in arrays.items()}
    there = other.cast_worlds(WORLDS, on_gpu(origins), on_gpu(directions), instances=instances, **tensors,
                              on_device=True)
    for key, value in host.items():
        mine = torch.from_dlpack(there[key]).cpu().numpy()
        assert np.array_equal(mine.view(np.uint32), value.view(np.uint32)), key
    print(f"tensors: {WORLDS} worlds of {len(instances)}, {np.isfinite(host['distance']).mean():.1%} of "
          f"{host['distance'].size} rays hit; the same bytes from tensors and from the host")
    camera, options = scene.default_camera(), {"shadows": "rays", "sun": (30, 50, 3), "samples": 1,
                                               "indirect": "one-bounce"}
    count = 64
    some = {key: value[:count] for key, value in arrays.items()}
    images = renderer.render_worlds(count, camera, (64, 64), instances=instances, **some, **options)["rgba"]
    placed = other.render_worlds(count, camera, (64, 64), instances=instances, on_device=True, **options,
                                 **{key: on_gpu(value) for key, value in some.items()})["rgba"]
    different = (torch.from_dlpack(placed).cpu().numpy() != images).mean()
    assert different == 0, different
    print(f"images with rays: {count} worlds, the same bytes from tensors and from the host")


def measure(name):
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0")
    calls = []
    for seed in range(2):
        arrays, origins, directions, instances = given(scene, seed)
        calls.append(({key: on_gpu(value) for key, value in arrays.items()}, on_gpu(origins), on_gpu(directions)))
    for outputs in ("distance", ("distance", "position", "normal", "id")):
        out, times = None, []
        for run in range(40):
            arrays, origins, directions = calls[run % 2]
            torch.cuda.synchronize()
            start = time.perf_counter()
            out = renderer.cast_worlds(WORLDS, origins, directions, instances=instances, on_device=True, **arrays,
                                       **({"out": out} if out else {"outputs": outputs}))
            times.append(1000 * (time.perf_counter() - start))
        print(f"cast_worlds, {WORLDS} x {RAYS} rays, {len(instances)} instances, {outputs}: "
              f"{np.median(times[10:]):.2f} ms a call, updates included")


if __name__ == "__main__":
    closed_form()
    compare(sys.argv[1])
    measure(sys.argv[1])
