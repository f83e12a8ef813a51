"""Other threads run while the device works; one renderer may be called from several; Ctrl-C ends a long call."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import latelight

# Background jobs of a shell ignore SIGINT.
LONG = """
import signal, sys, time, latelight
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = latelight.Scene("builtin:hall,triangles=60k,lights=20")
renderer = latelight.Renderer(scene, sys.argv[1])
camera = scene.default_camera()
before = renderer.render(camera, (64, 64))["rgba"]
try:
    print("ready", flush=True)
    renderer.render(camera, (512, 512), aa="ss16")
    print("it was not interrupted")
except KeyboardInterrupt:
    print("interrupted" if (renderer.render(camera, (64, 64))["rgba"] == before).all() else "it renders otherwise")
"""


def test_others_run_meanwhile(device):
    scene = latelight.Scene("builtin:hall,triangles=60k,lights=20")
    renderer = latelight.Renderer(scene, device)
    camera = scene.default_camera()
    renderer.render(camera, (64, 64), aa="ss2")
    counted = 0
    stop = threading.Event()

    def count():
        nonlocal counted
        while not stop.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    start = time.monotonic()
    renderer.render(camera, (256, 256), aa="ss2")
    seconds = time.monotonic() - start
    stop.set()
    thread.join()
    assert counted > 20 * seconds  # of a thousand a second, on a machine that has others to serve


def test_many_threads_with_one_renderer(renderer, boxes):
    cameras = [boxes.look_at((3, 2 + i, 4), (0, 0.5, 0)) for i in range(4)]
    expected = [renderer.render(camera, (24, 16), "depth")["depth"] for camera in cameras]
    wrong = []

    def work(number):
        for _ in range(5):
            if not np.array_equal(renderer.render(cameras[number], (24, 16), "depth")["depth"], expected[number]):
                wrong.append(number)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_edits_while_others_render(device, square):
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    camera = scene.default_camera()
    stop = threading.Event()

    def edit():
        while not stop.is_set():
            scene.remove_instance(scene.add_instance(scene.add_mesh(**square), scene.materials()[0]))

    thread = threading.Thread(target=edit)
    thread.start()
    try:
        for _ in range(10):
            assert renderer.render(camera, (16, 16))["rgba"].any()
    finally:
        stop.set()
        thread.join()


def test_every_call_while_others_edit(device, square):
    """Pictures, worlds, rays and tickets of one renderer, and new renderers, while the scene gains and loses what none of
    them sees: each result is that of one thread."""
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    camera, size = scene.look_at((3, 2, 4), (0, 0.5, 0)), (24, 16)
    rays = np.full((8, 3), (3.0, -4.0, 2.0)), np.linspace((-0.7, 0.9, -0.4), (-0.5, 1, -0.2), 8)
    behind = np.eye(4)
    behind[:3, 3] = 9, -12, 5  # no ray and no camera looks there
    moved = np.tile(np.eye(4), (2, 1, 1, 1))
    moved[1, 0, 2, 3] = 0.25
    first = scene.instances()[0]

    def edit():
        added = scene.add_instance(scene.add_mesh(**square), scene.materials()[0], behind)
        scene.set_transform(added, behind @ behind)
        scene.remove_instance(added)
        return np.zeros(0)

    calls = (
        lambda: renderer.render(camera, size, "depth")["depth"],
        lambda: renderer.submit(camera, size, "depth").take()["depth"],
        lambda: renderer.render_worlds(2, camera, size, "depth", instances=[first], transforms=moved)["depth"],
        lambda: renderer.cast(*rays)["distance"],
        lambda: renderer.submit_cast(*rays).take()["distance"],
        lambda: renderer.submit_cast_worlds(2, *np.stack([rays, rays], 1), instances=[first],
                                            transforms=moved).take()["distance"],
        lambda: latelight.Renderer(scene, device).render(camera, size, "depth")["depth"],
        edit,
    )
    expected = [call() for call in calls]
    assert np.isfinite(expected[3]).any()
    wrong = []

    def work(number):
        try:
            for _ in range(5):
                if not np.array_equal(calls[number](), expected[number]):
                    wrong.append(number)
        except Exception as error:
            wrong.append((number, error))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(len(calls))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert renderer.validation_messages() == []


def test_ctrl_c(device):
    environment = {**os.environ, "LATELIGHT_VALIDATION": "0"}
    child = subprocess.Popen([sys.executable, "-c", LONG, device], stdout=subprocess.PIPE, text=True, env=environment)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    assert child.communicate()[0] == "interrupted\n"
    assert child.returncode == 0


def test_ctrl_c_between_short_waits(device, square):
    """Labels wait for the device often, but never for long, and then count on the host."""
    scene = latelight.Scene()
    mesh, paint = scene.add_mesh(square["positions"], square["indices"]), scene.add_material(latelight.Material())
    for x, y, z in np.random.default_rng(0).normal(scale=0.5, size=(300, 3)):
        transform = np.eye(4)
        transform[:3, 3] = x, y, z
        scene.add_instance(mesh, paint, transform)
    renderer, camera = latelight.Renderer(scene, device), latelight.Camera.look_at((0, 0, 6), (0, 0, 0))
    expected = renderer.labels(camera, (64, 48)).amodal_masks
    start = time.perf_counter()
    renderer.labels(camera, (64, 48))
    duration = time.perf_counter() - start
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        start = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, duration / 5)
        with pytest.raises(KeyboardInterrupt):
            renderer.labels(camera, (64, 48))
        assert time.perf_counter() - start < 0.7 * duration
    finally:
        signal.signal(signal.SIGALRM, before)
    np.testing.assert_array_equal(renderer.labels(camera, (64, 48)).amodal_masks, expected)


def test_signal_handlers_cannot_call_the_renderer_that_they_interrupt(square, device):
    """The error of the call ends the interrupted call, too, because the handler does not catch it."""
    scene = latelight.Scene("builtin:boxes")
    renderer, camera = latelight.Renderer(scene, device), latelight.Camera.look_at((0, 0, 6), (0, 0, 0))
    ticket = renderer.submit(camera, (16, 16))
    before = signal.signal(signal.SIGALRM, lambda *_: renderer.render(camera, (8, 8)))
    try:
        # A signal between two calls interrupts none of them, and the handler may render.
        signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)
        with pytest.raises(latelight.UsageError, match="the renderer is in use"):
            while True:
                renderer.labels(camera, (64, 48))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert ticket.take()["rgba"].shape == (16, 16, 4)


def test_signal_handlers_cannot_edit_the_scene_that_they_interrupt(device):
    """They raise instead of waiting for the call that waits for them. Edits of other scenes work."""
    scene, other = latelight.Scene("builtin:boxes"), latelight.Scene("builtin:boxes")
    renderer, camera = latelight.Renderer(scene, device), latelight.Camera.look_at((0, 0, 6), (0, 0, 0))
    handle, edited = scene.instances()[0], other.instances()[0]
    pose = np.array([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    rejections = []

    def edit(*_):
        other.set_transform(edited, pose)
        try:
            scene.set_transform(handle, pose)  # A signal between two calls interrupts none of them.
        except latelight.UsageError as error:
            rejections.append(str(error))

    before = signal.signal(signal.SIGALRM, edit)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)
        end = time.monotonic() + 60
        while not rejections and time.monotonic() < end:
            renderer.labels(camera, (64, 48))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert set(rejections) == {
        "the scene is in use: a signal handler or __del__() that runs while a call reads the scene must not edit it"}
    np.testing.assert_array_equal(other.instance(edited).transform, pose)
    scene.set_transform(handle, np.eye(4))
    np.testing.assert_array_equal(scene.instance(handle).transform, np.eye(4))
