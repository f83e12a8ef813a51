"""Blend shapes with in-betweens: as morph targets and their weights over time, or the points at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import UsageError
from .context import Context
from .geometry import count_points, has_point_normals, points_of
from .skeletons import Binding


def blended_points(context: Context, binding: Binding, mesh: Any) -> tuple[np.ndarray, np.ndarray | None] | None:
    """The points and normals per point by the blend shapes at the time of the stage at rest; None without any."""
    if not binding.has_shapes() or not binding.animation:
        return None
    return BlendShapes(context, binding, mesh).blended()


class BlendShapes:
    """The blend shapes of a mesh with a binding that has shapes and an animation."""

    def __init__(self, context: Context, binding: Binding, mesh: Any) -> None:
        self.context, self.mesh, self.animation = context, mesh, binding.animation
        self.mapper = binding.skinning.GetBlendShapeMapper()
        self.query = context.pxr.UsdSkel.BlendShapeQuery(context.pxr.UsdSkel.BindingAPI(mesh.GetPrim()))

    # --- over time ---

    def targets(self) -> list[dict[str, np.ndarray]]:
        """The offsets of all points, and of normals per point, by each blend shape and in-between."""
        count = count_points(self.mesh, self.context.time)
        return [self._target(part, count) for part in range(self.query.GetNumSubShapes())]

    def _target(self, part: int, count: int) -> dict[str, np.ndarray]:
        blend, positions, normals = self._offsets(self.query.GetBlendShapeIndex(part), part)
        made = {}
        for name, offsets in (("positions", positions), ("normals", normals)):
            if name == "normals" and not has_point_normals(self.mesh):
                continue
            if offsets is not None and len(offsets) > 0:
                made[name] = np.zeros((count, 3), np.float32)
                self._add(made[name], blend, np.asarray(offsets, np.float32))
        return made

    def weights(self) -> tuple[list[float], np.ndarray]:
        """Times, and the weights of all shapes and in-betweens at them. Between two samples a weight is linear, and
        that of an in-between is linear between the weights of its neighbors, so that keys are added where a weight
        passes one."""
        samples = self.context.samples
        times = samples.clipped([samples.start, *self.animation.GetBlendShapeWeightTimeSamples()])
        passed: set[float] = set()
        stops: dict[int, set[float]] = {}
        for part in range(self.query.GetNumSubShapes()):
            if between := self.query.GetInbetween(part):
                stops.setdefault(self.query.GetBlendShapeIndex(part), {0.0, 1.0}).add(float(between.GetWeight()))
        for begin, end in zip(times, times[1:]) if not samples.held else ():
            first, last = (self._of_mesh(self.animation.ComputeBlendShapeWeights(time)) for time in (begin, end))
            for shape, weights in stops.items():
                a, b = first[shape], last[shape]
                passed |= {begin + (end - begin) * (w - a) / (b - a) for w in weights if min(a, b) < w < max(a, b)}
        times = sorted({*times, *passed})
        table = np.zeros((len(times), self.query.GetNumSubShapes()), np.float32)
        for row, time in zip(table, times):
            weights_then = self._of_mesh(self.animation.ComputeBlendShapeWeights(time))
            for weight, _, part in zip(*self.query.ComputeSubShapeWeights(weights_then)):
                row[part] += weight
        return times, table

    # --- at a time ---

    def blended(self) -> tuple[np.ndarray, np.ndarray | None] | None:
        """The points and the normals per point, by the weights of the skeleton's animation; none without weights.
        In-between shapes are interpolated as UsdSkel defines it."""
        time, mesh = self.context.time, self.mesh
        weights = self.animation.ComputeBlendShapeWeights(time)
        if not weights:
            return None
        parts = self.query.ComputeSubShapeWeights(self._of_mesh(weights))
        points = np.array(points_of(mesh, time))
        normals = None
        if has_point_normals(mesh) and mesh.GetNormalsAttr().Get(time):
            normals = np.array(mesh.GetNormalsAttr().Get(time), np.float32).reshape(-1, 3)
        for weight, shape, part in zip(*parts):
            blend, *moves = self._offsets(shape, part)
            for values, offsets in zip((points, normals), moves):
                if values is not None and offsets is not None and len(offsets) > 0:
                    self._add(values, blend, weight * np.asarray(offsets, np.float32))
        if normals is not None:
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        return points, normals

    def _of_mesh(self, weights: Any) -> Any:
        """Weights of the animation in the order of the mesh."""
        return self.mapper.Remap(weights) if self.mapper else weights

    def _offsets(self, shape: int, part: int) -> tuple[Any, Any, Any]:
        """A blend shape, and the offsets of points and normals by it or by one of its in-betweens."""
        blend, between = self.query.GetBlendShape(shape), self.query.GetInbetween(part)
        if between:
            return blend, between.GetOffsets(), between.GetNormalOffsets()
        return blend, blend.GetOffsetsAttr().Get(), blend.GetNormalOffsetsAttr().Get()

    def _add(self, values: np.ndarray, blend: Any, offsets: np.ndarray) -> None:
        """Adds offsets to the points that a blend shape moves, or to their normals, in place."""
        indices = blend.GetPointIndicesAttr().Get()
        where = None if indices is None or len(indices) == 0 else np.asarray(indices, np.int64)
        outside = where is not None and (where.min() < 0 or where.max() >= len(values))
        if len(offsets) != len(values if where is None else where) or outside:
            raise UsageError(f"{self.mesh.GetPath()} has a blend shape that does not match its points")
        if where is None:
            values += offsets
        else:
            np.add.at(values, where, offsets)
