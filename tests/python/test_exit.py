"""A program that ends while its threads render or load, or with pictures on their way, ends with exit code 0."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

START = """
import sys, threading, time
import numpy as np
import latelight
scene = latelight.Scene("builtin:boxes")
renderer = latelight.Renderer(scene, sys.argv[1])
camera = scene.default_camera(4 / 3)
def daemon(work):
    def forever():
        while True:
            work()
    threading.Thread(target=forever, daemon=True).start()
"""

ENDINGS = {
    "a thread renders": "daemon(lambda: renderer.render(camera, (64, 48)))\ntime.sleep(0.3)",
    "threads load scenes": "for _ in range(3): daemon(lambda: latelight.Scene('builtin:boxes'))\ntime.sleep(0.3)",
    "tickets are in flight": """
tickets = [renderer.submit([camera] * 4, (256, 192)) for _ in range(3)]
threading.Thread(target=lambda: renderer.render(camera, (1024, 768)), daemon=True).start()
sys.exit(0)""",
    "a thread creates renderers": "daemon(lambda: latelight.Renderer(scene, sys.argv[1]).render(camera, (8, 8)))\ntime.sleep(0.3)",
    "threads convert arrays": """
class Slow:
    def __array__(self, dtype=None, copy=None):
        for _ in range(1000): pass
        return np.zeros((300, 3))
for _ in range(3): daemon(lambda: latelight.Scene().add_mesh(Slow()))
time.sleep(0.2)""",
    "a thread edits": "daemon(lambda: scene.remove_light(scene.add_light(latelight.Light())))\ntime.sleep(0.1)",
    "the main thread still renders in atexit": """
import atexit
daemon(lambda: renderer.render(camera, (64, 48)))
@atexit.register
def last():
    assert renderer.render(camera, (8, 8))["rgba"].any()
time.sleep(0.1)""",
}


def run(source, device):
    environment = {**os.environ, "LATELIGHT_VALIDATION": "0"}
    done = subprocess.run(
        [sys.executable, "-c", START + source, device], env=environment, timeout=120, capture_output=True, text=True
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize("name", ENDINGS)
def test_ends_with_zero(name, device):
    runs = int(os.environ.get("LATELIGHT_TEST_EXITS", "3"))
    with ThreadPoolExecutor(2) as pool:
        ended = list(pool.map(lambda _: run(ENDINGS[name], device), range(runs)))
    assert ended == [(0, "")] * runs


def test_the_exit_code_of_a_program_stays(device):
    assert run("daemon(lambda: renderer.render(camera, (64, 48)))\ntime.sleep(0.1)\nsys.exit(5)", device) == (5, "")


def test_ctrl_c_does_not_wait_for_a_thread_that_never_ends(device):
    """A thread that waits for Python code of an argument which never returns."""
    source = """
class Endless:
    def __array__(self, dtype=None, copy=None):
        started.set()
        time.sleep(3600)
started = threading.Event()
daemon(lambda: latelight.Scene().add_mesh(Endless()))
started.wait()
import os, signal
threading.Timer(0.3, lambda: None).start()
signal.signal(signal.SIGALRM, signal.default_int_handler)
signal.setitimer(signal.ITIMER_REAL, 1)
"""
    code, said = run(source, device)
    assert code >= 0 and "KeyboardInterrupt" in said
