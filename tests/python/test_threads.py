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

LONG = """
import sys, time, latelight
scene = latelight.Scene("builtin:hall,triangles=60k,lights=20")
renderer = latelight.Renderer(scene, sys.argv[1])
camera = scene.default_camera()
before = renderer.render(camera, (64, 64))["rgba"]
try:
    print("ready", flush=True)
    renderer.render(camera, (256, 256), aa="ss16")
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
    cameras = [boxes.look_at((3, -4, 2 + i), (0, 0, 0.5)) for i in range(4)]
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


def test_ctrl_c(device):
    environment = {**os.environ, "LATELIGHT_VALIDATION": "0"}
    child = subprocess.Popen([sys.executable, "-c", LONG, device], stdout=subprocess.PIPE, text=True, env=environment)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.3)
    child.send_signal(signal.SIGINT)
    assert child.communicate()[0] == "interrupted\n"
    assert child.returncode == 0
