"""The inputs of surface shaders: constants, and the images and primvars that are connected to them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .._model_builder import Wrap
from .context import Context
from .images import is_radiance, open_image, radiance_image
from .primvars import Primvars
from .readers import Reader, reader_of

# The wrap modes of UsdUVTexture and MaterialX; all others are "repeat". Textures of glTF have no border color.
WRAPS: dict[str, Wrap] = {"clamp": "clamp", "mirror": "mirror", "black": "clamp", "constant": "clamp"}


_DEEPEST = 8  # transforms of texture coordinates, which may form a cycle


class ImageUse(NamedTuple):
    """The image that an input is connected to: no path if there is none."""

    path: str = ""
    output: str = ""  # the channel, or "rgb"
    scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)  # of red, green, blue and alpha
    wraps: tuple[str, ...] = ()  # USD's or MaterialX's wrap modes of s and t
    coordinates: Reader | None = None  # the texture coordinates, if the shader states their primvar

    def channel(self) -> int:
        return {"g": 1, "b": 2, "a": 3}.get(self.output, 0)


class Surface:
    """A surface shader, as it applies to a mesh or shape.

    images: the images that are open, by path and mode, or packed, by shader and slot, which surfaces share
    per_vertex: the inputs that may differ over a mesh, as colors of its vertices"""

    def __init__(
        self,
        context: Context,
        shader: Any,
        images: dict[tuple[str, str], Any],
        primvars: Primvars,
        per_vertex: Sequence[str] = (),
    ) -> None:
        self.context, self.shader, self.images = context, shader, images
        self.primvars, self.per_vertex = primvars, per_vertex

    # --- constants ---

    def value(self, name: str, otherwise: Any) -> Any:
        """A constant, also one that a node graph passes on, or that of a primvar; `otherwise` if it is missing or an
        image."""
        given = self.shader.GetInput(name)
        if not given:
            return otherwise
        if self.image_use(name).path:
            return otherwise
        if reader := self.reader(name):
            return self._read(name, reader, otherwise)
        result = self._constant(given)
        return otherwise if result is None else result

    def _constant(self, given: Any) -> Any:
        """The value of an input, also one that a node graph or the material passes on; None if it has none."""
        sources = self.context.pxr.UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return sources[0].Get(self.context.time) if sources else None

    def number(self, name: str, otherwise: float) -> float:
        return min(max(float(self.value(name, otherwise)), 0), 1)

    def color(self, name: str, otherwise: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple(max(float(c), 0) for c in self.value(name, otherwise))

    def f0(self, name: str, otherwise: float) -> float:
        """The reflectance of an index of refraction at normal incidence."""
        ior = float(self.value(name, otherwise))
        return ((ior - 1) / (ior + 1)) ** 2

    # --- primvars ---

    def reader(self, name: str) -> Reader | None:
        """The primvar that an input is connected to."""
        given, pxr = self.shader.GetInput(name), self.context.pxr
        sources = pxr.UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
        return reader_of(pxr, sources[0].GetPrim()) if sources else None

    def vertex_primvar(self, name: str) -> str:
        """The primvar with the values of an input per vertex: empty if it is constant."""
        reader = self.reader(name) if name in self.per_vertex else None
        return reader.primvar if reader and self.primvars.varies(reader.primvar) else ""

    def _read(self, name: str, reader: Reader, otherwise: Any) -> Any:
        """The constant value of a primvar, with as many numbers as `otherwise`. For values per vertex, their factor."""
        if self.vertex_primvar(name):
            return np.ones_like(otherwise).tolist()
        values = self.primvars.constant(reader.primvar)
        if values is None and self.primvars.varies(reader.primvar):
            self.context.warn(
                f'from_usd uses the fallback of the primvar "{reader.primvar}" for {name} of {self.shader.GetPath()}, '
                "because only the base color and the opacity may differ over a mesh"
            )
        values = reader.fallback if values is None else values
        width = np.size(otherwise)
        if np.ndim(otherwise) == 0:
            return values[0]
        return tuple(values[:width]) if len(values) >= width else values[:1] * width

    # --- constants or images ---

    def factor(self, name: str, otherwise: float) -> float:
        """A number in [0, 1], or the scale of the image that is connected in its place."""
        use = self.image_use(name)
        return min(max(use.scale[use.channel()], 0), 1) if use.path else self.number(name, otherwise)

    def tint(self, name: str, otherwise: tuple[float, float, float]) -> tuple[float, ...]:
        """A color, or the scale of the image that is connected in its place."""
        use = self.image_use(name)
        return tuple(max(c, 0) for c in use.scale[:3]) if use.path else self.color(name, otherwise)

    # --- images ---

    def coordinates(self, *first: str) -> Reader | None:
        """The texture coordinates of all images, by those of the first of these inputs and then of all others; None if
        no shader states them."""
        names = dict.fromkeys([*first, *(given.GetBaseName() for given in self.shader.GetInputs())])
        uses = [use for use in map(self.image_use, names) if use.path]
        readers = list(dict.fromkeys(use.coordinates for use in uses))
        if len(readers) > 1:
            chosen = f'"{readers[0].primvar}"' if readers[0] else "of the usual name"
            self.context.warn(
                f"from_usd uses the texture coordinates {chosen} for all images of {self.shader.GetPath()}, because a "
                "mesh has one set of them"
            )
        return readers[0] if readers else None

    def image(self, name: str, mode: str = "") -> Any:
        """The image that an input is connected to, as pixels: in a mode of Pillow, or in the file's.

        Colors, which are sRGB, are read as "RGB", because a shader's inputs of colors do not include the alpha of the
        image."""
        path = self.image_use(name).path
        if not path:
            return None
        key = (path, mode)
        if key not in self.images and is_radiance(path):
            self.images[key] = radiance_image(self.context.files, path, srgb=mode == "RGB")
        elif key not in self.images:
            self.images[key] = self.image(name).convert(mode) if mode else open_image(self.context.files, path)
        return self.images[key]

    def packed(self, slot: str, pack: Callable[[], Any]) -> Any:
        """The image of a texture that `pack` combines of others, once for all prims with this shader."""
        key = (str(self.shader.GetPath()), slot)
        if key not in self.images:
            self.images[key] = pack()
        return self.images[key]

    def channel(self, name: str) -> np.ndarray | None:
        """One channel of the image that a scalar input is connected to."""
        image = self.image(name)
        return None if image is None else np.asarray(image.convert("RGBA"))[..., self.image_use(name).channel()]

    def wrap(self, *names: str) -> Wrap:
        """The wrap mode of the texture that the images of these inputs are packed to."""
        wraps_by_name = {name: use.wraps for name in names if (use := self.image_use(name)).path}
        sources = list(dict.fromkeys(wrap for pair in wraps_by_name.values() for wrap in pair))
        wraps = list(dict.fromkeys(WRAPS.get(source, "repeat") for source in sources))
        texture = f"{' and '.join(wraps_by_name)} of {self.shader.GetPath()}"
        for source in sources:
            if source in ("black", "constant"):
                self.context.warn(f'from_usd uses the wrap mode "clamp" instead of "{source}" for {texture}')
        if len(wraps) > 1:
            reason = "a texture has one mode for both axes and all of its images"
            self.context.warn(f'from_usd uses the wrap mode "{wraps[0]}" for {texture}, because {reason}')
        return wraps[0] if wraps else "repeat"

    def image_use(self, name: str) -> ImageUse:
        """The image file that an input is connected to, also through a node graph."""
        return self._image_use(self.shader, name)

    def _image_use(self, shader: Any, name: str) -> ImageUse:
        given = shader.GetInput(name)
        shade, files = self.context.pxr.UsdShade, self.context.files
        for source in shade.Utils.GetValueProducingAttributes(given) if given else []:
            texture = shade.Shader(source.GetPrim())
            if texture and texture.GetShaderId() == "ND_normalmap" and texture.GetInput("in"):
                return self._image_use(texture, "in")
            file = self._constant(texture.GetInput("file")) if texture else None
            path = files.resolved(file)
            if path and files.exists(path):
                output = source.GetName().removeprefix("outputs:")
                scale, wraps = self._scale_of(texture), self._wraps_of(texture)
                return ImageUse(path, output, scale, wraps, self._coordinates_of(texture))
            if file and file.path:
                reason = "consists of UDIM tiles, which are not supported" if "<UDIM>" in file.path else "does not exist"
                self.context.warn(f"the image {file.path} of {texture.GetPath()} {reason}, and is left out")
        return ImageUse()

    def _scale_of(self, texture: Any) -> tuple[float, ...]:
        """The scale of an image. With a bias, as normal maps have one, glTF's factors cannot express it."""
        time, scale, bias = self.context.time, texture.GetInput("scale"), texture.GetInput("bias")
        if "UsdUVTexture" not in (texture.GetShaderId() or "") or not scale or (bias and any(bias.Get(time) or ())):
            return ImageUse().scale
        return tuple(float(c) for c in scale.Get(time) or ImageUse().scale)

    def _wraps_of(self, texture: Any) -> tuple[str, ...]:
        is_usd = "UsdUVTexture" in (texture.GetShaderId() or "")
        names = ("wrapS", "wrapT") if is_usd else ("uaddressmode", "vaddressmode")
        inputs = [texture.GetInput(name) for name in names]
        return tuple(str(given.Get(self.context.time) or "repeat") if given else "repeat" for given in inputs)

    def _coordinates_of(self, texture: Any) -> Reader | None:
        """The texture coordinates of an image, also through transforms of them."""
        pxr, shader = self.context.pxr, texture
        for _ in range(_DEEPEST):
            given = next((i for i in map(shader.GetInput, ("st", "texcoord", "in")) if i), None)
            sources = pxr.UsdShade.Utils.GetValueProducingAttributes(given) if given else ()
            shader = pxr.UsdShade.Shader(sources[0].GetPrim()) if sources else None
            if not shader:
                return None
            if reader := reader_of(pxr, shader.GetPrim()):
                return reader
        return None
