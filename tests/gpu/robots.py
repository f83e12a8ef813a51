"""Worlds of a robot with far more triangles than pixels, with the rasters compute and rays.

    python3 tests/gpu/robots.py --export robot g1.xml     # robot.glb and robot.npz, with mujoco
    python3 tests/gpu/robots.py robot

Every world has random joint angles, and each call has other poses, from a tensor of torch in the device's memory.
Compares the images of both rasters, then measures steady calls, which alternate between them. Requires an NVIDIA GPU
and torch; --export requires mujoco instead. Not part of the test suite, which has no GPU.
"""

import argparse
import statistics
import time

import numpy as np

import latelight

FOV = 40.0  # degrees, vertical
FORMATS = {"rgba": "rgb8", "depth": "float16"}


def export(name, model):
    """Writes the robot and the transforms (N, I, 3, 4) of its instances in random states."""
    import mujoco

    spec = mujoco.MjSpec.from_file(model)
    spec.worldbody.add_camera(name="eye", pos=[2.2, 0, 1], xyaxes=[0, 1, 0, -0.1, 0, 1], fovy=FOV)
    spec.worldbody.add_light(type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, dir=[-0.5, 0.3, -0.8], castshadow=False)
    model = spec.compile()
    robot = latelight.from_mujoco(model)
    data, rng, states = mujoco.MjData(model), np.random.default_rng(0), []
    limited = model.jnt_limited.astype(bool)
    low, high = model.jnt_range[limited].T
    for _ in range(256):
        data.qpos[model.jnt_qposadr[limited]] = rng.uniform(0.5 * low, 0.5 * high)
        mujoco.mj_kinematics(model, data)
        states.append((data.geom_xpos.copy(), data.geom_xmat.copy()))
    positions, axes = (np.stack(part) for part in zip(*states, strict=True))
    worlds = robot.worlds(geom_xpos=positions, geom_xmat=axes)
    camera = next(camera for camera in robot.cameras if camera.name == "eye")
    handles = robot.scene.instances()
    order = [worlds["instances"].index(handle) for handle in handles]
    transforms = np.asarray(worlds["transforms"])[:, order, :3]
    robot.scene.export(f"{name}.glb")
    np.savez_compressed(f"{name}.npz", transforms=transforms.astype(np.float32), camera=camera.camera_to_world)


class Robots:
    def __init__(self, name, device, worlds, side, environment):
        self.scene = latelight.Scene(f"{name}.glb")
        stored = np.load(f"{name}.npz")
        self.transforms, self.worlds, self.size = stored["transforms"], worlds, (side, side)
        self.camera = latelight.Camera(vertical_fov=FOV, camera_to_world=stored["camera"])
        self.renderer = latelight.Renderer(self.scene, device=device, environment=environment)
        self.out = {}

    def poses(self, call):
        states = np.random.default_rng(call).integers(0, len(self.transforms), self.worlds)
        return self.transforms[states]

    def render(self, raster, transforms, on_device=True, **options):
        frames = self.renderer.render_worlds(
            self.worlds, self.camera, self.size, ("rgba", "depth"), instances=self.scene.instances(),
            transforms=transforms, shadows="none", raster=raster, formats=FORMATS, on_device=on_device,
            out=self.out.get(raster), **options)
        if on_device:
            self.out[raster] = frames
        return frames


def seconds(function):
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def compare(images):
    """Prints how many pixels differ between two rasters, and by how much."""
    compute, rays = images
    color = np.abs(compute["rgba"].astype(int) - rays["rgba"].astype(int)).max(-1)
    near, found = (np.nan_to_num(image["depth"].astype(float), posinf=0) for image in (compute, rays))
    depth = np.abs(near - found)
    print(f"{(color > 2).mean():.3%} of the pixels differ by more than 2 of 255, "
          f"{(depth > 0.01).mean():.3%} by more than 1 cm", flush=True)


def measure(name, worlds, side, runs, environment):
    import torch

    robots = Robots(name, "cuda:0", worlds, side, environment)
    tensors = []
    for call in range(8):
        tensors.append(torch.from_numpy(robots.poses(call)).cuda())
    torch.cuda.synchronize()
    images = []
    for raster in ("compute", "rays"):
        frames = robots.render(raster, tensors[0])
        images.append({key: torch.from_dlpack(frames[key]).cpu().numpy() for key in FORMATS})
    compare(images)
    times = {"compute": [], "rays": []}
    for call in range(runs + 6):
        for raster, values in times.items():
            values.append(seconds(lambda: robots.render(raster, tensors[call % len(tensors)])))  # noqa: B023
    for raster, values in times.items():
        median = statistics.median(values[6:])
        print(f"{worlds} robots of {side}x{side}, raster {raster}: {median * 1e3:.2f} ms per call, "
              f"{worlds / median / 1e3:.0f} thousand views per second", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", help="NAME.glb and NAME.npz")
    parser.add_argument("model", nargs="?", help="with --export, an MJCF file")
    parser.add_argument("--export", action="store_true", help="write NAME.glb and NAME.npz")
    parser.add_argument("--environment", default="studio")
    parser.add_argument("--runs", type=int, default=20)
    options = parser.parse_args()
    if options.export:
        export(options.name, options.model)
        return
    for worlds, side in ((1024, 64), (4096, 64), (4096, 128)):
        measure(options.name, worlds, side, options.runs, options.environment)


if __name__ == "__main__":
    main()
