"""The prims of a stage, or of a prototype, that are visible and meant for rendering."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .context import Context


def visible_prims(context: Context, prototype: Any = None) -> Iterator[Any]:
    """The prims of the stage, or of a prototype of an instancer, that are shown at some time and meant for rendering.
    Prims below an instancer are left out.

    A prototype may be undefined or abstract, and inherits no visibility and no purpose from the prims that contain it,
    as in UsdImaging, since these often hide it outside of instancers."""
    geom, usd = context.pxr.UsdGeom, context.pxr.Usd
    top = prototype or context.stage.GetPseudoRoot()
    walk = iter(usd.PrimRange(top, context.prototype_predicate if prototype else context.predicate))
    purposes: dict[Any, Any] = {}
    for prim in walk:
        imageable = geom.Imageable(prim)
        if imageable and not (_is_visible_itself(context, imageable) if prototype else _is_ever_visible(context, prim)):
            walk.PruneChildren()
            continue
        if prim.IsA(geom.PointInstancer):
            walk.PruneChildren()
        above = purposes.get(prim.GetPath().GetParentPath(), geom.Imageable.PurposeInfo())
        purposes[prim.GetPath()] = imageable.ComputePurposeInfo(above) if imageable else above
        # Prims below may have a purpose of their own, and the skeletons of a root move them.
        for_rendering = purposes[prim.GetPath()].purpose not in (geom.Tokens.guide, geom.Tokens.proxy)
        if for_rendering or prim.IsA(context.pxr.UsdSkel.Root):
            yield prim


def is_visible(context: Context, prim: Any, time: Any) -> bool:
    """True if neither the prim nor a parent hides it at that time."""
    geom = context.pxr.UsdGeom
    return bool(geom.Imageable(prim).ComputeVisibility(time) != geom.Tokens.invisible)


def _is_ever_visible(context: Context, prim: Any) -> bool:
    return any(is_visible(context, prim, time) for time in context.samples.of_visibility(prim) or [context.time])


def _is_visible_itself(context: Context, imageable: Any) -> bool:
    """True if an imageable prim does not hide itself and what is below it."""
    attribute = imageable.GetVisibilityAttr()
    if context.samples.exist and attribute.ValueMightBeTimeVarying():
        context.samples.add_unplayed(attribute)
    return bool(attribute.Get(context.time) != context.pxr.UsdGeom.Tokens.invisible)
