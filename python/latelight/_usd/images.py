"""Images of stages: their files, and channels that are packed to textures of glTF."""

from __future__ import annotations

import importlib
import io
import os
import tempfile
from typing import Any

import numpy as np

from .._core import read_environment
from .._model_builder import encoded, missing, to_eight_bits
from ..errors import InputError
from .files import Files, extension


def _pillow() -> Any:
    try:
        return importlib.import_module("PIL.Image")
    except ImportError:
        raise missing("pillow", "from_usd") from None


def open_image(files: Files, path: str) -> Any:
    """A decoded image of Pillow, with 8 bits per channel."""
    pil = _pillow()
    source = io.BytesIO(files.packaged(path)) if files.is_packaged(path) else path
    try:
        with pil.open(source) as image:
            image.load()
            return to_eight_bits(image)
    except MemoryError:
        raise
    except Exception as error:  # Pillow's decoders raise errors of many types
        known = "it is truncated, damaged or of an unknown format"
        reason = known if isinstance(error, pil.UnidentifiedImageError) else error
        raise InputError(f"the image {path} cannot be read by Pillow: {reason}") from None


def is_radiance(path: str) -> bool:
    """Returns true for files with linear values, which Pillow does not decode."""
    return extension(path) in (".hdr", ".exr")


def read_radiance(files: Files, path: str) -> np.ndarray:
    """The pixels of a .hdr or .exr file."""
    if not files.is_packaged(path):
        return read_environment(path)
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, f"environment{extension(path)}")
        with open(copy, "wb") as file:
            file.write(files.packaged(path))
        try:
            return read_environment(copy)
        except InputError as error:
            raise InputError(str(error).replace(copy, path)) from None


def radiance_image(files: Files, path: str, srgb: bool) -> Any:
    """A .hdr or .exr file as an image of Pillow with 8 bits per channel, encoded as sRGB or linear. Values above 1
    become 1, because textures of glTF end there."""
    values = np.clip(np.nan_to_num(read_radiance(files, path)), 0, 1)
    return _pillow().fromarray(np.rint((encoded(values) if srgb else values) * 255).astype(np.uint8))


def metallic_roughness(rough: np.ndarray | None, metal: np.ndarray | None) -> np.ndarray | None:
    """glTF's texture: roughness is green, metalness blue; a channel without an image is left to its factor."""
    if rough is None and metal is None:
        return None
    like = max((c for c in (rough, metal) if c is not None), key=lambda c: c.size)
    white = np.full_like(like, 255)
    sized = [white if c is None else _sized(c, like) for c in (rough, metal)]
    return np.stack([white, *sized], axis=-1)


def occlusion(channel: np.ndarray | None) -> np.ndarray | None:
    """glTF's texture, whose occlusion is red."""
    return None if channel is None else np.repeat(channel[..., None], 3, axis=-1)


def with_alpha(image: Any, mask: np.ndarray | None) -> Any:
    """An RGB image with the opacity of another one; white if there is no color image."""
    if mask is None:
        return image
    if image is None:
        return np.concatenate([np.full((*mask.shape, 3), 255, np.uint8), mask[..., None]], axis=-1)
    pixels = np.asarray(image)
    return np.concatenate([pixels, _sized(mask, pixels)[..., None]], axis=-1)


def _sized(channel: np.ndarray, like: np.ndarray) -> np.ndarray:
    """The nearest values at the size of another channel."""
    rows = np.arange(like.shape[0]) * channel.shape[0] // like.shape[0]
    columns = np.arange(like.shape[1]) * channel.shape[1] // like.shape[1]
    return channel[rows[:, None], columns]
