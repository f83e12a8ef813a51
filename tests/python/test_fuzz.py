"""Random arguments: each call succeeds or raises a Python exception, and the interpreter lives."""

import random

import numpy as np
import pytest

import latelight


class Hostile:
    """Lies about its length and its values."""

    def __len__(self):
        return -1

    def __getitem__(self, index):
        raise RuntimeError("hostile")

    def __float__(self):
        raise RuntimeError("hostile")


def values(rng):
    shape = tuple(rng.choice([0, 1, 2, 3, 4]) for _ in range(rng.randrange(4)))
    dtype = rng.choice(["f4", "f8", "i8", "u1", "i2", "?", "c8", "U3", "O", "M8[s]"])
    choices = [
        None, True, 0, -1, 1 << 70, 1.5, float("nan"), float("inf"), -0.0, "", "a", "\ud800", "x\0y", b"b", (), [], {},
        Hostile(), object, int, range(3), (1, 2), (1, 2, 3), [[1, 2, 3]] * 3, np.float32(2), np.eye(4), np.eye(3),
        np.zeros(shape, dtype), np.full((3, 3), np.nan), np.zeros((3, 3))[::-1, ::2], np.ma.masked_array([1, 2, 3]),
        latelight.Camera(), latelight.Material(), latelight.Light(), latelight.Lens(),
    ]
    return rng.choice(choices)


def calls(scene, renderer):
    for name in dir(latelight.Scene):
        if not name.startswith("_") and callable(getattr(scene, name)):
            yield getattr(scene, name)
    yield from (latelight.Camera.look_at, latelight.Camera.from_k, latelight.Camera().k, renderer.pick)
    yield lambda *a, **k: setattr(latelight.Camera(), *(*a, "name", 1)[:2])
    yield lambda *a, **k: latelight.Material(**k)
    yield lambda *a, **k: latelight.Light(**k)
    yield lambda *a, **k: latelight.Renderer(scene, "cpu", *a[1:]) if len(a) > 1 else latelight.Renderer(*a)
    yield lambda *a, **k: renderer.render(latelight.Camera(), (4, 4), **k)


NAMES = """name exposure tonemap sun aa size outputs time shadow_filter base_color roughness position direction range
camera_to_world vertical_fov previous_cameras bloom layout anisotropy positions indices uv colors""".split()


@pytest.mark.filterwarnings("ignore:nanobind")
def test_objects_that_are_not_made_or_made_twice():
    scene = latelight.Scene("builtin:boxes")
    for kind in (latelight.Scene, latelight.Renderer, latelight.Camera, latelight.Material, latelight.Ticket, latelight.Pick):
        hollow = kind.__new__(kind)
        for name in dir(hollow):
            try:
                getattr(hollow, name)() if callable(getattr(hollow, name)) else None
            except Exception as error:
                assert type(error).__name__ != "SystemError", (kind, name)
    try:
        scene.__init__("builtin:spheres")
    except Exception:
        pass
    assert latelight.Renderer(scene, "cpu").render(scene.default_camera(), (8, 8))["rgba"].any()
    camera = latelight.Camera(name="first")
    camera.__init__(vertical_fov=50)
    assert (camera.name, camera.vertical_fov) == ("first", 50)


def test_any_arguments():
    rng = random.Random(11)
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, "cpu")
    handles = [scene.instances()[0], scene.materials()[0], scene.meshes()[0]]
    every = list(calls(scene, renderer))
    done = refused = 0
    for _ in range(4000):
        arguments = [rng.choice(handles) if rng.random() < 0.3 else values(rng) for _ in range(rng.randrange(5))]
        keywords = {rng.choice(NAMES): values(rng) for _ in range(rng.randrange(3))}
        try:
            rng.choice(every)(*arguments, **keywords)
            done += 1
        except Exception as error:
            assert type(error).__name__ != "SystemError", error
            refused += 1
    assert done > 100 and refused > 1000
    assert renderer.render(scene.default_camera(), (8, 8))["rgba"].shape == (8, 8, 4)
