"""Meshes of the primitive shapes of physics engines, in the frames of their geoms: Z is the axis of round shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

Shape = tuple[np.ndarray, np.ndarray, np.ndarray]  # positions (V, 3), normals (V, 3), triangles (T, 3)


def _grid(rows: int, columns: int, falling: bool = False) -> np.ndarray:
    """Triangles between rows x columns points, counterclockwise where columns run right and rows up. `falling`: cells
    are cut from the upper left to the lower right."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    right, up, across = first + 1, first + columns, first + columns + 1
    if falling:
        return np.concatenate([np.stack([first, right, up], 1), np.stack([right, across, up], 1)])
    return np.concatenate([np.stack([first, right, across], 1), np.stack([first, across, up], 1)])


def _round(profile: np.ndarray, normals: np.ndarray, around: int = 32) -> Shape:
    """A profile of (radius, z) points from the bottom to the top, turned about Z."""
    angle = np.linspace(0, 2 * np.pi, around + 1)
    circle = np.stack([np.cos(angle), np.sin(angle)], 1)

    def turned(points: np.ndarray) -> np.ndarray:
        flat = points[:, None, :1] * circle[None]
        return np.concatenate([flat, np.broadcast_to(points[:, None, 1:], (*flat.shape[:2], 1))], 2).reshape(-1, 3)

    return turned(profile), turned(normals), _grid(len(profile), around + 1)


def _half_circles(gap: float) -> tuple[np.ndarray, np.ndarray]:
    """The profile of a sphere of radius 1 that is cut in half and moved apart by `gap` to each side."""
    below, above = np.linspace(-np.pi / 2, 0, 9), np.linspace(0, np.pi / 2, 9)
    angle = np.concatenate([below, above])
    normals = np.stack([np.cos(angle), np.sin(angle)], 1)
    offset = np.concatenate([np.full(9, -gap), np.full(9, gap)])
    return normals + np.stack([np.zeros(18), offset], 1), normals


def mesh_arrays(shape: Shape) -> dict[str, Any]:
    """The arrays of Scene.add_mesh()."""
    points, normals, triangles = shape
    return {"positions": points.astype(np.float32), "normals": normals.astype(np.float32), "indices": triangles}


def plane(half: Any) -> Shape:
    """A rectangle at z = 0 that faces +Z. `half`: half sizes in X and Y."""
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * [*half, 0]
    return points, np.tile([0.0, 0.0, 1.0], (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])


def ellipsoid(radii: Any) -> Shape:
    points, normals, triangles = _round(*_half_circles(0))
    normals = normals / radii
    return points * radii, normals / np.linalg.norm(normals, axis=1, keepdims=True), triangles


def capsule(radius: float, half: float) -> Shape:
    points, normals, triangles = _round(*_half_circles(half / radius))
    return points * radius, normals, triangles


def _side(bottom: float, top: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    """The profile of the surface between circles at z = -half and half, of two radii."""
    normal = np.array([2 * half, bottom - top])
    return np.array([[bottom, -half], [top, half]]), np.tile(normal / max(np.linalg.norm(normal), 1e-30), (2, 1))


def cylinder(radius: float, half: float, top: float | None = None) -> Shape:
    """`top`: the radius of the upper end, if it differs from that of the lower one."""
    side, normals = _side(radius, radius if top is None else top, half)
    profile = np.array([[0, -half], side[0], side[0], side[1], side[1], [0, half]])
    return _round(profile, np.array([[0, -1], [0, -1], *normals, [0, 1], [0, 1]], float))


def tapered_capsule(bottom: float, top: float, half: float) -> Shape:
    """Half spheres of two radii with centers at z = -half and half, and the surface between their equators."""
    points, normals = _half_circles(0)
    side, side_normals = _side(bottom, top, half)
    profile = [points[:9] * bottom - [0, half], side, points[9:] * top + [0, half]]
    return _round(np.concatenate(profile), np.concatenate([normals[:9], side_normals, normals[9:]]))


def box(half: Any) -> Shape:
    points, normals, triangles = [], [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            face = np.zeros((4, 3))
            face[:, axis] = sign
            face[:, u] = np.array([-1, 1, 1, -1]) * sign
            face[:, v] = [-1, -1, 1, 1]
            normal = np.zeros(3)
            normal[axis] = sign
            triangles += [np.array([[0, 1, 2], [0, 2, 3]]) + 4 * len(points)]
            points.append(face * half)
            normals.append(np.tile(normal, (4, 1)))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(triangles)


def height_field(data: np.ndarray, size: np.ndarray, falling: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """The surface and the four sides down to the base, below zero. `size`: half sizes in X and Y, elevation, and base.
    `falling`: cells are cut from the corner at -X +Y to that at +X -Y."""
    rows, columns = data.shape
    x, y = np.meshgrid(np.linspace(-size[0], size[0], columns), np.linspace(-size[1], size[1], rows))
    top = np.stack([x, y, data * size[2]], 2)
    points, triangles = [top.reshape(-1, 3)], [_grid(rows, columns, falling)]
    for edge in (top[0], top[::-1, 0], top[-1, ::-1], top[:, -1]):  # in the order in which their sides face outward
        below = edge * [1, 1, 0] - [0, 0, size[3]]
        triangles.append(_grid(2, len(edge)) + sum(map(len, points)))
        points.append(np.concatenate([below, edge]))
    return np.concatenate(points), np.concatenate(triangles)


def cone(radius: float, half: float) -> Shape:
    """The tip is at z = half."""
    slope = np.hypot(radius, 2 * half)
    side = [2 * half / slope, radius / slope]
    profile = np.array([[0, -half], [radius, -half], [radius, -half], [0, half]])
    return _round(profile, np.array([[0, -1], [0, -1], side, side], float))
