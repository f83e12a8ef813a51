"""Dome lights: the scene's environment, as the sum of their textures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._model_builder import linear
from ..errors import UsageError
from .context import Context
from .images import is_radiance, open_image, read_radiance
from .lights import color_of, radiance_of
from .transforms import axes_of


def is_dome(context: Context, prim: Any) -> bool:
    lux = context.pxr.UsdLux
    return bool(prim.IsA(lux.DomeLight) or prim.IsA(lux.DomeLight_1))


def environment_of(context: Context, domes: Sequence[Any]) -> np.ndarray:
    """The radiance of all dome lights, in the frame of the scene's environments."""
    images = [_image_of(context, dome) for dome in domes]
    height = max(32, max(image.shape[0] for image in images))
    directions = _directions(height)
    total = np.zeros((height, 2 * height, 3), np.float32)
    for dome, image in zip(domes, images):
        api = context.pxr.UsdLux.LightAPI(dome)
        rotations, scales = axes_of(context.scene_from(dome)[None])
        axes = rotations[0] * np.where(scales[0] < 0, -1, 1)
        pole = dome.GetAttribute("poleAxis").Get() if dome.IsA(context.pxr.UsdLux.DomeLight_1) else "Y"
        up = context.pxr.UsdGeom.GetStageUpAxis(context.stage) if pole == "scene" else pole
        if up == "Z":  # the texture's pole, which is +Y, is turned about X
            axes = axes @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        color = radiance_of(api, context.time) * color_of(api, context.pxr, context.time)
        total += color.astype(np.float32) * _sampled(image, directions @ axes)
    return total


def _image_of(context: Context, dome: Any) -> np.ndarray:
    """The texture of a dome light as linear radiance; white without one."""
    lux = context.pxr.UsdLux
    light = lux.DomeLight_1(dome) if dome.IsA(lux.DomeLight_1) else lux.DomeLight(dome)
    if light.GetTextureFormatAttr().Get(context.time) not in ("automatic", "latlong"):
        raise UsageError(f"{dome.GetPath()} has a texture that is not latlong, the only format that is converted")
    file = light.GetTextureFileAttr().Get(context.time)
    path = context.files.resolved(file)
    if file and file.path and not path:
        raise UsageError(f"{dome.GetPath()} has the texture {file.path}, which does not exist")
    if not path:
        return np.ones((1, 2, 3), np.float32)
    if is_radiance(path):
        return read_radiance(context.files, path)
    return linear(np.asarray(open_image(context.files, path).convert("RGB")) / 255)


def _directions(height: int) -> np.ndarray:
    """The directions (H, 2 H, 3) of the pixels of an environment in the glTF frame: the center column is at +X, columns
    grow toward +Z, and the top row is +Y."""
    longitude = (np.arange(2 * height) + 0.5) / (2 * height) * 2 * np.pi - np.pi
    latitude = np.pi / 2 - (np.arange(height) + 0.5) / height * np.pi
    y, x = np.meshgrid(latitude, longitude, indexing="ij")
    return np.stack([np.cos(y) * np.cos(x), np.sin(y), np.cos(y) * np.sin(x)], axis=-1)


def _sampled(image: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Bilinear samples of a latlong image as UsdLux defines it by OpenEXR's convention: the center is +Z, columns grow
    toward -X, and the top row is +Y."""
    height, width = image.shape[:2]
    u = 0.5 - np.arctan2(directions[..., 0], directions[..., 2]) / (2 * np.pi)
    v = np.arccos(np.clip(directions[..., 1], -1, 1)) / np.pi
    x, y = u * width - 0.5, np.clip(v * height - 0.5, 0, height - 1)
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    right, low = (x - column)[..., None], (y - row)[..., None]
    below = np.minimum(row + 1, height - 1)

    def between(row: np.ndarray) -> np.ndarray:
        return image[row, column % width] * (1 - right) + image[row, (column + 1) % width] * right

    return np.asarray(between(row) * (1 - low) + between(below) * low, np.float32)
