"""latelight.newton.SensorCamera and Newton's own camera sensor, which traces rays, on the same models.

    python3 tests/gpu/newton_sensor.py [--robot g1.xml]

Bodies of all worlds get new poses in each call, and times are those of whole calls, from poses in the device's memory
to complete images there; Newton's include the refit of its BVH. Calls alternate between the two. The rows without
colors of shapes leave out `base_color`, one color per world and shape, to show what it costs. --robot adds a robot of
MJCF, which Newton reads with mujoco. Requires newton and, with the default --device, an NVIDIA GPU. Not part of the
test suite, which has no GPU.
"""

import argparse
import math
import statistics
import time

import newton
import numpy as np
import warp as wp
from latelight.newton import SensorCamera

FOV = 0.7  # radians, vertical
POSES = 8  # sets of poses, used in turn


def bodies():
    """A world of 32 bodies in three rings."""
    builder = newton.ModelBuilder()
    shapes = [
        ("box", {"hx": 0.3, "hy": 0.4, "hz": 0.2}), ("sphere", {"radius": 0.35}),
        ("capsule", {"radius": 0.2, "half_height": 0.3}), ("cylinder", {"radius": 0.25, "half_height": 0.3}),
    ]  # fmt: skip
    for i in range(32):
        angle, radius = 2 * math.pi * i / 11, 1.0 + 0.8 * (i // 11)
        place = wp.transform(wp.vec3(radius * math.cos(angle), radius * math.sin(angle), 0.5), wp.quat_identity())
        shape, sizes = shapes[i % len(shapes)]
        getattr(builder, f"add_shape_{shape}")(builder.add_body(xform=place), **sizes)
    return builder, (7.0, 0.0, 4.0)


def robot(path):
    builder = newton.ModelBuilder()
    builder.add_mjcf(path)
    return builder, (2.6, 0.0, 1.2)


def camera_at(eye, target):
    """The transform of a camera that looks along -Z with Y up."""
    back = np.subtract(eye, target) / np.linalg.norm(np.subtract(eye, target))
    right = np.cross((0, 0, 1), back) / np.linalg.norm(np.cross((0, 0, 1), back))
    axes = np.stack([right, np.cross(back, right), back], 1)
    return wp.transform(wp.vec3(*eye), wp.quat_from_matrix(wp.mat33(*axes.ravel().tolist())))


class WithoutColors(SensorCamera):
    """The sensor without the colors of shapes."""

    def _render(self, *arguments):
        sensor = super()
        if self._renderer is None:
            sensor._render(*arguments)
            render_worlds = self._renderer.render_worlds

            class Renderer:
                def render_worlds(_, *positional, base_color=None, **named):
                    return render_worlds(*positional, **named)

            self._renderer, self._results = Renderer(), {}
        return sensor._render(*arguments)


class Sensor:
    def __init__(self, kind, model, eye, worlds, side, names, device):
        self.sensor = kind(model)
        self.sensor.create_default_light()
        self.rays = kind.compute_camera_rays_pinhole(side, side, device=device, camera_fov=FOV)
        self.cameras = wp.array([camera_at(eye, (0, 0, 0.6))] * worlds, dtype=wp.transformf, device=device)
        allocate = {"color_image": "color", "depth_image": "depth", "shape_index_image": "shape_index"}
        self.images = {
            name: getattr(self.sensor, f"allocate_image_{allocate[name]}")(worlds, side, side) for name in names
        }

    def update(self, state):
        self.sensor.update(state, self.cameras, self.rays, **self.images)
        wp.synchronize()


def seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def random_states(model, worlds):
    """States whose bodies are moved and turned a little, at random."""
    rest, states = model.state(), []
    newton.eval_fk(model, model.joint_q, model.joint_qd, rest)
    poses = rest.body_q.numpy()
    for seed in range(POSES):
        rng, state = np.random.default_rng(seed), model.state()
        moved = poses.copy()
        moved[:, :3] += rng.normal(scale=0.02, size=moved[:, :3].shape)
        moved[:, 3:] += rng.normal(scale=0.05, size=moved[:, 3:].shape)
        moved[:, 3:] /= np.linalg.norm(moved[:, 3:], axis=1, keepdims=True)
        state.body_q.assign(moved)
        states.append(state)
    wp.synchronize()
    return states


def levels(sensor):
    return sensor.images["color_image"].numpy().view(np.uint8).astype(int)


def measure(what, builder, eye, worlds, side, names, runs, device):
    scene = newton.ModelBuilder()
    scene.replicate(builder, worlds)
    model = scene.finalize(device=device)
    kinds = {"latelight": SensorCamera, "without colors of shapes": WithoutColors, "newton": newton.sensors.SensorCamera}
    sensors = {name: Sensor(kind, model, eye, worlds, side, names, device) for name, kind in kinds.items()}
    states, times = random_states(model, worlds), {name: [] for name in kinds}
    for run in range(runs + 4):
        state = states[run % POSES]
        for name, sensor in sensors.items():
            refit = seconds(lambda: (model.bvh_refit_shapes(state), wp.synchronize())) if name == "newton" else 0
            times[name].append(refit + seconds(sensor.update, state))
    medians = {name: statistics.median(values[4:]) for name, values in times.items()}
    same = (np.abs(levels(sensors["latelight"]) - levels(sensors["newton"])) <= 8).mean()
    print(f"{worlds} worlds of {what}, {side}x{side}, {' + '.join(names)}:")
    for name, median in medians.items():
        print(f"    {name}: {median * 1e3:.2f} ms, {worlds / median / 1e3:.3g} thousand views per second")
    print(f"    {medians['newton'] / medians['latelight']:.2f} times; {same:.1%} of the channels within 8 levels",
          flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", help="an MJCF file")
    parser.add_argument("--device", default="cuda:0")
    parser.add_argument("--worlds", type=int, nargs="+", default=[1024, 4096])
    parser.add_argument("--side", type=int, default=64)
    parser.add_argument("--runs", type=int, default=20)
    options = parser.parse_args()
    wp.config.quiet = True
    models = {"32 bodies": bodies()}
    if options.robot:
        models["a robot"] = robot(options.robot)
    for what, (builder, eye) in models.items():
        for worlds in options.worlds:
            for names in (["color_image"], ["color_image", "depth_image", "shape_index_image"]):
                measure(what, builder, eye, worlds, options.side, names, options.runs, options.device)


if __name__ == "__main__":
    main()
