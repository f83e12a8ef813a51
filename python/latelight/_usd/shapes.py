"""Spheres, cubes, cylinders, cones, capsules and planes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .._core import MeshHandle
from .._shapes import Shape, box, capsule, cone, cylinder, ellipsoid, mesh_arrays, plane, tapered_capsule
from ..errors import UsageError
from .context import Context

# The shapes of UsdGeom by type, from their attributes, around Z. A plane faces its axis: if that is X or Y, its length
# comes before its width.
_SHAPES: dict[str, Callable[[Callable[[str], float], str], Shape]] = {
    "Sphere": lambda size, axis: ellipsoid([size("radius")] * 3),
    "Cube": lambda size, axis: box(size("size") / 2),
    "Cylinder": lambda size, axis: cylinder(size("radius"), size("height") / 2),
    "Cone": lambda size, axis: cone(size("radius"), size("height") / 2),
    "Capsule": lambda size, axis: capsule(size("radius"), size("height") / 2),
    "Cylinder_1": lambda size, axis: cylinder(size("radiusBottom"), size("height") / 2, size("radiusTop")),
    "Capsule_1": lambda size, axis: tapered_capsule(size("radiusBottom"), size("radiusTop"), size("height") / 2),
    "Plane": lambda size, axis: plane(
        np.array([size("width"), size("length")] if axis == "Z" else [size("length"), size("width")]) / 2
    ),
}
_TURNED = {"X": [2, 0, 1], "Y": [1, 2, 0], "Z": [0, 1, 2]}  # the coordinates around Z that become x, y and z


def is_shape(prim: Any) -> bool:
    return prim.GetTypeName() in _SHAPES


def add_shape(context: Context, prim: Any) -> MeshHandle:
    def size(name: str) -> float:
        value = float(prim.GetAttribute(name).Get(context.time))
        if not 0 <= value < math.inf or (value == 0 and name in ("radius", "size", "width", "length")):
            raise UsageError(f"{prim.GetPath()} has the {name} {value:g}, but it must be positive")
        return value

    given = prim.GetAttribute("axis")
    axis = str(given.Get(context.time)) if given else "Z"
    points, normals, triangles = _SHAPES[prim.GetTypeName()](size, axis)
    turned = _TURNED[axis]
    arrays = mesh_arrays((points[:, turned], normals[:, turned], triangles))
    return context.scene.add_mesh(**arrays, name=prim.GetName())
