"""Builds a scene from arrays, for the converters of other packages' models.

The scene is in glTF's frame (Y up, meters). Models with Z up are turned: (x, y, z) becomes (x, z, -y)."""

from __future__ import annotations

import contextlib
import importlib
import os
import re
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np

from ._core import Material, MaterialHandle, MeshHandle, Scene
from .errors import InputError, LatelightError, UsageError

Wrap = Literal["repeat", "mirror", "clamp"]

DEFAULT_COLOR = (0.8, 0.8, 0.8, 1.0)  # linear, of what has no material
FROM_Z_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float64)


def up_transform(up: str) -> np.ndarray:
    if up not in ("y", "z"):
        raise UsageError(f'up must be "y" or "z", not "{up}"')
    return np.eye(4) if up == "y" else FROM_Z_UP


def linear(colors: np.ndarray) -> np.ndarray:
    """Decodes sRGB in [0, 1] (IEC 61966-2-1). Alpha, the fourth channel, is linear."""
    colors = np.array(colors, np.float64)
    rgb = colors[..., :3]
    colors[..., :3] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return colors.astype(np.float32)


def encoded(colors: np.ndarray) -> np.ndarray:
    """Encodes linear colors in [0, 1] as sRGB (IEC 61966-2-1)."""
    return np.where(colors <= 0.0031308, colors * 12.92, 1.055 * np.maximum(colors, 0.0031308) ** (1 / 2.4) - 0.055)


def v_down(uv: Any) -> np.ndarray:
    """Texture coordinates with v up become those of glTF, with v down."""
    uv = np.array(uv, np.float32)[:, :2]
    uv[:, 1] = 1 - uv[:, 1]
    return uv


def to_eight_bits(image: Any) -> Any:
    """Rounds an image of Pillow with 16 bits per channel to 8 bits, to which Pillow would clip it."""
    if not getattr(image, "mode", "").startswith("I"):
        return image
    pixels = (np.clip(np.asarray(image).astype(np.int64), 0, 65535) + 128) // 257
    return importlib.import_module("PIL.Image").fromarray(pixels.astype(np.uint8))


def node_name(name: Any) -> str:
    return str(name).replace("/", "_") or "node"


class MissingPackageError(UsageError):
    pass


@contextlib.contextmanager
def reading(source: Any, package: str) -> Iterator[None]:
    """Reports what is wrong with a file, of which packages raise errors of all kinds, by an InputError of one sentence.
    Errors of models in memory pass unchanged."""
    try:
        yield
    except (MissingPackageError, MemoryError, InputError):
        raise
    except Exception as error:
        if not isinstance(source, (str, os.PathLike)):
            raise
        if isinstance(error, LatelightError):
            raise InputError(f"{os.fspath(source)}: {error}") from None
        reason = re.sub(r"\s+", " ", str(error)).strip() or type(error).__name__
        # USD lists errors with positions in its own sources and the grammar's rules: the first error's text is enough.
        if first := re.search(r" : '(.*?)'( Error in |$)", reason):
            reason = first[1].split(" matching ")[0]
        raise InputError(f"{os.fspath(source)} cannot be read by {package}: {reason}") from None


def missing(package: str, function: str) -> UsageError:
    return MissingPackageError(f"latelight.{function} requires the package {package}: install it, for example with pip")


class Builder:
    """Adds meshes, materials and instances. Objects that are used several times are added once."""

    def __init__(self, up: str) -> None:
        self.scene = Scene()
        self.world = up_transform(up)
        self.materials: dict[Any, MaterialHandle] = {}
        self.textures: dict[Any, Any] = {}
        self.kept: list[Any] = []  # keeps the ids in the keys above unique

    def default_material(self, double_sided: bool = False) -> MaterialHandle:
        return self.plain("default", DEFAULT_COLOR, False, double_sided)

    def white(self, translucent: bool, double_sided: bool = False) -> MaterialHandle:
        """For meshes whose vertices have colors."""
        return self.plain("vertex colors", (1, 1, 1, 1), translucent, double_sided)

    def plain(self, name: str, color: Any, translucent: bool, double_sided: bool) -> MaterialHandle:
        key = (name, color, translucent, double_sided)
        if key not in self.materials:
            mode = "blend" if translucent else "opaque"
            self.materials[key] = self.scene.add_material(
                Material(
                    name=name,
                    base_color=color,
                    metallic=0,
                    roughness=0.5,
                    alpha_mode=mode,
                    double_sided=double_sided,
                )
            )
        return self.materials[key]

    def add_texture(
        self, material: MaterialHandle, slot: Any, image: Any, srgb: bool, wrap: Wrap = "repeat"
    ) -> None:
        if image is None:
            return
        key = (id(image), srgb)
        if key not in self.textures:
            self.kept.append(image)
            mode = "RGBA" if "A" in getattr(image, "mode", "") or getattr(image, "mode", "") == "P" else "RGB"
            pixels = np.asarray(to_eight_bits(image).convert(mode) if hasattr(image, "convert") else image)
            self.textures[key] = self.scene.add_texture(np.ascontiguousarray(pixels), srgb=srgb, name=slot)
        self.scene.set_texture(material, slot, self.textures[key], wrap)

    def add_instance(self, mesh: MeshHandle, material: MaterialHandle, transform: Any, name: Any) -> None:
        self.scene.add_instance(mesh, material, self.world @ np.asarray(transform, np.float64), node_name(name))
