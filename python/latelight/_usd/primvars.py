"""The primvars of prims, including those that they inherit, and those per copy of an instancer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .context import Context

_PER_COPY = ("varying", "vertex", "faceVarying")  # interpolations of an instancer's primvars with a value per copy


class Values(NamedTuple):
    """The values of a primvar, (n, width), of which a constant one has one."""

    array: np.ndarray
    interpolation: str


class CopyPrimvars:
    """The primvars of an instancer that have a value per copy."""

    def __init__(self, context: Context, instancer: Any, count: int) -> None:
        self.context, self.count = context, count
        found = context.pxr.UsdGeom.PrimvarsAPI(instancer).GetPrimvarsWithValues()
        self.primvars = {p.GetPrimvarName(): p for p in found if p.GetInterpolation() in _PER_COPY}
        self.arrays: dict[str, np.ndarray | None] = {}

    def array(self, name: str) -> np.ndarray | None:
        """The values of all copies, (count, width); None if there is no such primvar, or too few values."""
        if name not in self.arrays:
            array = _numbers(self.primvars[name], self.context.time) if name in self.primvars else None
            self.arrays[name] = array if array is not None and len(array) >= self.count else None
        return self.arrays[name]


class Copy(NamedTuple):
    """A copy of an instancer, by its number, and the path of its prototype."""

    primvars: CopyPrimvars
    number: int
    prototype: Any


class Primvars:
    """The primvars of a mesh or shape. Shapes have constant ones only.

    copies: in which copies of instancers it is shown, the innermost one first. Their values replace those that the
        prototype inherits from prims above it, as a prim's own primvars replace inherited ones."""

    def __init__(self, context: Context, prim: Any, copies: Sequence[Copy] = ()) -> None:
        self.context, self.prim, self.copies = context, prim, copies
        self.own: dict[str, tuple[Values | None, Any]] = {}  # with the path of the primvar's attribute

    def of_copy(self, copies: Sequence[Copy]) -> Primvars:
        other = Primvars(self.context, self.prim, copies)
        other.own = self.own
        return other

    def find(self, name: str) -> Values | None:
        if name not in self.own:
            self.own[name] = self._find_own(name)
        own, path = self.own[name]
        for copies, number, prototype in self.copies:
            if own and path.HasPrefix(prototype):
                break
            array = copies.array(name)
            if array is not None:
                return Values(array[number : number + 1], "constant")
        return own

    def varies(self, name: str) -> bool:
        """True if the primvar exists and differs over the mesh."""
        found = self.find(name)
        return found is not None and found.interpolation != "constant"

    def constant(self, name: str) -> tuple[float, ...] | None:
        """The value of a constant primvar; None if there is none."""
        found = self.find(name)
        return tuple(found.array[0].tolist()) if found and found.interpolation == "constant" else None

    def _find_own(self, name: str) -> tuple[Values | None, Any]:
        primvar = self.context.pxr.UsdGeom.PrimvarsAPI(self.prim).FindPrimvarWithInheritance(name)
        array = _numbers(primvar, self.context.time) if primvar and primvar.HasValue() else None
        if array is None:
            return None, None
        interpolation = str(primvar.GetInterpolation())
        if interpolation == "constant":
            return Values(array[:1], interpolation), primvar.GetAttr().GetPath()
        if len(array) < self._count(interpolation):
            return None, None
        return Values(array, interpolation), primvar.GetAttr().GetPath()

    def _count(self, interpolation: str) -> float:
        """The number of values that a primvar of a mesh requires."""
        mesh = self.context.pxr.UsdGeom.Mesh(self.prim)
        if not mesh:
            return np.inf
        attribute = {"uniform": mesh.GetFaceVertexCountsAttr(), "faceVarying": mesh.GetFaceVertexIndicesAttr()}
        return len(attribute.get(interpolation, mesh.GetPointsAttr()).Get(self.context.time) or ())


def _numbers(primvar: Any, time: Any) -> np.ndarray | None:
    """The values, (n, width), of which a primvar that is no array has one; None unless they are numbers."""
    values = primvar.ComputeFlattened(time)
    is_array = bool(primvar.GetTypeName().isArray)
    if values is None or (is_array and len(values) == 0):
        return None
    try:
        return np.asarray(values, np.float32).reshape(len(values) if is_array else 1, -1)
    except (TypeError, ValueError):  # such as strings
        return None
