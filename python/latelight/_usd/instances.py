"""Instances: the meshes of prims, which all instances share, and where the scene shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .._core import MaterialHandle, MeshHandle
from .._model_builder import node_name
from .animation import Animation
from .blend_shapes import blended_points
from .context import Context, source_of
from .geometry import Deformation, add_meshes, subsets_of
from .materials import Look, Materials, Shading
from .primvars import Copy, Primvars
from .shapes import add_shape, is_shape
from .skeletons import Skeletons


class Pose(NamedTuple):
    """How skeletons and blend shapes deform a mesh at the time of the stage at rest: transforms of its points to the
    space of its skeleton, and blended points and normals per point; None for each without."""

    joints: np.ndarray | None
    points: np.ndarray | None
    normals: np.ndarray | None


class _Entry(NamedTuple):
    """A mesh or shape of the stage.

    materials: for each subset of its faces, and for the other faces
    read: the names of the primvars that the materials read
    geometry: the paths of the prims that determine its points, which instances in the same pose share
    frame: the prim in whose space its points are"""

    primvars: Primvars
    materials: list[Shading | None]
    read: set[str]
    double_sided: bool
    geometry: tuple[Any, ...]
    frame: Any


class Instances:
    def __init__(self, context: Context, animation: Animation, materials: Materials, skeletons: Skeletons) -> None:
        self.context, self.animation, self.materials, self.skeletons = context, animation, materials, skeletons
        self.entries: dict[Any, _Entry] = {}
        self.parts: dict[Any, list[tuple[MeshHandle, MaterialHandle]]] = {}
        self.meshes: dict[Any, list[MeshHandle | None]] = {}

    def is_shown(self, prim: Any) -> bool:
        """True for the types of prims that have parts."""
        return prim.IsA(self.context.pxr.UsdGeom.Mesh) or is_shape(prim)

    def parts_of(self, prim: Any, copies: Sequence[Copy] = ()) -> list[tuple[MeshHandle, MaterialHandle]]:
        """The parts of a prim at rest. Instances of it share the meshes, unless they differ in their pose or in the
        primvars of their vertices, and may have other materials.

        copies: in which copies of instancers it is shown"""
        entry = self._entry_of(prim)
        copies = [copy for copy in copies if not entry.read.isdisjoint(copy.primvars.primvars)]
        if copies:
            return self._parts(entry, entry.primvars.of_copy(copies))
        path = prim.GetPath()
        if path not in self.parts:
            self.parts[path] = self._parts(entry, entry.primvars)
        return self.parts[path]

    def frame_of(self, prim: Any) -> Any:
        """The prim in whose space its parts are: itself, or the skeleton that poses it."""
        return self._entry_of(prim).frame

    def deformed_parts(
        self, prim: Any, points: np.ndarray | None, normals: np.ndarray | None, deformation: Deformation
    ) -> list[tuple[MeshHandle, MaterialHandle]]:
        """The parts of a mesh that an animation deforms."""
        entry = self._entry_of(prim)
        looks = self._looks(entry, entry.primvars)
        sources = [look.vertices for look in looks]
        meshes = add_meshes(self.context, entry.primvars, sources, points, normals, deformation=deformation)
        return [(mesh, look.material) for mesh, look in zip(meshes, looks) if mesh is not None]

    def pose(self, prim: Any) -> Pose:
        """That of a mesh at rest."""
        mesh, binding = self.context.pxr.UsdGeom.Mesh(prim), self.skeletons.binding(prim)
        joints = self.skeletons.pose(binding, prim.GetPath())
        return Pose(joints, *(blended_points(self.context, binding, mesh) or (None, None)))

    def _entry_of(self, prim: Any) -> _Entry:
        path = prim.GetPath()
        if path not in self.entries:
            primvars, materials = Primvars(self.context, prim), [self.materials.bound(prim)]
            geometry: tuple[Any, ...] = (source_of(prim),)
            frame = prim
            if prim.IsA(self.context.pxr.UsdGeom.Mesh):
                materials = [*map(self.materials.bound, subsets_of(self.context, prim)), *materials]
                binding = self.skeletons.binding(prim)
                geometry += source_of(binding.prim), binding.animation and source_of(binding.animation.GetPrim())
                frame = binding.prim if self.skeletons.has_pose(binding) else prim
            read = {name for material in materials for name in self.materials.primvars_read(material)}
            double_sided = self.materials.is_double_sided(prim)
            self.entries[path] = _Entry(primvars, materials, read, double_sided, geometry, frame)
        return self.entries[path]

    def _looks(self, entry: _Entry, primvars: Primvars) -> list[Look]:
        return [self.materials.look(material, primvars, entry.double_sided) for material in entry.materials]

    def _parts(self, entry: _Entry, primvars: Primvars) -> list[tuple[MeshHandle, MaterialHandle]]:
        looks = self._looks(entry, primvars)
        sources = tuple(look.vertices for look in looks)
        key = (entry.geometry, sources)
        if key not in self.meshes:
            prim = primvars.prim
            if is_shape(prim):
                self.meshes[key] = [add_shape(self.context, prim)]
            else:
                pose = self.pose(prim)
                self.meshes[key] = add_meshes(self.context, primvars, sources, pose.points, pose.normals, pose.joints)
        return [(mesh, look.material) for mesh, look in zip(self.meshes[key], looks) if mesh is not None]

    def add(self, prim: Any) -> None:
        """Shows a prim, in its own frame or in that of its skeleton."""
        parts, frame = self.parts_of(prim), self.frame_of(prim)
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
