"""Point instancers: their copies, also of prototypes that contain instancers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .._model_builder import node_name
from ..errors import UsageError
from .animation import Animation
from .context import Context
from .instances import Instances, root_name
from .primvars import Copy, CopyPrimvars
from .skeletons import Skeletons
from .transforms import unsheared
from .traversal import visible_prims

# A prim of a prototype, its transform relative to the prototype's parent, and in which copies of instancers within the
# prototype it is shown, the innermost one first: those whose instancers have primvars per copy.
Part = tuple[Any, np.ndarray, tuple[Copy, ...]]

_MAX_PARTS = 2**20  # prims of a prototype, whose number is multiplied by each instancer below it


class Instancers:
    def __init__(
        self, context: Context, animation: Animation, instances: Instances, skeletons: Skeletons
    ) -> None:
        self.context, self.animation, self.instances, self.skeletons = context, animation, instances, skeletons
        self.prototypes: dict[Any, list[Part]] = {}  # what they show, by their paths
        self.unfolded: list[Any] = []  # paths of the instancers whose prototypes are being collected

    def add(self, prim: Any) -> None:
        """Shows the copies of an instancer, each of all prims of its prototype."""
        instancer = self.context.pxr.UsdGeom.PointInstancer(prim)
        numbers = self._numbers(instancer)
        copies = self._copies(instancer, numbers)
        if times := self._times(instancer, len(numbers)):
            above = self.animation.node_of(prim)
            nodes = [{"name": str(n), "parent": above} for n in numbers]

            def placed_at(time: float) -> np.ndarray:
                return unsheared(self._matrices(instancer, time))

            made = self.animation.add_moving_nodes(nodes, times, placed_at, prim.GetPath())
            node_of_copy = dict(zip(numbers, made))
            for n, _, part, local, within in copies:
                name, parts = node_name(part.GetName()), self.instances.parts_of(part, within)
                self.context.scene.add_node(name, node_of_copy[n], matrix=local, parts=parts)
        elif self.context.samples.moves(prim):
            above = self.animation.node_of(prim)
            for n, matrix, part, local, within in copies:
                parts = self.instances.parts_of(part, within)
                self.context.scene.add_node(str(n), above, matrix=matrix @ local, parts=parts)
        else:
            base = self.context.stage_from(prim)
            for n, matrix, part, local, within in copies:
                name = root_name(f"{prim.GetPath()}/{n}")
                for mesh, material in self.instances.parts_of(part, within):
                    self.context.builder.add_instance(mesh, material, base @ matrix @ local, name)

    # --- copies ---

    def _numbers(self, instancer: Any) -> list[int]:
        """Those of the copies that are not masked."""
        count = len(instancer.GetProtoIndicesAttr().Get(self.context.time) or [])
        mask = instancer.ComputeMaskAtTime(self.context.time)
        return [i for i in range(count) if not mask or mask[i]]

    def _copies(
        self, instancer: Any, numbers: Sequence[int]
    ) -> Iterator[tuple[int, np.ndarray, Any, np.ndarray, tuple[Copy, ...]]]:
        """The number and transform of each copy, relative to the instancer, with each prim that it shows, its transform
        relative to the copy, and the copies in which it is shown."""
        path = instancer.GetPath()
        indices = np.asarray(instancer.GetProtoIndicesAttr().Get(self.context.time) or [], np.int64)
        shown = indices[np.asarray(numbers, np.int64)]
        targets = instancer.GetPrototypesRel().GetTargets()
        if len(indices) and not 0 <= indices.min() <= indices.max() < len(targets):
            raise UsageError(f"{path} has copies of prototypes that it does not have: it has {len(targets)}")
        if path in self.unfolded:
            raise UsageError(f"{path} is an instancer within its own prototypes")
        self.unfolded.append(path)
        get_prim = self.context.stage.GetPrimAtPath
        parts = {index: self._parts_of_prototype(get_prim(targets[index])) for index in np.unique(shown)}
        self.unfolded.pop()
        primvars = CopyPrimvars(self.context, instancer, len(indices))
        for n, index, matrix in zip(numbers, shown, self._matrices(instancer, self.context.time)):
            copy = (Copy(primvars, n, targets[index]),) if primvars.primvars else ()
            for prim, local, within in parts[index]:
                yield n, matrix, prim, local, within + copy

    def _matrices(self, instancer: Any, time: Any) -> np.ndarray:
        """The transforms of the visible copies, (n, 4, 4), relative to the instancer."""
        usd = self.context.pxr.Usd
        code = usd.TimeCode(time)
        if code.IsEarliestTime():  # velocities lead from the sample to the time
            samples = self.context.samples.of_copies(instancer.GetPrim(), 1)
            code = usd.TimeCode(samples[0]) if samples else usd.TimeCode.Default()
        without = self.context.pxr.UsdGeom.PointInstancer.ExcludeProtoXform
        matrices = instancer.ComputeInstanceTransformsAtTime(code, code, without)
        return np.array(matrices, np.float64).reshape(-1, 4, 4).transpose(0, 2, 1)

    def _times(self, instancer: Any, count: int) -> list[float]:
        """The times of the samples of an instancer's transforms, if nodes can be its copies: the same ones at all
        times."""
        prim, samples = instancer.GetPrim(), self.context.samples
        times = samples.clipped(samples.of_copies(prim) if samples.exist else [])
        if len(times) < 2 or count == 0:
            return []
        which = (instancer.GetProtoIndicesAttr(), instancer.GetIdsAttr(), instancer.GetInvisibleIdsAttr())
        fixed = not any(attribute.ValueMightBeTimeVarying() for attribute in which)
        if not fixed or any(len(self._matrices(instancer, time)) != count for time in times):
            samples.add_unplayed(prim)
            return []
        return times

    # --- prototypes ---

    def _parts_of_prototype(self, prototype: Any) -> list[Part]:
        """The prims that a prototype shows."""
        if not prototype:  # a target that does not exist
            return []
        if prototype.GetPath() not in self.prototypes:
            parts: list[Part] = []
            for part in self._unfolded_parts(prototype):
                parts.append(part)
                if len(parts) > _MAX_PARTS:
                    raise UsageError(f"the instancers in {prototype.GetPath()} show more than {_MAX_PARTS} prims")
            self.prototypes[prototype.GetPath()] = parts
        return self.prototypes[prototype.GetPath()]

    def _unfolded_parts(self, prototype: Any) -> Iterator[Part]:
        geom, skel = self.context.pxr.UsdGeom, self.context.pxr.UsdSkel
        if root := skel.Root.Find(prototype):
            self.skeletons.add_root(root.GetPrim(), self.context.prototype_predicate)
        for prim in visible_prims(self.context, prototype):
            if prim.IsA(skel.Root):
                self.skeletons.add_root(prim, self.context.prototype_predicate)
            is_nested = prim.IsA(geom.PointInstancer)
            if not is_nested and not self.instances.is_shown(prim):
                continue
            frame = prim if is_nested else self.instances.frame_of(prim)
            self._warn_of_changes(prim, frame, prototype)
            local = self._relative(frame, prototype.GetParent())
            if not is_nested:
                yield prim, local, ()
                continue
            nested = geom.PointInstancer(prim)
            for _, matrix, part, own, within in self._copies(nested, self._numbers(nested)):
                yield part, local @ matrix @ own, within

    def _warn_of_changes(self, prim: Any, frame: Any, prototype: Any) -> None:
        """Notes a prim of a prototype that changes over time, since copies show it at rest."""
        samples, above = self.context.samples, prototype.GetParent()
        if samples.exist and (
            samples.of_points(prim)
            or samples.of_copies(prim)
            or self.skeletons.binding(prim).deforms()
            or any(samples.moves_below(moving, above) for moving in (prim, frame) if _is_below(moving, above))
        ):
            samples.add_unplayed(prim)

    def _relative(self, prim: Any, above: Any) -> np.ndarray:
        """The transform of a prim relative to another one, which is above it except for skeletons elsewhere."""
        if _is_below(prim, above):
            relative, _ = self.context.transforms.ComputeRelativeTransform(prim, above)
            return np.array(relative, np.float64).T
        elsewhere: np.ndarray = np.linalg.pinv(self.context.stage_from(above)) @ self.context.stage_from(prim)
        return elsewhere


def _is_below(prim: Any, above: Any) -> bool:
    return bool(prim.GetPath().HasPrefix(above.GetPath()))
