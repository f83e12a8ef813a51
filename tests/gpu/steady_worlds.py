"""10,000 steps of worlds with rays whose arrays in CUDA's memory change in every step.

Each step moves objects, removes some, moves a camera, and changes lights and environments. Rays find the visible
surfaces, shadows and one bounce of light. After ten steps, neither the memory of the device nor that of the process may
grow, and some worlds must have the bytes of the same world as the only one of another renderer. Requires an NVIDIA GPU
and torch. Not part of the test suite, which has no GPU.

usage: steady_worlds.py [STEPS]
"""

import resource
import sys
import time

import latelight
import numpy as np
import torch

WORLDS, SIZE, SETS = 256, (32, 32), 16
FORMATS = {"rgba": "rgb8", "depth": "float16"}
OPTIONS = {"shadows": "rays", "samples": 1, "raster": "rays", "background": "hdri"}
ENVIRONMENTS = ["studio", "dusk.hdr"]


def write_environment(name):
    """A sky whose radiance falls towards the ground, as a Radiance file of flat pixels."""
    height = 32
    pixels = np.empty((height, 2 * height, 4), np.uint8)
    pixels[...] = (200, 150, 130, 128)
    pixels[: height // 4, :, 3] = 130
    with open(name, "wb") as file:
        file.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {2 * height}\n".encode())
        file.write(pixels.tobytes())


def boxes():
    scene = latelight.Scene("builtin:boxes")
    for light in scene.lights():
        scene.remove_light(light)
    scene.add_light(latelight.Light(type="point", position=(1, 2, 1), intensity=8, size=0.1))
    scene.add_light(latelight.Light(type="spot", position=(-1, 3, 1), direction=(0.3, -1, -0.3), intensity=20))
    scene.add_light(latelight.Light(type="directional", direction=(-0.6, -1, 0.1), intensity=1))
    return scene


def state(scene, camera, seed):
    """The arrays of one step."""
    rng = np.random.default_rng(seed)
    rest = np.array([scene.instance(handle).transform for handle in scene.instances()], np.float32)
    transforms = np.tile(rest, (WORLDS, 1, 1, 1))
    transforms[:, :, :3, 3] += rng.uniform(-0.4, 0.4, transforms.shape[:2] + (3,))
    if seed % 5 == 0:
        transforms[rng.integers(WORLDS), 0, 0, 3] = np.nan
    poses = np.tile(np.asarray(camera.camera_to_world, np.float32), (WORLDS, 1, 1, 1))
    poses[:, :, :3, 3] += rng.uniform(-0.2, 0.2, (WORLDS, 1, 3))
    position = rng.uniform(-2, 2, (WORLDS, 3, 3)) + (0, 3, 0)
    values = {
        "transforms": transforms,
        "exists": rng.random(transforms.shape[:2]) > 0.1,
        "camera_to_world": poses,
        "light_position": position.astype(np.float32),
        "light_intensity": rng.uniform(0, 9, (WORLDS, 3)).astype(np.float32) * (rng.random((WORLDS, 3)) > 0.2),
        "environment_index": rng.integers(0, len(ENVIRONMENTS), WORLDS).astype(np.int32),
        "environment_rotation": rng.uniform(0, 360, WORLDS).astype(np.float32),
        "environment_intensity": rng.uniform(0, 1, WORLDS).astype(np.float32),
    }
    return {key: torch.from_numpy(np.ascontiguousarray(value)).cuda() for key, value in values.items()}


def render(renderer, scene, camera, arrays, indirect, count=WORLDS, out=None):
    return renderer.render_worlds(
        count, camera, SIZE, tuple(FORMATS), formats=FORMATS, on_device=True, out=out, instances=scene.instances(),
        lights=scene.lights(), environments=ENVIRONMENTS, indirect=indirect, **OPTIONS, **arrays)


def compare(frames, world, alone, scene, camera, arrays, indirect):
    one = {key: value[world : world + 1].clone() for key, value in arrays.items()}
    single = render(alone, scene, camera, one, indirect, 1)
    for key in FORMATS:
        there, here = torch.from_dlpack(frames[key])[world], torch.from_dlpack(single[key])[0]
        assert torch.equal(there, here), f"{key} of world {world}"


def footprint():
    """Used memory of the device, and the largest resident size of the process so far, in bytes."""
    free, total = torch.cuda.mem_get_info()
    return total - free, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def run(steps, indirect):
    scene = boxes()
    camera = scene.look_at((3, 2, 4), (0, 0, 0))
    renderer, alone = (latelight.Renderer(scene, device="cuda:0") for _ in range(2))
    arrays = [state(scene, camera, seed) for seed in range(SETS)]
    out, times, compared = None, [], 0
    compare(render(renderer, scene, camera, arrays[1], indirect), 0, alone, scene, camera, arrays[1], indirect)
    for step in range(steps):
        torch.cuda.synchronize()
        start = time.perf_counter()
        out = render(renderer, scene, camera, arrays[step * 7 % SETS], indirect, out=out)
        times.append(time.perf_counter() - start)
        if step == 10:
            device, process = footprint()
        if step % 500 == 250:
            compare(out, step % WORLDS, alone, scene, camera, arrays[step * 7 % SETS], indirect)
            compared += 1
    later, resident = footprint()
    assert later <= device, f"the device's memory grew by {later - device} bytes"
    assert resident <= process + (8 << 20), f"the process grew by {resident - process} bytes"
    print(f"{indirect}: {steps} steps of {WORLDS} worlds of {SIZE[0]}x{SIZE[1]}, median {np.median(times) * 1e3:.2f} ms, "
          f"the last tenth {np.median(times[-steps // 10:]) * 1e3:.2f}; {later - device:+} bytes of the device, "
          f"{resident - process:+} of the process; {compared} worlds compared", flush=True)


if __name__ == "__main__":
    write_environment(ENVIRONMENTS[1])
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    for bounces in ("one-bounce", "path"):
        run(count if bounces == "one-bounce" else count // 10, bounces)
