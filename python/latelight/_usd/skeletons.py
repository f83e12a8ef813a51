"""Skeletons: the joints of meshes as nodes and skins of the scene, or the pose at a time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._core import SkinHandle
from .._model_builder import node_name
from ..errors import UsageError
from .animation import Animation
from .context import Context


class Binding(NamedTuple):
    """The queries of a mesh's skinning, of its skeleton and of the skeleton's animation; None for each without.

    prim: the skeleton's. Within a native instance, that of its query is in USD's prototype, which has no transform of
        an instance."""

    skinning: Any
    skeleton: Any
    animation: Any
    prim: Any

    def has_joints(self) -> bool:
        return bool(self.skinning and self.skinning.HasJointInfluences())

    def has_shapes(self) -> bool:
        return bool(self.skinning and self.skinning.HasBlendShapes())

    def joints_move(self) -> bool:
        return bool(self.has_joints() and self.animation and self.animation.JointTransformsMightBeTimeVarying())

    def shapes_move(self) -> bool:
        return bool(self.has_shapes() and self.animation and self.animation.BlendShapeWeightsMightBeTimeVarying())

    def deforms(self) -> bool:
        return self.joints_move() or self.shapes_move()


class Skeletons:
    def __init__(self, context: Context, animation: Animation) -> None:
        self.context, self.animation = context, animation
        self.cache = context.pxr.UsdSkel.Cache()
        self.joints: dict[Any, list[str]] = {}

    def add_root(self, prim: Any, predicate: Any = None) -> None:
        """Finds the skeletons below a UsdSkelRoot, before the meshes that they move."""
        self.cache.Populate(self.context.pxr.UsdSkel.Root(prim), predicate or self.context.predicate)

    def binding(self, prim: Any) -> Binding:
        skinning = self.cache.GetSkinningQuery(prim)
        skeleton = self.context.pxr.UsdSkel.BindingAPI(prim).GetInheritedSkeleton() if skinning else None
        query = self.cache.GetSkelQuery(skeleton) if skeleton else None
        animation = query.GetAnimQuery() if query else None
        owner = skeleton.GetPrim() if skeleton and query else None
        return Binding(skinning or None, query or None, animation or None, owner)

    # --- joints that move ---

    def add_skin(self, binding: Binding, path: Any) -> SkinHandle:
        """The joints of a mesh, in its order."""
        query, start = binding.skeleton, self.context.samples.start
        nodes, where = self._add_joints(binding), _joint_order(binding, path)
        binds = query.GetSkeleton().GetBindTransformsAttr().Get() or []
        if len(binds) != len(nodes):
            raise UsageError(f"{binding.prim.GetPath()} has {len(nodes)} joints but {len(binds)} bind transforms")
        geometry = np.array(binding.skinning.GetGeomBindTransform(start), np.float64).T
        inverse = np.linalg.inv(np.array(binds, np.float64).transpose(0, 2, 1)) @ geometry
        inverse[:, 3] = (0, 0, 0, 1)
        return self.context.scene.add_skin([nodes[i] for i in where], inverse[where])

    def _add_joints(self, binding: Binding) -> list[str]:
        """The nodes of the joints of a skeleton, below that of the skeleton."""
        query, prim, samples = binding.skeleton, binding.prim, self.context.samples
        if prim.GetPath() not in self.joints:
            topology, names = query.GetTopology(), query.GetJointOrder()
            base = self.animation.node_of(prim)
            nodes: list[Any] = []
            for i, name in enumerate(names):
                above = topology.GetParent(i)
                nodes.append({"name": node_name(str(name).rpartition("/")[2]), "parent": base if above < 0 else above})
            animation = query.GetAnimQuery()
            times = animation.GetJointTransformTimeSamples() if animation else []
            self.joints[prim.GetPath()] = self.animation.add_moving_nodes(
                nodes,
                samples.clipped([samples.start, *times]),
                lambda time: np.array(query.ComputeJointLocalTransforms(time), np.float64).transpose(0, 2, 1),
                prim.GetPath(),
            )
        return self.joints[prim.GetPath()]

    def influences(self, binding: Binding, path: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The joints of all points and their weights, (count, n) each."""
        indices, weights, per_point = self._influences(binding, np.float32)
        if len(indices) != len(weights) or len(indices) not in (per_point, count * per_point) or (indices < 0).any():
            raise UsageError(f"{path} has joint influences that do not match its points")
        shape = (count, per_point)
        indices = np.broadcast_to(indices.reshape(-1, per_point), shape)
        weights = np.array(np.broadcast_to(weights.reshape(-1, per_point), shape))
        weights[weights.sum(axis=1) <= 0, 0] = 1
        return indices, weights

    # --- joints at a time ---

    def has_pose(self, binding: Binding) -> bool:
        """True if a skeleton poses the mesh."""
        return bool(self._skinning_transforms(binding))

    def _skinning_transforms(self, binding: Binding) -> Any:
        if not binding.has_joints() or not binding.skeleton:
            return None
        return binding.skeleton.ComputeSkinningTransforms(self.context.time)

    def pose(self, binding: Binding, path: Any) -> np.ndarray | None:
        """For a mesh with a skeleton: transforms (points or 1, 4, 4), which move its points to the skeleton's space."""
        transforms = self._skinning_transforms(binding)
        if not transforms:
            return None
        joints = np.array(transforms, np.float64).transpose(0, 2, 1)[_joint_order(binding, path)]
        indices, weights, per_point = self._influences(binding, np.float64)
        matches = len(indices) == len(weights) and not len(indices) % per_point
        if not matches or indices.min() < 0 or indices.max() >= len(joints):
            raise UsageError(f"{path} has joint influences that do not match its skeleton")
        indices, weights = indices.reshape(-1, per_point), weights.reshape(-1, per_point)
        weights = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-30)
        bind = np.array(binding.skinning.GetGeomBindTransform(self.context.time), np.float64).T
        blended: np.ndarray = np.einsum("pk,pkij->pij", weights, joints[indices]) @ bind
        return blended

    def _influences(self, binding: Binding, precision: Any) -> tuple[np.ndarray, np.ndarray, int]:
        """The joints and weights of all points in one row, and their number per point."""
        skinning, time = binding.skinning, self.context.time
        indices = np.asarray(skinning.GetJointIndicesPrimvar().ComputeFlattened(time), np.int64)
        weights = np.asarray(skinning.GetJointWeightsPrimvar().ComputeFlattened(time), precision)
        return indices, weights, max(skinning.GetNumInfluencesPerComponent(), 1)


def _joint_order(binding: Binding, path: Any) -> list[int]:
    """The joints of a mesh as indices into those of its skeleton."""
    names, order = [str(name) for name in binding.skeleton.GetJointOrder()], binding.skinning.GetJointOrder()
    own = names if order is None else [str(name) for name in order]
    if not set(own) <= set(names):
        raise UsageError(f"{path} has joints that its skeleton does not have")
    return [names.index(name) for name in own]
