"""Scenes and images whose differences are measured in 8-bit levels of the finished sRGB image."""

import subprocess

import numpy as np

import render
from error_scenes import ERROR_SCENES
from scenes import SCENES

# Direct light without noise, which the path tracer of --lighting reference has, too.
SHADOWS = ["--shadows", "rays", "--shadow-lights", "all"]


def encoded(color):
    """Levels of linear values, not rounded."""
    color = np.clip(color, 0, 1)
    return 255 * np.where(color <= 0.0031308, 12.92 * color, 1.055 * np.maximum(color, 1e-9) ** (1 / 2.4) - 0.055)


def scene_arguments(folder, hdri=None, helmet=None):
    """The arguments of `latelight render` for each scene, by name; writes the scenes' files into the folder."""
    render.write_gltf(SCENES["room"](), folder / "cornell.gltf")
    arguments = {"cornell": [folder / "cornell.gltf", "--exposure", "-1"], "hall": ["builtin:hall"]}
    environment = ["--hdri", hdri] if hdri else []
    for name, make in ERROR_SCENES.items():
        render.write_gltf(make(), folder / f"{name}.gltf")
        arguments[name] = [folder / f"{name}.gltf", *environment]
    for room in ("furnished", "glassware"):
        arguments[room] += ["--exposure", "1"]
    if helmet:
        arguments["helmet"] = [helmet, *environment]
    return arguments


def render_colors(program, scene, pattern, options):
    """Renders linear colors into the .npy files of a pattern with {aov}."""
    command = [program, "render", *scene, "-o", pattern, "--aov", "color", "--layout", "exact", *options]
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)


def load_levels(file):
    """Levels, and which pixels show a surface."""
    color = np.load(file)
    return encoded(color[..., :3]), color[..., 3] > 0.5


def image(program, scene, file, options):
    render_colors(program, scene, f"{file}.{{aov}}.npy", options)
    return load_levels(f"{file}.color.npy")
