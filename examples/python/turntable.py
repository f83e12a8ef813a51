"""A video of an object that turns. Rendering and encoding go on at once.

usage: turntable.py [SCENE] [VIDEO] [FRAMES]      (ffmpeg must be installed)
"""

import shutil
import subprocess
import sys
from collections import deque

import numpy as np

import latelight

source, video, count = (sys.argv[1:] + ["builtin:spheres", "turntable.mp4", "96"][len(sys.argv) - 1 :])[:3]
if not shutil.which("ffmpeg"):
    sys.exit("turntable.py: ffmpeg is not installed")
size = (640, 480)
scene = latelight.Scene(source)
renderer = latelight.Renderer(scene)
low, high = np.array(scene.bounds)
center, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
up = 2 if source.lower().endswith((".ply", ".stl")) else 1  # the axis: Z of PLY and STL files, otherwise Y
encoder = subprocess.Popen(
    ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{size[0]}x{size[1]}", "-r", "24"]
    + ["-i", "-", "-pix_fmt", "yuv420p", video],
    stdin=subprocess.PIPE,
)
tickets = deque()
for angle in np.linspace(0, 2 * np.pi, int(count), endpoint=False):
    around = np.array([np.sin(angle), np.cos(angle)]) * 3
    eye = center + radius * np.insert(around, up, 1)
    tickets.append(renderer.submit(scene.look_at(eye, center), size, background="#202428", aa="fxaa"))
    if len(tickets) == 3:
        encoder.stdin.write(tickets.popleft().take()["rgba"].tobytes())
for ticket in tickets:
    encoder.stdin.write(ticket.take()["rgba"].tobytes())
encoder.stdin.close()
sys.exit(encoder.wait())
