"""Worlds from arrays in CUDA's memory: torch, CuPy, JAX and Warp, as far as they are installed.

Checks that each library's arrays give the images of the same arrays on the host, that no byte passes through the host,
that the caller's stream comes before the call, and that results are the renderer's memory. Then measures steady calls.
Requires an NVIDIA GPU. Not part of the test suite, which has none.

usage: world_tensors.py [SCENE [ENVIRONMENT ...]]
"""

import ctypes
import importlib
import sys
import time
import traceback

import numpy as np

import latelight

SIZE = (64, 64)
FORMATS = {"rgba": "rgb8"}


def library(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name}: not installed")
        return None


def makers():
    """Functions that copy a NumPy array to the GPU, and back, by the name of the library."""
    if torch := library("torch"):
        yield "torch", lambda a: torch.from_numpy(a).cuda(), lambda a: torch.from_dlpack(a).cpu().numpy()
    if cupy := library("cupy"):
        yield "cupy", cupy.asarray, lambda a: cupy.from_dlpack(a).get()

        class Interface:
            def __init__(self, array):
                self.array = cupy.asarray(array)
                self.__cuda_array_interface__ = self.array.__cuda_array_interface__

        yield "__cuda_array_interface__", Interface, lambda a: cupy.asarray(a).get()
    if jax := library("jax"):
        yield "jax", lambda a: jax.device_put(a, jax.devices("gpu")[0]), lambda a: np.asarray(jax.numpy.from_dlpack(a))
    if warp := library("warp"):

        def from_warp(array):  # arrays of Warp have at most four dimensions
            interface = array.__cuda_array_interface__
            dtype = warp.dtype_from_numpy(np.dtype(interface["typestr"]))
            flat = warp.array(ptr=interface["data"][0], shape=int(np.prod(array.shape)), dtype=dtype, device="cuda")
            return flat.numpy().reshape(array.shape)

        yield "warp", lambda a: warp.array(a, device="cuda"), from_warp


def states(scene, count, seed=0):
    """Random poses of all instances, and of a camera that looks at the scene, as float32."""
    rng = np.random.default_rng(seed)
    instances = scene.instances()
    transforms = np.stack([scene.instance(i).transform for i in instances])[None].repeat(count, 0)
    angle = rng.uniform(-0.3, 0.3, (count, len(instances)))
    turn = np.tile(np.eye(4), (count, len(instances), 1, 1))
    turn[..., 0, 0] = turn[..., 2, 2] = np.cos(angle)
    turn[..., 0, 2], turn[..., 2, 0] = np.sin(angle), -np.sin(angle)
    camera = scene.default_camera()
    poses = np.tile(camera.camera_to_world, (count, 1, 1, 1))
    poses[:, 0, :3, 3] += rng.uniform(-0.05, 0.05, (count, 3))
    exists = rng.uniform(size=(count, len(instances))) > 0.1
    exists[:, 0] = True
    return instances, (turn @ transforms).astype(np.float32), poses.astype(np.float32), exists, camera


def check(name, environments):
    scene = latelight.Scene(name)
    instances, transforms, poses, exists, camera = states(scene, 300)
    scene.add_material(latelight.Material(base_color=(0.2, 0.6, 0.3, 1)))
    lights = [scene.add_light(latelight.Light(type=kind, size=0.2)) for kind in ("point", "spot", "directional",
                                                                                "sphere")]
    renderer = latelight.Renderer(scene, device="cuda:0", environment="studio")
    given = {"instances": instances, "materials": scene.materials(), "lights": lights, "environments": environments,
             "formats": FORMATS, "on_device": True, "shadows": "none"}
    rng = np.random.default_rng(1)
    values = {
        "base_color": rng.uniform(0.2, 1, (300, len(instances), 4)),
        "roughness": rng.uniform(0.1, 1, (300, len(instances))),
        "light_position": rng.uniform(-3, 3, (300, 4, 3)),
        "light_color": rng.uniform(0, 1, (300, 4, 3)),
        "light_intensity": rng.uniform(0, 5, (300, 4)),
        "environment_rotation": rng.uniform(0, 360, 300),
        "environment_intensity": rng.uniform(0.2, 2, 300),
    }
    values = {key: value.astype(np.float32) for key, value in values.items()}
    values["material_choice"] = rng.integers(0, len(scene.materials()), (300, len(instances)), np.int32)
    values["environment_index"] = rng.integers(0, len(environments), 300, np.int32)
    host = renderer.render_worlds(300, camera, SIZE, ("rgba", "depth", "id"), transforms=transforms, exists=exists,
                                  camera_to_world=poses, **values, **given)
    copied = renderer.copied_bytes
    expected = None
    for name, to_gpu, to_host in makers():
        if expected is None:
            expected = {output: to_host(array) for output, array in host.items()}
        arrays = {"transforms": to_gpu(transforms), "exists": to_gpu(exists), "camera_to_world": to_gpu(poses)}
        arrays |= {key: to_gpu(value) for key, value in values.items()}
        frames = renderer.render_worlds(300, camera, SIZE, ("rgba", "depth", "id"), **arrays, **given)
        for output, array in frames.items():
            np.testing.assert_array_equal(to_host(array), expected[output], f"{name}: {output}")
            assert array.__cuda_array_interface__["data"][0] != 0
        bytes_given = sum(array.nbytes for array in (transforms, exists, poses, *values.values()))
        assert renderer.copied_bytes - copied == bytes_given, "every byte is copied on the device, once"
        copied = renderer.copied_bytes
        print(f"{name}: 300 worlds equal those of host arrays; {bytes_given} bytes copied on the device")
    wrong = transforms.copy()
    wrong[7, 0, 0, 0] = np.nan
    name, to_gpu, to_host = next(makers())
    frames = renderer.render_worlds(300, camera, SIZE, "id", instances=instances, transforms=to_gpu(wrong),
                                    on_device=True)
    assert frames.invalid_worlds == (7,) and not to_host(frames["id"])[7].any()
    print("a world with NaN is reported, and shows nothing")
    check_order(scene, renderer)
    check_overlap(scene, renderer)
    check_environments(renderer, camera, environments)


def check_environments(renderer, camera, environments):
    """Each world has the bytes of a renderer with its environment."""
    index = np.arange(len(environments))
    frames = renderer.render_worlds(len(index), camera, SIZE, "color", environments=environments,
                                    environment_index=index, shadows="none", background="hdri")
    for name, world in zip(environments, frames):
        alone = latelight.Renderer(renderer.scene, device="cuda:0", environment=name)
        expected = alone.render(camera, SIZE, "color", shadows="none", background="hdri")["color"]
        different = np.mean(world[0]["color"] != expected)
        print(f"environment {name}: {100 * different:.3f} % of the values differ")
        assert different == 0


def check_shadows(name):
    """Shadow maps that the device fits, to lights of the scene and of arrays, have the bytes of those of the host."""
    scene = latelight.Scene(name)
    sun = scene.add_light(latelight.Light(type="directional", direction=(0.3, -1, -0.4), intensity=3))
    bright = str(len(scene.lights()))
    dark = scene.add_light(latelight.Light(intensity=0))
    renderer = latelight.Renderer(scene, device="cuda:0", environment="studio")
    instances, transforms, poses, exists, camera = states(scene, 64, seed=5)
    given = {"instances": instances, "transforms": transforms, "exists": exists, "camera_to_world": poses}
    lights = {"lights": [sun, dark], "light_intensity": np.tile(np.float32([3, 0]), (64, 1))}
    calls = {"scene": given, "arrays": {**given, **lights}}
    # The host fits the maps where it has to select the lights: here, all but the dark one.
    host = renderer.render_worlds(64, camera, SIZE, ("color", "depth"), **calls["arrays"], shadow_lights=bright)
    lit = renderer.render_worlds(64, camera, SIZE, ("color", "depth"), **given, shadows="none")
    for lights_of, call in calls.items():
        device = renderer.render_worlds(64, camera, SIZE, ("color", "depth"), **call)
        for output in ("color", "depth"):
            different = np.mean(device[output] != host[output])
            print(f"shadows, lights of {lights_of}, {output}: {100 * different:.4f} % of the values differ from the "
                  "host's maps")
            assert different == 0
        assert (device["color"] != lit["color"]).any()


def check_overlap(scene, renderer):
    """Calls in flight have the images of the same calls one after the other."""
    instances, _, _, _, camera = states(scene, 64)
    name, to_gpu, to_host = next(makers())
    given = [states(scene, 64, seed)[1:4] for seed in range(8)]
    arrays = [{"transforms": to_gpu(t), "camera_to_world": to_gpu(p), "exists": to_gpu(e)} for t, p, e in given]
    options = {"instances": instances, "formats": FORMATS, "on_device": True, "shadows": "none"}
    expected = [to_host(renderer.render_worlds(64, camera, SIZE, "rgba", **call, **options)["rgba"]) for call in arrays]
    tickets = []
    for index, call in enumerate([*arrays, None, None]):
        if call:
            tickets.append(renderer.submit_worlds(64, camera, SIZE, "rgba", **call, **options))
        if index >= 2:
            np.testing.assert_array_equal(to_host(tickets[index - 2].take()["rgba"]), expected[index - 2])
    print(f"{len(arrays)} calls with other arrays, three in flight, equal those one after the other")


def check_order(scene, renderer):
    """The call follows the work of the caller's stream, which is still running when the call begins."""
    torch = library("torch")
    if not torch:
        return
    instances, transforms, _, _, camera = states(scene, 64, seed=3)
    expected = renderer.render_worlds(64, camera, SIZE, "id", instances=instances, transforms=transforms)["id"]
    target = torch.full(transforms.shape, float("nan"), device="cuda")

    def submit(stream):
        return renderer.submit_worlds(64, camera, SIZE, "id", instances=instances, transforms=target, stream=stream)

    def check(ticket):
        np.testing.assert_array_equal(ticket.take()["id"], expected)

    behind_work = importlib.import_module("behind_work")
    for submitted, total in behind_work.submit_behind_work(torch.from_numpy(transforms).cuda(), target, submit, check):
        print(f"a call that follows {total:.3f} s of work was submitted in {submitted:.3f} s")


def steady(submit, moved, runs):
    """Median seconds of calls, the host's and all, of which each has other transforms. submit(out) returns a ticket."""
    torch = importlib.import_module("torch")
    out, host, total = None, [], []
    for run in range(runs + 6):
        moved[:, 0, 0, 3] += 1e-4
        torch.cuda.synchronize()
        start = time.perf_counter()
        ticket = submit(out)
        host.append(time.perf_counter() - start)
        out = ticket.take()
        total.append(time.perf_counter() - start)
    return np.median(host[6:]), np.median(total[6:])


def measure(scene, renderer, count, size, outputs, formats, runs=30, tensors=True):
    torch = importlib.import_module("torch")
    instances, transforms, poses, _, camera = states(scene, count)
    moved, seen = transforms, poses
    if tensors:
        moved, seen = torch.from_numpy(transforms).cuda(), torch.from_numpy(poses).cuda()
    host, total = steady(lambda out: renderer.submit_worlds(count, camera, size, outputs, instances=instances,
                                                            transforms=moved, camera_to_world=seen, formats=formats,
                                                            on_device=True, out=out), moved, runs)
    given = "CUDA" if tensors else "host"
    print(f"{count:5} worlds of {size[0]}x{size[1]}, {' + '.join(outputs)}, {given}: {count / total:9.0f} views/s, "
          f"{1e3 * total:.2f} ms, of which the host {1e3 * host:.2f} ms until submitted", flush=True)


def measure_overlap(scene, renderer, count, runs=60):
    """The next call is submitted before the one before is taken, with other memory for its images."""
    torch = importlib.import_module("torch")
    instances, transforms, poses, _, camera = states(scene, count)
    moved, seen, outs, tickets = torch.from_numpy(transforms).cuda(), torch.from_numpy(poses).cuda(), [None, None], []
    for run in range(runs + 6):
        if run == 6:
            start = time.perf_counter()
        moved[:, 0, 0, 3] += 1e-4
        tickets.append(renderer.submit_worlds(count, camera, SIZE, "rgba", instances=instances, transforms=moved,
                                              camera_to_world=seen, formats=FORMATS, on_device=True,
                                              out=outs[run % 2]))
        if len(tickets) == 2:
            outs[(run - 1) % 2] = tickets.pop(0).take()
    tickets.pop().take()
    each = (time.perf_counter() - start) / runs
    print(f"{count:5} worlds of {SIZE[0]}x{SIZE[1]}, rgba, CUDA, two calls in flight: {count / each:9.0f} views/s, "
          f"{1e3 * each:.2f} ms", flush=True)


def measure_lights(name, runs=20):
    """Calls with shadow maps of a light of the scene, and of one whose direction or position tensors describe."""
    torch = importlib.import_module("torch")
    for kind, key, place in (("directional", "light_direction", (0.3, -1, -0.4)),
                             ("point", "light_position", (2, 3, 2))):
        scene = latelight.Scene(name)
        light = scene.add_light(latelight.Light(type=kind, direction=(0.3, -1, -0.4), position=(2, 3, 2),
                                                intensity=3 if kind == "directional" else 60))
        renderer = latelight.Renderer(scene, device="cuda:0", environment="studio")
        for count in (1024, 4096):
            instances, transforms, poses, _, camera = states(scene, count)
            values = np.float32(np.random.default_rng(1).uniform(-0.3, 0.3, (count, 1, 3)) + place)
            moved, seen, own = (torch.from_numpy(array).cuda() for array in (transforms, poses, values))
            for lights_of, lights in (("scene", {}), ("arrays", {"lights": [light], key: own})):
                host, total = steady(lambda out: renderer.submit_worlds(
                    count, camera, SIZE, "rgba", instances=instances, transforms=moved, camera_to_world=seen,
                    formats=FORMATS, on_device=True, out=out, **lights), moved, runs)
                print(f"{count:5} worlds, shadow maps of a {kind} light of {lights_of}: {count / total:9.0f} views/s, "
                      f"{1e3 * total:.2f} ms, of which the host {1e3 * host:.2f} ms until submitted", flush=True)


if __name__ == "__main__":
    name = sys.argv[1] if len(sys.argv) > 1 else "builtin:boxes"
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0", environment="studio")
    print(renderer.device, ctypes.sizeof(ctypes.c_void_p) * 8, "bits")
    failed = False
    try:
        check(name, ["studio", *sys.argv[2:]])
        check_shadows(name)
    except Exception:  # measure nevertheless
        failed = True
        traceback.print_exc()
    messages = renderer.validation_messages()
    for message in messages:
        print("validation:", message)
    half = {"rgba": "rgb8", "depth": "float16", "id": "uint16", "normal": "float16"}
    for count in (1024, 4096):
        measure(scene, renderer, count, (64, 64), ("rgba",), FORMATS)
        measure(scene, renderer, count, (64, 64), ("rgba",), FORMATS, tensors=False)
        measure_overlap(scene, renderer, count)
    measure(scene, renderer, 4096, (64, 64), ("rgba", "depth", "id", "normal"), half)
    measure_lights(name)
    for side in (128, 256):
        measure(scene, renderer, 4096, (side, side), ("rgba",), FORMATS, 10)
    measure(scene, renderer, 4096, (256, 256), ("rgba", "depth", "id", "normal"), half, 10)
    sys.exit(failed or len(messages) > 0)
