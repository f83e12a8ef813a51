"""Time samples: which values of a stage change, and when."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .readers import reader_of

UV_PRIMVARS = ("st", "UVMap", "st0")  # usual names of texture coordinates; the first one that a mesh has is read

# Attributes, by the type of their prim, that are read once, at the first time.
_READ_ONCE = {
    "Gprim": ("radius", "height", "size", "axis", "width", "length", "radiusTop", "radiusBottom", "orientation")
    + ("faceVertexCounts", "faceVertexIndices", "holeIndices"),
    "Camera": ("focalLength", "horizontalAperture", "verticalAperture", "horizontalApertureOffset", "projection")
    + ("verticalApertureOffset", "clippingRange"),
    "Subset": ("indices",),
}


class TimeSamples:
    """The samples of the prims that an animation may include: none if the stage is converted at one time.

    The animation covers the stage's range of time codes, or else all of its samples: `start` to `end`."""

    def __init__(self, stage: Any, pxr: Any, prims: Sequence[Any]) -> None:
        self.stage, self.pxr = stage, pxr
        self.animated: dict[Any, bool] = {}
        self.held = stage.GetInterpolationType() == pxr.Usd.InterpolationTypeHeld
        self.unplayed: list[str] = []  # paths of attributes and prims with samples that are read once
        readers = (reader_of(pxr, prim) for prim in prims)
        read = {"displayColor", "displayOpacity", *UV_PRIMVARS, *(reader.primvar for reader in readers if reader)}
        self.primvars = {f"primvars:{name}" for name in read}
        samples = sorted({time for prim in prims for time in self.of_prim(prim)})
        self.exist = len(samples) > 0
        samples = sorted({*samples, *(time for prim in prims for time in self.read_once(prim))})
        if stage.HasAuthoredTimeCodeRange():
            samples = [stage.GetStartTimeCode(), stage.GetEndTimeCode()]
        self.start, self.end = (samples[0], samples[-1]) if samples else (0.0, 0.0)

    def add_unplayed(self, changing: Any) -> None:
        """Notes an attribute or a prim whose samples the animation does not include."""
        self.unplayed.append(str(changing.GetPath()))

    def clipped(self, times: Sequence[float]) -> list[float]:
        """The times within the stage's range, and its ends if there are any outside."""
        return sorted({min(max(float(time), self.start), self.end) for time in times})

    def seconds(self, times: Sequence[float]) -> np.ndarray:
        return (np.asarray(times) - self.start) / self.stage.GetTimeCodesPerSecond()

    # --- times ---

    def of_prim(self, prim: Any) -> list[float]:
        """The times at which the prim's own transform, its visibility, its points as a mesh, its copies as an
        instancer, or its pose as an animation of a skeleton changes."""
        geom, skel = self.pxr.UsdGeom, self.pxr.UsdSkel
        times: list[float] = []
        if (form := geom.Xformable(prim)) and form.TransformMightBeTimeVarying():
            times += form.GetTimeSamples()
        if (seen := geom.Imageable(prim)) and seen.GetVisibilityAttr().ValueMightBeTimeVarying():
            times += seen.GetVisibilityAttr().GetTimeSamples()
        times += self.of_points(prim) + self.of_copies(prim)
        if pose := skel.Animation(prim):
            for attribute in (
                pose.GetTranslationsAttr(),
                pose.GetRotationsAttr(),
                pose.GetScalesAttr(),
                pose.GetBlendShapeWeightsAttr(),
            ):
                if attribute.ValueMightBeTimeVarying():
                    times += attribute.GetTimeSamples()
        return times

    def of_points(self, prim: Any) -> list[float]:
        """The times at which the points of a mesh change, or their normals."""
        mesh = self.pxr.UsdGeom.Mesh(prim)
        if not mesh:
            return []
        normals = self.pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals").GetAttr(), mesh.GetNormalsAttr()
        return _samples((mesh.GetPointsAttr(), *normals))

    def of_copies(self, prim: Any, fewest: int = 2) -> list[float]:
        """The times at which the transforms of the copies of an instancer change: those of attributes with that many
        samples."""
        copies = self.pxr.UsdGeom.PointInstancer(prim)
        if not copies:
            return []
        names = ("positions", "orientations", "orientationsf", "scales", "velocities", "angularVelocities")
        return sorted(_samples([prim.GetAttribute(name) for name in names], fewest))

    def of_visibility(self, prim: Any) -> list[float]:
        """The times at which the visibility of the prim or of a parent changes; none if it does not."""
        times: list[float] = []
        while self.exist and prim and not prim.IsPseudoRoot():
            seen = self.pxr.UsdGeom.Imageable(prim)
            if seen and seen.GetVisibilityAttr().ValueMightBeTimeVarying():
                times += seen.GetVisibilityAttr().GetTimeSamples()
            prim = prim.GetParent()
        return self.clipped([self.start, *times]) if times else []

    def read_once(self, prim: Any) -> list[float]:
        """The times of all other values that change. Their attributes are noted."""
        geom, shade = self.pxr.UsdGeom, self.pxr.UsdShade
        is_shading = prim.IsA(shade.Shader) or prim.IsA(shade.NodeGraph) or prim.HasAPI(self.pxr.UsdLux.LightAPI)
        names = {name for kind, read in _READ_ONCE.items() if prim.IsA(getattr(geom, kind)) for name in read}
        if prim.IsA(geom.Gprim) or prim.IsA(geom.PointInstancer):
            names |= self.primvars
        attributes = [
            attribute
            for attribute in prim.GetAuthoredAttributes()
            if (attribute.GetName() in names or (is_shading and attribute.GetName().startswith("inputs:")))
            and attribute.ValueMightBeTimeVarying()
        ]
        for attribute in attributes:
            self.add_unplayed(attribute)
        return _samples(attributes)

    # --- motion ---

    def moves(self, prim: Any) -> bool:
        """True if the transform of the prim or of a parent changes over time, or its visibility."""
        if not self.exist or not prim or prim.IsPseudoRoot():
            return False
        path = prim.GetPath()
        if path not in self.animated:
            geom = self.pxr.UsdGeom
            form, seen = geom.Xformable(prim), geom.Imageable(prim)
            self.animated[path] = bool(
                (form and form.TransformMightBeTimeVarying())
                or (seen and seen.GetVisibilityAttr().ValueMightBeTimeVarying())
                or (not (form and form.GetResetXformStack()) and self.moves(prim.GetParent()))
            )
        return self.animated[path]

    def moves_below(self, prim: Any, above: Any) -> bool:
        """True if the transform of the prim changes over time relative to one of its parents."""
        while prim != above:
            form = self.pxr.UsdGeom.Xformable(prim)
            if form and form.TransformMightBeTimeVarying():
                return True
            prim = prim.GetParent()
        return False


def _samples(attributes: Iterable[Any], fewest: int = 2) -> list[float]:
    return [time for a in attributes if a and a.GetNumTimeSamples() >= fewest for time in a.GetTimeSamples()]
