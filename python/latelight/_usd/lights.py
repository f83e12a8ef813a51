"""Lights from prims of UsdLux.

As the documentation of UsdLuxLightAPI defines, `intensity` times 2^exposure is a radiance, and `normalize` divides it
by the area of the light in units of the stage, or by its projected solid angle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._core import Light
from ..errors import UsageError
from .animation import Animation
from .context import Context
from .transforms import axes_of

_WIDEST = 179.0  # degrees that a directional light may fill across, since its radius is a tangent


def color_of(api: Any, pxr: Any, time: Any) -> np.ndarray:
    color = np.array(api.GetColorAttr().Get(time), np.float64)
    if api.GetEnableColorTemperatureAttr().Get(time):
        color *= np.array(pxr.UsdLux.BlackbodyTemperatureAsRgb(float(api.GetColorTemperatureAttr().Get(time))))
    return color


def radiance_of(api: Any, time: Any) -> float:
    """Without color and `normalize`."""
    return float(api.GetIntensityAttr().Get(time) * 2.0 ** api.GetExposureAttr().Get(time))


def add_light(context: Context, animation: Animation, prim: Any) -> None:
    """Adds a light other than a dome. One that emits nothing or is of another type is left out."""
    transform, moves = context.scene_from(prim), context.samples.moves(prim)
    if moves:  # a light that is flat at first may grow, and then emits as one that is not scaled
        (axes,), (scales,) = axes_of(transform[None])
        transform[:3, :3] = axes * np.where(scales == 0, context.meters, scales)
    light = _light_of(context, prim, transform)
    if light is not None:
        context.scene.add_light(light, animation.node_of(prim) if moves else None)


def _light_of(context: Context, prim: Any, transform: np.ndarray) -> Light | None:
    pxr, time, meters = context.pxr, context.time, context.meters
    lux = pxr.UsdLux
    api, (axes, scales) = lux.LightAPI(prim), axes_of(transform[None])
    light = Light(
        name=prim.GetName(),
        color=tuple(color_of(api, pxr, time).tolist()),
        position=tuple(transform[:3, 3].tolist()),
        direction=tuple((-axes[0, :, 2]).tolist()),
        up=tuple(axes[0, :, 1].tolist()),
    )
    if prim.HasAPI(lux.ShadowAPI) and not lux.ShadowAPI(prim).GetShadowEnableAttr().Get(time):
        light.cast_shadow = False
    radiance, is_normalized = radiance_of(api, time), bool(api.GetNormalizeAttr().Get(time))
    if prim.IsA(lux.DistantLight):
        return _distant(light, float(prim.GetAttribute("inputs:angle").Get(time)), radiance, is_normalized)
    if prim.IsA(lux.SphereLight):
        radius = _size(prim, "radius", time) * float(np.cbrt(abs(np.linalg.det(transform[:3, :3]))))
        # A point without a radius is the limit of small normalized spheres, as there is no radiance that it could have.
        is_normalized |= radius == 0 and bool(lux.SphereLight(prim).GetTreatAsPointAttr().Get(time))
        # Radiance times the projected area, as seen from afar.
        light.intensity = radiance * (meters**2 / 4 if is_normalized else math.pi * radius**2)
        light.size = radius
        return _coned(light, prim, pxr, time)
    return _area(light, prim, pxr, time, np.abs(scales[0]), radiance, meters if is_normalized else 0)


def _size(prim: Any, name: str, time: Any) -> float:
    value = float(prim.GetAttribute(f"inputs:{name}").Get(time))
    if not 0 <= value < math.inf:
        raise UsageError(f"{prim.GetPath()} has the {name} {value:g}, but it must not be negative")
    return value


def _distant(light: Light, angle: float, radiance: float, is_normalized: bool) -> Light:
    """A light from everywhere within an angle in degrees, by the illuminance of a surface that faces it. If it fills no
    angle, UsdLux defines its radiance as the illuminance."""
    angle = min(max(angle, 0), 360)
    half = math.radians(angle / 2)
    cap = math.sin(half) ** 2
    above_horizon, size = (cap, cap) if angle <= 180 else (1, 2 - cap)  # over pi; UsdLux normalizes by the latter
    light.type, light.size = "directional", min(angle, _WIDEST)
    light.intensity = radiance
    if angle > 0:
        light.intensity *= above_horizon / size if is_normalized else math.pi * above_horizon
    return light


def _coned(light: Light, prim: Any, pxr: Any, time: Any) -> Light | None:
    """A point light, or a spot light if a cone of at most 90 degrees limits it."""
    if not prim.HasAPI(pxr.UsdLux.ShapingAPI):
        return light
    shaping = pxr.UsdLux.ShapingAPI(prim)
    cone = float(shaping.GetShapingConeAngleAttr().Get(time))
    if cone <= 0:
        return None
    if cone <= 90:
        softness = float(shaping.GetShapingConeSoftnessAttr().Get(time))
        light.type, light.outer_cone = "spot", cone
        light.inner_cone = cone * (1 - min(max(softness, 0), 1))
    return light


def _area(
    light: Light, prim: Any, pxr: Any, time: Any, scales: np.ndarray, radiance: float, unit: float
) -> Light | None:
    """Rectangles, disks and tubes. Their sizes are those of the prim, and `scales` are those of its transform.

    unit: meters of the unit whose square normalizes the radiance; 0: it is not normalized"""
    lux = pxr.UsdLux
    x, y, z = scales.tolist()
    if prim.IsA(lux.RectLight):
        light.type, light.width, light.height = "rect", _size(prim, "width", time), _size(prim, "height", time)
        area, z = light.width * x * light.height * y, z or 1
    elif prim.IsA(lux.DiskLight):
        light.type, light.size = "disk", _size(prim, "radius", time)
        area, z = math.pi * light.size**2 * x * y, z or 1
    elif prim.IsA(lux.CylinderLight):
        light.type, light.size, light.length = "tube", _size(prim, "radius", time), _size(prim, "length", time)
        around = math.pi * (3 * (y + z) - math.sqrt((3 * y + z) * (y + 3 * z)))  # Ramanujan 1914, for an ellipse
        area = light.size * around * light.length * x if y * z > 0 else 0
    else:
        return None
    if area <= 0:
        return None
    light.scale = (x, y, z)
    light.intensity = radiance * unit**2 / area if unit else radiance
    return light
