"""Meshes as triangles: their corners, the primvars of these, and a part per material."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .._core import MeshHandle, triangulate
from .._model_builder import v_down
from ..errors import UsageError
from .context import Context
from .materials import VertexSources
from .primvars import Primvars
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


def add_meshes(
    context: Context,
    primvars: Primvars,
    sources: Sequence[VertexSources],
    points: np.ndarray | None = None,
    point_normals: np.ndarray | None = None,
    pose: np.ndarray | None = None,
    deformation: Deformation | None = None,
) -> list[MeshHandle | None]:
    """Adds the meshes of a prim, one for each subset of its faces and one for the other faces; None for those without
    triangles. Corners share no vertices, because values may belong to faces and corners.

    sources: the primvars for the vertices of each of these meshes
    points, point_normals: in place of those of the prim
    pose: transforms of all points, or one for all of them"""
    prim = primvars.prim
    mesh = context.pxr.UsdGeom.Mesh(prim)
    if points is None:
        points = points_of(mesh, context.time)
    every = _corners_of(context, mesh, points)
    if len(every.flat) == 0:
        return [None] * len(sources)
    normals = corner_normals(context, mesh, every, context.time)
    if point_normals is not None and len(point_normals) == len(points):
        normals = point_normals[every.points]
    if pose is not None:
        points, normals = _posed(points, normals, every, pose, prim.GetPath())
    kinds = ("positions",) if normals is None else ("positions", "normals")
    meshes: list[MeshHandle | None] = []
    for source, triangles in zip(sources, _subset_triangles(context, prim, every.faces[::3])):
        if not triangles.any():
            meshes.append(None)
            continue
        chosen = np.repeat(triangles, 3)
        uv, colors = _texture_coordinates(primvars, source, every), _vertex_colors(primvars, source, every)
        added = context.scene.add_mesh(
            points[every.points][chosen],
            normals=None if normals is None else normals[chosen],
            uv=None if uv is None else v_down(uv[chosen]),
            colors=None if colors is None else colors[chosen],
            name=prim.GetName(),
            **(deformation(every.some(chosen), kinds) if deformation else {}),
        )
        meshes.append(added)
    return meshes


def subsets_of(context: Context, prim: Any) -> list[Any]:
    """The subsets of a mesh's faces that may have a material of their own."""
    return list(context.pxr.UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets())


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


def _texture_coordinates(primvars: Primvars, source: VertexSources, corners: Corners) -> np.ndarray | None:
    """Per corner. A primvar that the mesh does not have is replaced by its fallback, and one without a stated name by
    the first of the usual names."""
    if source.coordinates is None:
        candidates = (_corner_values(primvars, name, corners, 2) for name in UV_PRIMVARS)
        return next((values for values in candidates if values is not None), None)
    values = _corner_values(primvars, source.coordinates.primvar, corners, 2)
    if values is None:
        primvars.context.warn(
            f'meshes without the primvar "{source.coordinates.primvar}", which their material states for texture '
            "coordinates, have one texel of its images"
        )
        fallback = np.resize(np.array(source.coordinates.fallback, np.float32), 2)
        values = np.tile(fallback, (len(corners.flat), 1))
    return values


def _vertex_colors(primvars: Primvars, source: VertexSources, corners: Corners) -> np.ndarray | None:
    """Linear RGBA per corner, white and opaque without a primvar for each."""
    if not source.color and not source.opacity:
        return None
    rgba = np.ones((len(corners.flat), 4), np.float32)
    for name, part in ((source.color, slice(0, 3)), (source.opacity, slice(3, 4))):
        width = rgba[:, part].shape[1]
        values = _corner_values(primvars, name, corners, width) if name else None
        if values is not None and values.shape[1] in (1, width):
            rgba[:, part] = np.clip(values, 0, 1)
    return rgba


def _corner_values(primvars: Primvars, name: str, corners: Corners, width: int) -> np.ndarray | None:
    """The values of a primvar per corner of the triangles."""
    found = primvars.find(name)
    return None if found is None else _per_corner(found.array, found.interpolation, corners, width)


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


def _subset_triangles(context: Context, prim: Any, faces: np.ndarray) -> list[np.ndarray]:
    """Which triangles, of these faces, each subset has, and which ones belong to none."""
    rest = np.ones(len(faces), bool)
    parts = []
    for subset in subsets_of(context, prim):
        indices = np.asarray(context.pxr.UsdGeom.Subset(subset).GetIndicesAttr().Get(context.time) or [], np.int64)
        parts.append(np.isin(faces, indices) & rest)
        rest &= ~parts[-1]
    return [*parts, rest]
