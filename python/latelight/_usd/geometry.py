"""Meshes as triangles: their corners, the primvars of these, and a part per material."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .._core import MaterialHandle, MeshHandle, triangulate
from .._model_builder import v_down
from ..errors import UsageError
from .context import Context
from .materials import Materials, display_colors
from .time_samples import UV_PRIMVARS


class Corners(NamedTuple):
    """Corners of triangles, as indices of values per corner, point and face of their mesh."""

    flat: np.ndarray
    points: np.ndarray
    faces: np.ndarray

    def some(self, chosen: np.ndarray) -> Corners:
        return Corners(*(values[chosen] for values in self))


# Arguments of Scene.add_mesh() for vertices that are these corners, whose morph targets may have these arrays.
Deformation = Callable[[Corners, Sequence[str]], dict[str, Any]]


def mesh_parts(
    context: Context,
    materials: Materials,
    mesh: Any,
    points: np.ndarray | None = None,
    point_normals: np.ndarray | None = None,
    pose: np.ndarray | None = None,
    deformation: Deformation | None = None,
) -> list[tuple[MeshHandle, MaterialHandle]]:
    """One mesh per material. Corners share no vertices, because values may belong to faces and corners.

    points, point_normals: in place of those of the mesh
    pose: transforms of all points, or one for all of them"""
    prim = mesh.GetPrim()
    if points is None:
        points = points_of(mesh, context.time)
    every = _corners_of(context, mesh, points)
    if len(every.flat) == 0:
        return []
    normals = corner_normals(context, mesh, every, context.time)
    if point_normals is not None and len(point_normals) == len(points):
        normals = point_normals[every.points]
    if pose is not None:
        points, normals = _posed(points, normals, every, pose, prim.GetPath())
    candidates = (_corner_values(context, prim, name, every, 2) for name in UV_PRIMVARS)
    uv = next((values for values in candidates if values is not None), None)
    colors = _corner_values(context, prim, "displayColor", every, 3)
    opacities = _corner_values(context, prim, "displayOpacity", every, 1)
    kinds = ("positions",) if normals is None else ("positions", "normals")
    parts = []
    for material, triangles in _subsets(context, materials, prim, every.faces[::3]):
        chosen = np.repeat(triangles, 3)
        handle = materials.convert(material, prim)
        rgba = None
        if handle is None and (colors is not None or opacities is not None):  # the material of unbound meshes
            own = (None if values is None else values[chosen] for values in (colors, opacities))
            rgba = display_colors(chosen.sum(), *own)
            handle = materials.of_colors(prim, rgba)
        added = context.scene.add_mesh(
            points[every.points][chosen],
            normals=None if normals is None else normals[chosen],
            uv=None if uv is None else v_down(uv[chosen]),
            colors=rgba,
            name=prim.GetName(),
            **(deformation(every.some(chosen), kinds) if deformation else {}),
        )
        parts.append((added, handle if handle is not None else materials.default(prim)))
    return parts


def points_of(mesh: Any, time: Any) -> np.ndarray:
    return np.asarray(mesh.GetPointsAttr().Get(time) or [], np.float32).reshape(-1, 3)


def count_points(mesh: Any, time: Any) -> int:
    return len(mesh.GetPointsAttr().Get(time) or [])


def has_point_normals(mesh: Any) -> bool:
    """True if the attribute of a mesh for normals has one for each point, if any."""
    return mesh.GetNormalsInterpolation() in ("vertex", "varying")


def corner_normals(context: Context, mesh: Any, corners: Corners, time: Any) -> np.ndarray | None:
    """The normals per corner of the triangles, of the primvar or else of the attribute."""
    if primvar := _find_primvar(context, mesh.GetPrim(), "normals"):
        return _per_corner(primvar.ComputeFlattened(time), primvar.GetInterpolation(), corners, 3)
    return _per_corner(mesh.GetNormalsAttr().Get(time), mesh.GetNormalsInterpolation(), corners, 3)


def _corners_of(context: Context, mesh: Any, points: np.ndarray) -> Corners:
    """The corners of all triangles of a mesh, without those of its holes."""
    counts, indices, holes = (
        np.asarray(attribute.Get(context.time) or [], np.int64)
        for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(), mesh.GetHoleIndicesAttr())
    )
    if len(points) == 0 or len(counts) == 0:
        return Corners(*np.zeros((3, 0), np.int64))
    if (counts < 0).any():
        raise UsageError(f"{mesh.GetPath()} has a face with {counts.min()} corners")
    if counts.sum() != len(indices) or (indices < 0).any() or (indices >= len(points)).any():
        raise UsageError(f"{mesh.GetPath()} has faces that refer to points it does not have")
    corners = triangulate(np.ascontiguousarray(points, np.float32), indices, counts)
    faces = np.repeat(np.arange(len(counts)), np.maximum(counts - 2, 0))
    shown = ~np.isin(faces, holes)
    corners, faces = corners[shown], faces[shown]
    if mesh.GetOrientationAttr().Get(context.time) == context.pxr.UsdGeom.Tokens.leftHanded:
        corners = corners[:, ::-1]
    flat = corners.ravel()
    return Corners(flat, indices[flat], np.repeat(faces, 3))


def _posed(
    points: np.ndarray, normals: np.ndarray | None, corners: Corners, pose: np.ndarray, path: Any
) -> tuple[np.ndarray, np.ndarray | None]:
    """Points, and normals per corner, that the transforms of all points or one for all of them move."""
    if len(pose) not in (1, len(points)):
        raise UsageError(f"{path} has joint influences that do not match its points")
    pose = np.broadcast_to(pose, (len(points), 4, 4))
    points = (np.einsum("pij,pj->pi", pose[:, :3, :3], points) + pose[:, :3, 3]).astype(np.float32)
    if normals is not None:
        turn = np.linalg.pinv(pose[:, :3, :3]).transpose(0, 2, 1)
        normals = np.einsum("pij,pj->pi", turn[corners.points], normals).astype(np.float32)
    return points, normals


def _corner_values(context: Context, prim: Any, name: str, corners: Corners, width: int) -> np.ndarray | None:
    """The values of a primvar per corner of the triangles."""
    primvar = _find_primvar(context, prim, name)
    if primvar is None:
        return None
    return _per_corner(primvar.ComputeFlattened(context.time), primvar.GetInterpolation(), corners, width)


def _find_primvar(context: Context, prim: Any, name: str) -> Any:
    primvar = context.pxr.UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    return primvar if primvar and primvar.HasValue() else None


def _per_corner(values: Any, interpolation: str, corners: Corners, width: int) -> np.ndarray | None:
    """None if there are too few values."""
    if values is None or len(values) == 0:
        return None
    array = np.asarray(values, np.float32).reshape(len(values), -1)[:, :width]
    if interpolation == "constant":
        return np.repeat(array[:1], len(corners.flat), axis=0)
    if interpolation == "uniform":
        at = corners.faces
    else:
        at = corners.flat if interpolation == "faceVarying" else corners.points
    return array[at] if len(array) > at.max() else None


def _subsets(context: Context, materials: Materials, prim: Any, faces: np.ndarray) -> list[tuple[Any, np.ndarray]]:
    """The material of each subset of faces, and which triangles it has."""
    shade, geom = context.pxr.UsdShade, context.pxr.UsdGeom
    rest = np.ones(len(faces), bool)
    parts = []
    for subset in shade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        indices = np.asarray(geom.Subset(subset).GetIndicesAttr().Get(context.time) or [], np.int64)
        chosen = np.isin(faces, indices) & rest
        rest &= ~chosen
        if chosen.any():
            parts.append((materials.bound(subset), chosen))
    if rest.any():
        parts.append((materials.bound(prim), rest))
    return parts
