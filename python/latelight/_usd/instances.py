"""Instances: the meshes of prims, which all instances share, and where the scene shows them."""

from __future__ import annotations

from typing import Any

from .._core import MaterialHandle, MeshHandle
from .._model_builder import node_name
from .animation import Animation
from .context import Context, Parts
from .geometry import mesh_parts
from .materials import Materials
from .shapes import is_shape, shape_part


class Instances:
    def __init__(self, context: Context, animation: Animation, materials: Materials) -> None:
        self.context, self.animation, self.materials = context, animation, materials
        self.made: dict[Any, list[tuple[MeshHandle, MaterialHandle]]] = {}

    def is_shown(self, prim: Any) -> bool:
        """True for the types of prims that have parts."""
        return prim.IsA(self.context.pxr.UsdGeom.Mesh) or is_shape(prim)

    def parts_of(self, prim: Any) -> list[tuple[MeshHandle, MaterialHandle]]:
        """The meshes of a prim, which instances of it share."""
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        key = source.GetPath()
        if key not in self.made:
            if prim.IsA(self.context.pxr.UsdGeom.Mesh):
                self.made[key] = mesh_parts(self.context, self.materials, self.context.pxr.UsdGeom.Mesh(prim))
            else:
                self.made[key] = [shape_part(self.context, self.materials, prim)]
        return self.made[key]

    def add(self, prim: Any) -> None:
        self.place(self.parts_of(prim), prim, prim)

    def place(self, parts: Parts, prim: Any, frame: Any) -> None:
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
