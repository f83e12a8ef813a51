"""Scenes from Open3D's triangle meshes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._core import Material, Scene
from ._model_builder import Builder, linear, v_down
from .errors import UsageError


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
        images = [np.atleast_3d(np.asarray(image)) for image in mesh.textures]  # grayscale images are (H, W)
        images = [image for image in images if image.size]
        if not mesh.has_triangle_uvs() or not images:
            handle = self.scene.add_mesh(positions, indices=indices, normals=normals, colors=colors, name=name)
            self.add_instance(handle, self.default_material() if colors is None else self.white(False), np.eye(4), name)
            return
        self._add_textured(positions, indices, normals, colors, mesh, images, name)

    def _add_textured(
        self, positions: Any, indices: Any, normals: Any, colors: Any, mesh: Any, images: list[Any], name: str
    ) -> None:
        """Texture coordinates belong to corners, and each triangle has one of the textures."""
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
                uv=v_down(uv[ids == number].reshape(-1, 2)),
                name=f"{name} {number}",
            )
            material = self.scene.add_material(Material(name=f"{name} {number}", metallic=0, roughness=0.5))
            self.add_texture(material, "base_color", images[min(int(number), len(images) - 1)], True)
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
