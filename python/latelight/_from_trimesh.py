"""Scenes from trimesh."""

from __future__ import annotations

import importlib
import warnings
from typing import Any

import numpy as np

from ._core import Material, MaterialHandle, MeshHandle, Scene
from ._model_builder import Builder, linear, node_name, v_down
from .errors import UsageError


def _factor(value: Any, size: int, otherwise: float = 1) -> tuple[float, ...]:
    """Factors of trimesh are floats, or bytes for colors."""
    if value is None:
        return (otherwise,) * size
    array = np.asarray(value)
    scale = 255 if array.dtype == np.uint8 else 1
    array = np.clip(array.astype(np.float64).ravel() / scale, 0, 1)
    return tuple(np.concatenate([array, np.ones(size)])[:size].tolist())


def _colors_of_gltf(visual: Any, count: int) -> np.ndarray | None:
    """The vertex colors that trimesh reads from glTF files for meshes with a material, which multiply it. They are
    linear, and integers are normalized."""
    colors = getattr(visual, "vertex_attributes", {}).get("color")
    if visual.kind != "texture" or colors is None or len(colors) != count:
        return None
    colors = np.asarray(colors)
    scale = np.iinfo(colors.dtype).max if np.issubdtype(colors.dtype, np.integer) else 1
    return np.clip(colors / np.float32(scale), 0, 1).astype(np.float32)


def has_triangles(geometry: Any) -> bool:
    """Paths and point clouds have none."""
    return hasattr(geometry, "faces") and len(geometry.faces) > 0


def _meters_per_unit(meshes: list[Any]) -> float:
    """The length in meters of the unit that the meshes state, or 1 if they state none. Lengths are not converted, with
    a warning, if trimesh does not know the unit, or if meshes differ, because transforms of nodes state no unit."""
    units = [getattr(mesh, "units", None) for mesh in meshes]
    stated = ", ".join(sorted({unit for unit in units if unit}))
    if not stated:
        return 1
    convert = importlib.import_module("trimesh.units").unit_conversion
    try:
        lengths = {convert(unit, "meters") if unit else 1.0 for unit in units}
    except ValueError:
        warnings.warn(f"trimesh does not know the unit of the model: lengths in {stated} are not converted", stacklevel=3)
        return 1
    if len(lengths) > 1:
        some = " or no unit" if None in units else ""
        warnings.warn(f"meshes have different units: lengths in {stated}{some} are not converted", stacklevel=3)
        return 1
    return float(lengths.pop())


class TrimeshBuilder(Builder):
    def __init__(self, up: str, smooth: bool | None) -> None:
        super().__init__(up)
        self.smooth = smooth

    def scale(self, factor: float) -> None:
        """Scales all instances that are added afterward."""
        self.world = self.world @ np.diag([factor, factor, factor, 1])

    def normals(self, mesh: Any) -> np.ndarray | None:
        """Nothing for flat triangles. Normals of files are in the mesh's cache, as are those that trimesh has computed
        since; its exporters also write the normals that the cache has. Normals that are not finite become those of the
        triangles, as do zeros."""
        known = "vertex_normals" in getattr(mesh, "_cache", ())
        if not (known if self.smooth is None else self.smooth):
            return None
        return np.nan_to_num(np.asarray(mesh.vertex_normals, np.float32), nan=0, posinf=0, neginf=0)

    def material(self, source: Any, has_textures: bool) -> MaterialHandle:
        """has_textures: whether the mesh has the texture coordinates that textures require"""
        if source is None:
            return self.default_material()
        key = (id(source), has_textures)
        if key not in self.materials:
            self.kept.append(source)
            self.materials[key] = self._add_material(source, has_textures)
        return self.materials[key]

    def _add_material(self, source: Any, has_textures: bool) -> MaterialHandle:
        pbr = source if hasattr(source, "baseColorFactor") else source.to_pbr()
        # Materials of glTF have its defaults. Simple materials are not metals, but their conversion omits the factor.
        is_gltf = pbr is source or any(pbr is each for each in getattr(source, "materials", ()))
        base_color = _factor(pbr.baseColorFactor, 4)
        # Simple materials have no alpha mode: their opacity is the alpha of the diffuse color.
        mode = (pbr.alphaMode or ("BLEND" if not is_gltf and base_color[3] < 1 else "OPAQUE")).lower()
        values = Material(
            name=str(getattr(source, "name", None) or "material"),
            base_color=base_color,
            metallic=_factor(pbr.metallicFactor, 1, 1 if is_gltf else 0)[0],
            roughness=_factor(pbr.roughnessFactor, 1)[0],
            emissive=_factor(pbr.emissiveFactor, 3, 0),
            alpha_mode=mode if mode in ("opaque", "mask", "blend") else "opaque",
            alpha_cutoff=0.5 if pbr.alphaCutoff is None else float(pbr.alphaCutoff),
            double_sided=bool(pbr.doubleSided),
        )
        handle = self.scene.add_material(values)
        if not has_textures:
            return handle
        self.add_texture(handle, "base_color", pbr.baseColorTexture, True)
        self.add_texture(handle, "metallic_roughness", pbr.metallicRoughnessTexture, False)
        self.add_texture(handle, "normal", pbr.normalTexture, False)
        self.add_texture(handle, "occlusion", pbr.occlusionTexture, False)
        self.add_texture(handle, "emissive", pbr.emissiveTexture, True)
        return handle

    def geometry(self, mesh: Any, name: Any) -> tuple[MeshHandle, MaterialHandle] | None:
        """Returns nothing for geometry without triangles."""
        if not has_triangles(mesh):
            return None
        positions, indices = np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.int64)
        visual, uv = mesh.visual, None
        colors = _colors_of_gltf(visual, len(positions))
        normals = self.normals(mesh)
        if getattr(visual, "uv", None) is not None and len(visual.uv) == len(positions):
            uv = v_down(visual.uv)
        if visual.kind == "vertex":
            colors = linear(np.asarray(visual.vertex_colors) / 255)
        elif visual.kind == "face":
            positions, colors = positions[indices.ravel()], linear(np.repeat(visual.face_colors, 3, axis=0) / 255)
            normals = normals[indices.ravel()] if normals is not None else None
            indices = np.arange(len(positions)).reshape(-1, 3)
        handle = self.scene.add_mesh(
            positions, indices=indices, normals=normals, uv=uv, colors=colors, name=node_name(name)
        )
        if colors is not None and visual.kind in ("vertex", "face"):
            return handle, self.white(bool((colors[:, 3] < 1).any()))
        return handle, self.material(getattr(visual, "material", None), uv is not None)


def from_trimesh(model: Any, *, up: str = "y", smooth: bool | None = None) -> Scene:
    """Converts a trimesh.Trimesh or trimesh.Scene.

    up: the axis that points up in the model, "y" or "z"
    smooth: True: use vertex normals, which trimesh computes for meshes without any; False: triangles are flat; default:
    as the model defines it, by the vertex normals of its file or those that trimesh has computed

    Lengths become meters if the meshes state their unit, as those of 3MF, COLLADA and glTF files do; others are read as
    meters. PBR and simple materials, textures, and vertex and face colors (sRGB) are converted. A mesh without texture
    coordinates has its material's colors and factors. Vertex colors that glTF files have in addition to a material
    (linear) multiply it. Paths, point clouds, lights and cameras are left out."""
    builder = TrimeshBuilder(up, smooth)
    if hasattr(model, "faces"):
        builder.scale(_meters_per_unit([model]))
        if made := builder.geometry(model, "mesh"):
            builder.add_instance(*made, np.eye(4), "mesh")
        return builder.scene
    if not hasattr(model, "geometry") or not hasattr(model, "graph"):
        raise UsageError(f"from_trimesh requires a trimesh.Trimesh or trimesh.Scene, not {type(model).__name__}")
    builder.scale(_meters_per_unit([mesh for mesh in model.geometry.values() if has_triangles(mesh)]))
    made_by_name = {name: builder.geometry(mesh, name) for name, mesh in model.geometry.items()}
    for node in model.graph.nodes_geometry:
        transform, geometry = model.graph[node]
        if made := made_by_name.get(geometry):
            builder.add_instance(*made, transform, node)
    return builder.scene
