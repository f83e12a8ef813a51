"""Scenes from Open3D's triangle meshes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._core import Material, MaterialHandle, Scene
from ._model_builder import Builder, linear
from .errors import UsageError


def _pixels(image: Any) -> np.ndarray | None:
    """(H, W, C), or nothing for empty images, which stand for materials without a texture: NumPy sees these as objects
    without dimensions."""
    pixels = np.asarray(image)
    if pixels.dtype != np.uint8 or pixels.ndim not in (2, 3) or pixels.size == 0:
        return None
    return np.atleast_3d(pixels)  # grayscale images are (H, W)


class _Open3d(Builder):
    def add(self, mesh: Any, name: str) -> None:
        positions, indices = np.asarray(mesh.vertices, np.float32), np.asarray(mesh.triangles, np.int64)
        if len(indices) == 0:
            return
        colors = None
        if mesh.has_vertex_colors():
            rgb = np.clip(np.asarray(mesh.vertex_colors), 0, 1)
            colors = linear(np.concatenate([rgb, np.ones((len(rgb), 1))], axis=1))
        normals = np.asarray(mesh.vertex_normals, np.float32) if mesh.has_vertex_normals() else None
        images = [_pixels(image) for image in mesh.textures]
        if not mesh.has_triangle_uvs() or all(image is None for image in images):
            handle = self.scene.add_mesh(positions, indices=indices, normals=normals, colors=colors, name=name)
            self.add_instance(handle, self.untextured(colors), np.eye(4), name)
            return
        self._add_textured(positions, indices, normals, colors, mesh, images, name)

    def untextured(self, colors: Any) -> MaterialHandle:
        return self.default_material() if colors is None else self.white(False)

    def _add_textured(
        self, positions: Any, indices: Any, normals: Any, colors: Any, mesh: Any, images: list[Any], name: str
    ) -> None:
        """Texture coordinates belong to corners, and each triangle has one of the textures, or none. Open3D stores
        images with the row at v = 0 first, as glTF does."""
        uv = np.asarray(mesh.triangle_uvs).reshape(-1, 3, 2)
        ids = (
            np.asarray(mesh.triangle_material_ids) if mesh.has_triangle_material_ids() else np.zeros(len(indices), int)
        )
        for number in np.unique(ids):
            corners = indices[ids == number].ravel()
            handle = self.scene.add_mesh(
                positions[corners],
                normals=None if normals is None else normals[corners],
                colors=None if colors is None else colors[corners],
                uv=uv[ids == number].reshape(-1, 2).astype(np.float32),
                name=f"{name} {number}",
            )
            image = images[min(int(number), len(images) - 1)]
            material = self.untextured(colors)
            if image is not None:
                material = self.scene.add_material(Material(name=f"{name} {number}", metallic=0, roughness=0.5))
                self.add_texture(material, "base_color", image, True)
            self.add_instance(handle, material, np.eye(4), f"{name} {number}")


def from_open3d(*meshes: Any, up: str = "y") -> Scene:
    """Converts open3d.geometry.TriangleMesh objects.

    up: the axis that points up in the meshes, "y" or "z"

    Normals, vertex colors (sRGB) and textures are converted; meshes without normals are flat."""
    builder = _Open3d(up)
    for number, mesh in enumerate(meshes):
        if not hasattr(mesh, "triangles") or not hasattr(mesh, "has_triangle_uvs"):
            raise UsageError(f"from_open3d requires open3d.geometry.TriangleMesh objects, not {type(mesh).__name__}")
        builder.add(mesh, f"mesh {number}")
    return builder.scene
