"""Worlds with joints and vertices of their own, from arrays in CUDA's memory: torch, CuPy, JAX and Warp.

Checks that each library's arrays give the images of the same arrays on the host, that no byte passes through the host,
and that moved vertices have the bytes of an edited mesh. Then measures steady calls, with new poses in each. Requires
an NVIDIA GPU. Not part of the test suite, which has none.

usage: deformed_worlds.py FIGURE.glb
"""

import sys
import time
import traceback

import numpy as np

import latelight
from world_tensors import FORMATS, library, makers

SIZE = (64, 64)


def figure_poses(scene, joints, count, seed=0):
    """Random poses of a skeleton as (count, J, 4, 4) float32: each joint turns about its own origin."""
    rng = np.random.default_rng(seed)
    nodes = {node.path: node for node in scene.nodes}
    rest = {path: np.asarray(node.transform, np.float64) for path, node in nodes.items()}
    posed = {}

    def turns():
        angle, axis = rng.uniform(-0.35, 0.35, count), rng.normal(size=(count, 3))
        x, y, z = (axis / np.linalg.norm(axis, axis=1, keepdims=True)).T
        k = np.zeros((count, 3, 3))
        k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -z, y, -x
        k -= k.transpose(0, 2, 1)
        matrices = np.tile(np.eye(4), (count, 1, 1))
        matrices[:, :3, :3] += np.sin(angle)[:, None, None] * k + (1 - np.cos(angle))[:, None, None] * k @ k
        return matrices

    def pose(path):
        if path not in posed:
            parent = nodes[path].parent
            relative = np.linalg.inv(rest[parent]) @ rest[path] if parent else rest[path]
            above = pose(parent) if parent else np.tile(np.eye(4), (count, 1, 1))
            posed[path] = above @ relative @ turns() if path in joints else above @ relative
        return posed[path]

    return np.stack([pose(path) for path in joints], 1).astype(np.float32)


def check_joints(scene, renderer, joints, camera):
    poses, before = figure_poses(scene, joints, 300), figure_poses(scene, joints, 300, 1)
    outputs = ("rgba", "depth", "id", "normal", "motion")
    given = {"joints": joints, "shadows": "none", "on_device": True, "formats": FORMATS}
    arrays = {"joint_transforms": poses, "previous_joint_transforms": before}
    check_libraries(renderer, camera, outputs, given, arrays, "joints")
    alone = renderer.render_worlds(1, camera, SIZE, outputs, joints=joints, joint_transforms=poses[7:8],
                                   previous_joint_transforms=before[7:8], shadows="none")
    together = renderer.render_worlds(300, camera, SIZE, outputs, joints=joints, joint_transforms=poses,
                                      previous_joint_transforms=before, shadows="none")
    for output in outputs:
        np.testing.assert_array_equal(together[output][7], alone[output][0])
    hardware = renderer.render_worlds(300, camera, SIZE, ("depth", "id"), joints=joints, joint_transforms=poses,
                                      shadows="none", raster="hardware")
    np.testing.assert_array_equal(together["id"], hardware["id"])
    seen = together["id"] != 0
    error = np.abs(together["depth"][seen] - hardware["depth"][seen]).max()
    print(f"joints: both rasters show the same objects, and their depths differ by at most {error:.2g} m")


def check_libraries(renderer, camera, outputs, given, arrays, what):
    count = len(next(iter(arrays.values())))
    host = renderer.render_worlds(count, camera, SIZE, outputs, **arrays, **given)
    copied, expected = renderer.copied_bytes, None
    for name, to_gpu, to_host in makers():
        if expected is None:
            expected = {output: to_host(array) for output, array in host.items()}
        tensors = {key: to_gpu(value) for key, value in arrays.items()}
        frames = renderer.render_worlds(count, camera, SIZE, outputs, **tensors, **given)
        for output, array in frames.items():
            np.testing.assert_array_equal(to_host(array), expected[output], f"{name}: {output}")
        size = sum(array.nbytes for array in arrays.values())
        assert renderer.copied_bytes - copied == size, "every byte is copied on the device, once"
        copied = renderer.copied_bytes
        print(f"{what}, {name}: {count} worlds equal those of host arrays; {size} bytes copied on the device")


def check_vertices():
    """A cloth whose vertices move has the bytes of the edited mesh, and a world with NaN is reported."""
    side, count = 33, 200
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    rest = np.stack([x, y, 0 * x], -1).reshape(-1, 3).astype(np.float32)
    at = np.arange(side * side).reshape(side, side)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)
    made, edited = latelight.Scene(), latelight.Scene()
    for scene in (made, edited):
        mesh = scene.add_mesh(rest, triangles, normals=np.tile(np.float32([0, 0, 1]), (len(rest), 1)))
        scene.add_instance(mesh, scene.add_material(latelight.Material(base_color=(0.2, 0.5, 0.8, 1),
                                                                       double_sided=True)))
        scene.add_light(latelight.Light(position=(1, 2, 3), intensity=40))
    rng = np.random.default_rng(2)
    vertices = np.tile(rest, (count, 1, 1))
    wave = rng.uniform(1, 5, (count, 1)) * rest[:, 0] + rng.uniform(0, 6, (count, 1))
    vertices[..., 2] = rng.uniform(0.05, 0.5, (count, 1)) * np.sin(wave) * rest[:, 1]
    camera = latelight.Camera.look_at((0, -1, 4), (0, 0, 0))
    renderer = latelight.Renderer(made, device="cuda:0")
    outputs = ("rgba", "depth", "id", "normal", "motion")
    given = {"meshes": made.meshes(), "shadows": "none", "on_device": True}
    check_libraries(renderer, camera, outputs, given, {"vertices": vertices}, "vertices")
    frames = renderer.render_worlds(count, camera, SIZE, outputs, vertices=vertices, meshes=made.meshes(),
                                    shadows="none")
    alone = latelight.Renderer(edited, device="cuda:0")
    for world in range(0, count, 5):
        edited.set_mesh(edited.meshes()[0], vertices[world], triangles, normals=0 * vertices[world])
        expected = alone.render(camera, SIZE, outputs, shadows="none")
        for output in outputs:
            np.testing.assert_array_equal(frames[world][0][output], expected[output], f"world {world}: {output}")
    print("vertices: worlds have the bytes of the edited mesh")
    check_rays(renderer, alone, edited, camera, vertices, triangles)
    name, to_gpu, to_host = next(makers())
    vertices[7, 3, 1] = np.nan
    frames = renderer.render_worlds(count, camera, SIZE, "id", meshes=made.meshes(), vertices=to_gpu(vertices),
                                    on_device=True, shadows="none")
    assert frames.invalid_worlds == (7,) and not to_host(frames["id"])[7].any()
    print("a world with NaN is reported, and shows nothing")
    return renderer


def check_rays(renderer, alone, edited, camera, vertices, triangles):
    """Light that rays find among moved vertices is that of the edited mesh, apart from the rounding of two shaders."""
    given = {"shadows": "rays", "indirect": "one-bounce", "samples": 4}
    frames = renderer.render_worlds(len(vertices), camera, SIZE, ("color",), vertices=vertices,
                                    meshes=renderer.scene.meshes(), **given)
    worst, others, pixels = 0.0, 0, 0
    for world in range(0, len(vertices), 20):
        edited.set_mesh(edited.meshes()[0], vertices[world], triangles, normals=0 * vertices[world])
        expected = alone.render(camera, SIZE, ("color",), **given)["color"]
        difference = np.abs(frames[world][0]["color"] - expected)
        worst = max(worst, difference.mean() / expected.mean())
        others += np.count_nonzero(difference.any(-1))
        pixels += difference[..., 0].size
    assert worst < 1e-4, worst
    print(f"rays: {others} of {pixels} pixels differ from the edited mesh, by at most {worst:.2g} of the mean of a world")


def measure(renderer, camera, count, what, arguments, tensors=(), runs=30):
    """`tensors`: the name of an argument and the arrays that successive calls give."""
    torch = library("torch")
    given = {"formats": FORMATS, "on_device": True, "shadows": "none", **arguments}
    out, host, total = None, [], []
    for run in range(runs + 6):
        own = {tensors[0]: tensors[1][run % len(tensors[1])]} if tensors else {}
        torch.cuda.synchronize()
        start = time.perf_counter()
        ticket = renderer.submit_worlds(count, camera, SIZE, ("rgba",), **own, **given, out=out)
        host.append(time.perf_counter() - start)
        out = ticket.take()
        total.append(time.perf_counter() - start)
    host, total = np.median(host[6:]), np.median(total[6:])
    print(f"{count:5} worlds of {SIZE[0]}x{SIZE[1]}, {what}: {count / total:9.0f} views/s, {1e3 * total:.2f} ms, of "
          f"which the host {1e3 * host:.2f} ms until submitted", flush=True)


def measure_all(scene, renderer, joints, camera):
    torch = library("torch")
    for count in (1024, 4096):
        measure(renderer, camera, count, "figure at rest", {})
        poses = [torch.from_numpy(figure_poses(scene, joints, count, seed)).cuda() for seed in range(3)]
        measure(renderer, camera, count, "figure posed by joints", {"joints": joints}, ("joint_transforms", poses))
        for rays in ({"shadows": "rays"}, {"shadows": "rays", "indirect": "one-bounce", "samples": 1}):
            what = ", ".join(f"{key} {value}" for key, value in rays.items())
            measure(renderer, camera, count, f"the same, {what}", {"joints": joints, **rays}, ("joint_transforms", poses))
        mesh = scene.instance(scene.instances()[0]).mesh
        rest = torch.from_numpy(scene.mesh_arrays(mesh)["positions"]).cuda()
        moved = [(rest + 0.01 * torch.randn(count, 1, 3, device="cuda")).contiguous() for _ in range(3)]
        measure(renderer, camera, count, "figure with given vertices", {"meshes": [mesh]}, ("vertices", moved))


if __name__ == "__main__":
    scene = latelight.Scene(sys.argv[1])
    renderer = latelight.Renderer(scene, device="cuda:0", environment="studio")
    body = scene.instances()[0]
    joints = scene.joints(body)
    print(f"{renderer.device}: {len(joints)} joints, {scene.mesh(scene.instance(body).mesh).vertices} vertices, "
          f"{scene.triangle_count} triangles")
    camera = scene.default_camera(1)
    failed = False
    try:
        check_joints(scene, renderer, joints, camera)
        cloth = check_vertices()
        failed = len(cloth.validation_messages()) > 0
    except Exception:  # measure nevertheless
        failed = True
        traceback.print_exc()
    measure_all(scene, renderer, joints, camera)
    for message in renderer.validation_messages():
        failed = True
        print("validation:", message)
    sys.exit(failed)
