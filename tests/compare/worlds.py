r"""Many worlds per call: latelight beside mujoco_warp_pbr (PyPI: mujoco-warp-pbr), a ray tracer in Warp for MuJoCo.

    python3.12 -m venv /tmp/compare
    /tmp/compare/bin/pip install mujoco-warp-pbr==0.2.0 pillow torch nanobind-backend
    PYTHONPATH=build/release/python /tmp/compare/bin/python tests/compare/worlds.py \
        DamagedHelmet.glb --environment spiaggia_1k.hdr

Every world has its own pose of the object, and each call has new poses, which lie in the device's memory; so do the
images. A time is that of a whole call, from poses to complete images, and rows alternate between the two renderers.
mujoco_warp_pbr's times include `kinematics` and the refit of its BVH, which place the object ("update"), and are given
without them, too. "In a row" is the time per call of 32 calls, whose poses are in the device's memory before: the host
waits for mujoco_warp_pbr only in the end, and two of Latelight's calls are in flight. --robot FILE.xml adds a robot of
MJCF with random joints, whose kinematics MuJoCo Warp computes for both. --device cpu compares on the processor:
mujoco_warp_pbr uses one core per process, so it gets a process per core. There, Latelight renders with several rasters
in turn, and processor times of both are printed, too, because they depend less on the other work of a machine.
--pictures FOLDER writes an image of each, to see that both render the same.
"""

import argparse
import functools
import io
import math
import multiprocessing
import os
import statistics
import time

import numpy as np

FOV = 40.0  # degrees, vertical
DISTANCE = 3.2  # meters from the helmet, whose bounds have a radius of about 1.2
WARM_UP = 4  # runs
CALLS, EVERY = 32, 4  # calls in a row, after each fourth run


def random_quaternions(count, seed):
    q = np.random.default_rng(seed).normal(size=(count, 4))
    return (q / np.linalg.norm(q, axis=1, keepdims=True)).astype(np.float32)


def matrices(quaternions):
    """Rotation matrices (N, 3, 3) of quaternions (w, x, y, z)."""
    w, x, y, z = np.moveaxis(quaternions.astype(np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


# --- the helmet as MJCF -----------------------------------------------------------------------------------------------


def png(pixels):
    from PIL import Image

    to = io.BytesIO()
    Image.fromarray(pixels[..., :3]).save(to, "png")
    return to.getvalue()


def mjcf_of(scene, sun):
    """The scene's first instance as a free body: MJCF, and its assets by name."""
    instance = scene.instance(scene.instances()[0])
    mesh = scene.mesh_arrays(instance.mesh)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh["positions"]]
    lines += [f"vt {u:.9g} {1 - v:.9g}" for u, v in mesh["uv"]]
    lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh["normals"]]
    for a, b, c in mesh["indices"].reshape(-1, 3) + 1:
        lines.append(f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")
    assets = {"object.obj": "\n".join(lines).encode()}
    textures, layers = "", ""
    slots = {"base_color": "rgb", "metallic_roughness": "orm", "normal": "normal", "emissive": "emissive"}
    for slot, role in slots.items():
        if texture := scene.texture_of(instance.material, slot):
            pixels = scene.texture_pixels(texture).copy()
            if role == "orm":  # glTF may have occlusion in a texture of its own
                occlusion = scene.texture_of(instance.material, "occlusion")
                pixels[..., 0] = scene.texture_pixels(occlusion)[..., 0] if occlusion else 255
            assets[f"{slot}.png"] = png(pixels)
            space = "sRGB" if role in ("rgb", "emissive") else "linear"
            textures += f'<texture name="{slot}" type="2d" file="{slot}.png" colorspace="{space}"/>'
            layers += f'<layer role="{role}" texture="{slot}"/>'
    light = '<light type="directional" dir="-0.5 -0.7 -0.5" castshadow="true" intensity="{:g}" diffuse="1 1 1"/>'
    return f"""
<mujoco>
  <asset>
    <mesh name="object" file="object.obj"/>{textures}
    <material name="object" metallic="1" roughness="1" specular="0.5" emission="1">{layers}</material>
  </asset>
  <visual><headlight active="0"/><map znear="0.001"/></visual>
  <worldbody>
    {light.format(math.pi) if sun else ""}
    <camera name="eye" pos="0 0 {DISTANCE}" fovy="{FOV}"/>
    <body><freejoint/><geom type="mesh" mesh="object" material="object" mass="1" contype="0" conaffinity="0"/></body>
  </worldbody>
</mujoco>""", assets


# --- the two renderers ------------------------------------------------------------------------------------------------


class Kinematics:
    """The worlds of a MuJoCo model, which MuJoCo Warp places."""

    def __init__(self, model, worlds, device):
        import mujoco
        import mujoco_warp as mjw
        import warp as wp

        wp.config.quiet = True
        self.wp, self.mjw, self.device = wp, mjw, device
        with wp.ScopedDevice(device):
            self.model = mjw.put_model(model)
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
            self.data = mjw.put_data(model, data, nworld=worlds)

    def on_device(self, qpos):
        """States (N, nq) in memory of the device."""
        with self.wp.ScopedDevice(self.device):
            return self.wp.array(qpos, dtype=float)

    def pose(self, qpos):
        """Sets new states (N, nq)."""
        self.qpos = self.on_device(qpos)

    def place(self):
        """Computes where everything is."""
        self.start_placing(self.qpos)
        self.wp.synchronize_device(self.device)

    def start_placing(self, qpos):
        with self.wp.ScopedDevice(self.device):
            self.wp.copy(self.data.qpos, qpos)
            self.mjw.kinematics(self.model, self.data)
            self.mjw.camlight(self.model, self.data)


class Rival(Kinematics):
    """mujoco_warp_pbr, of a MuJoCo model."""

    def __init__(self, model, worlds, side, environment, outputs, device):
        import mujoco_warp_pbr as pbr

        super().__init__(model, worlds, device)
        self.pbr = pbr
        with self.wp.ScopedDevice(device):
            # It stores environments as half floats, which are smaller than the sun in most files.
            radiance = np.minimum(pbr.load_hdr(environment), 65504.0)
            self.context = pbr.create_render_context(
                model, nworld=worlds, cam_active=["eye"], cam_res=(side, side), render_rgb=True,
                render_depth="depth" in outputs, render_seg="id" in outputs, render_guides="normal" in outputs,
                envmap=radiance, envmap_background=False, ev100=-math.log2(1.2))  # exposure 1

    def update(self):
        self.place()
        with self.wp.ScopedDevice(self.device):
            self.mjw.refit_bvh(self.model, self.data, self.context.base)
            self.wp.synchronize()

    def render(self):
        with self.wp.ScopedDevice(self.device):
            self.pbr.render(self.model, self.data, self.context)
            self.wp.synchronize()

    def render_in_a_row(self, states):
        """Renders a call for each of `states`, which are in memory of the device."""
        with self.wp.ScopedDevice(self.device):
            for qpos in states:
                self.start_placing(qpos)
                self.mjw.refit_bvh(self.model, self.data, self.context.base)
                self.pbr.render(self.model, self.data, self.context)
            self.wp.synchronize()

    def image(self, world, side):
        with self.wp.ScopedDevice(self.device):
            rgb = self.wp.zeros((self.data.nworld, side, side), dtype=self.wp.vec3)
            self.pbr.get_rgb(self.context, 0, rgb)
            return (rgb.numpy()[world] * 255 + 0.5).astype(np.uint8)


class Latelight:
    half = {"rgba": "rgb8", "depth": "float16", "id": "uint16", "normal": "float16"}
    sun_shadows = {"shadows": "d32"}

    def __init__(self, scene, camera, worlds, side, environment, outputs, device, sun, raster="auto"):
        import latelight

        options = {"sun": (45, 45, math.pi)} if sun else {}
        options |= self.sun_shadows if sun else {"shadows": "none"}
        options["raster"] = raster
        self.renderer = latelight.Renderer(scene, device=device, environment=environment)
        formats = {key: self.half[key] for key in outputs}
        self.submit = lambda out, arrays: self.renderer.submit_worlds(
            worlds, camera, (side, side), outputs, formats=formats, on_device=True, out=out, **options, **arrays)
        self.device, self.arrays, self.outs = device, {}, [None, None]

    def on_device(self, array):
        if self.device == "cpu":
            return array
        import torch

        tensor = torch.from_numpy(np.ascontiguousarray(array)).cuda()
        torch.cuda.synchronize()
        return tensor

    def render(self):
        self.outs[0] = self.submit(self.outs[0], self.arrays).take()

    def render_in_a_row(self, steps):
        """Renders a call for each of `steps`, functions that return its arrays. Two calls are in flight."""
        waiting = None
        for i, arrays in enumerate(steps):
            ticket = self.submit(self.outs[i % 2], arrays())
            if waiting:
                self.outs[(i - 1) % 2] = waiting.take()
            waiting = ticket
        self.outs[(len(steps) - 1) % 2] = waiting.take()

    def image(self, world, side):
        if self.device == "cpu":
            array = np.from_dlpack(self.outs[0]["rgba"])
        else:
            import torch

            array = torch.from_dlpack(self.outs[0]["rgba"]).cpu().numpy()
        return array.reshape(-1, side, side, 3)[world]


class Robot:
    """An MJCF robot with random joint angles. MuJoCo Warp computes where its geoms are, for both renderers."""

    outputs = ("rgba", "depth")

    def __init__(self, path, environment, device):
        import latelight
        import mujoco

        spec = mujoco.MjSpec.from_file(path)
        spec.worldbody.add_camera(name="eye", pos=[2.2, 0, 1], xyaxes=[0, 1, 0, -0.1, 0, 1], fovy=FOV)
        spec.worldbody.add_light(type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, dir=[-0.5, 0.3, -0.8], castshadow=False)
        self.model = spec.compile()
        self.converted = latelight.from_mujoco(self.model)
        self.environment, self.device = environment, device

    def rival(self, worlds, side):
        return Rival(self.model, worlds, side, self.environment, self.outputs, rival_device(self.device))

    def latelight(self, worlds, side, raster="rays"):
        cameras = [camera for camera in self.converted.cameras if camera.name == "eye"]
        return Latelight(
            self.converted.scene, cameras, worlds, side, self.environment, self.outputs, self.device, False, raster)

    def states(self, worlds, seed):
        rng = np.random.default_rng(seed)
        qpos = np.tile(self.model.qpos0, (worlds, 1)).astype(np.float32)
        for joint in range(self.model.njnt):
            if self.model.jnt_limited[joint]:
                low, high = self.model.jnt_range[joint]
                qpos[:, self.model.jnt_qposadr[joint]] = rng.uniform(0.5 * low, 0.5 * high, worlds)
        return qpos

    def arrays(self, data):
        """The arguments of render_worlds() of states in the device's memory, which stay there."""
        import warp as wp

        read = wp.array.numpy if self.device == "cpu" else wp.to_torch
        return self.converted.worlds(geom_xpos=read(data.geom_xpos), geom_xmat=read(data.geom_xmat))


RIVAL, IN_A_ROW = ("with update", "render alone"), ("ours in a row", "rival in a row")


def medians(times):
    """Of each list, without the runs of the warm-up."""
    first = {name: WARM_UP // EVERY if name in IN_A_ROW else WARM_UP for name in times}
    return {name: statistics.median(values[first[name]:]) for name, values in times.items()}


def measure_robot(robot, worlds, side, runs, pictures):
    """Median seconds from joint angles to images; alone: from poses of geoms, or from a complete BVH."""
    import torch

    ours, rival = robot.latelight(worlds, side), robot.rival(worlds, side)
    times = {name: [] for name in ("ours", "ours alone", *RIVAL, *IN_A_ROW)}

    def placed(qpos):
        rival.start_placing(qpos)
        return robot.arrays(rival.data)

    for run in range(runs + WARM_UP):
        rival.pose(robot.states(worlds, run))
        update, render = seconds(rival.update), seconds(rival.render)
        place = seconds(rival.place)

        def call():
            ours.arrays = robot.arrays(rival.data)
            ours.render()

        alone = seconds(call)
        times["ours"].append(place + alone)
        times["ours alone"].append(alone)
        times["with update"].append(update + render)
        times["render alone"].append(render)

        if run % EVERY == 0:
            states = [rival.on_device(robot.states(worlds, CALLS * run + i)) for i in range(CALLS)]
            steps = [functools.partial(placed, qpos) for qpos in states]
            torch.cuda.synchronize()
            with torch.cuda.stream(torch.cuda.ExternalStream(rival.wp.get_stream(rival.device).cuda_stream)):
                times["ours in a row"].append(seconds(lambda: ours.render_in_a_row(steps)) / CALLS)
            times["rival in a row"].append(seconds(lambda: rival.render_in_a_row(states)) / CALLS)
    if pictures:
        save(pictures, f"robot-{worlds}-{side}", ours, rival, side)
    return medians(times)


class Helmet:
    """A scene of one object, whose pose in each world is random."""

    def __init__(self, path, environment, device):
        import latelight

        self.scene = latelight.Scene(path)
        self.environment, self.device = environment, device
        self.camera = self.scene.look_at((0, 0, DISTANCE), (0, 0, 0), vertical_fov=FOV)
        self.instance = self.scene.instances()[0]

    def rival(self, worlds, side, outputs, sun):
        model = mujoco_model(*mjcf_of(self.scene, sun))
        return Rival(model, worlds, side, self.environment, outputs, rival_device(self.device))

    def latelight(self, worlds, side, outputs, sun, raster="auto"):
        return Latelight(self.scene, self.camera, worlds, side, self.environment, outputs, self.device, sun, raster)

    def states(self, worlds, seed):
        """Poses, as the two renderers accept them."""
        q = random_quaternions(worlds, seed)
        qpos = np.concatenate([np.zeros((worlds, 3), np.float32), q], axis=1)
        transforms = np.zeros((worlds, 1, 3, 4), np.float32)
        transforms[:, 0, :, :3] = matrices(q)
        return qpos, {"instances": [self.instance], "transforms": transforms}


def mujoco_model(xml, assets):
    import mujoco

    return mujoco.MjModel.from_xml_string(xml, assets)


def rival_device(device):
    return "cpu" if device == "cpu" else "cuda:0"


# --- measuring --------------------------------------------------------------------------------------------------------


def seconds(call):
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def measure(helmet, worlds, side, outputs, sun, runs, pictures):
    """Median seconds of a call: latelight, mujoco_warp_pbr, and the latter without the update."""
    ours, rival = helmet.latelight(worlds, side, outputs, sun), helmet.rival(worlds, side, outputs, sun)
    times = {name: [] for name in ("ours", *RIVAL, *IN_A_ROW)}

    def placed(arrays):
        return {key: ours.on_device(value) if key == "transforms" else value for key, value in arrays.items()}

    for run in range(runs + WARM_UP):
        qpos, arrays = helmet.states(worlds, run)
        ours.arrays = placed(arrays)
        times["ours"].append(seconds(ours.render))
        rival.pose(qpos)
        update, render = seconds(rival.update), seconds(rival.render)
        times["with update"].append(update + render)
        times["render alone"].append(render)

        if run % EVERY == 0:
            states = [helmet.states(worlds, CALLS * run + i) for i in range(CALLS)]
            steps = [functools.partial(dict, placed(arrays)) for _, arrays in states]
            times["ours in a row"].append(seconds(lambda: ours.render_in_a_row(steps)) / CALLS)
            steps = [rival.on_device(qpos) for qpos, _ in states]
            rival.wp.synchronize()
            times["rival in a row"].append(seconds(lambda: rival.render_in_a_row(steps)) / CALLS)
    if pictures:
        save(pictures, f"{worlds}-{side}-{len(outputs)}{'-sun' * sun}", ours, rival, side)
    return medians(times)


def save(folder, name, ours, rival, side):
    from PIL import Image

    os.makedirs(folder, exist_ok=True)
    rows = [np.concatenate([renderer.image(world, side) for world in range(8)], axis=1) for renderer in (ours, rival)]
    Image.fromarray(np.concatenate(rows)).save(os.path.join(folder, name + ".png"))


COLOR, FOUR = ("rgba",), ("rgba", "depth", "id", "normal")
ROWS = [  # worlds, side, outputs, sun
    (1024, 64, COLOR, False), (4096, 64, COLOR, False), (4096, 64, FOUR, False), (4096, 64, COLOR, True),
    (1024, 128, COLOR, False), (4096, 128, COLOR, False),
    (1024, 256, COLOR, False), (4096, 256, COLOR, False), (4096, 256, FOUR, False),
]


def compare_on_gpu(options):
    helmet = Helmet(options.scene, options.environment, "cuda:0")
    for worlds, side, outputs, sun in ROWS:
        what = f"{worlds:5} worlds of {side:3}x{side:<3} {' + '.join(outputs)}{', sun with shadows' * sun}"
        try:
            times = measure(helmet, worlds, side, outputs, sun, options.runs, options.pictures)
        except Exception as error:  # the other rows may work
            print(f"{what}: {type(error).__name__}: {error}", flush=True)
            continue
        report(what, worlds, times)
    if options.robot:
        robot = Robot(options.robot, options.environment, "cuda:0")
        times = measure_robot(robot, 4096, 64, options.runs, options.pictures)
        report(" 4096 robots of  64x64  rgba + depth", 4096, times)
        print(f"  latelight from poses of geoms: {4096 / times['ours alone']:.0f} views/s")


def report(what, worlds, times):
    rates = {name: worlds / value for name, value in times.items()}
    print(f"{what}: latelight {rates['ours']:9.0f} views/s; mujoco_warp_pbr {rates['with update']:9.0f} with update, "
          f"{rates['render alone']:9.0f} render alone; {rates['ours'] / rates['with update']:.2f}, "
          f"{rates['ours'] / rates['render alone']:.2f} times; in a row {rates['ours in a row']:.0f} and "
          f"{rates['rival in a row']:.0f}, {rates['ours in a row'] / rates['rival in a row']:.2f} times", flush=True)


# --- on the processor -------------------------------------------------------------------------------------------------

EACH, SIDE = 32, 64  # worlds per core, pixels


class HelmetOnCpu:
    name, rasters = "helmets", ("hardware", "compute", "rays")

    def __init__(self, options):
        self.helmet = Helmet(options.scene, options.environment, "cpu")

    def rival(self, worlds):
        return self.helmet.rival(worlds, SIDE, COLOR, False)

    def states(self, worlds, seed):
        return self.helmet.states(worlds, seed)[0]

    def latelight(self, worlds, raster):
        return self.helmet.latelight(worlds, SIDE, COLOR, False, raster)

    def prepare(self, worlds, seed):
        """Returns a function of the arguments of render_worlds()."""
        arrays = self.helmet.states(worlds, seed)[1]
        return lambda: arrays


class RobotOnCpu:
    name, rasters = "robots", ("rays",)  # the others are slower by the ratio of triangles to pixels

    def __init__(self, options):
        self.robot, self.kinematics = Robot(options.robot, options.environment, "cpu"), None

    def rival(self, worlds):
        return self.robot.rival(worlds, SIDE)

    def states(self, worlds, seed):
        return self.robot.states(worlds, seed)

    def latelight(self, worlds, raster):
        return self.robot.latelight(worlds, SIDE, raster)

    def prepare(self, worlds, seed):
        if self.kinematics is None:
            self.kinematics = Kinematics(self.robot.model, worlds, "cpu")
        self.kinematics.pose(self.states(worlds, seed))

        def arrays():
            self.kinematics.place()
            return self.robot.arrays(self.kinematics.data)

        return arrays


def rival_on_a_core(subject, options, core, barrier, results):
    os.sched_setaffinity(0, {core})
    subject = subject(options)
    rival = subject.rival(EACH)
    processor = []
    for run in range(options.runs + 1):
        rival.pose(subject.states(EACH, run))
        barrier.wait()
        start = time.process_time()
        rival.update()
        rival.render()
        processor.append(time.process_time() - start)
        barrier.wait()
    if options.pictures:
        np.save(os.path.join(options.pictures, f"{subject.name}-{core}.npy"),
                np.stack([rival.image(world, SIDE) for world in range(8)]))
    results.put(processor[1:])


def compare_on_cpu(subject, options):
    """All alternate: while one renders, the others wait at a barrier."""
    cores = sorted(os.sched_getaffinity(0))
    count = EACH * len(cores)
    context = multiprocessing.get_context("spawn")
    barrier, results = context.Barrier(len(cores) + 1), context.Queue()
    workers = [context.Process(target=rival_on_a_core, args=(subject, options, core, barrier, results))
               for core in cores]
    for worker in workers:
        worker.start()
    subject = subject(options)
    ours = {raster: subject.latelight(count, raster) for raster in subject.rasters}
    elapsed, processor = {name: [] for name in (*subject.rasters, "rival")}, {name: [] for name in subject.rasters}
    for run in range(options.runs + 1):
        for raster in subject.rasters:
            arrays, used, start = subject.prepare(count, run), time.process_time(), time.perf_counter()
            ours[raster].arrays = arrays()
            ours[raster].render()
            elapsed[raster].append(time.perf_counter() - start)
            processor[raster].append(time.process_time() - used)
        barrier.wait()
        start = time.perf_counter()
        barrier.wait()
        elapsed["rival"].append(time.perf_counter() - start)
    processor["rival"] = [0.0] + [sum(times) for times in zip(*(results.get() for _ in workers))]
    for worker in workers:
        worker.join()
    if options.pictures:
        from PIL import Image

        rows = [np.concatenate(np.load(os.path.join(options.pictures, f"{subject.name}-{cores[0]}.npy")), axis=1)]
        subject.prepare(EACH, options.runs)
        for raster in subject.rasters:
            rows.append(np.concatenate([ours[raster].image(world, SIDE) for world in range(8)], axis=1))
        Image.fromarray(np.concatenate(rows)).save(os.path.join(options.pictures, f"{subject.name}-cpu.png"))
    print(f"{count} {subject.name} of {SIDE}x{SIDE} on {len(cores)} cores, load {os.getloadavg()[0]:.1f}")
    for name in (*subject.rasters, "rival"):
        whole, used = (statistics.median(times[name][1:]) for times in (elapsed, processor))
        ratio = statistics.median(b / a for a, b in zip(elapsed[name][1:], elapsed["rival"][1:]))
        print(f"  {name:8}: {count / whole:6.0f} views/s, {ratio:5.2f} times the rival's rate; "
              f"{1e3 * used / count:6.2f} ms of processor time per view", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--environment", required=True)
    parser.add_argument("--device", choices=("gpu", "cpu"), default="gpu")
    parser.add_argument("--robot", help="an MJCF file")
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--pictures")
    parser.add_argument("--sun-rays", action="store_true", help="shadows of latelight's sun by one ray, not by maps")
    options = parser.parse_args()
    if options.sun_rays:
        Latelight.sun_shadows = {"shadows": "rays", "samples": 1}
    if options.device == "gpu":
        return compare_on_gpu(options)
    compare_on_cpu(HelmetOnCpu, options)
    if options.robot:
        compare_on_cpu(RobotOnCpu, options)


if __name__ == "__main__":
    main()
