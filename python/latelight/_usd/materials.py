"""Materials of glTF from UsdPreviewSurface and MaterialX's standard surface, and for prims without a material."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._core import Material, MaterialHandle
from .._model_builder import DEFAULT_COLOR
from . import images
from .context import Context, source_of
from .primvars import Primvars
from .readers import Reader
from .surfaces import Surface

F0 = 0.04  # the reflectance at normal incidence of the index of refraction 1.5


class VertexSources(NamedTuple):
    """The primvars that the vertices of a mesh have: for colors and opacities that differ over it, which the factors of
    its material multiply, and for texture coordinates. Empty or None for each without."""

    color: str = ""
    opacity: str = ""
    coordinates: Reader | None = None


class Look(NamedTuple):
    material: MaterialHandle
    vertices: VertexSources


class Shading(NamedTuple):
    """A material: the path that it shares with native instances, its surface shader, if it is supported, the shader's
    identifier, and the primvars that it reads."""

    source: Any
    shader: Any = None
    identifier: str = ""
    primvars: tuple[str, ...] = ()


_DISPLAY = ("displayColor", "displayOpacity")  # the primvars that meshes without a material read


class Materials:
    def __init__(self, context: Context) -> None:
        self.context = context
        self.made: dict[Any, Look] = {}
        self.shadings: dict[Any, Shading] = {}
        self.images: dict[tuple[str, str], Any] = {}

    def bound(self, prim: Any) -> Shading | None:
        """The material of a prim or of a subset of its faces, None without one: that for full renderings, or else the
        one for previews if only this one has a supported shader or only this one is bound."""
        shade, first = self.context.pxr.UsdShade, None
        binding = shade.MaterialBindingAPI(prim)
        for purpose in (shade.Tokens.full, shade.Tokens.preview):
            material = binding.ComputeBoundMaterial(purpose)[0]
            shading = self._shading(material) if material else None
            if shading and shading.shader:
                return shading
            first = first or shading
        return first

    def primvars_read(self, shading: Shading | None) -> tuple[str, ...]:
        return shading.primvars if shading else _DISPLAY

    def is_double_sided(self, prim: Any) -> bool:
        return bool(self.context.pxr.UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(self.context.time))

    def look(self, shading: Shading | None, primvars: Primvars, double_sided: bool) -> Look:
        """How a mesh or shape, or a subset of its faces, looks with a material, or with none."""
        if not shading:
            return self._display_look(primvars, double_sided)
        if not shading.shader:
            return Look(self.context.builder.default_material(double_sided), VertexSources())
        read = tuple(None if primvars.varies(p) else primvars.constant(p) or () for p in shading.primvars)
        key = (shading.source, double_sided, read)
        if key not in self.made:
            self.made[key] = self._add(shading, primvars, double_sided)
        return self.made[key]

    def _display_look(self, primvars: Primvars, double_sided: bool) -> Look:
        """By the linear displayColor and displayOpacity. The default is the color of meshes without a material."""
        color, opacity = map(primvars.find, _DISPLAY)
        if not color and not opacity:
            return Look(self.context.builder.default_material(double_sided), VertexSources())
        rgba, vertices = np.array(DEFAULT_COLOR, np.float32), VertexSources()
        if color:
            rgba[:3] = np.clip(np.resize(color.array[0], 3), 0, 1)
        if color and color.interpolation != "constant":
            rgba[:3], vertices = 1, vertices._replace(color="displayColor")
        if opacity:
            rgba[3] = np.clip(opacity.array[0, 0], 0, 1)
        if opacity and opacity.interpolation != "constant":
            rgba[3], vertices = 1, vertices._replace(opacity="displayOpacity")
        translucent = bool(opacity and (opacity.array < 1).any())
        name = "vertex colors" if vertices.color or vertices.opacity else "display color"
        return Look(self.context.builder.plain(name, tuple(rgba.tolist()), translucent, double_sided), vertices)

    def _shading(self, material: Any) -> Shading:
        source = source_of(material.GetPrim())
        if source not in self.shadings:
            self.shadings[source] = Shading(source)
            for render_context in ("", "mtlx"):  # the universal one first
                shader = material.ComputeSurfaceSource(render_context)[0]
                identifier = shader.GetShaderId() if shader else ""
                if identifier in _CONVERSIONS:
                    surface = Surface(self.context, shader, self.images, Primvars(self.context, None))
                    readers = (surface.reader(given.GetBaseName()) for given in shader.GetInputs())
                    primvars = dict.fromkeys(reader.primvar for reader in readers if reader)
                    self.shadings[source] = Shading(source, shader, identifier, tuple(primvars))
                    break
        return self.shadings[source]

    def _add(self, shading: Shading, primvars: Primvars, double_sided: bool) -> Look:
        add, color, opacity = _CONVERSIONS[shading.identifier]
        inputs = [name for name in (color, opacity) if name]
        surface = Surface(self.context, shading.shader, self.images, primvars, inputs)
        handle = add(self.context, shading.source.name, surface)
        if double_sided:
            values = self.context.scene.material(handle)
            values.double_sided = True
            self.context.scene.set_material(handle, values)
        colors = surface.vertex_primvar(color), surface.vertex_primvar(opacity)
        return Look(handle, VertexSources(*colors, surface.coordinates(*inputs)))


def _has_specular_workflow(surface: Surface) -> bool:
    """The reflectance at normal incidence is then specularColor, and metallic and ior do not apply to it."""
    return bool(surface.value("useSpecularWorkflow", 0))


def _add_preview_surface(context: Context, name: str, surface: Surface) -> MaterialHandle:
    mask = surface.channel("opacity")
    opacity, threshold = surface.factor("opacity", 1), surface.number("opacityThreshold", 0)
    is_translucent = opacity < 1 or mask is not None or surface.vertex_primvar("opacity") != ""
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
            alpha_mode="mask" if threshold > 0 else "blend" if is_translucent else "opaque",
            alpha_cutoff=threshold if threshold > 0 else 0.5,
        )
    )
    _add_preview_textures(context, handle, surface)
    return handle


def _add_preview_textures(context: Context, handle: MaterialHandle, surface: Surface) -> None:
    has_specular = _has_specular_workflow(surface)

    def pack_color() -> Any:
        return images.with_alpha(surface.image("diffuseColor", "RGB"), surface.channel("opacity"))

    def pack_roughness() -> Any:
        metal = None if has_specular else surface.channel("metallic")
        return images.metallic_roughness(surface.channel("roughness"), metal)

    color, packed = surface.packed("color", pack_color), surface.packed(f"roughness{has_specular}", pack_roughness)
    occlusion = surface.packed("occlusion", lambda: images.occlusion(surface.channel("occlusion")))
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

    def pack_roughness() -> Any:
        return images.metallic_roughness(surface.channel("specular_roughness"), surface.channel("metalness"))

    add, packed = context.builder.add_texture, surface.packed("roughness", pack_roughness)
    add(handle, "base_color", image, True, surface.wrap("base_color"))
    add(handle, "emissive", emissive, True, surface.wrap("emission_color"))
    add(handle, "normal", surface.image("normal"), False, surface.wrap("normal"))
    add(handle, "metallic_roughness", packed, False, surface.wrap("specular_roughness", "metalness"))
    return handle


# The conversions of surface shaders by their identifiers, with their inputs whose values may differ per vertex: the
# color and the opacity.
_CONVERSIONS = {
    "UsdPreviewSurface": (_add_preview_surface, "diffuseColor", "opacity"),
    "ND_UsdPreviewSurface_surfaceshader": (_add_preview_surface, "diffuseColor", "opacity"),
    "ND_standard_surface_surfaceshader": (_add_standard_surface, "base_color", ""),
}
