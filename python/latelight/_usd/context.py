"""The context of a conversion: the stage, the time at which it is read, and the scene under construction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._core import MaterialHandle, MeshHandle
from .._model_builder import Builder
from .files import Files
from .time_samples import TimeSamples

Parts = Sequence[tuple[MeshHandle, MaterialHandle]]  # what a prim consists of


def source_of(prim: Any) -> Any:
    """The path that a prim of a native instance shares with the same prim of other instances: that in the prototype of
    USD. For other prims, their own; None without a prim."""
    if not prim:
        return None
    return prim.GetPrimInPrototype().GetPath() if prim.IsInstanceProxy() else prim.GetPath()


class Context:
    """`pxr` holds the modules of usd-core.

    time: the code at which values are read. Without a given one the samples become an animation, and the stage at rest
        is as at its first time."""

    def __init__(self, stage: Any, pxr: Any, time: float | None, files: Files) -> None:
        geom = pxr.UsdGeom
        self.stage, self.pxr, self.files = stage, pxr, files
        self.predicate = pxr.Usd.TraverseInstanceProxies(pxr.Usd.PrimDefaultPredicate)
        # Prototypes of instancers may be undefined or abstract.
        self.prototype_predicate = pxr.Usd.TraverseInstanceProxies(pxr.Usd.PrimIsActive & pxr.Usd.PrimIsLoaded)
        self.samples = TimeSamples(stage, pxr, self._prims_with_samples() if time is None else ())
        if time is not None:
            self.time = pxr.Usd.TimeCode(time)
        elif self.samples.exist or self.samples.unplayed:
            self.time = pxr.Usd.TimeCode(self.samples.start)
        else:  # attributes may have a single sample, which is their value at all times, and no default
            self.time = pxr.Usd.TimeCode.EarliestTime()
        self.transforms = geom.XformCache(self.time)
        self.builder = Builder("z" if geom.GetStageUpAxis(stage) == geom.Tokens.z else "y")
        self.warnings: list[str] = []  # for the caller
        self.meters = float(geom.GetStageMetersPerUnit(stage))  # the length of the stage's unit
        self.builder.world = self.builder.world @ np.diag([self.meters, self.meters, self.meters, 1])
        self.scene, self.scene_from_stage = self.builder.scene, self.builder.world

    def warn(self, message: str) -> None:
        """Each message is issued once, after the conversion."""
        if message not in self.warnings:
            self.warnings.append(message)

    def stage_from(self, prim: Any) -> np.ndarray:
        """The transform of a prim to the stage."""
        return np.array(self.transforms.GetLocalToWorldTransform(prim), np.float64).T  # USD's vectors are rows

    def scene_from(self, prim: Any) -> np.ndarray:
        return self.scene_from_stage @ self.stage_from(prim)

    def _prims_with_samples(self) -> Sequence[Any]:
        """All prims, or none if no layer has samples, which is faster than a search in each prim."""
        if not any(layer.ListAllTimeSamples() for layer in self.stage.GetUsedLayers()):
            return ()
        return list(self.pxr.Usd.PrimRange(self.stage.GetPseudoRoot(), self.predicate))
