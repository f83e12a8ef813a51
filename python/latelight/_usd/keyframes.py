"""Keyframes that follow transforms which change over time.

Transforms are sampled where their attributes have samples, and keys are added between them until the interpolated
transforms follow the stage's, since USD interpolates the operations of a transform, such as angles, and glTF its
translation, rotation and scale."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .transforms import composed, decomposed, interpolated

Matrices = Callable[[float], np.ndarray]  # transforms (n, 4, 4) at a time

_TOLERANCE = 1e-4  # of interpolated transforms: radians and relative scale, and of the path that translations cover
_FRACTIONS = (0.29, 0.5, 0.83)  # of intervals, where interpolated transforms are compared with the stage's
_DEEPEST = 10  # halvings of an interval between samples


def keyframes(
    times: Sequence[float], matrices: Matrices, path: Any, held: bool
) -> tuple[list[float], dict[str, np.ndarray]]:
    """Times, and the translations, rotations and scales at them, (times, n, 3 or 4).

    path: of the prim that messages name; held: values stay until the next sample, so that no keys are added"""
    known = {time: decomposed(matrices(time), path, time) for time in times}
    reach = max(float(np.ptp([t for t, _, _ in known.values()], axis=0).max()), 1e-30)
    pending = [] if held else [(a, b, 0) for a, b in zip(times, times[1:])]
    while pending:
        begin, end, depth = pending.pop()
        if depth < _DEEPEST and not _follows(known, begin, end, matrices, reach):
            middle = (begin + end) / 2
            known[middle] = decomposed(matrices(middle), path, middle)
            pending += [(begin, middle, depth + 1), (middle, end, depth + 1)]
    order = sorted(known)
    stacked = [np.stack([known[time][i] for time in order]) for i in range(3)]
    return order, dict(zip(("translation", "rotation", "scale"), stacked))


def _follows(known: Any, begin: float, end: float, matrices: Matrices, reach: float) -> bool:
    """True if the transforms interpolated between two keys are those of the stage."""
    for fraction in _FRACTIONS:
        exact = matrices(begin + fraction * (end - begin))
        error = np.abs(composed(*interpolated(known[begin], known[end], fraction)) - exact)
        size = np.maximum(np.abs(exact[:, :3, :3]).max(axis=(1, 2)), 1e-30)
        turned = (error[:, :3, :3].max(axis=(1, 2)) > _TOLERANCE * size).any()
        if turned or error[:, :3, 3].max() > _TOLERANCE * reach:
            return False
    return True
