"""Converts a stage, or its cameras' exposures."""

from __future__ import annotations

import contextlib
import importlib
import os
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

from .._core import Scene
from .._enclosure import Enclosure
from .._model_builder import missing, reading
from ..errors import InputError
from .animation import Animation
from .cameras import add_camera, exposures_of
from .context import Context
from .dome_lights import environment_of, is_dome
from .files import Files, open_stage
from .instancers import Instancers
from .instances import Instances
from .lights import add_light
from .materials import Materials
from .meshes import Meshes
from .shapes import is_shape
from .skeletons import Skeletons
from .time_samples import TimeSamples
from .traversal import visible_prims


def from_usd(
    stage: Any, *, time: float | None = None, allow_outside: Sequence[str | os.PathLike[str]] = ()
) -> Scene:
    """Converts a Usd.Stage, or the path of a .usd, .usda, .usdc or .usdz file, with usd-core.

    time: the time code at which values are read. Default: time samples become an animation, "stage", which the option
        `time` plays in seconds from the stage's first time code; values that it does not include are those of that time
        code, and a warning names them
    allow_outside: folders that a file may refer to, besides its own

    Converted are visible meshes with their subsets, holes, normals, texture coordinates, displayColor and
    displayOpacity; skeletons and blend shapes with in-betweens; spheres, cubes, cones, planes, and cylinders and
    capsules with one or two radii; instances and point instancers, with primvars per copy; UsdPreviewSurface and
    MaterialX's standard surface with their images and primvars; distant, sphere, rect, disk and cylinder lights, with
    color temperatures, and spheres with a cone as spot lights; dome lights, as the scene's environment; perspective,
    orthographic and shifted cameras; and the stage's units, up axis and chosen variants. Animated are transforms,
    skeletons, weights of blend shapes, points and normals, copies of instancers, and visibility. Subdivision surfaces
    are shown as their cages. Curves, points, volumes, procedural textures and other shaders are left out."""
    with _opened(stage, time, allow_outside, "from_usd") as context:
        scene = _converted(context)
    if context.samples.unplayed:
        context.warn(_read_once(context.samples))
    for message in context.warnings:  # from here, the caller is one level up, and an error is no fault of the file
        warnings.warn(message, stacklevel=2)
    return scene


def usd_exposures(
    stage: Any, *, time: float | None = None, allow_outside: Sequence[str | os.PathLike[str]] = ()
) -> list[float]:
    """The exposures of the cameras of from_usd(stage), in their order, in stops for the option `exposure`.

    They follow from the attribute `exposure` of a UsdGeomCamera and from its sensitivity, f-stop, exposure time and
    responsivity: log2(time iso / (100 fStop^2) responsivity) + exposure. The arguments are those of from_usd."""
    with _opened(stage, time, allow_outside, "usd_exposures") as context:
        return list(exposures_of(context))


@contextlib.contextmanager
def _opened(
    stage: Any, time: float | None, allow_outside: Sequence[str | os.PathLike[str]], function: str
) -> Iterator[Context]:
    """Opens a stage, and reports errors of its conversion. `function`: the name of the public function."""
    try:
        pxr = importlib.import_module("pxr")
        for name in ("Ar", "Gf", "Sdf", "Usd", "UsdGeom", "UsdLux", "UsdShade", "UsdSkel"):
            importlib.import_module(f"pxr.{name}")
    except ImportError:
        raise missing("usd-core", function) from None
    is_file = isinstance(stage, (str, os.PathLike))
    if is_file and not os.path.isfile(stage):
        raise InputError(f"{os.fspath(stage)} does not exist: give a .usd, .usda, .usdc or .usdz file")
    enclosure = Enclosure(stage, allow_outside) if is_file else None
    with reading(stage, "usd-core"):
        opened = open_stage(pxr, os.fspath(stage), enclosure) if enclosure else stage
        yield Context(opened, pxr, time, Files(pxr, enclosure))


def _converted(context: Context) -> Scene:
    geom, skel, lux = context.pxr.UsdGeom, context.pxr.UsdSkel, context.pxr.UsdLux
    animation, materials = Animation(context), Materials(context)
    skeletons = Skeletons(context, animation)
    instances = Instances(context, animation, materials, skeletons)
    meshes = Meshes(context, animation, instances, skeletons)
    domes: list[Any] = []
    copied: list[Any] = []
    for prim in visible_prims(context):
        if prim.IsA(geom.PointInstancer):
            copied.append(prim)
        elif prim.IsA(geom.Mesh):
            meshes.add(prim)
        elif is_shape(prim):
            instances.add(prim)
        elif prim.IsA(skel.Root):
            skeletons.add_root(prim)
        elif prim.IsA(geom.Camera):
            add_camera(context, animation, prim)
        elif is_dome(context, prim):
            domes.append(prim)
            if context.samples.moves(prim):  # the scene's environment stays
                context.samples.add_unplayed(prim)
        elif prim.HasAPI(lux.LightAPI):
            add_light(context, animation, prim)
    instancers = Instancers(context, animation, instances, skeletons)
    for prim in copied:
        instancers.add(prim)
    if domes:
        context.scene.set_environment(environment_of(context, domes))
    animation.finish()
    return context.scene


def _read_once(samples: TimeSamples) -> str:
    """The warning of values that the animation does not include."""
    unplayed = list(dict.fromkeys(samples.unplayed))
    named, others = ", ".join(unplayed[:3]), len(unplayed) - 3
    if others > 0:
        named += f" and {others} others"
    return (
        f"from_usd reads the time samples of {named} only at the time code {samples.start:g}: animations do not "
        "include them"
    )
