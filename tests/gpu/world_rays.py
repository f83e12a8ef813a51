"""Rays through worlds from arrays of torch in CUDA's memory.

Checks that hits are those of the same rays from the host, that distances to a moved box have their closed form, that
images with rays from tensors are those from arrays of the host, and that calls in flight have the hits of the same
calls one after the other. Then measures steady calls. Requires an NVIDIA GPU. Not part of the test suite, which has
none.

usage: world_rays.py SCENE
"""

import itertools
import sys
import time

import latelight
import numpy as np
import torch
from behind_work import submit_behind_work

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


def calls_on_gpu(scene):
    """The arrays of two calls, and their rays."""
    calls = []
    for seed in range(2):
        arrays, origins, directions, _ = given(scene, seed)
        calls.append(({key: on_gpu(value) for key, value in arrays.items()}, on_gpu(origins), on_gpu(directions)))
    return calls


def bytes_of(hits):
    """The arrays of NumPy, or of the device, as NumPy's integers."""
    host = {key: value if isinstance(value, np.ndarray) else torch.from_dlpack(value).cpu().numpy()
            for key, value in hits.items()}
    return {key: np.ascontiguousarray(value).view(np.uint32) for key, value in host.items()}


def assert_same(hits, expected):
    hits = bytes_of(hits)
    assert hits.keys() == expected.keys()
    for key, value in expected.items():
        assert np.array_equal(hits[key], value), key


def check_tickets(name, count=5):
    """Calls in flight, with hits on the device and on the host, taken in another order; one more is dropped.

    Tensors are overwritten as soon as a call returns: its copies precede that on the caller's stream. Images are in
    flight between the calls of the second turn.
    """
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0")
    stream, camera = torch.cuda.current_stream(), scene.default_camera()
    calls = [given(scene, seed) for seed in range(10, 10 + count)]
    expected, flat, images = [], [], []
    for arrays, origins, directions, instances in calls:
        expected.append(bytes_of(renderer.cast_worlds(WORLDS, origins, directions, instances=instances, **arrays)))
        flat.append(bytes_of(renderer.cast(on_gpu(origins[0]), on_gpu(directions[0]))))
        images.append(renderer.render_worlds(64, camera, (64, 64), "id", instances=instances, shadows="none",
                                             **{key: value[:64] for key, value in arrays.items()})["id"])
    order = [*range(1, count, 2), *range(0, count, 2)]
    for on_device in (True, False):
        options = {"on_device": on_device, "stream": stream}
        worlds, scenes, frames, before = [], [], [], renderer.copied_bytes
        for arrays, origins, directions, instances in [*calls, calls[0]]:
            tensors = {key: on_gpu(value) for key, value in arrays.items()}
            rays = on_gpu(origins), on_gpu(directions)
            own = rays[0][0].clone(), rays[1][0].clone()
            worlds.append(renderer.submit_cast_worlds(WORLDS, *rays, instances=instances, **tensors, **options))
            scenes.append(renderer.submit_cast(*own, **options))
            some = {key: value[:64].clone() for key, value in tensors.items()}
            if not on_device:
                frames.append(renderer.submit_worlds(64, camera, (64, 64), "id", instances=instances, shadows="none",
                                                     stream=stream, **some))
            for tensor in (*rays, *own, *tensors.values(), *some.values()):
                tensor.fill_(float("nan") if tensor.is_floating_point() else 0)
            del tensors, rays, own, some, tensor
        copied = renderer.copied_bytes - before
        for tickets in (worlds, scenes, *([] if on_device else [frames])):
            tickets.pop()
        for index in order:
            assert_same(worlds[index].take(), expected[index])
            assert_same(scenes[index].take(), flat[index])
            if not on_device:
                assert np.array_equal(frames[index].take()["id"], images[index]), index
        print(f"tickets, hits on the {'device' if on_device else 'host'}: {count} calls through worlds and {count} "
              f"through the scene equal those one after the other; {copied} bytes were copied on the device")
    outs = [renderer.cast_worlds(WORLDS, calls[0][1], calls[0][2], outputs=("distance", "id"), on_device=True)
            for _ in range(2)]
    for first in range(count - 1):
        tickets = []
        for out, (arrays, origins, directions, instances) in zip(outs, calls[first:first + 2]):
            tensors = {key: on_gpu(value) for key, value in arrays.items()}
            tickets.append(renderer.submit_cast_worlds(WORLDS, on_gpu(origins), on_gpu(directions), instances=instances,
                                                       out=out, on_device=True, **tensors))
        for index in (1, 0):
            tickets[index].take()
            assert_same(outs[index], {key: expected[first + index][key] for key in ("distance", "id")})
    print("tickets, out: two calls in flight store their hits in the arrays of earlier calls")


def check_order(name, through_worlds):
    """A call follows the work of the caller's stream, which is still running when the call returns.

    Only the first call of a renderer waits for that work: it allocates the memory to which arrays are copied.
    """
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0")
    arrays, origins, directions, instances = given(scene, 3)
    along = on_gpu(directions)
    if through_worlds:
        arguments = {"instances": instances, **{key: on_gpu(value) for key, value in arrays.items()}}
        expected = bytes_of(renderer.cast_worlds(WORLDS, on_gpu(origins), along, **arguments))
    else:
        expected = bytes_of(renderer.cast(on_gpu(origins[0]), along[0]))
    target = torch.empty(origins.shape, device="cuda")

    def submit(stream):
        if through_worlds:
            return renderer.submit_cast_worlds(WORLDS, target, along, stream=stream, **arguments)
        return renderer.submit_cast(target[0], along[0], stream=stream)

    def check(ticket):
        assert_same(ticket.take(), expected)

    kind = "submit_cast_worlds" if through_worlds else "submit_cast"
    for submitted, total in submit_behind_work(on_gpu(origins), target, submit, check):
        print(f"{kind} that follows {total:.3f} s of work returned in {submitted:.4f} s")
        assert submitted < total / 2


def check_streams(name):
    """Calls of several streams, of which the first is busy for longer than the others."""
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0")
    rays = [given(scene, seed)[1:3] for seed in range(3)]
    expected = [bytes_of(renderer.cast(*(on_gpu(array[0]) for array in pair))) for pair in rays]
    sources = [[on_gpu(array[0]) for array in pair] for pair in rays]
    targets = [[torch.full_like(array, float("nan")) for array in pair] for pair in sources]
    streams = [torch.cuda.Stream(), torch.cuda.Stream(), None]
    busy = torch.randn(8192, 8192, device="cuda")
    torch.cuda.synchronize()
    tickets = []
    for turn, stream in enumerate(streams):
        with torch.cuda.stream(stream or torch.cuda.current_stream()):
            for _ in range(20 if turn == 0 else 0):
                busy = (busy @ busy).clamp(-1, 1)
            for target, source in zip(targets[turn], sources[turn]):
                target.copy_(source)
            tickets.append(renderer.submit_cast(*targets[turn], stream=stream))
    for ticket, hits in zip(tickets, expected):
        assert_same(ticket.take(), hits)
    print(f"streams: calls of {len(streams)} streams in flight have the hits of their own rays")


def measure_overlap(name, runs=60):
    """Calls one by one, and calls of which the next is submitted before the one before is taken."""
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0")
    instances, calls = scene.instances(), calls_on_gpu(scene)
    every = ("distance", "position", "normal", "id")
    for outputs, on_device, at_once in itertools.product(("distance", every), (True, False), (1, 2)):
        outs, tickets = [None, None], []
        for run in range(runs + 10):
            if run == 10:
                torch.cuda.synchronize()
                start = time.perf_counter()
            arrays, origins, directions = calls[run % 2]
            out = outs[run % 2]
            ticket = renderer.submit_cast_worlds(
                WORLDS, origins, directions, instances=instances, on_device=on_device,
                stream=torch.cuda.current_stream(), **arrays, **({"out": out} if out else {"outputs": outputs}))
            tickets.append((run, ticket))
            if len(tickets) == at_once:
                first, ticket = tickets.pop(0)
                outs[first % 2] = ticket.take()
        for _, ticket in tickets:
            ticket.take()
        print(f"submit_cast_worlds, {WORLDS} x {RAYS} rays, {len(instances)} instances, {outputs}, hits on the "
              f"{'device' if on_device else 'host'}, {at_once} in flight: "
              f"{1000 * (time.perf_counter() - start) / runs:.2f} ms a call, updates included", flush=True)


def measure(name):
    scene = latelight.Scene(name)
    renderer = latelight.Renderer(scene, device="cuda:0")
    instances, calls = scene.instances(), calls_on_gpu(scene)
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
    check_tickets(sys.argv[1])
    check_order(sys.argv[1], through_worlds=True)
    check_order(sys.argv[1], through_worlds=False)
    check_streams(sys.argv[1])
    measure(sys.argv[1])
    measure_overlap(sys.argv[1])
