"""Instances: the meshes of prims, which all instances share, and where the scene shows them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._core import MaterialHandle, MeshHandle
from .._model_builder import node_name
from .animation import Animation
from .blend_shapes import blended_points
from .context import Context, Parts
from .geometry import mesh_parts
from .materials import Materials
from .shapes import is_shape, shape_part
from .skeletons import Binding, Skeletons


class Pose(NamedTuple):
    """How skeletons and blend shapes deform a mesh at the time of the stage at rest: transforms of its points to the
    space of its skeleton, and blended points and normals per point; None for each without."""

    joints: np.ndarray | None
    points: np.ndarray | None
    normals: np.ndarray | None


class Shown(NamedTuple):
    """The parts of a prim, and the prim in whose frame they are: its own, or its skeleton."""

    parts: list[tuple[MeshHandle, MaterialHandle]]
    frame: Any


class Instances:
    def __init__(self, context: Context, animation: Animation, materials: Materials, skeletons: Skeletons) -> None:
        self.context, self.animation, self.materials, self.skeletons = context, animation, materials, skeletons
        self.by_prim: dict[Any, Shown] = {}
        self.made: dict[Any, tuple[list[tuple[MeshHandle, MaterialHandle]], bool]] = {}

    def is_shown(self, prim: Any) -> bool:
        """True for the types of prims that have parts."""
        return prim.IsA(self.context.pxr.UsdGeom.Mesh) or is_shape(prim)

    def shown(self, prim: Any) -> Shown:
        """The parts of a prim at rest, which instances of it in the same pose share."""
        path = prim.GetPath()
        if path not in self.by_prim:
            mesh = self.context.pxr.UsdGeom.Mesh(prim)
            if mesh:
                binding = self.skeletons.binding(prim)
                posed_by = binding.prim, binding.animation.GetPrim() if binding.animation else None
                key = tuple(_source(source) for source in (prim, *posed_by))
                if key not in self.made:
                    pose = self.pose(mesh, binding)
                    parts = mesh_parts(self.context, self.materials, mesh, pose.points, pose.normals, pose.joints)
                    self.made[key] = parts, pose.joints is not None
                parts, is_posed = self.made[key]
                self.by_prim[path] = Shown(parts, binding.prim if is_posed else prim)
            else:
                key = (_source(prim),)
                if key not in self.made:
                    self.made[key] = [shape_part(self.context, self.materials, prim)], False
                self.by_prim[path] = Shown(self.made[key][0], prim)
        return self.by_prim[path]

    def pose(self, mesh: Any, binding: Binding) -> Pose:
        joints = self.skeletons.pose(binding, mesh.GetPath())
        return Pose(joints, *(blended_points(self.context, binding, mesh) or (None, None)))

    def add(self, prim: Any) -> None:
        parts, frame = self.shown(prim)
        self._place(parts, prim, frame)

    def _place(self, parts: Parts, prim: Any, frame: Any) -> None:
        """Shows what a prim consists of, in the frame of that prim or of its skeleton."""
        if self.context.samples.moves(frame):
            if frame == prim:
                self.animation.node_of(prim, parts)
            else:
                name, parent = node_name(prim.GetName()), self.animation.node_of(frame)
                self.context.scene.add_node(name, parent, parts=parts)
            return
        for mesh, material in parts:
            name, transform = root_name(prim.GetPath()), self.context.stage_from(frame)
            self.context.builder.add_instance(mesh, material, transform, name)


def root_name(path: Any) -> str:
    """The name of a root node that stands for a prim: with dots, because a path of the scene has slashes only between
    nodes."""
    return str(path)[1:].replace("/", ".")


def _source(prim: Any) -> Any:
    """The path that a prim shares with those of other native instances."""
    if not prim:
        return None
    return prim.GetPrimInPrototype().GetPath() if prim.IsInstanceProxy() else prim.GetPath()
