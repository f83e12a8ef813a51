"""Scenes from USD stages, by usd-core."""

from __future__ import annotations

import importlib
import io
import math
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ._core import Material, MaterialHandle, MeshHandle, Scene, read_environment
from ._enclosure import Enclosure
from ._model_builder import Builder, linear, missing, node_name, reading, v_down
from ._shapes import Shape, box, capsule, cone, cylinder, ellipsoid, mesh_arrays, plane, tapered_capsule
from ._usd_animation import Motion, Parts, axes_of, joint_order, unsheared
from ._usd_lights import color_of, light_of, radiance_of
from .errors import UsageError


Result = TypeVar("Result")

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


_MAX_PARTS = 2**20  # prims of a prototype, whose number is multiplied by each instancer below it
_LARGEST_MORPH = 2**31  # bytes of the morph targets of a mesh, which small files can make large


class Corners(NamedTuple):
    """Corners of triangles, as indices of values per corner, point and face of their mesh."""

    flat: np.ndarray
    points: np.ndarray
    faces: np.ndarray

    def some(self, chosen: np.ndarray) -> Corners:
        return Corners(*(values[chosen] for values in self))


class ImageUse(NamedTuple):
    """The image that an input is connected to: no path if there is none."""

    path: str = ""
    output: str = ""  # the channel, or "rgb"
    scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)  # of red, green, blue and alpha

    def channel(self) -> int:
        return {"g": 1, "b": 2, "a": 3}.get(self.output, 0)


class _Usd(Builder):
    """Walks a stage. `pxr` holds its modules."""

    def __init__(self, stage: Any, pxr: Any, time: float | None, enclosure: Enclosure | None) -> None:
        geom = pxr.UsdGeom
        super().__init__("z" if geom.GetStageUpAxis(stage) == geom.Tokens.z else "y")
        self.stage, self.pxr, self.enclosure = stage, pxr, enclosure
        self.domes: list[Any] = []
        self.plays = time is None  # otherwise the stage is converted as it is at that time
        # Attributes may have a single sample, which is their value at all times, and no default.
        self.time = pxr.Usd.TimeCode.EarliestTime() if time is None else pxr.Usd.TimeCode(time)
        scale = float(geom.GetStageMetersPerUnit(stage))
        self.world = self.world @ np.diag([scale, scale, scale, 1])
        self.scale = scale
        self.cache = geom.XformCache(self.time)
        self.made: dict[Any, list[tuple[MeshHandle, MaterialHandle]]] = {}
        self.images: dict[str, Any] = {}
        self.prototypes: dict[Any, list[tuple[Any, np.ndarray]]] = {}  # what they show, by their paths
        self.unfolded: list[Any] = []  # paths of the instancers whose prototypes are being collected
        self.skins = pxr.UsdSkel.Cache()
        self.predicate = pxr.Usd.TraverseInstanceProxies(pxr.Usd.PrimDefaultPredicate)
        self.motion = Motion(stage, pxr, self.scene, self.world, ())

    def transform(self, prim: Any) -> np.ndarray:
        return np.array(self.cache.GetLocalToWorldTransform(prim), np.float64).T  # USD's vectors are rows

    def visible(self, prototype: Any = None) -> Iterator[Any]:
        """The prims of the stage, or of a prototype of an instancer, that are shown at some time and meant for
        rendering. Prims below an instancer are left out.

        A prototype may be undefined or abstract, and inherits no visibility and no purpose from the prims that contain
        it, as in UsdImaging, since these often hide it outside of instancers."""
        geom, usd = self.pxr.UsdGeom, self.pxr.Usd
        loaded = usd.TraverseInstanceProxies(usd.PrimIsActive & usd.PrimIsLoaded)
        top, predicate = (prototype, loaded) if prototype else (self.stage.GetPseudoRoot(), self.predicate)
        walk = iter(usd.PrimRange(top, predicate))
        purposes: dict[Any, Any] = {}
        for prim in walk:
            imageable = geom.Imageable(prim)
            if imageable and not (self.is_visible_itself(imageable) if prototype else self.is_visible_at_all(prim)):
                walk.PruneChildren()
                continue
            if prim.IsA(geom.PointInstancer):
                walk.PruneChildren()
            above = purposes.get(prim.GetPath().GetParentPath(), geom.Imageable.PurposeInfo())
            purposes[prim.GetPath()] = imageable.ComputePurposeInfo(above) if imageable else above
            # Prims below may have a purpose of their own, and the skeletons of a root move them.
            for_rendering = purposes[prim.GetPath()].purpose not in (geom.Tokens.guide, geom.Tokens.proxy)
            if for_rendering or prim.IsA(self.pxr.UsdSkel.Root):
                yield prim

    def is_visible_at_all(self, prim: Any) -> bool:
        return any(self.motion.is_visible(prim, time) for time in self.motion.visibility_times(prim) or [self.time])

    def is_visible_itself(self, imageable: Any) -> bool:
        """True if an imageable prim does not hide itself and what is below it."""
        attribute = imageable.GetVisibilityAttr()
        if self.motion.exists and attribute.ValueMightBeTimeVarying():
            self.motion.unplayed.append(str(attribute.GetPath()))
        return bool(attribute.Get(self.time) != self.pxr.UsdGeom.Tokens.invisible)

    def animate(self) -> None:
        """Finds what changes over time. The stage at rest is then as at its first time."""
        if not any(layer.ListAllTimeSamples() for layer in self.stage.GetUsedLayers()):
            return
        prims = list(self.pxr.Usd.PrimRange(self.stage.GetPseudoRoot(), self.predicate))
        self.motion = Motion(self.stage, self.pxr, self.scene, self.world, prims)
        if self.motion.exists or self.motion.unplayed:
            self.time = self.pxr.Usd.TimeCode(self.motion.start)
            self.cache = self.pxr.UsdGeom.XformCache(self.time)

    def run(self) -> Scene:
        geom, lux = self.pxr.UsdGeom, self.pxr.UsdLux
        if self.plays:
            self.animate()
        instancers: list[Any] = []
        for prim in self.visible():
            if prim.IsA(geom.PointInstancer):
                instancers.append(geom.PointInstancer(prim))
            elif prim.IsA(geom.Mesh):
                self.add_mesh(prim)
            elif prim.GetTypeName() in _SHAPES:
                self.show(prim)
            elif prim.IsA(self.pxr.UsdSkel.Root):
                self.skins.Populate(self.pxr.UsdSkel.Root(prim), self.predicate)
            elif prim.IsA(geom.Camera):
                self.add_camera(geom.Camera(prim), prim)
            elif prim.HasAPI(lux.LightAPI):
                self.add_light(prim)
        for instancer in instancers:
            self.add_instancer(instancer)
        if self.domes:
            self.scene.set_environment(self.environment())
        self.motion.finish()
        return self.scene

    def add_mesh(self, prim: Any) -> None:
        mesh = self.pxr.UsdGeom.Mesh(prim)
        deforms = self.deforms(prim)
        skin, shapes = (None, None) if deforms else (self.skin_of(prim), self.blended(mesh, prim))
        times = self.times_of_points(mesh, prim, not deforms and skin is None and shapes is None)
        if deforms:
            self.add_deforming(mesh, prim)
            return
        if times:
            self.add_changing(mesh, prim, times)
            return
        if skin is None and shapes is None:
            self.show(prim)
            return
        pose, frame = skin or (None, prim)
        self.place(self.meshes(mesh, prim, pose, shapes or (None, None)), prim, frame)

    def place(self, parts: Parts, prim: Any, frame: Any) -> None:
        """Shows what a prim consists of, in the frame of that prim or of its skeleton."""
        if self.motion.moves(frame):
            if frame == prim:
                self.motion.node_of(prim, parts)
            else:
                self.scene.add_node(node_name(prim.GetName()), self.motion.node_of(frame), parts=parts)
            return
        for mesh, material in parts:
            self.add_instance(mesh, material, self.transform(frame), _dotted(prim.GetPath()))

    # --- points that change over time ---

    def times_of_points(self, mesh: Any, prim: Any, is_plain: bool) -> list[float]:
        """The times of the samples of a mesh's points and normals, if morph targets can be these samples: there are as
        many points at all times, no skeleton moves them, the faces stay, and the targets are not too large."""
        times = self.motion.clipped(self.motion.samples_of_points(prim) if self.motion.exists else [])
        if len(times) < 2:
            return []
        counts = {len(mesh.GetPointsAttr().Get(time) or []) for time in times}
        faces = (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
        triangles = np.maximum(np.asarray(faces[0].Get(self.time) or [], np.int64) - 2, 0).sum()
        size = len(times) * (3 * 24 * triangles + 4 * len(times))  # targets with normals, and weights
        changes = any(attribute.ValueMightBeTimeVarying() for attribute in faces)
        if not is_plain or len(counts) > 1 or changes or size > _LARGEST_MORPH:
            self.motion.unplayed.append(str(mesh.GetPointsAttr().GetPath()))
            return []
        return times

    def add_changing(self, mesh: Any, prim: Any, times: Sequence[float]) -> None:
        """Adds a mesh with a morph target per sample after the first. Two neighbors are blended at a time."""
        points = [np.asarray(mesh.GetPointsAttr().Get(time), np.float32).reshape(-1, 3) for time in times]
        moves = [later - points[0] for later in points[1:]]

        def of_corners(corners: Corners, kinds: Sequence[str]) -> dict[str, Any]:
            targets = [{"positions": move[corners.points]} for move in moves]
            if "normals" in kinds:
                normals = [self.normals_of_corners(mesh, prim, corners, time) for time in times]
                for target, later in zip(targets, normals[1:]):
                    if later is not None and normals[0] is not None:
                        target["normals"] = later - normals[0]
            return {"targets": targets}

        parts = self.meshes(mesh, prim, None, (None, None), of_corners)
        self.place_deforming(parts, prim, times, np.eye(len(times), dtype=np.float32)[:, 1:])

    # --- skeletons and blend shapes ---

    def binding(self, prim: Any) -> tuple[Any, Any, Any]:
        """The queries of a mesh's skinning, of its skeleton and of the skeleton's animation; None for each without."""
        skinning = self.skins.GetSkinningQuery(prim)
        skeleton = self.pxr.UsdSkel.BindingAPI(prim).GetInheritedSkeleton() if skinning else None
        query = self.skins.GetSkelQuery(skeleton) if skeleton else None
        animation = query.GetAnimQuery() if query else None
        return skinning or None, query or None, animation or None

    def deforms(self, prim: Any) -> bool:
        """True if a mesh is animated by its skeleton or by blend shapes."""
        skinning, _, animation = self.binding(prim)
        return bool(
            self.motion.exists
            and animation
            and (
                (skinning.HasJointInfluences() and animation.JointTransformsMightBeTimeVarying())
                or (skinning.HasBlendShapes() and animation.BlendShapeWeightsMightBeTimeVarying())
            )
        )

    def add_deforming(self, mesh: Any, prim: Any) -> None:
        skinning, query, animation = self.binding(prim)
        count = len(mesh.GetPointsAttr().Get(self.time) or [])
        arrays: dict[str, Any] = {}
        if skinning.HasJointInfluences():
            arrays["joints"], arrays["joint_weights"] = self.influences(skinning, prim, count)
            skin = self.motion.add_skin(skinning, query, prim.GetPath())
        still: tuple[Any, Any] | None = None
        targets: list[dict[str, np.ndarray]] = []
        times, weights = [0.0], np.zeros((1, 0), np.float32)
        if skinning.HasBlendShapes() and animation.BlendShapeWeightsMightBeTimeVarying():
            shapes = self.pxr.UsdSkel.BlendShapeQuery(self.pxr.UsdSkel.BindingAPI(prim))
            targets = [self.target(shapes, part, count, mesh, prim) for part in range(shapes.GetNumSubShapes())]
            times, weights = self.motion.weights_of(animation, skinning.GetBlendShapeMapper(), shapes)
        else:
            still = self.blended(mesh, prim)

        def of_corners(corners: Corners, kinds: Sequence[str]) -> dict[str, Any]:
            own = {name: values[corners.points] for name, values in arrays.items()}
            moved = [{kind: target[kind][corners.points] for kind in kinds if kind in target} for target in targets]
            return {**own, "targets": moved, **({"skin": skin} if arrays else {})}

        parts = self.meshes(mesh, prim, None, still or (None, None), of_corners)
        self.place_deforming(parts, prim, times, weights, bool(arrays))

    def place_deforming(
        self, parts: Parts, prim: Any, times: Sequence[float], weights: np.ndarray, has_joints: bool = False
    ) -> None:
        """Shows a mesh, whose morph targets have these weights over time. Joints move a mesh with a skin, its node does
        not."""
        if not parts:
            return
        if self.motion.moves(prim) and not has_joints:
            node = self.motion.node_of(prim, parts, weights[0])
        else:
            frame = np.eye(4) if has_joints else self.world @ self.transform(prim)
            node = self.scene.add_node(_dotted(prim.GetPath()), matrix=frame, parts=parts, weights=weights[0])
            self.motion.show(node, prim)
        if weights.shape[1] > 0:
            self.motion.add_channel(node, "weights", times, weights)

    def target(self, shapes: Any, part: int, count: int, mesh: Any, prim: Any) -> dict[str, np.ndarray]:
        """The offsets of all points, and of normals per point, by a blend shape or one of its in-betweens."""
        blend, between = shapes.GetBlendShape(shapes.GetBlendShapeIndex(part)), shapes.GetInbetween(part)
        made = {}
        for name, offsets in (("positions", _offsets(blend, between)), ("normals", _normal_offsets(blend, between))):
            if name == "normals" and mesh.GetNormalsInterpolation() not in ("vertex", "varying"):
                continue
            if offsets is not None and len(offsets) > 0:
                made[name] = np.zeros((count, 3), np.float32)
                _add_offsets(made[name], _points_of(blend), np.asarray(offsets, np.float32), prim.GetPath())
        return made

    def influences(self, skinning: Any, prim: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The joints of all points and their weights, (count, n) each."""
        indices = np.asarray(skinning.GetJointIndicesPrimvar().ComputeFlattened(self.time), np.int64)
        weights = np.asarray(skinning.GetJointWeightsPrimvar().ComputeFlattened(self.time), np.float32)
        per_point = max(skinning.GetNumInfluencesPerComponent(), 1)
        if len(indices) != len(weights) or len(indices) not in (per_point, count * per_point) or (indices < 0).any():
            raise UsageError(f"{prim.GetPath()} has joint influences that do not match its points")
        shape = (count, per_point)
        indices = np.broadcast_to(indices.reshape(-1, per_point), shape)
        weights = np.array(np.broadcast_to(weights.reshape(-1, per_point), shape))
        weights[weights.sum(axis=1) <= 0, 0] = 1
        return indices, weights

    def blended(self, mesh: Any, prim: Any) -> tuple[Any, Any] | None:
        """The points and the normals per point of a mesh with blend shapes, by the weights of its skeleton's animation.
        In-between shapes are interpolated as UsdSkel defines it."""
        skel = self.pxr.UsdSkel
        skinning, _, animation = self.binding(prim)
        weights = animation.ComputeBlendShapeWeights(self.time) if animation else None
        if not skinning or not skinning.HasBlendShapes() or not weights:
            return None
        mapper = skinning.GetBlendShapeMapper()
        shapes = skel.BlendShapeQuery(skel.BindingAPI(prim))
        own = mapper.Remap(weights) if mapper else weights
        parts = shapes.ComputeSubShapeWeights(own)
        points = np.array(mesh.GetPointsAttr().Get(self.time), np.float32).reshape(-1, 3)
        normals = None
        if mesh.GetNormalsInterpolation() in ("vertex", "varying") and mesh.GetNormalsAttr().Get(self.time):
            normals = np.array(mesh.GetNormalsAttr().Get(self.time), np.float32).reshape(-1, 3)
        for weight, shape, part in zip(*parts):
            blend, between = shapes.GetBlendShape(shape), shapes.GetInbetween(part)
            for values, offsets in ((points, _offsets(blend, between)), (normals, _normal_offsets(blend, between))):
                if values is not None and offsets is not None and len(offsets) > 0:
                    _add_offsets(values, _points_of(blend), weight * np.asarray(offsets, np.float32), prim.GetPath())
        if normals is not None:
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        return points, normals

    def skin_of(self, prim: Any) -> tuple[np.ndarray, Any] | None:
        """For a mesh with a skeleton: transforms (points or 1, 4, 4), which move its points to the skeleton's space,
        and the skeleton."""
        skinning, query, _ = self.binding(prim)
        if not skinning or not skinning.HasJointInfluences():
            return None
        transforms = query.ComputeSkinningTransforms(self.time) if query else None
        if not transforms:
            return None
        joints = np.array(transforms, np.float64).transpose(0, 2, 1)[joint_order(skinning, query, prim.GetPath())]
        indices = np.asarray(skinning.GetJointIndicesPrimvar().ComputeFlattened(self.time), np.int64)
        weights = np.asarray(skinning.GetJointWeightsPrimvar().ComputeFlattened(self.time), np.float64)
        per_point = max(skinning.GetNumInfluencesPerComponent(), 1)
        if len(indices) != len(weights) or len(indices) % per_point or indices.min() < 0 or indices.max() >= len(joints):
            raise UsageError(f"{prim.GetPath()} has joint influences that do not match its skeleton")
        indices, weights = indices.reshape(-1, per_point), weights.reshape(-1, per_point)
        weights = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-30)
        bind = np.array(skinning.GetGeomBindTransform(self.time), np.float64).T
        blended: np.ndarray = np.einsum("pk,pkij->pij", weights, joints[indices]) @ bind
        return blended, query.GetPrim()

    def show(self, prim: Any) -> None:
        self.place(self.parts_of(prim), prim, prim)

    def parts_of(self, prim: Any) -> list[tuple[MeshHandle, MaterialHandle]]:
        """The meshes of a prim, which instances of it share."""
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        key = source.GetPath()
        if key not in self.made:
            if prim.IsA(self.pxr.UsdGeom.Mesh):
                self.made[key] = self.meshes(self.pxr.UsdGeom.Mesh(prim), prim)
            else:
                self.made[key] = [self.shape(prim)]
        return self.made[key]

    def add_instancer(self, instancer: Any) -> None:
        """Shows the copies of an instancer, each of all prims of its prototype."""
        prim = instancer.GetPrim()
        numbers = self.numbers_of_copies(instancer)
        copies = self.copies_of(instancer, numbers)
        if times := self.times_of_copies(instancer, len(numbers)):
            above = self.motion.node_of(prim)
            nodes = [{"name": str(n), "parent": above} for n in numbers]

            def placed_at(time: float) -> np.ndarray:
                return unsheared(self.copies_at(instancer, time))

            made = self.motion.moving_nodes(nodes, times, placed_at, prim.GetPath())
            node_of_copy = dict(zip(numbers, made))
            for n, _, part, local in copies:
                name = node_name(part.GetName())
                self.scene.add_node(name, node_of_copy[n], matrix=local, parts=self.parts_of(part))
        elif self.motion.moves(prim):
            above = self.motion.node_of(prim)
            for n, matrix, part, local in copies:
                self.scene.add_node(str(n), above, matrix=matrix @ local, parts=self.parts_of(part))
        else:
            base = self.transform(prim)
            for n, matrix, part, local in copies:
                for mesh, material in self.parts_of(part):
                    self.add_instance(mesh, material, base @ matrix @ local, _dotted(f"{prim.GetPath()}/{n}"))

    def numbers_of_copies(self, instancer: Any) -> list[int]:
        """Those of the copies that are not masked."""
        count = len(instancer.GetProtoIndicesAttr().Get(self.time) or [])
        mask = instancer.ComputeMaskAtTime(self.time)
        return [i for i in range(count) if not mask or mask[i]]

    def copies_of(self, instancer: Any, numbers: Sequence[int]) -> Iterator[tuple[int, np.ndarray, Any, np.ndarray]]:
        """The number and transform of each copy, relative to the instancer, with each prim that it shows and its
        transform relative to the copy."""
        path = instancer.GetPath()
        indices = np.asarray(instancer.GetProtoIndicesAttr().Get(self.time) or [], np.int64)
        targets = instancer.GetPrototypesRel().GetTargets()
        if len(indices) and not 0 <= indices.min() <= indices.max() < len(targets):
            raise UsageError(f"{path} has copies of prototypes that it does not have: it has {len(targets)}")
        if path in self.unfolded:
            raise UsageError(f"{path} is an instancer within its own prototypes")
        self.unfolded.append(path)
        shown = [self.parts_of_prototype(self.stage.GetPrimAtPath(target)) for target in targets]
        self.unfolded.pop()
        for n, matrix in zip(numbers, self.copies_at(instancer, self.time)):
            for prim, local in shown[indices[n]]:
                yield n, matrix, prim, local

    def copies_at(self, instancer: Any, time: Any) -> np.ndarray:
        """The transforms of the visible copies, (n, 4, 4), relative to the instancer."""
        code = self.pxr.Usd.TimeCode(time)
        if code.IsEarliestTime():  # velocities lead from the sample to the time
            samples = self.motion.samples_of_copies(instancer.GetPrim(), 1)
            code = self.pxr.Usd.TimeCode(samples[0]) if samples else self.pxr.Usd.TimeCode.Default()
        without = self.pxr.UsdGeom.PointInstancer.ExcludeProtoXform
        matrices = instancer.ComputeInstanceTransformsAtTime(code, code, without)
        return np.array(matrices, np.float64).reshape(-1, 4, 4).transpose(0, 2, 1)

    def parts_of_prototype(self, prototype: Any) -> list[tuple[Any, np.ndarray]]:
        """The prims that a prototype shows, with their transforms relative to its parent."""
        if not prototype:  # a target that does not exist
            return []
        if prototype.GetPath() not in self.prototypes:
            parts: list[tuple[Any, np.ndarray]] = []
            for part in self.unfolded_parts(prototype):
                parts.append(part)
                if len(parts) > _MAX_PARTS:
                    raise UsageError(f"the instancers in {prototype.GetPath()} show more than {_MAX_PARTS} prims")
            self.prototypes[prototype.GetPath()] = parts
        return self.prototypes[prototype.GetPath()]

    def unfolded_parts(self, prototype: Any) -> Iterator[tuple[Any, np.ndarray]]:
        geom = self.pxr.UsdGeom
        for prim in self.visible(prototype):
            is_nested = prim.IsA(geom.PointInstancer)
            if not is_nested and not prim.IsA(geom.Mesh) and prim.GetTypeName() not in _SHAPES:
                continue
            if self.motion.exists and (
                self.motion.samples_of_points(prim)
                or self.motion.samples_of_copies(prim)
                or self.motion.moves_below(prim, prototype.GetParent())
            ):
                self.motion.unplayed.append(str(prim.GetPath()))
            relative, _ = self.cache.ComputeRelativeTransform(prim, prototype.GetParent())
            local = np.array(relative, np.float64).T
            if not is_nested:
                yield prim, local
                continue
            nested = geom.PointInstancer(prim)
            for _, matrix, part, own in self.copies_of(nested, self.numbers_of_copies(nested)):
                yield part, local @ matrix @ own

    def times_of_copies(self, instancer: Any, count: int) -> list[float]:
        """The times of the samples of an instancer's transforms, if nodes can be its copies: the same ones at all
        times."""
        prim = instancer.GetPrim()
        times = self.motion.clipped(self.motion.samples_of_copies(prim) if self.motion.exists else [])
        if len(times) < 2 or count == 0:
            return []
        which = (instancer.GetProtoIndicesAttr(), instancer.GetIdsAttr(), instancer.GetInvisibleIdsAttr())
        fixed = not any(attribute.ValueMightBeTimeVarying() for attribute in which)
        if not fixed or any(len(self.copies_at(instancer, time)) != count for time in times):
            self.motion.unplayed.append(str(prim.GetPath()))
            return []
        return times

    # --- geometry ---

    def shape(self, prim: Any) -> tuple[MeshHandle, MaterialHandle]:
        def size(name: str) -> float:
            value = float(prim.GetAttribute(name).Get(self.time))
            if not 0 <= value < math.inf or (value == 0 and name in ("radius", "size", "width", "length")):
                raise UsageError(f"{prim.GetPath()} has the {name} {value:g}, but it must be positive")
            return value

        given = prim.GetAttribute("axis")
        axis = str(given.Get(self.time)) if given else "Z"
        points, normals, triangles = _SHAPES[prim.GetTypeName()](size, axis)
        turned = _TURNED[axis]
        arrays = mesh_arrays((points[:, turned], normals[:, turned], triangles))
        material = self.material_of(self.pxr.UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0], prim)
        color = self.pxr.UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
        if material is None and color and color.HasValue() and color.GetInterpolation() == "constant":
            rgb = np.clip(np.asarray(color.ComputeFlattened(self.time), np.float32)[:1], 0, 1)
            arrays["colors"] = np.tile([*rgb[0], 1], (len(points), 1)).astype(np.float32)
            material = self.white(False, self.is_double_sided(prim))
        mesh = self.scene.add_mesh(**arrays, name=prim.GetName())
        return mesh, material if material is not None else self.default_material(self.is_double_sided(prim))

    def is_double_sided(self, prim: Any) -> bool:
        return bool(self.pxr.UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self.time))

    def meshes(
        self,
        mesh: Any,
        prim: Any,
        pose: np.ndarray | None = None,
        shapes: tuple[Any, Any] = (None, None),
        deformation: Callable[[Corners, Sequence[str]], dict[str, Any]] | None = None,
    ) -> list[tuple[MeshHandle, MaterialHandle]]:
        """One mesh per material. Corners share no vertices, because values may belong to faces and corners.

        pose: transforms of all points, or one for all of them
        shapes: points and normals per point in place of those of the mesh
        deformation: arguments of Scene.add_mesh() for vertices that are these corners, whose targets may have these
            arrays"""
        points, blended_normals = shapes
        if points is None:
            points = np.asarray(mesh.GetPointsAttr().Get(self.time), np.float32).reshape(-1, 3)
        every = self.corners_of(mesh, prim, len(points))
        if len(every.flat) == 0:
            return []
        normals = self.normals_of_corners(mesh, prim, every, self.time)
        if blended_normals is not None and len(blended_normals) == len(points):
            normals = blended_normals[every.points]
        if pose is not None:
            if len(pose) not in (1, len(points)):
                raise UsageError(f"{prim.GetPath()} has joint influences that do not match its points")
            pose = np.broadcast_to(pose, (len(points), 4, 4))
            points = (np.einsum("pij,pj->pi", pose[:, :3, :3], points) + pose[:, :3, 3]).astype(np.float32)
            if normals is not None:
                turn = np.linalg.pinv(pose[:, :3, :3]).transpose(0, 2, 1)
                normals = np.einsum("pij,pj->pi", turn[every.points], normals).astype(np.float32)
        uv = next(
            (
                v
                for v in (self.primvar(prim, n, None, "", every, 2, self.time) for n in ("st", "UVMap", "st0"))
                if v is not None
            ),
            None,
        )
        colors = self.primvar(prim, "displayColor", None, "", every, 3, self.time)
        kinds = ("positions",) if normals is None else ("positions", "normals")
        made = []
        for material, triangles in self.subsets(prim, every.faces[::3]):
            chosen = np.repeat(triangles, 3)
            handle = self.material_of(material, prim)
            rgba = None
            if handle is None and colors is not None:  # displayColor is linear, and the material of unbound meshes
                rgba = np.concatenate([np.clip(colors[chosen], 0, 1), np.ones((chosen.sum(), 1), np.float32)], axis=1)
                handle = self.white(False, self.is_double_sided(prim))
            made.append(
                (
                    self.scene.add_mesh(
                        points[every.points][chosen],
                        normals=None if normals is None else normals[chosen],
                        uv=None if uv is None else v_down(uv[chosen]),
                        colors=rgba,
                        name=prim.GetName(),
                        **(deformation(every.some(chosen), kinds) if deformation else {}),
                    ),
                    handle if handle is not None else self.default_material(self.is_double_sided(prim)),
                )
            )
        return made

    def corners_of(self, mesh: Any, prim: Any, count: int) -> Corners:
        """The corners of all triangles of a mesh with that many points, without those of its holes."""
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get(self.time) or [], np.int64)
        indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(self.time) or [], np.int64)
        holes = np.asarray(mesh.GetHoleIndicesAttr().Get(self.time) or [], np.int64)
        if count == 0 or len(counts) == 0:
            return Corners(*np.zeros((3, 0), np.int64))
        if (counts < 0).any():
            raise UsageError(f"{prim.GetPath()} has a face with {counts.min()} corners")
        if counts.sum() != len(indices) or (indices < 0).any() or (indices >= count).any():
            raise UsageError(f"{prim.GetPath()} has faces that refer to points it does not have")
        first = np.concatenate([[0], np.cumsum(counts)[:-1]])
        corners, faces = _fans(first, counts)  # corners of triangles, and the face of each triangle
        shown = ~np.isin(faces, holes)
        corners, faces = corners[shown], faces[shown]
        if mesh.GetOrientationAttr().Get(self.time) == self.pxr.UsdGeom.Tokens.leftHanded:
            corners = corners[:, ::-1]
        flat = corners.ravel()
        return Corners(flat, indices[flat], np.repeat(faces, 3))

    def normals_of_corners(self, mesh: Any, prim: Any, corners: Corners, time: Any) -> np.ndarray | None:
        attribute, interpolation = mesh.GetNormalsAttr(), mesh.GetNormalsInterpolation()
        return self.primvar(prim, "normals", attribute, interpolation, corners, 3, time)

    def primvar(
        self, prim: Any, name: str, attribute: Any, interpolation: str, corners: Corners, width: int, time: Any
    ) -> np.ndarray | None:
        """The values of a primvar, or of the attribute of the same meaning, per corner of the triangles."""
        source = self.pxr.UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        if source and source.HasValue():
            values, interpolation = source.ComputeFlattened(time), source.GetInterpolation()
        else:
            values = attribute.Get(time) if attribute else None
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

    def subsets(self, prim: Any, faces: np.ndarray) -> list[tuple[Any, np.ndarray]]:
        """The material of each subset of faces, and which triangles it has."""
        shade, geom = self.pxr.UsdShade, self.pxr.UsdGeom
        rest = np.ones(len(faces), bool)
        parts = []
        for subset in shade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
            chosen = (
                np.isin(faces, np.asarray(geom.Subset(subset).GetIndicesAttr().Get(self.time) or [], np.int64)) & rest
            )
            rest &= ~chosen
            if chosen.any():
                parts.append((shade.MaterialBindingAPI(subset).ComputeBoundMaterial()[0], chosen))
        if rest.any():
            parts.append((shade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0], rest))
        return parts

    # --- materials ---

    def material_of(self, material: Any, prim: Any) -> MaterialHandle | None:
        """The material of a mesh or shape, which says whether it has two sides."""
        if not material:
            return None
        double_sided = self.is_double_sided(prim)
        key = (str(material.GetPath()), double_sided)
        if key not in self.materials:
            handle = self.convert(material)
            if handle is None:
                return self.default_material(double_sided)
            if double_sided:
                values = self.scene.material(handle)
                values.double_sided = True
                self.scene.set_material(handle, values)
            self.materials[key] = handle
        return self.materials[key]

    def convert(self, material: Any) -> MaterialHandle | None:
        for context in ("", "mtlx"):  # the universal one first
            surface = material.ComputeSurfaceSource(context)[0]
            name = surface.GetShaderId() if surface else ""
            if name in ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader"):
                return self.preview_surface(material, surface)
            if name == "ND_standard_surface_surfaceshader":
                return self.standard_surface(material, surface)
        return None

    def value(self, surface: Any, name: str, otherwise: Any) -> Any:
        """A constant, also one that a node graph passes on; `otherwise` if it is missing or an image."""
        given = surface.GetInput(name)
        if not given:
            return otherwise
        if self.image_of(surface, name).path:
            return otherwise
        sources = self.pxr.UsdShade.Utils.GetValueProducingAttributes(given)
        result = sources[0].Get(self.time) if sources else None
        return otherwise if result is None else result

    def number(self, surface: Any, name: str, otherwise: float) -> float:
        return min(max(float(self.value(surface, name, otherwise)), 0), 1)

    def color(self, surface: Any, name: str, otherwise: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple(max(float(c), 0) for c in self.value(surface, name, otherwise))

    def factor(self, surface: Any, name: str, otherwise: float) -> float:
        """A number in [0, 1], or the scale of the image that is connected in its place."""
        use = self.image_of(surface, name)
        return min(max(use.scale[use.channel()], 0), 1) if use.path else self.number(surface, name, otherwise)

    def tint(self, surface: Any, name: str, otherwise: tuple[float, float, float]) -> tuple[float, ...]:
        """A color, or the scale of the image that is connected in its place."""
        use = self.image_of(surface, name)
        return tuple(max(c, 0) for c in use.scale[:3]) if use.path else self.color(surface, name, otherwise)

    def preview_surface(self, material: Any, surface: Any) -> MaterialHandle:
        diffuse, emissive = self.image(surface, "diffuseColor"), self.image(surface, "emissiveColor")
        normal, mask = self.image(surface, "normal"), self.channel(surface, "opacity")
        rough, metal = self.channel(surface, "roughness"), self.channel(surface, "metallic")
        opacity, threshold = self.factor(surface, "opacity", 1), self.number(surface, "opacityThreshold", 0)
        base = self.tint(surface, "diffuseColor", (0.18, 0.18, 0.18))
        handle = self.scene.add_material(
            Material(
                name=material.GetPrim().GetName(),
                base_color=(*(min(c, 1) for c in base), opacity),
                metallic=self.factor(surface, "metallic", 0),
                roughness=self.factor(surface, "roughness", 0.5),
                emissive=self.tint(surface, "emissiveColor", (0, 0, 0)),
                clearcoat=self.number(surface, "clearcoat", 0),
                clearcoat_roughness=self.number(surface, "clearcoatRoughness", 0.01),
                f0=_f0(float(self.value(surface, "ior", 1.5))),
                alpha_mode="mask" if threshold > 0 else "blend" if opacity < 1 or mask is not None else "opaque",
                alpha_cutoff=threshold if threshold > 0 else 0.5,
            )
        )
        self.add_texture(handle, "base_color", _with_alpha(diffuse, mask), True)
        self.add_texture(handle, "emissive", emissive, True)
        self.add_texture(handle, "normal", normal, False)
        self.add_texture(handle, "metallic_roughness", _packed(rough, metal), False)
        self.add_texture(handle, "occlusion", _packed_red(self.channel(surface, "occlusion")), False)
        return handle

    def standard_surface(self, material: Any, surface: Any) -> MaterialHandle:
        """Autodesk Standard Surface 1.0.1 (Georgiev et al. 2019) as far as glTF's model has its layers."""
        image, emissive = self.image(surface, "base_color"), self.image(surface, "emission_color")
        rough, metal = self.channel(surface, "specular_roughness"), self.channel(surface, "metalness")
        base, emission = self.number(surface, "base", 1), float(self.value(surface, "emission", 0))
        color = self.tint(surface, "base_color", (0.8, 0.8, 0.8))
        glow = self.tint(surface, "emission_color", (1, 1, 1))
        transmission, sheen = self.number(surface, "transmission", 0), self.number(surface, "sheen", 0)
        if transmission > 0 and image is None:  # what passes is tinted by transmission_color in place of base_color
            tint = self.color(surface, "transmission_color", (1, 1, 1))
            color = tuple((1 - transmission) * c + transmission * t for c, t in zip(color, tint))
        opacity = min(sum(self.color(surface, "opacity", (1, 1, 1))) / 3, 1)
        handle = self.scene.add_material(
            Material(
                name=material.GetPrim().GetName(),
                base_color=(*(min(base * c, 1) for c in color), opacity),
                metallic=self.factor(surface, "metalness", 0),
                roughness=self.factor(surface, "specular_roughness", 0.2),
                specular=self.number(surface, "specular", 1),
                specular_color=self.color(surface, "specular_color", (1, 1, 1)),
                f0=_f0(float(self.value(surface, "specular_IOR", 1.5))),
                anisotropy=self.number(surface, "specular_anisotropy", 0),
                emissive=tuple(emission * c for c in glow),
                clearcoat=self.number(surface, "coat", 0),
                clearcoat_roughness=self.number(surface, "coat_roughness", 0.1),
                sheen_color=tuple(sheen * min(c, 1) for c in self.color(surface, "sheen_color", (1, 1, 1))),
                sheen_roughness=self.number(surface, "sheen_roughness", 0.3),
                transmission=transmission,
                alpha_mode="blend" if opacity < 1 else "opaque",
            )
        )
        self.add_texture(handle, "base_color", image, True)
        self.add_texture(handle, "emissive", emissive, True)
        self.add_texture(handle, "normal", self.image(surface, "normal"), False)
        self.add_texture(handle, "metallic_roughness", _packed(rough, metal), False)
        return handle

    def image_of(self, surface: Any, name: str) -> ImageUse:
        """The image file that an input is connected to, also through a node graph."""
        given = surface.GetInput(name)
        shade = self.pxr.UsdShade
        for source in shade.Utils.GetValueProducingAttributes(given) if given else []:
            texture = shade.Shader(source.GetPrim())
            if texture and texture.GetShaderId() == "ND_normalmap" and texture.GetInput("in"):
                return self.image_of(texture, "in")
            file = texture.GetInput("file").Get(self.time) if texture and texture.GetInput("file") else None
            path = file.resolvedPath if file else ""
            path = self.allowed(path)
            if path and (self.pxr.Ar.IsPackageRelativePath(path) or os.path.isfile(path)):
                return ImageUse(path, source.GetName().removeprefix("outputs:"), self.scale_of(texture))
        return ImageUse()

    def scale_of(self, texture: Any) -> tuple[float, ...]:
        """The scale of an image. With a bias, as normal maps have one, glTF's factors cannot express it."""
        scale, bias = texture.GetInput("scale"), texture.GetInput("bias")
        if "UsdUVTexture" not in (texture.GetShaderId() or "") or not scale or (bias and any(bias.Get(self.time) or ())):
            return ImageUse().scale
        return tuple(float(c) for c in scale.Get(self.time) or ImageUse().scale)

    def channel(self, surface: Any, name: str) -> np.ndarray | None:
        """One channel of the image that a scalar input is connected to."""
        image = self.image(surface, name)
        if image is None:
            return None
        return np.asarray(image.convert("RGBA"))[..., self.image_of(surface, name).channel()]

    def image(self, surface: Any, name: str) -> Any:
        """The image that an input is connected to, as pixels."""
        path = self.image_of(surface, name).path
        if not path:
            return None
        if path not in self.images:
            self.images[path] = self.open_image(path)
        return self.images[path]

    def allowed(self, path: str) -> str:
        """Checks a file that the stage refers to, or the archive that it is in. Returns its path."""
        if not path or not self.enclosure:
            return path
        if self.pxr.Ar.IsPackageRelativePath(path):
            _check_file(self.pxr, path, self.enclosure)
            return path
        return self.enclosure.check(path)

    def open_image(self, path: str) -> Any:
        try:
            pil = importlib.import_module("PIL.Image")
        except ImportError:
            raise missing("pillow", "from_usd") from None
        packaged = self.pxr.Ar.IsPackageRelativePath(path)
        image = pil.open(io.BytesIO(_packaged(self.pxr, path)) if packaged else path)
        if image.mode.startswith("I"):  # 16 bits, which Pillow would clip to 8 bits
            image = pil.fromarray((np.clip(np.asarray(image), 0, 65535) // 257).astype(np.uint8))
        return image

    def read_radiance(self, path: str) -> np.ndarray:
        """The pixels of a .hdr or .exr file."""
        if not self.pxr.Ar.IsPackageRelativePath(path):
            return read_environment(path)
        with tempfile.TemporaryDirectory() as folder:
            copy = os.path.join(folder, f"environment{_extension(path)}")
            with open(copy, "wb") as file:
                file.write(_packaged(self.pxr, path))
            return read_environment(copy)

    # --- lights ---

    def add_light(self, prim: Any) -> None:
        lux = self.pxr.UsdLux
        if prim.IsA(lux.DomeLight) or prim.IsA(lux.DomeLight_1):
            self.domes.append(prim)
            if self.motion.moves(prim):  # the scene's environment stays
                self.motion.unplayed.append(str(prim.GetPath()))
            return
        transform, moves = self.world @ self.transform(prim), self.motion.moves(prim)
        if moves:  # a light that is flat at first may grow, and then emits as one that is not scaled
            (axes,), (scales,) = axes_of(transform[None])
            transform[:3, :3] = axes * np.where(scales == 0, self.scale, scales)
        light = light_of(prim, self.pxr, self.time, transform, self.scale)
        if light is not None:
            self.scene.add_light(light, self.motion.node_of(prim) if moves else None)

    # --- dome lights ---

    def environment(self) -> np.ndarray:
        """The radiance of all dome lights, in the frame of the scene's environments."""
        images = [self.dome_image(dome) for dome in self.domes]
        height = max(32, max(image.shape[0] for image in images))
        directions = _directions(height)
        total = np.zeros((height, 2 * height, 3), np.float32)
        for dome, image in zip(self.domes, images):
            api = self.pxr.UsdLux.LightAPI(dome)
            rotations, scales = axes_of((self.world @ self.transform(dome))[None])
            axes = rotations[0] * np.where(scales[0] < 0, -1, 1)
            pole = dome.GetAttribute("poleAxis").Get() if dome.IsA(self.pxr.UsdLux.DomeLight_1) else "Y"
            up = self.pxr.UsdGeom.GetStageUpAxis(self.stage) if pole == "scene" else pole
            if up == "Z":  # the texture's pole, which is +Y, is turned about X
                axes = axes @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
            color = radiance_of(api, self.time) * color_of(api, self.pxr, self.time)
            total += color.astype(np.float32) * _sampled(image, directions @ axes)
        return total

    def dome_image(self, dome: Any) -> np.ndarray:
        """The texture of a dome light as linear radiance; white without one."""
        lux = self.pxr.UsdLux
        light = lux.DomeLight_1(dome) if dome.IsA(lux.DomeLight_1) else lux.DomeLight(dome)
        if light.GetTextureFormatAttr().Get(self.time) not in ("automatic", "latlong"):
            raise UsageError(f"{dome.GetPath()} has a texture that is not latlong, the only format that is converted")
        file = light.GetTextureFileAttr().Get(self.time)
        path = file.resolvedPath if file else ""
        if file and file.path and not path:
            raise UsageError(f"{dome.GetPath()} has the texture {file.path}, which does not exist")
        if not path:
            return np.ones((1, 2, 3), np.float32)
        path = self.allowed(path)
        if _extension(path) in (".hdr", ".exr"):
            return self.read_radiance(path)
        return linear(np.asarray(self.open_image(path).convert("RGB")) / 255)

    # --- cameras ---

    def exposures(self) -> list[float]:
        if self.plays:
            self.animate()  # cameras that appear later belong to the scene, too
        cameras = [self.pxr.UsdGeom.Camera(prim) for prim in self.visible() if prim.IsA(self.pxr.UsdGeom.Camera)]
        scales = [float(camera.ComputeLinearExposureScale(self.time)) for camera in cameras]
        return [math.log2(scale) if scale > 0 else -math.inf for scale in scales]

    def add_camera(self, camera: Any, prim: Any) -> None:
        gf = camera.GetCamera(self.time)
        is_orthographic = gf.projection == self.pxr.Gf.Camera.Orthographic
        if gf.verticalAperture <= 0 or (gf.focalLength <= 0 and not is_orthographic):
            name = "verticalAperture" if gf.verticalAperture <= 0 else "focalLength"
            raise UsageError(f"{prim.GetPath()} has the {name} {getattr(gf, name):g}, but it must be positive")
        pose = _camera_pose(self.world @ self.transform(prim))
        made = self.scene.look_at(pose[:3, 3], pose[:3, 3] + pose[:3, 2])
        made.camera_to_world, made.name = pose, prim.GetName()
        if is_orthographic:
            made.orthographic = True
            made.half_height = gf.verticalAperture * self.pxr.Gf.Camera.APERTURE_UNIT / 2 * self.scale
            made.near_clip, made.far_clip = gf.clippingRange.min * self.scale, gf.clippingRange.max * self.scale
        else:
            made.vertical_fov = float(gf.GetFieldOfView(self.pxr.Gf.Camera.FOVVertical))
        # An offset moves what the camera sees, and the center of the projection moves the other way in the image.
        if gf.horizontalAperture > 0:
            made.principal_x = -2 * gf.horizontalApertureOffset / gf.horizontalAperture
        made.principal_y = -2 * gf.verticalApertureOffset / gf.verticalAperture
        self.scene.add_camera(made, self.motion.node_of(prim) if self.motion.moves(prim) else None)


def _camera_pose(transform: np.ndarray) -> np.ndarray:
    """The pose of OpenCV's camera, which has Y down and Z forward, by USD's, which has Y up and -Z forward. Scale,
    mirroring and shear do not change the image, as in GfFrustum; a sheared camera keeps its direction."""
    rotation = axes_of(transform[None])[0][0]
    back = rotation[:, 2]
    right = np.cross(rotation[:, 1], back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.stack([right, -np.cross(back, right), -back], axis=1), transform[:3, 3]
    return pose


def _dotted(path: Any) -> str:
    """The name of a root node that stands for a prim: with dots, because a path of the scene has slashes only between
    nodes."""
    return str(path)[1:].replace("/", ".")


def _offsets(blend: Any, between: Any) -> Any:
    return between.GetOffsets() if between else blend.GetOffsetsAttr().Get()


def _normal_offsets(blend: Any, between: Any) -> Any:
    return between.GetNormalOffsets() if between else blend.GetNormalOffsetsAttr().Get()


def _points_of(blend: Any) -> Any:
    """The points that a blend shape moves, as an index of arrays."""
    at = blend.GetPointIndicesAttr().Get()
    return slice(None) if at is None or len(at) == 0 else np.asarray(at, np.int64)


def _add_offsets(values: np.ndarray, where: Any, offsets: np.ndarray, path: Any) -> None:
    """Adds the offsets of a blend shape to points or normals in place."""
    count = len(values) if isinstance(where, slice) else len(where)
    outside = not isinstance(where, slice) and (where.min() < 0 or where.max() >= len(values))
    if len(offsets) != count or outside:
        raise UsageError(f"{path} has a blend shape that does not match its points")
    if isinstance(where, slice):
        values += offsets
    else:
        np.add.at(values, where, offsets)


def _directions(height: int) -> np.ndarray:
    """The directions (H, 2 H, 3) of the pixels of an environment in the glTF frame: the center column is at +X, columns
    grow toward +Z, and the top row is +Y."""
    longitude = (np.arange(2 * height) + 0.5) / (2 * height) * 2 * np.pi - np.pi
    latitude = np.pi / 2 - (np.arange(height) + 0.5) / height * np.pi
    y, x = np.meshgrid(latitude, longitude, indexing="ij")
    return np.stack([np.cos(y) * np.cos(x), np.sin(y), np.cos(y) * np.sin(x)], axis=-1)


def _sampled(image: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Bilinear samples of a latlong image as UsdLux defines it by OpenEXR's convention: the center is +Z, columns grow
    toward -X, and the top row is +Y."""
    height, width = image.shape[:2]
    u = 0.5 - np.arctan2(directions[..., 0], directions[..., 2]) / (2 * np.pi)
    v = np.arccos(np.clip(directions[..., 1], -1, 1)) / np.pi
    x, y = u * width - 0.5, np.clip(v * height - 0.5, 0, height - 1)
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    right, low = (x - column)[..., None], (y - row)[..., None]
    below = np.minimum(row + 1, height - 1)

    def between(row: np.ndarray) -> np.ndarray:
        return image[row, column % width] * (1 - right) + image[row, (column + 1) % width] * right

    return np.asarray(between(row) * (1 - low) + between(below) * low, np.float32)


def _check_layers(pxr: Any, root: str, enclosure: Enclosure) -> None:
    """Checks the layers that a stage would read, before any of them is composed."""
    pending, known = [root], set()
    stronger: dict[str, Any] = {}  # the root's variables, which those of other layers do not replace
    while pending:
        layer = pxr.Sdf.Layer.FindOrOpen(pending.pop())
        if not layer:
            continue
        stronger = stronger or dict(layer.expressionVariables)
        variables = {**layer.expressionVariables, **stronger}
        for asset in (*layer.GetCompositionAssetDependencies(), *_clip_files(layer)):
            if pxr.Sdf.VariableExpression.IsExpression(asset):
                asset = pxr.Sdf.VariableExpression(asset).Evaluate(variables).value
            path = layer.ComputeAbsolutePath(asset) if asset else ""
            if not path or path in known:
                continue
            known.add(path)
            _check_file(pxr, path, enclosure)
            pending.append(path)


def _check_file(pxr: Any, path: str, enclosure: Enclosure) -> None:
    """Checks a file that a layer refers to; for one in an archive, the archive."""
    packaged = pxr.Ar.IsPackageRelativePath(path)
    enclosure.check(pxr.Ar.SplitPackageRelativePathOuter(path)[0] if packaged else path)


def _packaged(pxr: Any, path: str) -> bytes:
    """The contents of a file in a .usdz archive, or in one within it. Their files are not compressed."""
    source: Any
    source, rest = pxr.Ar.SplitPackageRelativePathOuter(path)
    while rest:
        name, rest = pxr.Ar.SplitPackageRelativePathOuter(rest)
        with zipfile.ZipFile(source) as archive:
            if archive.getinfo(name).compress_type != zipfile.ZIP_STORED:
                raise UsageError(f"{path} is compressed, which USD's archives do not support")
            contents = archive.read(name)
        source = io.BytesIO(contents)
    return contents


def _extension(path: str) -> str:
    """Also of a file in an archive, as in model.usdz[textures/sky.hdr]."""
    return os.path.splitext(path.rstrip("]"))[1].lower()


def _opened(pxr: Any, path: str, enclosure: Enclosure) -> Any:
    """A stage all of whose layers may be read. Those found only by composition are checked after it."""
    _check_layers(pxr, path, enclosure)
    stage = pxr.Usd.Stage.Open(path)
    for layer in stage.GetUsedLayers():
        if layer.realPath:
            _check_file(pxr, layer.realPath, enclosure)
    return stage


def _clip_files(layer: Any) -> list[str]:
    """The files of the value clips that the prims of a layer name; patterns of numbered files have the sign #."""
    files: list[str] = []

    def visit(path: Any) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if not prim or not prim.HasInfo("clips"):
            return
        for clips in prim.GetInfo("clips").values():
            assets = [*clips.get("assetPaths", ()), clips.get("manifestAssetPath"), clips.get("templateAssetPath")]
            files.extend(str(getattr(asset, "path", asset)) for asset in assets if asset)

    layer.Traverse("/", visit)
    return files


def _f0(ior: float) -> float:
    return ((ior - 1) / (ior + 1)) ** 2


def _sized(channel: np.ndarray, like: np.ndarray) -> np.ndarray:
    """The nearest values at the size of another channel."""
    rows = np.arange(like.shape[0]) * channel.shape[0] // like.shape[0]
    columns = np.arange(like.shape[1]) * channel.shape[1] // like.shape[1]
    return channel[rows[:, None], columns]


def _packed(rough: np.ndarray | None, metal: np.ndarray | None) -> np.ndarray | None:
    """glTF's texture: roughness is green, metalness blue; a channel without an image is left to its factor."""
    if rough is None and metal is None:
        return None
    like = max((c for c in (rough, metal) if c is not None), key=lambda c: c.size)
    white = np.full_like(like, 255)
    sized = [white if c is None else _sized(c, like) for c in (rough, metal)]
    return np.stack([white, *sized], axis=-1)


def _packed_red(channel: np.ndarray | None) -> np.ndarray | None:
    return None if channel is None else np.repeat(channel[..., None], 3, axis=-1)


def _with_alpha(image: Any, mask: np.ndarray | None) -> Any:
    """A color image with the opacity of another one; white if there is no color image."""
    if mask is None:
        return image
    if image is None:
        return np.concatenate([np.full((*mask.shape, 3), 255, np.uint8), mask[..., None]], axis=-1)
    pixels = np.asarray(image.convert("RGB"))
    return np.concatenate([pixels, _sized(mask, pixels)[..., None]], axis=-1)


def _fans(first: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the triangles of polygons, as fans, and the polygon of each triangle."""
    triangles = np.maximum(counts - 2, 0)
    faces = np.repeat(np.arange(len(counts)), triangles)
    step = np.arange(len(faces)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    begin = first[faces]
    return np.stack([begin, begin + step + 1, begin + step + 2], axis=1), faces


def _converted(
    stage: Any,
    time: float | None,
    allow_outside: Sequence[str | os.PathLike[str]],
    function: str,
    convert: Callable[[_Usd], Result],
) -> Result:
    """Opens a stage and calls `convert` with it. `function`: the name of the public function."""
    try:
        pxr = importlib.import_module("pxr")
        for name in ("Ar", "Gf", "Sdf", "Usd", "UsdGeom", "UsdLux", "UsdShade", "UsdSkel"):
            importlib.import_module(f"pxr.{name}")
    except ImportError:
        raise missing("usd-core", function) from None
    if isinstance(stage, (str, os.PathLike)):
        if not os.path.isfile(stage):
            raise UsageError(f"{os.fspath(stage)} does not exist: give a .usd, .usda, .usdc or .usdz file")
    with reading(stage, "usd-core"):
        if not isinstance(stage, (str, os.PathLike)):
            return convert(_Usd(stage, pxr, time, None))
        enclosure = Enclosure(stage, allow_outside)
        return convert(_Usd(_opened(pxr, os.fspath(stage), enclosure), pxr, time, enclosure))


def from_usd(
    stage: Any, *, time: float | None = None, allow_outside: Sequence[str | os.PathLike[str]] = ()
) -> Scene:
    """Converts a Usd.Stage, or the path of a .usd, .usda, .usdc or .usdz file, with usd-core.

    time: the time code at which values are read. Default: time samples become an animation, "stage", which the option
        `time` plays in seconds from the stage's first time code; values that it does not include are those of that time
        code, and a warning names them
    allow_outside: folders that a file may refer to, besides its own

    Converted are visible meshes with their subsets, holes, normals, texture coordinates (st) and displayColor;
    skeletons and blend shapes with in-betweens; spheres, cubes, cones, planes, and cylinders and capsules with one or
    two radii; instances and point instancers; UsdPreviewSurface and MaterialX's standard surface with their images;
    distant, sphere, rect, disk and cylinder lights, with color temperatures, and spheres with a cone as spot lights;
    dome lights, as the scene's environment; perspective, orthographic and shifted cameras; and the stage's units, up
    axis and chosen variants. Animated are transforms, skeletons, weights of blend shapes, points and normals, copies of
    instancers, and visibility. Subdivision surfaces are shown as their cages, and polygons as fans. Curves, points,
    volumes, procedural textures and other shaders are left out."""
    return _converted(stage, time, allow_outside, "from_usd", _Usd.run)


def usd_exposures(
    stage: Any, *, time: float | None = None, allow_outside: Sequence[str | os.PathLike[str]] = ()
) -> list[float]:
    """The exposures of the cameras of from_usd(stage), in their order, in stops for the option `exposure`.

    They follow from the attribute `exposure` of a UsdGeomCamera and from its sensitivity, f-stop, exposure time and
    responsivity: log2(time iso / (100 fStop^2) responsivity) + exposure. The arguments are those of from_usd."""
    return _converted(stage, time, allow_outside, "usd_exposures", _Usd.exposures)
