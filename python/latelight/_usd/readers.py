"""Shaders that read primvars: those of UsdPreviewSurface and of MaterialX."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

# The inputs for the name of the primvar and for the value without it, by the start of the shader's identifier.
_INPUTS = {
    "UsdPrimvarReader_": ("varname", "fallback"),
    "ND_UsdPrimvarReader_": ("varname", "fallback"),
    "ND_geompropvalue_": ("geomprop", "default"),
}


class Reader(NamedTuple):
    """The name of a primvar, and the value for meshes without it, by default zeros."""

    primvar: str
    fallback: tuple[float, ...]


def reader_of(pxr: Any, prim: Any) -> Reader | None:
    """None unless the prim is a shader that reads a primvar of a given name."""
    shader = pxr.UsdShade.Shader(prim)
    identifier = (shader.GetShaderId() or "") if shader else ""
    for start, (name, fallback) in _INPUTS.items():
        if identifier.startswith(start):
            primvar, otherwise = (_constant(pxr, shader.GetInput(given)) for given in (name, fallback))
            is_number = otherwise is not None and not isinstance(otherwise, str)
            numbers = np.ravel(np.array(otherwise, float)).tolist() if is_number else []
            return Reader(str(primvar), tuple(numbers or [0.0])) if primvar else None
    return None


def _constant(pxr: Any, given: Any) -> Any:
    """The value of an input, also one that the material passes on; None if it has none."""
    sources = pxr.UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
    return sources[0].Get(pxr.Usd.TimeCode.EarliestTime()) if sources else None
