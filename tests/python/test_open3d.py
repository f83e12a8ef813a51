"""Scenes from Open3D, which is too large to be installed for every test."""

import numpy as np
import pytest

import latelight
from model_checks import assert_bounds


def test_open3d_textures_may_be_grayscale():
    class Mesh:
        """The part of open3d.geometry.TriangleMesh that from_open3d reads."""

        vertices, triangles, triangle_uvs = np.eye(3), [[0, 1, 2]], [[0, 0], [1, 0], [1, 1]]
        textures = [np.array([[10, 200, 30]], np.uint8)]

        def has_vertex_colors(self):
            return False

        def has_triangle_uvs(self):
            return True

        has_vertex_normals = has_triangle_material_ids = has_vertex_colors

    scene = latelight.from_open3d(Mesh())
    pixels = scene.texture_pixels(scene.textures()[0])
    np.testing.assert_array_equal(pixels[0], [[10, 10, 10, 255], [200, 200, 200, 255], [30, 30, 30, 255]])


class EmptyImage:
    """As open3d.geometry.Image without pixels: NumPy sees an object without dimensions."""


def test_open3d_textures_are_upright_and_belong_to_their_materials(device):
    """As Open3D reads an OBJ file of two textured materials, the left one red above green, and one without a texture:
    assimp's unused default material is first, and rows of images are from the bottom."""
    pixels = np.zeros((2, 8, 8, 3), np.uint8)
    pixels[0, :4], pixels[0, 4:] = (0, 255, 0), (255, 0, 0)  # v = 0 is green
    pixels[1] = 0, 0, 255

    class Mesh:
        """The part of open3d.geometry.TriangleMesh that from_open3d reads: three unit squares in a row."""

        vertices = [[x, y, 0] for x in range(4) for y in range(2)]
        triangles = [[2 * x + c for c in corners] for x in range(3) for corners in ((0, 2, 3), (0, 3, 1))]
        triangle_uvs = [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]] * 3
        triangle_material_ids = [1, 1, 2, 2, 3, 3]
        textures = [EmptyImage(), pixels[0], pixels[1], EmptyImage()]

        def has_vertex_colors(self):
            return False

        def has_triangle_uvs(self):
            return True

        has_vertex_normals, has_triangle_material_ids = has_vertex_colors, has_triangle_uvs

    scene = latelight.from_open3d(Mesh())
    camera = latelight.Camera.look_at((1.5, 0.5, 4), (1.5, 0.5, 0), vertical_fov=2 * np.degrees(np.arctan(0.5 / 4)))
    albedo = latelight.Renderer(scene, device).render(camera, (36, 12), "albedo", shadows="none")["albedo"]
    for row, column, color in ((1, 6, (1, 0, 0)), (10, 6, (0, 1, 0)), (1, 18, (0, 0, 1)), (1, 30, (0.8, 0.8, 0.8))):
        np.testing.assert_allclose(albedo[row, column, :3], color, atol=0.01, err_msg=f"{row} {column}")


def test_open3d_meshes_have_colors_and_textures(tmp_path):
    o3d = pytest.importorskip("open3d", reason="Open3D is too large to be installed for every test")
    image = pytest.importorskip("PIL.Image")
    box = o3d.geometry.TriangleMesh.create_box(1, 2, 3)
    box.paint_uniform_color((1, 0.5, 0))
    scene = latelight.from_open3d(box, up="z")
    assert_bounds(scene, (0, 0, -2), (1, 3, 0))
    np.testing.assert_allclose(scene.mesh_arrays(scene.meshes()[0])["colors"][0], (1, 0.21404, 0, 1), atol=1e-4)
    triangle = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector([[0, 0, 0], [1, 0, 0], [1, 1, 0]]), o3d.utility.Vector3iVector([[0, 1, 2]])
    )
    triangle.triangle_uvs = o3d.utility.Vector2dVector([[0, 0], [1, 0], [1, 0.25]])
    triangle.textures = [o3d.geometry.Image(np.full((2, 4, 3), 200, np.uint8))]
    triangle.triangle_material_ids = o3d.utility.IntVector([0])
    scene = latelight.from_open3d(triangle)
    np.testing.assert_allclose(scene.mesh_arrays(scene.meshes()[0])["uv"], [[0, 0], [1, 0], [1, 0.25]])
    assert scene.texture(scene.textures()[0]).width == 4
    (tmp_path / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
        "usemtl photo\nf 1/1 2/2 3/3\nusemtl plain\nf 1/1 3/3 2/2\n"
    )
    (tmp_path / "a.mtl").write_text("newmtl photo\nmap_Kd a.png\nnewmtl plain\nKd 1 1 1\n")
    image.fromarray(np.array([[[255, 0, 0]], [[0, 255, 0]]], np.uint8)).save(tmp_path / "a.png")
    scene = latelight.from_open3d(o3d.io.read_triangle_mesh(str(tmp_path / "a.obj")))
    (photo,) = scene.textures()
    np.testing.assert_array_equal(scene.texture_pixels(photo)[:, 0, :3], [[0, 255, 0], [255, 0, 0]])
    textured = [scene.texture_of(scene.instance(i).material, "base_color") for i in scene.instances()]
    assert textured == [photo, None]
