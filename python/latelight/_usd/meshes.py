"""Meshes of the stage: rigid ones, and those that skeletons, blend shapes or samples of their points deform.

Joints and weights of blend shapes are interpolated alike by USD and glTF. Points are blended between a morph target per
sample."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .animation import Animation
from .blend_shapes import BlendShapes, blended_points
from .context import Context, Parts
from .geometry import Corners, corner_normals, count_points, points_of
from .instances import Instances, root_name
from .skeletons import Binding, Skeletons

_LARGEST_MORPH = 2**31  # bytes of the morph targets of a mesh, which small files can make large


class Meshes:
    def __init__(
        self, context: Context, animation: Animation, instances: Instances, skeletons: Skeletons
    ) -> None:
        self.context, self.animation = context, animation
        self.instances, self.skeletons = instances, skeletons

    def add(self, prim: Any) -> None:
        mesh, binding = self.context.pxr.UsdGeom.Mesh(prim), self.skeletons.binding(prim)
        deforms = self.context.samples.exist and binding.deforms()
        times = self._times_of_points(mesh, binding)
        if deforms:
            self._add_deforming(mesh, binding)
        elif times:
            self._add_changing(mesh, times)
        else:
            self.instances.add(prim)

    # --- points that change over time ---

    def _times_of_points(self, mesh: Any, binding: Binding) -> list[float]:
        """The times of the samples of a mesh's points and normals, if morph targets can be these samples: there are as
        many points at all times, no skeleton moves them, the faces stay, and the targets are not too large."""
        samples = self.context.samples
        times = samples.clipped(samples.of_points(mesh.GetPrim()) if samples.exist else [])
        if len(times) < 2:
            return []
        counts = {count_points(mesh, time) for time in times}
        faces = (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
        triangles = np.maximum(np.asarray(faces[0].Get(self.context.time) or [], np.int64) - 2, 0).sum()
        size = len(times) * (3 * 24 * triangles + 4 * len(times))  # targets with normals, and weights
        changes = any(attribute.ValueMightBeTimeVarying() for attribute in faces)
        is_posed = binding.deforms() or any(part is not None for part in self.instances.pose(mesh.GetPrim()))
        if is_posed or len(counts) > 1 or changes or size > _LARGEST_MORPH:
            samples.add_unplayed(mesh.GetPointsAttr())
            return []
        return times

    def _add_changing(self, mesh: Any, times: Sequence[float]) -> None:
        """Adds a mesh with a morph target per sample after the first. Two neighbors are blended at a time."""
        points = [points_of(mesh, time) for time in times]
        moves = [later - points[0] for later in points[1:]]

        def of_corners(corners: Corners, kinds: Sequence[str]) -> dict[str, Any]:
            targets = [{"positions": move[corners.points]} for move in moves]
            if "normals" in kinds:
                normals = [corner_normals(self.context, mesh, corners, time) for time in times]
                for target, later in zip(targets, normals[1:]):
                    if later is not None and normals[0] is not None:
                        target["normals"] = later - normals[0]
            return {"targets": targets}

        parts = self.instances.deformed_parts(mesh.GetPrim(), None, None, of_corners)
        self._place(parts, mesh.GetPrim(), times, np.eye(len(times), dtype=np.float32)[:, 1:])

    # --- skeletons and blend shapes that are animated ---

    def _add_deforming(self, mesh: Any, binding: Binding) -> None:
        path = mesh.GetPath()
        arrays: dict[str, Any] = {}
        if binding.has_joints():
            count = count_points(mesh, self.context.time)
            arrays["joints"], arrays["joint_weights"] = self.skeletons.influences(binding, path, count)
            skin = self.skeletons.add_skin(binding, path)
        points, normals = None, None
        targets: list[dict[str, np.ndarray]] = []
        times, weights = [0.0], np.zeros((1, 0), np.float32)
        if binding.shapes_move():
            shapes = BlendShapes(self.context, binding, mesh)
            targets = shapes.targets()
            times, weights = shapes.weights()
        else:
            points, normals = blended_points(self.context, binding, mesh) or (None, None)

        def of_corners(corners: Corners, kinds: Sequence[str]) -> dict[str, Any]:
            own = {name: values[corners.points] for name, values in arrays.items()}
            moved = [{kind: target[kind][corners.points] for kind in kinds if kind in target} for target in targets]
            return {**own, "targets": moved, **({"skin": skin} if arrays else {})}

        parts = self.instances.deformed_parts(mesh.GetPrim(), points, normals, of_corners)
        self._place(parts, mesh.GetPrim(), times, weights, bool(arrays))

    def _place(
        self, parts: Parts, prim: Any, times: Sequence[float], weights: np.ndarray, has_joints: bool = False
    ) -> None:
        """Shows a mesh, whose morph targets have these weights over time. Joints move a mesh with a skin, its node does
        not."""
        if not parts:
            return
        if self.context.samples.moves(prim) and not has_joints:
            node = self.animation.node_of(prim, parts, weights[0])
        else:
            frame = np.eye(4) if has_joints else self.context.scene_from(prim)
            name = root_name(prim.GetPath())
            node = self.context.scene.add_node(name, matrix=frame, parts=parts, weights=weights[0])
            self.animation.add_visibility(node, prim)
        if weights.shape[1] > 0:
            self.animation.add_channel(node, "weights", times, weights)
