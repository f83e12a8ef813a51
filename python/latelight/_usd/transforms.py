"""Transforms (n, 4, 4) as translations, rotations and scales, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import UsageError

_FLAT = 1e-13  # relative length of an axis of a transform whose direction is rounding


def _quaternions(rotations: np.ndarray) -> np.ndarray:
    """Quaternions x, y, z, w of rotation matrices (n, 3, 3). Each row of the matrix below is a multiple of the
    quaternion; the one with the largest diagonal element is the most precise."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(rotations, 0, -1)
    rows = np.array(
        [
            [1 + a - e - i, d + b, c + g, h - f],
            [d + b, 1 - a + e - i, h + f, c - g],
            [c + g, h + f, 1 - a - e + i, d - b],
            [h - f, c - g, d - b, 1 + a + e + i],
        ]
    )
    best = np.argmax(np.stack([rows[k, k] for k in range(4)]), axis=0)
    chosen: np.ndarray = rows[best, :, np.arange(len(rotations))]
    return chosen / np.linalg.norm(chosen, axis=1, keepdims=True)


def unsheared(matrices: np.ndarray) -> np.ndarray:
    """Transforms (n, 4, 4) by a translation, a rotation and a scale that are close to the given ones. Those of
    instancers are not exactly such, because their quaternions have half precision."""
    return composed(*_parts(matrices))


def axes_of(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rotations (n, 3, 3) and scales (n, 3) whose product are the axes of transforms (n, 4, 4). The first scale is
    negative if a transform mirrors. The axes of a rotation are not perpendicular if a transform shears."""
    axes = matrices[:, :3, :3]
    scales = np.linalg.norm(axes, axis=1)
    flat = scales <= _FLAT * scales.max(axis=1, keepdims=True)
    scales[:, 0] *= np.where((np.linalg.det(axes) < 0) & ~flat.any(axis=1), -1, 1)
    return _completed(axes / np.where(flat, 1, scales)[:, None, :], flat), scales


def _parts(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The translations, rotations and scales of transforms (n, 4, 4) without shear."""
    rotations, scales = axes_of(matrices)
    return matrices[:, :3, 3], _quaternions(rotations), scales


def _completed(rotations: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3), of which a scale of zero left the axes that are flat (n, 3) without a direction. One follows
    from the other two, two are any that are perpendicular to the third, and three are those of the identity."""
    rotations, flat = rotations.copy(), flat.copy()
    rotations[flat.all(axis=1)] = np.eye(3)
    flat[flat.all(axis=1)] = False
    (line,) = np.nonzero(flat.sum(axis=1) == 2)
    known = np.argmin(flat[line], axis=1)
    axis, following = rotations[line, :, known], (known + 1) % 3
    steep = np.abs(axis[np.arange(len(line)), following]) < 0.9
    other = np.eye(3)[np.where(steep, following, (known + 2) % 3)]
    other -= np.sum(other * axis, axis=1, keepdims=True) * axis
    rotations[line, :, following] = other / np.linalg.norm(other, axis=1, keepdims=True)
    flat[line, following] = False
    (plane,) = np.nonzero(flat.any(axis=1))
    last = np.argmax(flat[plane], axis=1)
    first, second = (rotations[plane, :, (last + step) % 3] for step in (1, 2))
    rotations[plane, :, last] = np.cross(first, second)
    return rotations


def decomposed(matrices: np.ndarray, path: Any, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Translations, rotations and scales of transforms (n, 4, 4). Shear is an error."""
    axes, parts = matrices[:, :3, :3], _parts(matrices)
    error = np.abs(composed(*parts) - matrices)[:, :3, :3].max(axis=(1, 2))
    if (error > 1e-5 * np.maximum(np.abs(axes).max(axis=(1, 2)), 1e-30)).any():
        raise UsageError(
            f"{path} is sheared at the time code {time:g}, which animations of a translation, a rotation and a scale "
            "cannot be: give a time, at which the stage is then converted"
        )
    return parts


def composed(translations: np.ndarray, rotations: np.ndarray, scales: np.ndarray) -> np.ndarray:
    x, y, z, w = np.moveaxis(rotations, -1, 0)
    matrices = np.zeros((len(scales), 4, 4))
    matrices[:, 3, 3] = 1
    matrices[:, :3, 3] = translations
    matrices[:, :3, :3] = np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        ),
        -1,
        0,
    ) * scales[:, None, :]
    return matrices


def interpolated(first: Any, last: Any, fraction: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Interpolates as glTF does: rotations along the shorter arc at constant speed."""
    (t0, q0, s0), (t1, q1, s1) = first, last
    cosine = np.sum(q0 * q1, axis=1, keepdims=True)
    q1, cosine = np.where(cosine < 0, -q1, q1), np.abs(cosine)
    angle = np.arccos(np.clip(cosine, 0, 1))
    sine = np.sin(angle)
    near = sine < 1e-6
    a = np.where(near, 1 - fraction, np.sin((1 - fraction) * angle) / np.where(near, 1, sine))
    b = np.where(near, fraction, np.sin(fraction * angle) / np.where(near, 1, sine))
    q = a * q0 + b * q1
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return t0 + fraction * (t1 - t0), q, s0 + fraction * (s1 - s0)
