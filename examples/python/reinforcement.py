"""Agents that learn to see: each step moves 1,024 cameras and renders them all in one call.

The policy here is none: an agent turns towards where its picture is deepest, and walks. A learner takes `seen` instead.

usage: reinforcement.py [STEPS] [AGENTS]
"""

import sys
import time

import numpy as np

import latelight

STEPS, AGENTS = (int(word) for word in (sys.argv[1:] + ["5", "1024"][len(sys.argv) - 1 :])[:2])
SIZE = (64, 64)

scene = latelight.Scene("builtin:hall")
renderer = latelight.Renderer(scene)
low, high = np.array(scene.bounds)
rng = np.random.default_rng(0)
places = rng.uniform(low + (high - low) * 0.2, high - (high - low) * 0.2, (AGENTS, 3))
places[:, 1] = low[1] + 1.7  # built-in scenes have Y up
headings = rng.uniform(0, 2 * np.pi, AGENTS)  # counterclockwise as seen from above


def ahead():
    return np.stack([np.cos(headings), np.zeros(AGENTS), -np.sin(headings)], -1)


def cameras():
    return [scene.look_at(place, target, vertical_fov=90) for place, target in zip(places, places + ahead())]


for step in range(STEPS):
    start = time.perf_counter()
    seen = np.nan_to_num(renderer.render(cameras(), SIZE, "depth")["depth"], posinf=100)  # (AGENTS, 64, 64)
    free = seen[:, 24:40].min(axis=1)  # meters to the nearest surface, per column
    column = free.argmax(axis=1)
    headings -= np.arctan((column + 0.5) / 32 - 1)
    walk = np.minimum(0.25, free[np.arange(AGENTS), column] / 2)
    places += walk[:, None] * ahead()
    reward = free.max(axis=1).mean()
    print(f"step {step}: {AGENTS / (time.perf_counter() - start):.0f} views/s, mean free way {reward:.2f} m")
