"""Scenes from trimesh."""

import json
import zipfile

import numpy as np
import pytest

import latelight
from model_checks import OCTAHEDRON, assert_bounds, has_radial_normals, only_material

trimesh = pytest.importorskip("trimesh")


def test_trimesh_scenes_keep_their_nodes():
    source = trimesh.Scene()
    transform = np.eye(4)
    transform[:3, 3] = (5, 0, 1)
    source.add_geometry(trimesh.creation.box((1, 2, 3)), node_name="crate", transform=transform)
    source.add_geometry(trimesh.creation.icosphere(subdivisions=1), node_name="a/ball")
    scene = latelight.from_trimesh(source, up="z")
    assert [node.path for node in scene.nodes] == ["/crate", "/a_ball"]
    assert scene.triangle_count == sum(len(mesh.faces) for mesh in source.geometry.values())
    (low, high) = source.bounds
    assert_bounds(scene, (low[0], low[2], -high[1]), (high[0], high[2], -low[1]))  # Z up becomes Y up
    assert_bounds(latelight.from_trimesh(source), low, high)


@pytest.mark.parametrize("unit, meters", [("mm", 1e-3), ("inch", 0.0254), ("0.01 * meters", 0.01), ("m", 1), (None, 1)])
def test_trimesh_units_become_meters(unit, meters):
    """Also the distances between nodes. Meshes without a unit are in meters."""
    source, transform = trimesh.Scene(), np.eye(4)
    transform[:3, 3] = (10, 0, 0)
    crate = trimesh.creation.box((1, 2, 4))
    if unit:
        crate.units = unit
    source.add_geometry(crate, node_name="near")
    source.graph.update("far", matrix=transform, geometry="geometry_0")
    for up, (x, y, z) in (("y", (1, 2, 4)), ("z", (1, 4, 2))):
        half = np.array((x, y, z)) * meters / 2
        assert_bounds(latelight.from_trimesh(crate, up=up), -half, half)
        assert_bounds(latelight.from_trimesh(source, up=up), -half, half + (10 * meters, 0, 0))


def test_trimesh_reads_units_of_3mf(tmp_path):
    """3MF Core Specification 1.3, 3.4: the default unit is the millimeter."""
    pytest.importorskip("lxml", reason="trimesh requires lxml for 3MF files")
    corners = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in ((0, 0, 0), (100, 0, 0), (0, 200, 0), (0, 0, 300)))
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)))
    for unit, meters in (("", 1e-3), ('unit="centimeter"', 1e-2)):
        with zipfile.ZipFile(tmp_path / "part.3mf", "w") as archive:
            archive.writestr("3D/3dmodel.model", f'''<?xml version="1.0"?><model {unit}
                xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">
                <mesh><vertices>{corners}</vertices><triangles>{faces}</triangles></mesh></object></resources>
                <build><item objectid="1"/></build></model>''')
        scene = latelight.from_trimesh(trimesh.load(tmp_path / "part.3mf"), up="z")
        assert_bounds(scene, (0, 0, -200 * meters), (100 * meters, 300 * meters, 0))


def test_trimesh_warns_of_units_that_it_cannot_convert():
    crates = {name: trimesh.creation.box((2, 2, 2)) for name in ("a", "b")}
    crates["a"].units = "furlong"
    with pytest.warns(UserWarning, match="does not know the unit of the model: lengths in furlong are not converted"):
        assert_bounds(latelight.from_trimesh(crates["a"]), (-1, -1, -1), (1, 1, 1))
    crates["a"].units = "mm"
    with pytest.warns(UserWarning, match="different units: lengths in mm or no unit are not converted"):
        assert_bounds(latelight.from_trimesh(trimesh.Scene(crates)), (-1, -1, -1), (1, 1, 1))
    crates["b"].units = "inch"
    with pytest.warns(UserWarning, match="different units: lengths in inch, mm are not converted"):
        assert_bounds(latelight.from_trimesh(trimesh.Scene(crates)), (-1, -1, -1), (1, 1, 1))
    crates["b"].units = "millimeters"
    assert_bounds(latelight.from_trimesh(trimesh.Scene(crates)), (-1e-3,) * 3, (1e-3,) * 3)


@pytest.mark.parametrize("ending", ["glb", "obj", "ply"])
def test_trimesh_normals_are_those_of_files(tmp_path, ending):
    """Flat normals are the default of files without normals only."""
    vertices, faces = OCTAHEDRON
    for name, normals in (("smooth", vertices), ("flat", None)):
        trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False).export(tmp_path / f"{name}.{ending}")
        expected = name == "smooth"
        for process in (True, False):
            for smooth in (None, True, False):
                model = trimesh.load(tmp_path / f"{name}.{ending}", process=process)
                scene = latelight.from_trimesh(model, smooth=smooth)
                assert has_radial_normals(scene) == (expected if smooth is None else smooth)


def test_trimesh_normals_may_be_damaged():
    """Zeros and values that are not finite become the normals of the triangles, as in files that Latelight reads."""
    vertices, faces = TRIANGLE
    mesh = trimesh.Trimesh(vertices, faces, vertex_normals=[[0, 0, 0], [np.nan, 0, 1], [0, 1, 0]], process=False)
    scene = latelight.from_trimesh(mesh)
    np.testing.assert_allclose(scene.mesh_arrays(scene.meshes()[0])["normals"], [[0, 0, 1], [0, 0, 1], [0, 1, 0]])


def test_trimesh_colors_are_decoded():
    mesh = trimesh.creation.box((1, 1, 1))
    mesh.visual.face_colors = np.tile([255, 188, 0, 255], (12, 1))
    scene = latelight.from_trimesh(mesh)
    arrays = scene.mesh_arrays(scene.meshes()[0])
    np.testing.assert_allclose(arrays["colors"][0], (1, 0.50289, 0, 1), atol=1e-4)  # IEC 61966-2-1
    assert scene.material(scene.materials()[0]).base_color == (1, 1, 1, 1)


@pytest.mark.parametrize("kind, scale", [(np.float32, 1), (np.uint8, 255), (np.uint16, 65535)])
@pytest.mark.parametrize("has_uv", [True, False])
def test_trimesh_colors_of_gltf_multiply_the_material(tmp_path, kind, scale, has_uv):
    """glTF 2.0, 3.9.2: COLOR_0 is linear, and a factor of the base color. Integers are normalized."""
    colors = (np.array([[1, 0, 0, 1], [0, 1, 0.2, 1], [0.4, 0, 1, 0.6]]) * scale).astype(kind)
    arrays = [np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), colors, np.float32([[0, 0], [1, 0], [0, 1]])]
    offsets = np.cumsum([0] + [array.nbytes for array in arrays])
    attributes = {"POSITION": 0, "COLOR_0": 1, **({"TEXCOORD_0": 2} if has_uv else {})}
    types = {np.float32: 5126, np.uint8: 5121, np.uint16: 5123}
    accessors = [{"bufferView": i, "componentType": types[array.dtype.type], "count": 3, "type": f"VEC{array.shape[1]}",
                  "normalized": array.dtype != np.float32} for i, array in enumerate(arrays)]
    accessors[0] |= {"min": [0, 0, 0], "max": [1, 1, 0]}
    (tmp_path / "paint.bin").write_bytes(b"".join(array.tobytes() for array in arrays))
    (tmp_path / "paint.gltf").write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.2, 1, 1, 1], "metallicFactor": 0.25}}],
        "meshes": [{"primitives": [{"attributes": attributes, "material": 0}]}], "accessors": accessors,
        "bufferViews": [{"buffer": 0, "byteOffset": int(start), "byteLength": array.nbytes}
                        for start, array in zip(offsets, arrays)],
        "buffers": [{"uri": "paint.bin", "byteLength": int(offsets[-1])}]}))
    for scene in (latelight.from_trimesh(trimesh.load(tmp_path / "paint.gltf")), latelight.Scene(tmp_path / "paint.gltf")):
        made = scene.mesh_arrays(scene.meshes()[0])
        np.testing.assert_allclose(made["colors"], colors / scale, atol=1 / 255)
        _, material = only_material(scene)
        np.testing.assert_allclose((material.metallic, *material.base_color), (0.25, 0.2, 1, 1, 1), atol=1e-6)


def test_trimesh_opacity_of_simple_materials_is_blended():
    kinds = trimesh.visual.material
    square = trimesh.Trimesh(*TRIANGLE, process=False)
    for alpha, source, mode in (
        (100, kinds.SimpleMaterial(diffuse=[128, 64, 32, 100]), "blend"),
        (255, kinds.SimpleMaterial(diffuse=[128, 64, 32, 255]), "opaque"),
        (100, kinds.PBRMaterial(baseColorFactor=[128, 64, 32, 100]), "opaque"),  # glTF's default
    ):
        square.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1]], material=source)
        _, made = only_material(latelight.from_trimesh(square))
        assert made.alpha_mode == mode
        np.testing.assert_allclose(made.base_color[3], alpha / 255, rtol=1e-5)


def test_trimesh_materials_have_their_textures():
    image = pytest.importorskip("PIL.Image").fromarray(np.full((2, 4, 3), 200, np.uint8))
    material = trimesh.visual.material.PBRMaterial(
        name="paint", baseColorTexture=image, metallicFactor=0.25, roughnessFactor=0.75, alphaMode="MASK", alphaCutoff=0.3
    )
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]], process=False)
    square.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 0.25]], material=material)
    scene = latelight.from_trimesh(square)
    made = scene.material(scene.materials()[0])
    assert (made.name, made.metallic, made.roughness, made.alpha_mode) == ("paint", 0.25, 0.75, "mask")
    texture = scene.texture(scene.texture_of(scene.materials()[0], "base_color"))
    assert (texture.width, texture.height, texture.srgb) == (4, 2, True)
    np.testing.assert_allclose(scene.mesh_arrays(scene.meshes()[0])["uv"], [[0, 1], [1, 1], [1, 0.75]])


@pytest.mark.parametrize("mode", ["I;16", "I;16B", "I"])
def test_trimesh_images_may_have_16_bits(mode):
    """65535 is white, as 255 is in 8 bits, so values are divided by 257 and rounded."""
    image = pytest.importorskip("PIL.Image")
    values = [[0, 128, 129, 257], [120 * 257, 4096, 65534, 65535]]
    types = {"I;16": "<u2", "I;16B": ">u2", "I": "<i4"}
    deep = image.frombytes(mode, (4, 2), np.array(values, types[mode]).tobytes())
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]], process=False)
    paint = trimesh.visual.material.PBRMaterial(baseColorTexture=deep)
    square.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1]], material=paint)
    scene = latelight.from_trimesh(square)
    pixels = scene.texture_pixels(scene.textures()[0])
    assert pixels[..., 0].tolist() == [[0, 0, 1, 1], [120, 16, 255, 255]]
    assert (pixels[..., :3] == pixels[..., :1]).all() and (pixels[..., 3] == 255).all()


def test_trimesh_materials_have_the_defaults_of_gltf(tmp_path):
    """metallicFactor is 1 and emissiveFactor 0 by default (glTF 2.0, 5.19 and 5.22). Simple materials are not metals."""
    image = pytest.importorskip("PIL.Image").fromarray(np.full((2, 2, 3), 200, np.uint8))
    kinds = trimesh.visual.material
    gold = kinds.PBRMaterial(name="gold", baseColorFactor=[255, 200, 0, 255], emissiveTexture=image)
    simple = kinds.SimpleMaterial(diffuse=[255, 0, 0, 255])
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]], process=False)

    def made(material):
        square.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1]], material=material)
        return only_material(latelight.from_trimesh(square))[1]

    for material, metallic in ((gold, 1), (kinds.MultiMaterial([simple, gold]), 1), (simple, 0)):
        values = made(material)
        assert (values.metallic, tuple(values.emissive)) == (metallic, (0, 0, 0)), material
    made(gold)
    square.export(tmp_path / "gold.glb")
    expected = only_material(latelight.Scene(tmp_path / "gold.glb"))[1]
    assert (expected.metallic, tuple(expected.emissive)) == (1, (0, 0, 0))


TRIANGLE = [[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2]]


def test_trimesh_materials_require_no_texture_coordinates(tmp_path):
    """Colors and factors apply to meshes without texture coordinates, but textures do not."""
    kinds = trimesh.visual.material
    image = pytest.importorskip("PIL.Image").fromarray(np.full((2, 2, 3), 200, np.uint8))
    paint = kinds.PBRMaterial(
        name="paint", baseColorFactor=[255, 0, 0, 255], metallicFactor=0.25, baseColorTexture=image
    )
    plain, textured = trimesh.creation.box(), trimesh.Trimesh(*TRIANGLE, process=False)
    plain.visual = trimesh.visual.TextureVisuals(material=paint)
    textured.visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1]], material=paint)
    scene = latelight.from_trimesh(trimesh.Scene({"plain": plain, "textured": textured}))
    for name, has_texture in (("/plain", False), ("/textured", True)):
        handle = scene.instance(scene.instances(name)[0]).material
        made = scene.material(handle)
        assert (made.name, tuple(made.base_color), made.metallic) == ("paint", (1, 0, 0, 1), 0.25)
        assert (scene.texture_of(handle, "base_color") is not None) == has_texture
    plain.visual = trimesh.visual.TextureVisuals(material=kinds.SimpleMaterial(diffuse=[0, 255, 0, 255]))
    _, made = only_material(latelight.from_trimesh(plain))
    assert (tuple(made.base_color), made.metallic) == ((0, 1, 0, 1), 0)


def test_models_of_other_types_are_refused():
    with pytest.raises(latelight.UsageError, match="from_trimesh requires"):
        latelight.from_trimesh(3)
    with pytest.raises(latelight.UsageError, match='"y" or "z"'):
        latelight.from_trimesh(trimesh.creation.box(), up="x")
    with pytest.raises(latelight.UsageError, match="from_open3d requires"):
        latelight.from_open3d("mesh")
