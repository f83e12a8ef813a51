"""Materials of glTF from UsdPreviewSurface and MaterialX's standard surface, and for prims without a material."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._core import Material, MaterialHandle
from .._model_builder import DEFAULT_COLOR
from . import images
from .context import Context
from .surfaces import Surface

F0 = 0.04  # the reflectance at normal incidence of the index of refraction 1.5


def display_colors(count: int, colors: np.ndarray | None, opacities: np.ndarray | None) -> np.ndarray:
    """The values of displayColor, which is linear, and displayOpacity, as colors of vertices. The default is that of
    meshes without a material."""
    rgba = np.tile(np.array(DEFAULT_COLOR, np.float32), (count, 1))
    if colors is not None:
        rgba[:, :3] = np.clip(colors, 0, 1)
    if opacities is not None:
        rgba[:, 3:] = np.clip(opacities, 0, 1)
    return rgba


class Materials:
    def __init__(self, context: Context) -> None:
        self.context = context
        self.made: dict[tuple[str, bool], MaterialHandle] = {}
        self.images: dict[tuple[str, str], Any] = {}

    def bound(self, prim: Any) -> Any:
        """The UsdShadeMaterial of a prim or of a subset of its faces."""
        return self.context.pxr.UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]

    def default(self, prim: Any) -> MaterialHandle:
        return self.context.builder.default_material(self._is_double_sided(prim))

    def of_colors(self, prim: Any, rgba: np.ndarray) -> MaterialHandle:
        """For a mesh or shape whose vertices have these colors."""
        return self.context.builder.white(bool((rgba[:, 3] < 1).any()), self._is_double_sided(prim))

    def convert(self, material: Any, prim: Any) -> MaterialHandle | None:
        """The material of a mesh or shape, which states whether it has two sides; None if none is bound."""
        if not material:
            return None
        double_sided = self._is_double_sided(prim)
        key = (str(material.GetPath()), double_sided)
        if key not in self.made:
            handle = self._add(material)
            if handle is None:
                return self.default(prim)
            if double_sided:
                values = self.context.scene.material(handle)
                values.double_sided = True
                self.context.scene.set_material(handle, values)
            self.made[key] = handle
        return self.made[key]

    def _is_double_sided(self, prim: Any) -> bool:
        return bool(self.context.pxr.UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self.context.time))

    def _add(self, material: Any) -> MaterialHandle | None:
        for render_context in ("", "mtlx"):  # the universal one first
            shader = material.ComputeSurfaceSource(render_context)[0]
            identifier = shader.GetShaderId() if shader else ""
            name, surface = material.GetPrim().GetName(), Surface(self.context, shader, self.images)
            if identifier in ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader"):
                return _add_preview_surface(self.context, name, surface)
            if identifier == "ND_standard_surface_surfaceshader":
                return _add_standard_surface(self.context, name, surface)
        return None


def _has_specular_workflow(surface: Surface) -> bool:
    """The reflectance at normal incidence is then specularColor, and metallic and ior do not apply to it."""
    return bool(surface.value("useSpecularWorkflow", 0))


def _add_preview_surface(context: Context, name: str, surface: Surface) -> MaterialHandle:
    mask = surface.channel("opacity")
    opacity, threshold = surface.factor("opacity", 1), surface.number("opacityThreshold", 0)
    base = surface.tint("diffuseColor", (0.18, 0.18, 0.18))
    specular = surface.tint("specularColor", (0, 0, 0)) if _has_specular_workflow(surface) else None
    handle = context.scene.add_material(
        Material(
            name=name,
            base_color=(*(min(c, 1) for c in base), opacity),
            metallic=surface.factor("metallic", 0) if specular is None else 0,
            roughness=surface.factor("roughness", 0.5),
            emissive=surface.tint("emissiveColor", (0, 0, 0)),
            clearcoat=surface.number("clearcoat", 0),
            clearcoat_roughness=surface.number("clearcoatRoughness", 0.01),
            f0=surface.f0("ior", 1.5) if specular is None else F0,
            specular_color=(1, 1, 1) if specular is None else tuple(min(c, 1) / F0 for c in specular),
            alpha_mode="mask" if threshold > 0 else "blend" if opacity < 1 or mask is not None else "opaque",
            alpha_cutoff=threshold if threshold > 0 else 0.5,
        )
    )
    _add_preview_textures(context, handle, surface)
    return handle


def _add_preview_textures(context: Context, handle: MaterialHandle, surface: Surface) -> None:
    color = images.with_alpha(surface.image("diffuseColor", "RGB"), surface.channel("opacity"))
    has_specular = _has_specular_workflow(surface)
    metal = None if has_specular else surface.channel("metallic")
    packed = images.metallic_roughness(surface.channel("roughness"), metal)
    occlusion = images.occlusion(surface.channel("occlusion"))
    add = context.builder.add_texture
    add(handle, "base_color", color, True, surface.wrap("diffuseColor", "opacity"))
    add(handle, "emissive", surface.image("emissiveColor", "RGB"), True, surface.wrap("emissiveColor"))
    add(handle, "normal", surface.image("normal"), False, surface.wrap("normal"))
    wrap = surface.wrap("roughness") if has_specular else surface.wrap("roughness", "metallic")
    add(handle, "metallic_roughness", packed, False, wrap)
    if has_specular:
        add(handle, "specular_color", surface.image("specularColor", "RGB"), True, surface.wrap("specularColor"))
    add(handle, "occlusion", occlusion, False, surface.wrap("occlusion"))


def _add_standard_surface(context: Context, name: str, surface: Surface) -> MaterialHandle:
    """Autodesk Standard Surface 1.0.1 (Georgiev et al. 2019) as far as glTF's model has its layers."""
    image, emissive = surface.image("base_color", "RGB"), surface.image("emission_color", "RGB")
    rough, metal = surface.channel("specular_roughness"), surface.channel("metalness")
    base, emission = surface.number("base", 1), float(surface.value("emission", 0))
    color = surface.tint("base_color", (0.8, 0.8, 0.8))
    glow = surface.tint("emission_color", (1, 1, 1))
    transmission, sheen = surface.number("transmission", 0), surface.number("sheen", 0)
    if transmission > 0 and image is None:  # what passes is tinted by transmission_color in place of base_color
        tint = surface.color("transmission_color", (1, 1, 1))
        color = tuple((1 - transmission) * c + transmission * t for c, t in zip(color, tint))
    opacity = min(sum(surface.color("opacity", (1, 1, 1))) / 3, 1)
    handle = context.scene.add_material(
        Material(
            name=name,
            base_color=(*(min(base * c, 1) for c in color), opacity),
            metallic=surface.factor("metalness", 0),
            roughness=surface.factor("specular_roughness", 0.2),
            specular=surface.number("specular", 1),
            specular_color=surface.color("specular_color", (1, 1, 1)),
            f0=surface.f0("specular_IOR", 1.5),
            anisotropy=surface.number("specular_anisotropy", 0),
            emissive=tuple(emission * c for c in glow),
            clearcoat=surface.number("coat", 0),
            clearcoat_roughness=surface.number("coat_roughness", 0.1),
            sheen_color=tuple(sheen * min(c, 1) for c in surface.color("sheen_color", (1, 1, 1))),
            sheen_roughness=surface.number("sheen_roughness", 0.3),
            transmission=transmission,
            alpha_mode="blend" if opacity < 1 else "opaque",
        )
    )
    add, packed = context.builder.add_texture, images.metallic_roughness(rough, metal)
    add(handle, "base_color", image, True, surface.wrap("base_color"))
    add(handle, "emissive", emissive, True, surface.wrap("emission_color"))
    add(handle, "normal", surface.image("normal"), False, surface.wrap("normal"))
    add(handle, "metallic_roughness", packed, False, surface.wrap("specular_roughness", "metalness"))
    return handle
