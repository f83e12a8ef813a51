"""Processes forked from one that renders: what they inherit is refused at once, and what they create works."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import latelight

DEVICE = os.environ.get("LATELIGHT_TEST_DEVICE", "cpu")
SIZE = (24, 16)


def in_fork(body, seconds=600):
    """The value that `body` returns in a forked process, or the exception that it raises as a text."""
    fork = multiprocessing.get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)

    def run():
        try:
            sender.send(body())
        except BaseException as error:
            sender.send(f"{type(error).__name__}: {error}")

    child = fork.Process(target=run)
    child.start()
    try:
        assert receiver.poll(seconds), "the forked process hangs"
        return receiver.recv()
    finally:
        child.join(seconds)
        alive = child.is_alive()
        child.kill()
        assert not alive, "the forked process does not end"


@pytest.fixture(scope="module")
def own():
    """A scene of this module's, with its renderer and a ticket in flight."""
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, DEVICE)
    camera = scene.default_camera(aspect=1.5)
    return scene, renderer, camera, renderer.submit(camera, SIZE)


@pytest.mark.parametrize(
    "call",
    [
        lambda renderer, camera, ticket: renderer.render(camera, SIZE),
        lambda renderer, camera, ticket: renderer.submit(camera, SIZE),
        lambda renderer, camera, ticket: renderer.pick(camera, [[0, 0]], SIZE),
        lambda renderer, camera, ticket: renderer.device,
        lambda renderer, camera, ticket: renderer.validation_messages(),
        lambda renderer, camera, ticket: renderer.finish(),
        lambda renderer, camera, ticket: renderer.submit_cast_worlds(1, *np.ones((2, 1, 1, 3))),
        lambda renderer, camera, ticket: ticket.take(),
        lambda renderer, camera, ticket: ticket.done,
    ],
)
def test_what_the_parent_created_is_refused(own, call):
    _, renderer, camera, ticket = own
    said = in_fork(lambda: call(renderer, camera, ticket))
    assert said.startswith("UsageError: the renderer belongs to process"), said
    assert str(os.getpid()) in said and "\n" not in said


@pytest.mark.parametrize("on_device", [False, True])
def test_rays_in_flight_belong_to_the_parent(own, on_device):
    _, renderer, _, _ = own
    rays = np.full((2, 8, 3), (3, 4, 2.0)), np.full((2, 8, 3), (-3, -4, -1.5))
    ticket = renderer.submit_cast_worlds(2, *rays, on_device=on_device)
    for call in (lambda: ticket.take(), lambda: ticket.done):
        said = in_fork(call)
        assert said.startswith("UsageError: the renderer belongs to process"), said
    assert ticket.take()["distance"].shape == (2, 8)


def test_a_new_renderer_of_an_inherited_scene_works(own, device):
    scene, renderer, camera, _ = own
    expected = renderer.render(camera, SIZE, ("rgba", "depth"))

    def render():
        frame = latelight.Renderer(scene, device).render(camera, SIZE, ("rgba", "depth"))
        scene.remove_instance(scene.instances()[0])
        return frame["rgba"], frame["depth"], len(scene.instances())

    rgba, depth, left = in_fork(render)
    np.testing.assert_array_equal(rgba, expected["rgba"])
    np.testing.assert_array_equal(depth, expected["depth"])
    assert left == len(scene.instances()) - 1, "the parent's scene is another"
    np.testing.assert_array_equal(renderer.render(camera, SIZE)["rgba"], expected["rgba"])


def test_a_new_scene_in_a_forked_process(own, device):
    def render():
        scene = latelight.Scene("builtin:spheres")
        return bool(latelight.Renderer(scene, device).render(scene.default_camera(), SIZE)["rgba"].any())

    assert in_fork(render) is True


def test_arrays_and_frames_are_memory(own):
    _, renderer, camera, _ = own
    frame = renderer.render(camera, SIZE, "depth")
    arrays = renderer.render(camera, SIZE, "depth", on_device=True)
    total = float(np.nan_to_num(frame["depth"], posinf=0).sum())
    assert in_fork(lambda: float(np.nan_to_num(frame["depth"], posinf=0).sum())) == total
    if arrays["depth"].device == "cpu":
        assert in_fork(lambda: float(np.nan_to_num(arrays["depth"].numpy(), posinf=0).sum())) == total


def test_while_other_threads_render_and_edit(device, square):
    """Their locks are free in the forked process, and the scene is whole."""
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    camera = scene.default_camera()
    material = scene.materials()[0]
    stop = threading.Event()

    def render():
        while not stop.is_set():
            renderer.render(camera, (64, 64))

    def edit():
        while not stop.is_set():
            scene.remove_instance(scene.add_instance(scene.add_mesh(**square), material))
            scene.remove_mesh(scene.meshes()[-1])

    threads = [threading.Thread(target=render), threading.Thread(target=edit)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(10):
            assert in_fork(lambda: scene.add_texture(np.zeros((2, 2, 3), np.uint8)) is not None) is True
    finally:
        stop.set()
        for thread in threads:
            thread.join()


END = """
import os, sys, time, latelight
scene = latelight.Scene("builtin:boxes")
renderer = latelight.Renderer(scene, sys.argv[1])
camera = scene.default_camera()
renderer.render(camera, (16, 16))
ticket = renderer.submit([camera] * 4, (64, 64))
arrays = renderer.render(camera, (16, 16), "depth", on_device=True)
child = os.fork()
if child == 0:
    sys.exit(3)  # the interpreter's whole end, with its destructors
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3
ticket.take()
"""


def test_a_forked_process_ends(device):
    environment = {**os.environ, "LATELIGHT_VALIDATION": "0"}
    done = subprocess.run([sys.executable, "-c", END, device], env=environment, timeout=60, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_ctrl_c_ends_a_wait_in_a_forked_process(device):
    def render():
        scene = latelight.Scene("builtin:boxes")
        renderer = latelight.Renderer(scene, device)
        renderer.render(scene.default_camera(), (64, 64))
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        renderer.render([scene.default_camera()] * 16, (256, 256), aa="ss16")

    assert in_fork(render).startswith("KeyboardInterrupt")
