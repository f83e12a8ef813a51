"""Scenes from trimesh, yourdfpy, usd-core and Open3D. Open3D is too large to be installed for every test."""

import json
import pathlib
import re
import sys
import warnings
import zipfile

import numpy as np
import pytest

import latelight

trimesh = pytest.importorskip("trimesh")

URDF = """<robot name="crane">
<link name="base"><visual><geometry><box size="1 2 0.5"/></geometry></visual></link>
<link name="arm">
  <visual><origin xyz="0 0 1"/><geometry><box size="0.25 0.25 2"/></geometry></visual>
  <visual><origin xyz="0 0 2.25"/><geometry><box size="0.5 0.5 0.5"/></geometry></visual>
</link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.25"/>
<axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def assert_bounds(scene, low, high):
    np.testing.assert_allclose(scene.bounds, (low, high), atol=1e-6)


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


OCTAHEDRON = (np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float),
              [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def has_radial_normals(scene):
    """Of an octahedron around the origin with smooth normals, in contrast to (1, 1, 1) / sqrt(3) of its faces."""
    arrays = scene.mesh_arrays(scene.meshes()[0])
    radial = arrays["positions"] / np.linalg.norm(arrays["positions"], axis=1, keepdims=True)
    cosines = (radial * arrays["normals"]).sum(axis=1)
    assert np.allclose(cosines, 1, atol=1e-5) or np.allclose(cosines, 3**-0.5, atol=1e-5)
    return bool(np.allclose(cosines, 1, atol=1e-5))


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


def test_robots_have_the_normals_of_their_meshes(tmp_path):
    pytest.importorskip("yourdfpy")
    vertices, faces = OCTAHEDRON
    trimesh.Trimesh(vertices, faces, vertex_normals=vertices, process=False).export(tmp_path / "smooth.glb")
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "flat.glb")
    for name, expected in (("smooth", True), ("flat", False)):
        path = tmp_path / "robot.urdf"
        link = f'<link name="base"><visual><geometry><mesh filename="{name}.glb"/></geometry></visual></link>'
        path.write_text(f'<robot name="robot">{link}</robot>')
        assert has_radial_normals(latelight.from_urdf(path)) == expected
        assert has_radial_normals(latelight.Scene(path)) == expected
        for smooth in (True, False):
            assert has_radial_normals(latelight.from_urdf(path, smooth=smooth)) == smooth


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


def test_robots_have_the_materials_of_meshes_without_texture_coordinates(tmp_path):
    pytest.importorskip("yourdfpy")
    (tmp_path / "red.mtl").write_text("newmtl red\nKd 1 0 0\n")
    (tmp_path / "red.obj").write_text("mtllib red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
    path = tmp_path / "robot.urdf"
    link = '<link name="base"><visual><geometry><mesh filename="red.obj"/></geometry></visual></link>'
    path.write_text(f'<robot name="robot">{link}</robot>')
    _, made = only_material(latelight.from_urdf(path))
    assert (tuple(made.base_color), made.metallic) == ((1, 0, 0, 1), 0)


def test_robots_move_their_joints(tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    path = tmp_path / "crane.urdf"
    path.write_text(URDF)
    scene = latelight.from_urdf(path)
    arm = "/base/shoulder/arm"
    nodes = ["/base", "/base/visual", "/base/shoulder", arm, f"{arm}/visual 0", f"{arm}/visual 1"]
    assert [node.path for node in scene.nodes] == nodes
    assert_bounds(scene, (-0.5, -0.25, -1), (0.5, 2.75, 1))  # 2.5 m above the shoulder, which is at 0.25 m
    robot = yourdfpy.URDF.load(str(path))
    posed = latelight.from_urdf(robot, {"shoulder": np.pi / 2})
    assert_bounds(posed, (-0.5, -0.25, -1), (0.5, 0.5, 2.5))  # the arm points along -Y, which is +Z with Y up
    latelight.pose_urdf(posed, robot, [0])
    assert_bounds(posed, (-0.5, -0.25, -1), (0.5, 2.75, 1))
    with pytest.raises(latelight.UsageError, match='no joint "elbow": its joints are shoulder'):
        latelight.pose_urdf(posed, robot, {"elbow": 1})
    with pytest.raises(latelight.UsageError, match='has no node "/base/shoulder"'):
        latelight.pose_urdf(latelight.Scene("builtin:boxes"), robot, [0])
    with pytest.raises(latelight.UsageError, match="give a position for each of the 1 joints: shoulder"):
        latelight.pose_urdf(posed, robot, [0, 1])
    with pytest.raises(latelight.UsageError, match="positions of joints must be numbers, not 'up'"):
        latelight.pose_urdf(posed, robot, {"shoulder": "up"})
    with pytest.raises(latelight.UsageError, match="requires the yourdfpy.URDF that the scene was made from, not "):
        latelight.pose_urdf(posed, str(path), [0])
    for convert in (latelight.from_urdf, latelight.Scene):
        with pytest.raises(latelight.InputError, match="missing.urdf does not exist"):
            convert(tmp_path / "missing.urdf")


# A tree of joints of each type: a mimicking joint, a turned axis, a link without geometry, and names with slashes.
TREE = """<robot name="tree">
<link name="base"><visual><origin xyz="0.1 0 0.2" rpy="0.3 0 0"/><geometry><box size="1 0.5 0.25"/></geometry></visual></link>
<link name="turret"/><link name="left/finger"><visual><geometry><sphere radius="0.2"/></geometry></visual></link>
<link name="right/finger"><visual><geometry><cylinder radius="0.1" length="0.4"/></geometry></visual></link>
<link name="slider"><visual><origin rpy="0 0.5 0.1"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
<visual><origin xyz="0 0.4 0"/><geometry><box size="0.3 0.2 0.1"/></geometry></visual></link>
<link name="wheel"><visual><geometry><cylinder radius="0.3" length="0.1"/></geometry></visual></link>
<link name="drone"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
<link name="puck"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
<joint name="yaw" type="revolute"><parent link="base"/><child link="turret"/><origin xyz="0 0.2 0.5" rpy="0.1 0.2 0.3"/>
<axis xyz="0 0.6 0.8"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="grip/left" type="prismatic"><parent link="turret"/><child link="left/finger"/><origin xyz="0.5 0 0"/>
<axis xyz="0 1 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
<joint name="grip/right" type="prismatic"><parent link="turret"/><child link="right/finger"/><origin xyz="0.5 0 0"/>
<axis xyz="0 -1 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/><mimic joint="grip/left" multiplier="0.5" offset="0.1"/></joint>
<joint name="mount" type="fixed"><parent link="turret"/><child link="slider"/><origin xyz="0 0 0.7" rpy="0 0 1"/></joint>
<joint name="spin" type="continuous"><parent link="slider"/><child link="wheel"/><origin xyz="0.2 0 0" rpy="1.5 0 0"/>
<axis xyz="0 0 1"/></joint>
<joint name="fly" type="floating"><parent link="base"/><child link="drone"/><origin xyz="-1 0 1" rpy="0 0 0.4"/></joint>
<joint name="glide" type="planar"><parent link="base"/><child link="puck"/><origin xyz="0 -1 0"/><axis xyz="0 0 1"/></joint>
</robot>"""
Z_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])  # from URDF's frame to glTF's


def assert_links_are_where_yourdfpy_has_them(scene, robot):
    by_path = {node.path: np.asarray(node.transform) for node in scene.nodes}
    by_name = {path.rpartition("/")[2]: transform for path, transform in by_path.items()}
    for link in robot.link_map:
        expected = Z_UP @ robot.get_transform(link)
        np.testing.assert_allclose(by_name[link.replace("/", "_")], expected, atol=1e-6, err_msg=link)
    for joint in robot.joint_map.values():  # a joint's node is where its child link is
        expected = Z_UP @ robot.get_transform(joint.child)
        np.testing.assert_allclose(by_name[joint.name.replace("/", "_")], expected, atol=1e-6, err_msg=joint.name)
    assert_geometry_is_where_yourdfpy_has_it(scene, robot.scene)


def assert_geometry_is_where_yourdfpy_has_it(scene, shown):
    instances = sum(len(scene.instances(node.path)) for node in scene.nodes)
    assert instances == len(shown.graph.nodes_geometry)
    boxes = []
    for name in shown.graph.nodes_geometry:
        transform, geometry = shown.graph[name]
        points = shown.geometry[geometry].vertices @ transform[:3, :3].T + transform[:3, 3]
        boxes.append((points @ Z_UP[:3, :3].T).min(0).tolist() + (points @ Z_UP[:3, :3].T).max(0).tolist())
    found = []
    for instance in map(scene.instance, scene.instances()):
        transform = np.asarray(instance.transform)
        points = scene.mesh_arrays(instance.mesh)["positions"] @ transform[:3, :3].T + transform[:3, 3]
        found.append(points.min(0).tolist() + points.max(0).tolist())
    np.testing.assert_allclose(sorted(found), sorted(boxes), atol=1e-6)


def random_configuration(robot, random):
    joints = [robot.joint_map[name] for name in robot.actuated_joint_names]
    bounded = [joint for joint in joints if joint.type in ("revolute", "prismatic")]
    values = {joint.name: random.uniform(joint.limit.lower, joint.limit.upper) for joint in bounded}
    return values | {joint.name: random.uniform(-9, 9) for joint in joints if joint.type == "continuous"}


def test_joints_move_all_links_below_them(tmp_path):
    """The forward kinematics of yourdfpy, in random configurations."""
    yourdfpy = pytest.importorskip("yourdfpy")
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = yourdfpy.URDF.load(str(tmp_path / "tree.urdf"))
    scene = latelight.from_urdf(robot)
    assert_links_are_where_yourdfpy_has_them(scene, robot)
    random = np.random.default_rng(5)
    for _ in range(8):
        configuration = random_configuration(robot, random)
        latelight.pose_urdf(scene, robot, configuration)
        assert_links_are_where_yourdfpy_has_them(scene, robot)
        assert_links_are_where_yourdfpy_has_them(latelight.from_urdf(robot), robot)
    parents = {node.path: node.parent for node in scene.nodes}
    wheel = "/base/yaw/turret/mount/slider/spin/wheel"
    assert parents[wheel] == wheel[: -len("/wheel")] and parents["/base"] == ""


def test_names_of_joints_that_become_equal_are_numbered(tmp_path):
    pytest.importorskip("yourdfpy")
    names = ["a_b", "a_b 2", "a/b", "a/b 2"]
    links = [f'<link name="l{i}"/>' for i in range(len(names))]
    joints = [
        f'<joint name="{name}" type="fixed"><parent link="base"/><child link="l{i}"/></joint>'
        for i, name in enumerate(names)
    ]
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="base"/>{"".join(links + joints)}</robot>')
    paths = [node.path for node in latelight.from_urdf(tmp_path / "r.urdf").nodes if node.path.count("/") == 2]
    assert paths == ["/base/a_b", "/base/a_b 2", "/base/a_b 3", "/base/a_b 2 2"]


@pytest.mark.parametrize("kind", ["visual", "collision"])
@pytest.mark.parametrize("shapes", [1, 2])
def test_joints_named_as_geometry_are_posed(tmp_path, kind, shapes):
    """Joints that are called as the nodes of geometry keep their names, and move what is below them."""
    yourdfpy = pytest.importorskip("yourdfpy")
    shape = '<{0}><origin xyz="0 {1} 0"/><geometry><box size="1 0.5 0.25"/></geometry></{0}>'
    geometry = "".join(shape.format(name, i) for name in ("visual", "collision") for i in range(shapes))
    joint = (
        '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="0 0 2"/><axis xyz="0 1 0"/>'
        '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
    )
    names = [kind, f"{kind} 0", f"{kind} 1", f"{kind} 2"]
    links = [f'<link name="{name}">{geometry}</link>' for name in ("base", *"abcd", "hand", "thumb")]
    joints = [joint.format(name, "base", link) for name, link in zip(names, "abcd")]
    joints += [joint.format("wrist", "a", "hand"), joint.format("knuckle", "hand", "thumb")]
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{"".join(links + joints)}</robot>')
    collisions = dict(build_collision_scene_graph=True, load_collision_meshes=True, force_collision_mesh=False)
    robot = yourdfpy.URDF.load(str(tmp_path / "r.urdf"), **collisions)
    scene = latelight.from_urdf(robot, geometry=kind)
    random = np.random.default_rng(9)
    for _ in range(3):
        configuration = {name: random.uniform(-3, 3) for name in robot.actuated_joint_names}
        latelight.pose_urdf(scene, robot, configuration, geometry=kind)
        assert_geometry_is_where_yourdfpy_has_it(scene, robot.scene if kind == "visual" else robot.collision_scene)
    paths = [node.path for node in scene.nodes]
    assert {f"/base/{name}/{link}" for name, link in zip(names, "abcd")} <= set(paths)
    assert f"/base/{kind}/a/wrist/hand/knuckle/thumb" in paths and not any("#" in path for path in paths)


def test_one_joint_is_moved_by_its_node(tmp_path):
    """As robots' forward kinematics: a joint's node moves the links below it, and no others."""
    yourdfpy = pytest.importorskip("yourdfpy")
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = yourdfpy.URDF.load(str(tmp_path / "tree.urdf"))
    scene = latelight.from_urdf(robot)
    robot.update_cfg({"yaw": 0.8})
    scene.set_node_transform("/base/yaw", robot.get_transform("turret", "base"))
    assert_links_are_where_yourdfpy_has_them(scene, robot)
    scene.add_camera(latelight.Camera(), node="/base/fly/drone")
    half = np.array([0, 0, np.sin(0.35), np.cos(0.35)])  # 0.7 rad about Z, at the origin of the joint "fly"
    turn = latelight.AnimationChannel(node="/base/fly", property="rotation", times=[0, 1], values=[[0, 0, 0, 1], half])
    scene.add_animation("fly", [turn])
    drone = np.array([[np.cos(0.7), -np.sin(0.7), 0, -1], [np.sin(0.7), np.cos(0.7), 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]])
    expected = Z_UP @ drone @ np.diag([1, -1, -1, 1])  # from OpenCV's camera frame
    np.testing.assert_allclose(scene.cameras_at(1)[-1].camera_to_world, expected, atol=1e-6)


def test_exported_robots_keep_their_joints(tmp_path):
    """trimesh reads the nodes of the exported file, and moves the wheel by the node of a joint above it."""
    yourdfpy = pytest.importorskip("yourdfpy")
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = yourdfpy.URDF.load(str(tmp_path / "tree.urdf"))
    scene = latelight.from_urdf(robot, {"yaw": -0.9, "grip/left": 0.2, "spin": 2})
    scene.export(tmp_path / "tree.glb")
    graph = trimesh.load(tmp_path / "tree.glb").graph
    for link in robot.link_map:
        expected = Z_UP @ robot.get_transform(link)
        np.testing.assert_allclose(graph.get(link.replace("/", "_"))[0], expected, atol=1e-6, err_msg=link)
    for node in scene.nodes:
        if node.parent:
            name, parent = (path.rpartition("/")[2] for path in (node.path, node.parent))
            assert graph.transforms.parents[name] == parent or name.startswith("visual")
    robot.update_cfg({"yaw": 1.1})
    graph.update("yaw", frame_from="base", matrix=robot.get_transform("turret", "base"))
    np.testing.assert_allclose(graph.get("wheel")[0], Z_UP @ robot.get_transform("wheel"), atol=1e-6)
    exported = latelight.Scene(tmp_path / "tree.glb")  # has the same paths and ids
    ids = {node.path: node.id for node in scene.nodes}
    assert {node.path: node.id for node in exported.nodes} == ids
    latelight.pose_urdf(exported, robot, {"yaw": 0.3, "grip/left": 0.1, "spin": -1})
    assert_links_are_where_yourdfpy_has_them(exported, robot)


def test_robots_of_too_many_nested_links_are_refused(tmp_path, monkeypatch):
    pytest.importorskip("yourdfpy")
    monkeypatch.setattr("latelight._from_urdf.MAX_PATH_BYTES", 5000)
    links = [f'<link name="l{i}"/>' for i in range(40)]
    joints = [
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>' for i in range(39)
    ]
    (tmp_path / "chain.urdf").write_text(f'<robot name="r">{"".join(links[:20] + joints[:19])}</robot>')
    assert len(latelight.from_urdf(tmp_path / "chain.urdf").nodes) == 39
    (tmp_path / "chain.urdf").write_text(f'<robot name="r">{"".join(links + joints)}</robot>')
    with pytest.raises(latelight.InputError, match="chain.urdf: its links are nested too deeply"):
        latelight.from_urdf(tmp_path / "chain.urdf")


def test_the_page_of_robots(tmp_path, monkeypatch):
    yourdfpy = pytest.importorskip("yourdfpy")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(URDF)
    page = (pathlib.Path(__file__).parents[2] / "docs" / "scene-files.md").read_text()
    (block,) = [text for text in re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE) if '"nod"' in text]
    names = {"latelight": latelight, "np": np, "yourdfpy": yourdfpy}
    exec(compile(block, "scene-files.md", "exec"), names)
    exported = latelight.Scene("robot.glb", id_nodes=["base", "arm"])
    assert [animation.name for animation in exported.animations] == ["nod"]
    assert len({node.id for node in exported.nodes}) == 2


def test_robots_show_collisions_if_required(tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    both, bare = tmp_path / "both.urdf", tmp_path / "bare.urdf"
    shape = '<{kind}><geometry><box size="{size}"/></geometry></{kind}>'
    links = [shape.format(kind="visual", size="1 2 3"), shape.format(kind="collision", size="4 4 4")]
    both.write_text(f'<robot name="r"><link name="base">{links[0]}{links[1]}</link></robot>')
    bare.write_text(f'<robot name="r"><link name="base">{links[1]}</link></robot>')
    assert_bounds(latelight.from_urdf(both), (-0.5, -1.5, -1), (0.5, 1.5, 1))
    assert_bounds(latelight.from_urdf(both, geometry="collision"), (-2, -2, -2), (2, 2, 2))
    with pytest.warns(UserWarning, match="no visual geometry: its collision geometry is shown"):
        scene = latelight.from_urdf(bare)
    assert_bounds(scene, (-2, -2, -2), (2, 2, 2))
    assert [node.path for node in scene.nodes] == ["/base", "/base/collision"]
    with pytest.raises(latelight.UsageError, match="load it with build_collision_scene_graph=True"):
        latelight.from_urdf(yourdfpy.URDF.load(str(bare)))
    with pytest.raises(latelight.UsageError, match='geometry must be "visual" or "collision", not "all"'):
        latelight.from_urdf(both, geometry="all")


SUBPIXEL = 1 / 256  # to which the raster rounds vertices; docs/compute.md states the same bound for edges


def near_edges(scene, camera, size):
    """Whether the center of each pixel is within one subpixel of a projected edge of any triangle."""
    width, height = size
    focal = height / 2 / np.tan(np.radians(camera.vertical_fov) / 2)
    camera_from_world = np.linalg.inv(camera.camera_to_world)
    near = np.zeros((height, width), bool)
    for instance in map(scene.instance, scene.instances()):
        arrays = scene.mesh_arrays(instance.mesh)
        matrix = camera_from_world @ np.asarray(instance.transform)
        points = arrays["positions"].astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
        assert points[:, 2].min() > 0
        pixels = points[:, :2] / points[:, 2:] * focal + (width / 2, height / 2)
        triangles = pixels[arrays["indices"].reshape(-1, 3)]
        for begin, end in zip(triangles.reshape(-1, 2), np.roll(triangles, -1, axis=1).reshape(-1, 2)):
            low = np.maximum(np.floor(np.minimum(begin, end)).astype(int) - 1, 0)
            high = np.minimum(np.ceil(np.maximum(begin, end)).astype(int) + 1, size)
            x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
            along = end - begin
            t = np.clip(((x - begin[0]) * along[0] + (y - begin[1]) * along[1]) / max(along @ along, 1e-30), 0, 1)
            distance = np.hypot(begin[0] + t * along[0] - x, begin[1] + t * along[1] - y)
            near[low[1] : high[1], low[0] : high[0]] |= distance <= SUBPIXEL
    return near


def assert_seen_as_exported(scene, device, tmp_path):
    """Distances and ids of all pixels are those of rays through the exported file, except where the center of a pixel
    is so close to an edge that rounding vertices to subpixels decides which side it shows."""
    scene.export(tmp_path / "exported.glb")
    exported = latelight.Scene(tmp_path / "exported.glb")
    low, high = np.array(scene.bounds)
    camera = scene.look_at(high + 0.7 * np.linalg.norm(high - low), (low + high) / 2)
    width, height = 480, 320
    frame = latelight.Renderer(scene, device).render(camera, (width, height), ("distance", "id"))
    focal = height / 2 / np.tan(np.radians(camera.vertical_fov) / 2)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    pose = np.asarray(camera.camera_to_world)
    rays = np.stack([x / focal, y / focal, np.ones_like(x)], axis=-1).reshape(-1, 3) @ pose[:3, :3].T
    hits = latelight.Renderer(exported, device).cast(np.broadcast_to(pose[:3, 3], rays.shape), rays)
    ids, distances = (hits[name].reshape(height, width) for name in ("id", "distance"))
    assert len(np.unique(ids)) > 3
    near = near_edges(scene, camera, (width, height))
    assert near.mean() < 0.003
    np.testing.assert_array_equal(frame["id"][~near], ids[~near])
    np.testing.assert_allclose(frame["distance"][~near], distances[~near], rtol=1e-5)
    assert (frame["id"] == ids).mean() > 0.9998
    nodes = [node.path for node in scene.nodes]
    assert [node.path for node in exported.nodes][: len(nodes)] == nodes  # nodes of lights follow


def test_robots_are_seen_as_exported(tmp_path, device):
    pytest.importorskip("yourdfpy")
    (tmp_path / "crane.urdf").write_text(URDF)
    assert_seen_as_exported(latelight.from_urdf(tmp_path / "crane.urdf", {"shoulder": 0.7}), device, tmp_path)


@pytest.mark.parametrize("name", ["quadruped", "cartpole"])
def test_robots_of_newton_are_seen_as_exported(name, tmp_path, device):
    """Real robots, of boxes and cylinders. The geometry of the quadruped is that of its collisions."""
    pytest.importorskip("yourdfpy")
    newton = pytest.importorskip("newton")
    text = (pathlib.Path(newton.__file__).parent / "examples" / "assets" / f"{name}.urdf").read_text()
    if "<visual" not in text:
        text = text.replace("collision", "visual")
    (tmp_path / "robot.urdf").write_text(text)
    assert_seen_as_exported(latelight.from_urdf(tmp_path / "robot.urdf"), device, tmp_path)


def test_files_of_other_packages_are_scenes(tmp_path, monkeypatch):
    pytest.importorskip("yourdfpy")
    UsdGeom, Usd = pytest.importorskip("pxr.UsdGeom"), pytest.importorskip("pxr.Usd")
    (tmp_path / "crane.urdf").write_text(URDF)
    assert "/base/shoulder/arm/visual 1" in [node.path for node in latelight.Scene(tmp_path / "crane.urdf").nodes]
    stage = Usd.Stage.CreateNew(str(tmp_path / "cube.usda"))
    mesh = UsdGeom.Mesh.Define(stage, "/square")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    stage.Save()
    scene = latelight.Scene(tmp_path / "cube.usda")
    assert scene.triangle_count == 1 and latelight.Renderer(scene, "cpu").render(scene.default_camera(), (8, 8))
    with pytest.raises(latelight.UsageError, match="Scene\\(\\) has no options for '.*cube.usda': call latelight.from_usd"):
        latelight.Scene(tmp_path / "cube.usda", up_axis="z")
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(latelight.UsageError, match="requires the package usd-core"):
        latelight.Scene(tmp_path / "cube.usda")


# --- USD ------------------------------------------------------------------------------------------------------------


def add_mesh(stage, path):
    """Two squares of 1 m, in a stage in centimeters."""
    UsdGeom = pytest.importorskip("pxr.UsdGeom")
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0), (200, 0, 0), (200, 100, 0)])
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 4, 5, 2])
    return mesh


def save_mesh_stage(path):
    """Writes a stage that others can refer to: its default prim is a mesh."""
    Usd = pytest.importorskip("pxr.Usd")
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetDefaultPrim(add_mesh(stage, "/mesh").GetPrim())
    stage.Save()


@pytest.fixture
def stage():
    Usd, UsdGeom = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    made = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(made, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(made, 0.01)
    return made


def test_usd_meshes_have_materials_by_subset(stage):
    from pxr import Sdf, UsdGeom, UsdShade

    mesh = add_mesh(stage, "/world/squares")
    UsdGeom.XformCommonAPI(mesh).SetTranslate((0, 0, 50))
    material = UsdShade.Material.Define(stage, "/red")
    shader = UsdShade.Shader.Define(stage, "/red/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((1, 0, 0))
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.25)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "right", UsdGeom.Tokens.face, [1], "materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    scene = latelight.from_usd(stage)
    assert scene.triangle_count == 4
    assert_bounds(scene, (0, 0.5, -1), (2, 0.5, 0))
    by_name = {scene.material(m).name: scene.material(m) for m in scene.materials()}
    assert by_name["red"].base_color == (1, 0, 0, 1) and by_name["red"].roughness == 0.25
    (red,) = [i for i in scene.instances() if scene.material(scene.instance(i).material).name == "red"]
    np.testing.assert_allclose(scene.mesh(scene.instance(red).mesh).bounds, ((100, 0, 0), (200, 100, 0)))


def shape_radii(positions, axis):
    """The distances from an axis, and the coordinates along it, in meters."""
    other = [i for i in range(3) if i != axis]
    return np.linalg.norm(positions[:, other], axis=1) / 100, positions[:, axis] / 100


def test_usd_shapes_have_their_sizes(stage):
    from pxr import UsdGeom

    ball = UsdGeom.Sphere.Define(stage, "/ball")
    ball.CreateRadiusAttr(50)
    ball.CreateDisplayColorAttr([(1, 0, 0.5)])
    UsdGeom.XformCommonAPI(ball).SetTranslate((300, 0, 0))
    UsdGeom.Cube.Define(stage, "/cube").CreateSizeAttr(30)
    for number, axis in enumerate("XYZ"):
        for kind in (UsdGeom.Cylinder, UsdGeom.Cone, UsdGeom.Capsule):
            shape = kind.Define(stage, f"/{kind.__name__}{axis}")
            shape.CreateRadiusAttr(20)
            shape.CreateHeightAttr(100)
            shape.CreateAxisAttr(axis)
        sheet = UsdGeom.Plane.Define(stage, f"/Plane{axis}")
        sheet.CreateWidthAttr(40)
        sheet.CreateLengthAttr(80)
        sheet.CreateAxisAttr(axis)
        sheet.CreateDoubleSidedAttr(True)
    scene = latelight.from_usd(stage)
    arrays = {n.path[1:]: scene.mesh_arrays(scene.instance(i).mesh) for n, i in zip(scene.nodes, scene.instances())}
    materials = {n.path[1:]: scene.material(scene.instance(i).material) for n, i in zip(scene.nodes, scene.instances())}
    assert len(arrays) == 14
    np.testing.assert_allclose(np.linalg.norm(arrays["ball"]["positions"], axis=1), 50, rtol=1e-6)
    assert materials["ball"].base_color == (1, 0, 0.5, 1)
    assert not materials["ball"].double_sided and materials["PlaneX"].double_sided
    np.testing.assert_allclose(np.abs(arrays["cube"]["positions"]), 15)
    sizes = {"X": (0, 80, 40), "Y": (40, 0, 80), "Z": (40, 80, 0)}  # a plane's width is along Z if it faces X
    for number, axis in enumerate("XYZ"):
        radii, along = shape_radii(arrays[f"Cylinder{axis}"]["positions"], number)
        assert radii.max() == pytest.approx(0.2) and set(np.round(np.abs(along), 6)) == {0.5}
        radii, along = shape_radii(arrays[f"Cone{axis}"]["positions"], number)
        np.testing.assert_allclose(radii[along > 0], 0, atol=1e-9)
        assert radii[along < 0].max() == pytest.approx(0.2) and along.max() == pytest.approx(0.5)
        radii, along = shape_radii(arrays[f"Capsule{axis}"]["positions"], number)
        np.testing.assert_allclose(np.hypot(radii, np.maximum(np.abs(along) - 0.5, 0)), 0.2, rtol=1e-6)
        sheet = arrays[f"Plane{axis}"]
        np.testing.assert_allclose(np.ptp(sheet["positions"], axis=0), sizes[axis])
        np.testing.assert_allclose(sheet["normals"], np.tile(np.eye(3)[number], (4, 1)))
    for name, mesh in arrays.items():  # triangles face outward, as their normals do
        corners = mesh["positions"][mesh["indices"].reshape(-1, 3)]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        shaded = mesh["normals"][mesh["indices"].reshape(-1, 3)].sum(axis=1)
        assert (np.einsum("ij,ij->i", facing, shaded) >= -1e-3).all(), name
    ball.GetRadiusAttr().Set(-1)
    with pytest.raises(latelight.UsageError, match="/ball has the radius -1, but it must be positive"):
        latelight.from_usd(stage)


def surface_colors(scene, instance):
    """The linear colors of an instance's vertices: those of its material and of its mesh, multiplied."""
    arrays = scene.mesh_arrays(instance.mesh)
    colors = arrays.get("colors", np.ones((len(arrays["positions"]), 4)))
    return colors * np.array(scene.material(instance.material).base_color)


def test_usd_meshes_and_shapes_have_opacities(stage):
    """Alpha is displayOpacity, of meshes also per point, and inherited. Without displayColor the color is the default's."""
    from pxr import Sdf, UsdGeom

    glass = add_mesh(stage, "/glass")
    glass.CreateDisplayColorAttr([(1, 0.5, 0)])
    glass.CreateDisplayOpacityAttr([0.5])
    opacity = add_mesh(stage, "/fade").CreateDisplayOpacityPrimvar("vertex")
    opacity.Set([0, 0.5, 1, 1, 1, 2])
    add_mesh(stage, "/opaque").CreateDisplayOpacityAttr([1])
    UsdGeom.Sphere.Define(stage, "/group/bubble").CreateDisplayColorAttr([(0, 0, 1)])
    group = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/group"))
    group.CreatePrimvar("displayOpacity", Sdf.ValueTypeNames.FloatArray, "constant").Set([0.25])
    scene = latelight.from_usd(stage)
    made = {}
    for node, handle in zip(scene.nodes, scene.instances()):
        instance = scene.instance(handle)
        colors = np.unique(surface_colors(scene, instance), axis=0).round(4).tolist()
        made[node.path] = (scene.material(instance.material).alpha_mode, colors)
    assert made == {
        "/glass": ("blend", [[1, 0.5, 0, 0.5]]),
        "/fade": ("blend", [pytest.approx([0.8, 0.8, 0.8, alpha], abs=1e-4) for alpha in (0, 0.5, 1)]),
        "/opaque": ("opaque", [pytest.approx([0.8, 0.8, 0.8, 1], abs=1e-4)]),
        "/group.bubble": ("blend", [[0, 0, 1, 0.25]]),
    }


def test_usd_shapes_may_taper(stage):
    from pxr import UsdGeom

    for kind in (UsdGeom.Cylinder_1, UsdGeom.Capsule_1):
        shape = kind.Define(stage, f"/{kind.__name__}")
        shape.CreateRadiusBottomAttr(30)
        shape.CreateRadiusTopAttr(10)
        shape.CreateHeightAttr(100)
        shape.CreateAxisAttr("X")
    scene = latelight.from_usd(stage)
    arrays = {n.path[1:]: scene.mesh_arrays(scene.instance(i).mesh) for n, i in zip(scene.nodes, scene.instances())}
    cylinder, capsule = arrays["Cylinder_1"], arrays["Capsule_1"]
    for mesh in (cylinder, capsule):
        radii, along = shape_radii(mesh["positions"], 0)
        side = np.abs(mesh["normals"][:, 0] - 20 / np.hypot(100, 20)) < 1e-6  # of a cone that narrows by 20 over 100
        assert side.sum() == 66
        np.testing.assert_allclose(radii[side], np.where(along[side] < 0, 0.3, 0.1), rtol=1e-6)
        np.testing.assert_allclose(np.abs(along[side]), 0.5, rtol=1e-6)
        corners = mesh["positions"][mesh["indices"].reshape(-1, 3)]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ij,ij->i", facing, mesh["normals"][mesh["indices"].reshape(-1, 3)].sum(axis=1)) >= -1e-3).all()
    radii, along = shape_radii(capsule["positions"], 0)
    np.testing.assert_allclose(np.hypot(radii, np.abs(along) - 0.5), np.where(along < 0, 0.3, 0.1), rtol=1e-5)
    assert along.min() == pytest.approx(-0.8) and along.max() == pytest.approx(0.6)


def test_usd_meshes_have_holes(stage):
    mesh = add_mesh(stage, "/squares")  # of two faces
    mesh.CreateHoleIndicesAttr([1])
    scene = latelight.from_usd(stage)
    assert scene.triangle_count == 2
    assert_bounds(scene, (0, 0, -1), (1, 0, 0))
    mesh.GetHoleIndicesAttr().Set([0, 1])
    assert latelight.from_usd(stage).triangle_count == 0


def triangle_areas(scene):
    (handle,) = scene.instances()
    mesh = scene.mesh_arrays(scene.instance(handle).mesh)
    a, b, c = np.moveaxis(mesh["positions"][mesh["indices"]].astype(float), 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


@pytest.mark.parametrize("orientation", ("rightHanded", "leftHanded"))
def test_usd_polygons_may_be_concave(stage, orientation):
    """The triangles do not overlap if their areas add up to that of the polygons."""
    mesh = add_mesh(stage, "/shapes")
    angle = np.arange(1000) * 2 * np.pi / 1000
    radius = 1 + 0.3 * np.sin(10 * angle)
    wave = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(1000)], axis=1)
    arrow = np.array([(0, 0, 0), (3, -1, 0), (1, 0, 0), (3, 1, 0)])  # of the area 1, concave at its third corner
    mesh.CreatePointsAttr(np.concatenate([wave, arrow, wave[:3]]).tolist())
    mesh.CreateFaceVertexCountsAttr([1000, 2, 4, 3])
    mesh.CreateFaceVertexIndicesAttr([*range(1000), 0, 1, *range(1001, 1004), 1000, 1004, 1005, 1006])
    mesh.CreateOrientationAttr(orientation)
    areas = triangle_areas(latelight.from_usd(stage))
    assert len(areas) == 998 + 2 + 1
    expected = (radius * np.roll(radius, -1)).sum() * np.sin(2 * np.pi / 1000) / 2
    assert areas[:998].sum() == pytest.approx(expected, rel=1e-5)
    assert areas[998:1000].sum() == pytest.approx(1)


def test_usd_meshes_without_triangles_are_left_out(stage):
    mesh = add_mesh(stage, "/squares")
    mesh.CreateFaceVertexCountsAttr([2, 2])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 1, 2])
    mesh.CreateNormalsAttr([(0, 0, 1)] * len(mesh.GetPointsAttr().Get()))
    assert latelight.from_usd(stage).triangle_count == 0
    mesh.CreateFaceVertexCountsAttr([5, -1])
    with pytest.raises(latelight.UsageError, match="/squares has a face with -1 corners"):
        latelight.from_usd(stage)


def test_usd_meshes_without_points_are_left_out(stage):
    """Placeholders, whose geometry a stronger layer or a variant adds, have no attributes yet."""
    from pxr import UsdGeom

    UsdGeom.Mesh.Define(stage, "/placeholder")
    add_mesh(stage, "/faces").GetPointsAttr().Clear()
    UsdGeom.Cube.Define(stage, "/cube").CreateSizeAttr(100)
    scene = latelight.from_usd(stage)
    assert [node.path for node in scene.nodes] == ["/cube"]
    assert_bounds(scene, (-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))


def test_usd_meshes_may_be_double_sided(stage):
    for name, sides in (("one", False), ("two", True)):
        add_mesh(stage, f"/{name}").CreateDoubleSidedAttr(sides)
    scene = latelight.from_usd(stage)
    assert [scene.material(scene.instance(i).material).double_sided for i in scene.instances()] == [False, True]


def test_usd_instances_share_meshes(stage):
    from pxr import Sdf, UsdGeom

    stage.DefinePrim("/proto", "Xform").SetSpecifier(Sdf.SpecifierClass)
    add_mesh(stage, "/proto/leaf")
    for number in range(2):
        tree = UsdGeom.Xform.Define(stage, f"/tree{number}")
        tree.GetPrim().GetReferences().AddInternalReference("/proto")
        tree.GetPrim().SetInstanceable(True)
        UsdGeom.XformCommonAPI(tree).SetTranslate((0, 300 * number, 0))
    grass = UsdGeom.PointInstancer.Define(stage, "/grass")
    blade = add_mesh(stage, "/grass/protos/blade")
    UsdGeom.XformCommonAPI(blade).SetScale((2, 2, 2))
    grass.CreatePrototypesRel().SetTargets(["/grass/protos/blade"])
    grass.CreateProtoIndicesAttr([0, 0, 0])
    grass.CreatePositionsAttr([(0, 0, 100), (0, 0, 200), (0, 0, 300)])
    UsdGeom.Imageable(add_mesh(stage, "/hidden")).MakeInvisible()
    scene = latelight.from_usd(stage)
    assert [node.path for node in scene.nodes] == ["/tree0.leaf", "/tree1.leaf", "/grass.0", "/grass.1", "/grass.2"]
    assert len(scene.meshes()) == 2
    assert_bounds(scene, (0, 0, -4), (4, 3, 0))


def add_paint(stage, path, color):
    """A material of one color."""
    from pxr import Sdf, UsdShade

    material, shader = UsdShade.Material.Define(stage, path), UsdShade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def add_native_instances(stage, count):
    """Instances of a prototype with a mesh, one of whose two faces is a subset, and a shape."""
    from pxr import UsdGeom, UsdShade

    stage.CreateClassPrim("/kind")
    mesh = add_mesh(stage, "/kind/squares")
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "right", UsdGeom.Tokens.face, [1], "materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(add_paint(stage, "/kind/paint", (0, 0.25, 0)))
    UsdGeom.Cube.Define(stage, "/kind/cube")
    instances = []
    for number in range(count):
        instances.append(UsdGeom.Xform.Define(stage, f"/copy{number}").GetPrim())
        instances[-1].GetInherits().AddInherit("/kind")
        instances[-1].SetInstanceable(True)
    return instances


def colors_by_node(scene):
    """The first color of each part, by the path of its node."""
    colors = {}
    for node, handle in zip(scene.nodes, scene.instances()):
        color = surface_colors(scene, scene.instance(handle))[0]
        colors.setdefault(node.path.partition("#")[0], []).append(tuple(color.round(4).tolist()))
    return colors


@pytest.mark.parametrize("strength", ["weakerThanDescendants", "strongerThanDescendants"])
def test_usd_instances_have_their_own_materials(stage, strength):
    """USD's bindings, of instances in the same prototype, whose meshes are shared."""
    from pxr import UsdShade

    paints = {"/red": (0.5, 0, 0), "/blue": (0, 0, 0.75), "/kind/paint": (0, 0.25, 0)}
    instances = add_native_instances(stage, 3)
    for prim, path in zip(instances, ("/red", "/blue")):
        material = add_paint(stage, path, paints[path])
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, strength)
    assert len({prim.GetPrototype() for prim in instances}) == 1
    scene = latelight.from_usd(stage)
    assert len(scene.meshes()) == 3  # two of the faces, and the cube
    expected = {}
    for number in range(3):
        for name, parts in (("squares", ["squares/right", "squares"]), ("cube", ["cube"])):
            prims = [stage.GetPrimAtPath(f"/copy{number}/{part}") for part in parts]
            bound = [str(UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath()) for prim in prims]
            colors = [paints.get(path.replace(f"/copy{number}", "/kind"), (0.8, 0.8, 0.8)) for path in bound]
            expected[f"/copy{number}.{name}"] = [(*color, 1) for color in colors]
    assert colors_by_node(scene) == expected


def test_usd_instances_have_their_own_display_colors(stage):
    """Primvars that an instance states are inherited by what it shows, which shares the meshes nevertheless."""
    from pxr import Sdf, UsdGeom

    instances = add_native_instances(stage, 4)
    for number, color in ((0, (1, 0, 0)), (1, (0, 0, 1)), (3, (1, 0, 0))):
        UsdGeom.PrimvarsAPI(instances[number]).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray).Set([color])
    UsdGeom.PrimvarsAPI(instances[1]).CreatePrimvar("displayOpacity", Sdf.ValueTypeNames.FloatArray).Set([0.5])
    scene = latelight.from_usd(stage)
    own = [(1, 0, 0, 1), (0, 0, 1, 0.5), (0.8, 0.8, 0.8, 1), (1, 0, 0, 1)]
    squares = {f"/copy{n}.squares": [(0, 0.25, 0, 1), color] for n, color in enumerate(own)}
    assert colors_by_node(scene) == {**squares, **{f"/copy{n}.cube": [color] for n, color in enumerate(own)}}
    modes = [scene.material(scene.instance(i).material).alpha_mode for i in scene.instances("/copy1.cube")]
    assert modes == ["blend"]
    assert len(scene.meshes()) == 3 and len(scene.materials()) == 4  # paint, red, blue and the default


@pytest.mark.parametrize("full, preview, every, expected", [
    ("red", "", "", "red"),
    ("", "red", "", "red"),
    ("red", "blue", "", "red"),
    ("red", "", "blue", "red"),
    ("", "red", "blue", "blue"),  # the binding for all purposes is also one for full renderings
    ("other", "red", "", "red"),  # no shader of the material for full renderings is supported
    ("other", "", "", "default"),
])  # fmt: skip
def test_usd_bindings_may_have_purposes(stage, full, preview, every, expected):
    from pxr import UsdShade

    binding = UsdShade.MaterialBindingAPI.Apply(add_mesh(stage, "/squares").GetPrim())
    add_paint(stage, "/other", (0, 1, 0))
    UsdShade.Shader(stage.GetPrimAtPath("/other/surface")).CreateIdAttr("another")
    materials = {"red": add_paint(stage, "/red", (1, 0, 0)), "blue": add_paint(stage, "/blue", (0, 0, 1))}
    materials["other"] = UsdShade.Material(stage.GetPrimAtPath("/other"))
    for name, purpose in ((full, "full"), (preview, "preview"), (every, "")):
        if name:
            binding.Bind(materials[name], UsdShade.Tokens.weakerThanDescendants, purpose)
    scene = latelight.from_usd(stage)
    (handle,) = scene.instances()
    assert scene.material(scene.instance(handle).material).name == expected
    computed = binding.ComputeBoundMaterial("full")[0]
    if computed and full != "other":
        assert computed.GetPath().name == expected


def add_instancer(stage, path, prototypes, positions=((0, 0, 0), (30, 0, 0)), indices=None):
    from pxr import UsdGeom

    copies = UsdGeom.PointInstancer.Define(stage, path)
    copies.CreatePrototypesRel().SetTargets(prototypes)
    copies.CreateProtoIndicesAttr([0] * len(positions) if indices is None else indices)
    copies.CreatePositionsAttr(list(positions))
    return copies


def add_kind(stage, path):
    """A shown cube, a hidden one, a guide with a cube that is meant for rendering, a proxy, and an instance."""
    from pxr import Sdf, UsdGeom

    for name in ("shown", "hidden", "guide/guide", "guide/rendered", "proxy/coarse"):
        UsdGeom.Cube.Define(stage, f"{path}/{name}")
    UsdGeom.Imageable(stage.GetPrimAtPath(f"{path}/hidden")).MakeInvisible()
    for name, purpose in (("guide", "guide"), ("guide/rendered", "render"), ("proxy", "proxy")):
        prim = stage.GetPrimAtPath(f"{path}/{name}")
        prim.SetTypeName("Cube" if "/" in name else "Xform")
        UsdGeom.Imageable(prim).CreatePurposeAttr(purpose)
    UsdGeom.Sphere.Define(stage, "/library/ball").CreateRadiusAttr(3)
    stage.GetPrimAtPath("/library").SetSpecifier(Sdf.SpecifierOver)
    instance = stage.DefinePrim(f"{path}/instance", "Xform")
    instance.GetReferences().AddInternalReference("/library")
    instance.SetInstanceable(True)


def shown_by(stage):
    """The sizes of the instances of a stage, and where they are, in units of the stage."""
    scene = latelight.from_usd(stage)
    found = []
    for instance in map(scene.instance, scene.instances()):
        matrix = 100 * np.linalg.inv(Z_UP) @ np.asarray(instance.transform)  # from meters and Y up
        size = np.ptp(scene.mesh_arrays(instance.mesh)["positions"] @ matrix[:3, :3].T, axis=0).max()
        found.append((round(float(size), 3), tuple((np.round(matrix[:3, 3], 3) + 0.0).tolist())))
    return sorted(found)


def test_usd_instancers_show_what_is_visible_in_their_prototypes(stage, capfd):
    add_kind(stage, "/kind")
    direct = [(2, (0, 0, 0)), (2, (0, 0, 0)), (6, (0, 0, 0))]  # the shown cube, the rendered one and the instance
    assert shown_by(stage) == direct
    stage.RemovePrim("/kind")
    add_instancer(stage, "/copies", ["/copies/kind"])
    add_kind(stage, "/copies/kind")
    assert shown_by(stage) == sorted(direct + [(size, (30, 0, 0)) for size, _ in direct])
    output = capfd.readouterr()
    assert (output.out, output.err) == ("", "")


def add_primvar(prim, name, kind, interpolation, values):
    from pxr import Sdf, UsdGeom

    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, getattr(Sdf.ValueTypeNames, kind), interpolation).Set(values)


def test_usd_copies_of_instancers_have_colors(stage):
    """Values per copy apply by the number of the copy, also after a masked one, and share the meshes. They replace what a
    prototype inherits, and a prototype's own color replaces them."""
    from pxr import UsdGeom

    positions = [(10 * n, 0, 0) for n in range(4)]
    copies = add_instancer(stage, "/group/copies", ["/group/copies/plain", "/group/copies/own"], positions, [0, 0, 1, 0])
    copies.InvisId(1, 0)
    UsdGeom.Cube.Define(stage, "/group/copies/plain")
    UsdGeom.Cube.Define(stage, "/group/copies/own/cube")
    for path, color in (("/group", (0.5, 0.5, 0.5)), ("/group/copies/own", (1, 1, 0))):
        add_primvar(stage.GetPrimAtPath(path), "displayColor", "Color3fArray", "constant", [color])
    colors = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0.25, 0)]
    add_primvar(copies, "displayColor", "Color3fArray", "vertex", colors)
    add_primvar(copies, "displayOpacity", "FloatArray", "varying", [0.5, 1, 0.25, 1])
    scene = latelight.from_usd(stage)
    expected = {"0": [(1, 0, 0, 0.5)], "2": [(1, 1, 0, 0.25)], "3": [(0, 0.25, 0, 1)]}
    assert colors_by_node(scene) == {f"/group.copies.{n}": color for n, color in expected.items()}
    modes = [scene.material(scene.instance(handle).material).alpha_mode for handle in scene.instances()]
    assert modes == ["blend", "blend", "opaque"] and len(scene.meshes()) == 2
    add_primvar(copies, "displayColor", "Color3fArray", "vertex", colors[:3])  # too few, but they end the inheritance
    cube = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/group/copies/plain"))
    assert not cube.FindPrimvarWithInheritance("displayColor")
    first, _, last = colors_by_node(latelight.from_usd(stage)).values()
    assert first == [(0.8, 0.8, 0.8, 0.5)] and last == [(0.8, 0.8, 0.8, 1)]


def test_usd_copies_of_nested_instancers_have_colors(stage):
    """The innermost instancer with values per copy counts."""
    from pxr import UsdGeom

    forest = add_instancer(stage, "/forest", ["/forest/tree"])
    tree = add_instancer(stage, "/forest/tree", ["/forest/tree/leaf"], [(1, 0, 0), (2, 0, 0)])
    UsdGeom.Cube.Define(stage, "/forest/tree/leaf")
    add_primvar(forest, "displayColor", "Color3fArray", "vertex", [(1, 0, 0), (0, 0, 1)])
    add_primvar(forest, "displayOpacity", "FloatArray", "vertex", [0.5, 1])
    by_forest = [(1, 0, 0, 0.5)] * 2 + [(0, 0, 1, 1)] * 2
    assert sum(colors_by_node(latelight.from_usd(stage)).values(), []) == by_forest
    add_primvar(tree, "displayColor", "Color3fArray", "vertex", [(0, 1, 0), (0.5, 0, 0)])
    by_both = [(0, 1, 0, 0.5), (0.5, 0, 0, 0.5), (0, 1, 0, 1), (0.5, 0, 0, 1)]
    assert sum(colors_by_node(latelight.from_usd(stage)).values(), []) == by_both


@pytest.mark.parametrize("moving", ["copies", "parent"])
def test_usd_copies_that_move_have_colors(stage, moving):
    from pxr import UsdGeom

    copies = add_instancer(stage, "/group/copies", ["/group/copies/cube"])
    UsdGeom.Cube.Define(stage, "/group/copies/cube")
    add_primvar(copies, "displayColor", "Color3fArray", "vertex", [(1, 0, 0), (0, 0, 1)])
    if moving == "copies":
        copies.GetPositionsAttr().Set([(0, 0, 0), (9, 0, 0)], 0)
        copies.GetPositionsAttr().Set([(0, 0, 0), (9, 9, 0)], 24)
    else:
        shift = UsdGeom.Xformable(stage.DefinePrim("/group", "Xform")).AddTranslateOp()
        shift.Set((0, 0, 0), 0)
        shift.Set((5, 0, 0), 24)
    scene = latelight.from_usd(stage)
    colors = [surface_colors(scene, scene.instance(handle))[0].tolist() for handle in scene.instances()]
    assert scene.animations and colors == [[1, 0, 0, 1], [0, 0, 1, 1]]


@pytest.mark.parametrize("hidden_by", ["over", "class", "visibility", "purpose"])
@pytest.mark.parametrize("folder", ["/copies/kinds", "/kinds"])
def test_usd_prototypes_may_be_hidden_outside_of_instancers(stage, hidden_by, folder):
    """As in UsdImaging: neither the visibility nor the purpose above a prototype counts, and it may be undefined."""
    from pxr import Sdf, UsdGeom

    kinds = UsdGeom.Scope.Define(stage, folder)
    add_instancer(stage, "/copies", [f"{folder}/kind"])
    cube = UsdGeom.Cube.Define(stage, f"{folder}/kind")
    if hidden_by in ("over", "class"):
        kinds.GetPrim().SetSpecifier(Sdf.SpecifierOver if hidden_by == "over" else Sdf.SpecifierClass)
    elif hidden_by == "visibility":
        kinds.MakeInvisible()
    else:
        kinds.CreatePurposeAttr("guide")
    assert shown_by(stage) == [(2, (0, 0, 0)), (2, (30, 0, 0))]
    cube.CreateVisibilityAttr("invisible")  # that of the prototype itself counts
    assert shown_by(stage) == []


def test_usd_instancers_may_be_nested(stage):
    from pxr import UsdGeom

    add_instancer(stage, "/forest", ["/forest/tree"])
    tree = add_instancer(stage, "/forest/tree", ["/forest/tree/leaf"], [(1, 0, 0), (2, 0, 0)])
    UsdGeom.XformCommonAPI(tree).SetTranslate((0, 10, 0))
    UsdGeom.XformCommonAPI(UsdGeom.Cube.Define(stage, "/forest/tree/leaf")).SetTranslate((0, 0, 5))
    expected = [(2, (x, 10, 5)) for x in (1, 2, 31, 32)]
    assert shown_by(stage) == expected
    positions = [(0, 0, 0), (9, 9, 9), (30, 0, 0)]
    add_instancer(stage, "/forest", ["/forest/tree", "/missing"], positions, [0, 1, 0])
    assert shown_by(stage) == expected


def test_usd_instancers_that_cannot_be_shown_are_refused(stage):
    from pxr import UsdGeom

    UsdGeom.Cube.Define(stage, "/copies/kind")
    for indices in ([0, 1], [-1, 0]):
        add_instancer(stage, "/copies", ["/copies/kind"], indices=indices)
        with pytest.raises(latelight.UsageError, match="/copies has copies of prototypes that it does not have: it has 1"):
            latelight.from_usd(stage)
    add_instancer(stage, "/copies", ["/copies"])
    with pytest.raises(latelight.UsageError, match="/copies is an instancer within its own prototypes"):
        latelight.from_usd(stage)


def test_small_usd_files_of_nested_instancers_end(stage, monkeypatch):
    """Each of 40 instancers shows a copy of each of the next two: 2.7e8 paths lead from the first to the last one."""
    from pxr import Sdf, UsdGeom

    monkeypatch.setattr("latelight._usd.instancers._MAX_PARTS", 1000)
    for level in range(40):
        below = [f"/levels/n{level + 1}", f"/levels/n{level + 2}"]
        add_instancer(stage, f"/levels/n{level}", below, indices=[0, 1])
    stage.GetPrimAtPath("/levels").SetSpecifier(Sdf.SpecifierClass)
    add_instancer(stage, "/copies", ["/levels/n0"])
    assert shown_by(stage) == []
    UsdGeom.Cube.Define(stage, "/levels/n40")
    stage.GetPrimAtPath("/levels").SetSpecifier(Sdf.SpecifierClass)
    with pytest.raises(latelight.UsageError, match="the instancers in /levels/n.* show more than 1000 prims"):
        latelight.from_usd(stage)


def test_usd_stages_are_seen_as_exported(stage, tmp_path, device):
    """Instances, a point instancer, a light, and the chosen one of two variants."""
    from pxr import UsdGeom, UsdLux

    stage.DefinePrim("/tree", "Xform")
    choice = stage.GetPrimAtPath("/tree").GetVariantSets().AddVariantSet("size")
    for size in ("small", "large"):
        choice.AddVariant(size)
        choice.SetVariantSelection(size)
        with choice.GetVariantEditContext():
            leaf = add_mesh(stage, "/tree/leaf")
            leaf.CreateDoubleSidedAttr(True)
            UsdGeom.XformCommonAPI(leaf).SetScale((1, 1, 1) if size == "small" else (2, 2, 2))
    choice.SetVariantSelection("large")
    grass = UsdGeom.PointInstancer.Define(stage, "/grass")
    add_mesh(stage, "/grass/protos/blade")
    grass.CreatePrototypesRel().SetTargets(["/grass/protos/blade"])
    grass.CreateProtoIndicesAttr([0, 0])
    grass.CreatePositionsAttr([(300, -300, 100), (300, 100, 200)])
    UsdLux.SphereLight.Define(stage, "/bulb").CreateIntensityAttr(100)
    scene = latelight.from_usd(stage)
    assert scene.bounds[1][0] == pytest.approx(5)
    assert_seen_as_exported(scene, device, tmp_path)


def test_usd_lights_and_cameras(stage):
    from pxr import UsdGeom, UsdLux

    bulb = UsdLux.SphereLight.Define(stage, "/bulb")
    bulb.CreateIntensityAttr(100)
    bulb.CreateRadiusAttr(10)
    UsdGeom.XformCommonAPI(bulb).SetTranslate((0, 0, 200))
    camera = UsdGeom.Camera.Define(stage, "/camera")
    camera.CreateVerticalApertureAttr(20)
    camera.CreateFocalLengthAttr(10)
    UsdGeom.XformCommonAPI(camera).SetTranslate((0, 0, 500))
    scene = latelight.from_usd(stage)
    light = scene.light(scene.lights()[0])
    np.testing.assert_allclose(light.position, (0, 2, 0), atol=1e-12)
    assert light.intensity == pytest.approx(100 * np.pi * 0.1**2)  # radiance times the disk's area
    assert light.size == pytest.approx(0.1)
    assert scene.cameras[0].vertical_fov == pytest.approx(90, abs=1e-3)
    # It looks along the stage's -Z, which is down.
    np.testing.assert_allclose(
        scene.cameras[0].camera_to_world, [[1, 0, 0, 0], [0, 0, -1, 5], [0, 1, 0, 0], [0, 0, 0, 1]], atol=1e-12
    )


def test_usd_spot_lights_have_cones(stage):
    from pxr import UsdGeom, UsdLux

    spot = UsdLux.SphereLight.Define(stage, "/spot")
    spot.CreateIntensityAttr(100)
    spot.CreateRadiusAttr(5)
    UsdGeom.XformCommonAPI(spot).SetScale((2, 2, 2))  # the radius is 10 units, or 0.1 m
    shaping = UsdLux.ShapingAPI.Apply(spot.GetPrim())
    shaping.CreateShapingConeAngleAttr(40)
    shaping.CreateShapingConeSoftnessAttr(0.25)
    scene = latelight.from_usd(stage)
    light = scene.light(scene.lights()[0])
    assert light.type == "spot"
    assert (light.outer_cone, light.inner_cone) == (pytest.approx(40, abs=1e-4), pytest.approx(30, abs=1e-4))
    np.testing.assert_allclose(light.direction, (0, -1, 0), atol=1e-6)  # the stage's -Z
    assert light.size == pytest.approx(0.1) and light.intensity == pytest.approx(100 * np.pi * 0.1**2)
    for angle, types in ((90, ["spot"]), (180, ["point"]), (0, []), (-1, [])):  # none emits beyond its cone
        shaping.CreateShapingConeAngleAttr(angle)
        scene = latelight.from_usd(stage)
        assert [scene.light(light).type for light in scene.lights()] == types


def test_usd_lights_may_be_normalized(stage):
    """The same light with a radiance of 3, directly and divided by the area of its sphere in the stage's units."""
    from pxr import UsdLux

    for name, intensity, normalize in (("plain", 3, False), ("divided", 3 * 4 * np.pi * 20**2, True)):
        bulb = UsdLux.SphereLight.Define(stage, f"/{name}")
        bulb.CreateIntensityAttr(intensity)
        bulb.CreateRadiusAttr(20)
        bulb.CreateNormalizeAttr(normalize)
    scene = latelight.from_usd(stage)
    for light in map(scene.light, scene.lights()):
        assert light.intensity == pytest.approx(3 * np.pi * 0.2**2), light.name


def test_usd_points_are_as_bright_as_small_normalized_spheres(stage):
    from pxr import UsdLux

    for name, radius, normalize in (("point", 0, False), ("sphere", 1e-3, True), ("nothing", 0, False)):
        bulb = UsdLux.SphereLight.Define(stage, f"/{name}")
        bulb.CreateIntensityAttr(3)
        bulb.CreateRadiusAttr(radius)
        bulb.CreateNormalizeAttr(normalize)
        bulb.CreateTreatAsPointAttr(name == "point")
    scene = latelight.from_usd(stage)
    candela = {light.name: light.intensity for light in map(scene.light, scene.lights())}
    # A normalized sphere has the radiance 3 / (4 pi r^2), and from afar the area of a disk, pi r^2, in units of 1 cm.
    assert candela == {"point": pytest.approx(0.75e-4), "sphere": pytest.approx(0.75e-4), "nothing": 0}


@pytest.mark.parametrize("angle", [0.53, 20, 180, 270])
@pytest.mark.parametrize("normalize", [False, True])
def test_usd_distant_lights_are_as_bright_as_their_cap(stage, angle, normalize):
    """UsdLux: a cap of directions of that angle has the given radiance, which `normalize` divides by the cap's size: by
    what a surface that faces it receives, or by 2 pi minus that of the rest if it is more than a hemisphere."""
    from pxr import UsdLux

    sun = UsdLux.DistantLight.Define(stage, "/sun")
    sun.CreateIntensityAttr(1000)
    sun.CreateExposureAttr(-1)
    sun.CreateAngleAttr(angle)
    sun.CreateNormalizeAttr(normalize)
    edges = np.radians(np.linspace(0, angle / 2, 100001))
    middle = (edges[1:] + edges[:-1]) / 2
    parts = 2 * np.pi * np.sin(middle) * np.cos(middle) * np.diff(edges)
    received = parts[parts > 0].sum()
    scene = latelight.from_usd(stage)
    light = scene.light(scene.lights()[0])
    assert light.type == "directional" and light.size == pytest.approx(min(angle, 179))
    assert light.intensity == pytest.approx(500 * received / (np.abs(parts).sum() if normalize else 1), rel=1e-5)


def test_usd_distant_lights_have_the_defaults_of_the_schema(stage):
    from pxr import UsdLux

    sun = UsdLux.DistantLight.Define(stage, "/sun")
    scene = latelight.from_usd(stage)
    # A radiance of 50,000 in a cap of 0.53 degrees, which makes white about 1.
    assert scene.light(scene.lights()[0]).intensity == pytest.approx(50000 * np.pi * np.sin(np.radians(0.265)) ** 2)
    np.testing.assert_allclose(scene.light(scene.lights()[0]).direction, (0, -1, 0), atol=1e-6)
    sun.CreateAngleAttr(0)
    scene = latelight.from_usd(stage)
    assert (scene.light(scene.lights()[0]).intensity, scene.light(scene.lights()[0]).size) == (50000, 0)


def test_usd_normalized_area_lights_keep_their_power_when_scaled(stage):
    from pxr import UsdGeom, UsdLux

    power, scale = 600, np.array((2, 3, 5))
    turn = np.linspace(0, 2 * np.pi, 100001)
    around = np.hypot(*np.diff([3 * np.cos(turn), 5 * np.sin(turn)], axis=1)).sum()  # of the tube's end, for radius 1
    areas = {"panel": 10 * 2 * 20 * 3, "disk": np.pi * 4**2 * 2 * 3, "tube": 4 * around * 10 * 2}
    panel, tube = UsdLux.RectLight.Define(stage, "/panel"), UsdLux.CylinderLight.Define(stage, "/tube")
    panel.CreateWidthAttr(10)
    panel.CreateHeightAttr(20)
    tube.CreateLengthAttr(10)
    tube.CreateRadiusAttr(4)
    disk = UsdLux.DiskLight.Define(stage, "/disk")
    disk.CreateRadiusAttr(4)
    for light in (panel, tube, disk):
        light.CreateIntensityAttr(power)
        light.CreateNormalizeAttr(True)
        UsdGeom.XformCommonAPI(light).SetScale(tuple(scale.tolist()))
    scene = latelight.from_usd(stage)
    assert {light.name for light in map(scene.light, scene.lights())} == set(areas)
    for light in map(scene.light, scene.lights()):
        assert light.intensity == pytest.approx(power / areas[light.name], rel=1e-4), light.name
        np.testing.assert_allclose(light.scale, scale / 100)


def test_usd_lights_without_extent_emit_nothing(stage):
    from pxr import UsdGeom, UsdLux

    for kind, names in ((UsdLux.RectLight, ("width", "height")), (UsdLux.DiskLight, ("radius",)),
                        (UsdLux.CylinderLight, ("radius", "length"))):  # fmt: skip
        for name in names:
            light = kind.Define(stage, f"/{kind.__name__}_{name}")
            light.GetPrim().GetAttribute(f"inputs:{name}").Set(0)
        UsdGeom.XformCommonAPI(kind.Define(stage, f"/{kind.__name__}_scaled")).SetScale((1, 0, 1))
    flat = UsdLux.RectLight.Define(stage, "/flat")  # as a plane, which is all that it is
    UsdGeom.XformCommonAPI(flat).SetScale((1, 1, 0))
    UsdLux.ShadowAPI.Apply(flat.GetPrim()).CreateShadowEnableAttr(False)
    scene = latelight.from_usd(stage)
    (light,) = map(scene.light, scene.lights())
    assert light.name == "flat" and light.cast_shadow is False
    np.testing.assert_allclose(light.direction, (0, -1, 0), atol=1e-6)
    flat.CreateWidthAttr(-2)
    with pytest.raises(latelight.UsageError, match="/flat has the width -2, but it must not be negative"):
        latelight.from_usd(stage)


def test_usd_lights_have_color_temperatures(stage):
    from pxr import UsdLux

    for kind in (UsdLux.SphereLight, UsdLux.RectLight):
        light = kind.Define(stage, f"/{kind.__name__}")
        light.CreateColorAttr((1, 0.5, 1))
        light.CreateEnableColorTemperatureAttr(True)
        light.CreateColorTemperatureAttr(2700)
    scene = latelight.from_usd(stage)
    expected = np.array(UsdLux.BlackbodyTemperatureAsRgb(2700)) * (1, 0.5, 1)
    for light in map(scene.light, scene.lights()):
        np.testing.assert_allclose(light.color, expected, atol=1e-6)


def test_usd_cameras_may_be_orthographic_or_shifted(stage, device):
    """The corners of what GfCamera sees are at the corners of the image."""
    from pxr import UsdGeom

    for name, projection in (("flat", "orthographic"), ("deep", "perspective")):
        camera = UsdGeom.Camera.Define(stage, f"/{name}")
        camera.CreateProjectionAttr(projection)
        camera.CreateHorizontalApertureAttr(60)
        camera.CreateVerticalApertureAttr(40)
        camera.CreateHorizontalApertureOffsetAttr(9)
        camera.CreateVerticalApertureOffsetAttr(-4)
        camera.CreateFocalLengthAttr(50)
        UsdGeom.XformCommonAPI(camera).SetTranslate((0, 0, 300))
    UsdGeom.Plane.Define(stage, "/floor").CreateWidthAttr(10000)
    UsdGeom.Plane(stage.GetPrimAtPath("/floor")).CreateLengthAttr(10000)
    scene = latelight.from_usd(stage)
    for camera in scene.cameras:
        position = latelight.Renderer(scene, device).render(camera, (60, 40), "position")["position"]
        frustum = UsdGeom.Camera(stage.GetPrimAtPath(f"/{camera.name}")).GetCamera(0).frustum
        for row, column in ((0, 0), (39, 59), (12, 7)):
            ray = frustum.ComputePickRay(((column + 0.5) / 30 - 1, 1 - (row + 0.5) / 20))
            start, direction = np.array(ray.startPoint), np.array(ray.direction)
            x, y, _ = (start - direction * start[2] / direction[2]) / 100
            np.testing.assert_allclose(position[row, column], (x, 0, -y), atol=2e-5)


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
def test_usd_cameras_clip_by_their_range(stage, device, projection):
    """Floors 0.3, 2 and 20 m below the camera. USD's range without an authored one begins at 1 unit."""
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, 1)
    camera = UsdGeom.Camera.Define(stage, "/camera")
    camera.CreateProjectionAttr(projection)
    for depth in (0.3, 2, 20):
        UsdGeom.XformCommonAPI(add_mesh(stage, f"/floor{int(10 * depth)}")).SetTranslate((-50, -50, -depth))

    def seen(clipping):
        if clipping:
            camera.CreateClippingRangeAttr(clipping)
        scene = latelight.from_usd(stage)
        return float(latelight.Renderer(scene, device).render(scene.cameras[0], (8, 8), "depth")["depth"][4, 4])

    assert seen(None) == pytest.approx(0.3, abs=0.01)  # depth is rounded to 2^-24 of USD's default far plane
    assert seen((0.5, 10)) == pytest.approx(2)
    assert seen((3, 100)) == pytest.approx(20)
    assert seen((3, 10)) == np.inf
    repaired = {"perspective": (0.3, 20), "orthographic": (0.3, 2)}[projection]
    assert seen((0, 10)) == pytest.approx(repaired[0])
    assert seen((10, 0.5)) == pytest.approx(repaired[1])


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
@pytest.mark.parametrize("size", [(120, 40), (60, 80), (60, 40)])
def test_usd_cameras_show_their_frame_in_images_of_any_shape(stage, device, projection, size):
    """The window of the frustum is widened about its center to the shape of the image."""
    from pxr import Gf, UsdGeom

    camera = UsdGeom.Camera.Define(stage, "/camera")
    camera.CreateProjectionAttr(projection)
    camera.CreateHorizontalApertureAttr(60)
    camera.CreateVerticalApertureAttr(40)
    camera.CreateFocalLengthAttr(50)
    UsdGeom.XformCommonAPI(camera).SetTranslate((0, 0, 300))
    UsdGeom.Plane.Define(stage, "/floor").CreateWidthAttr(10000)
    UsdGeom.Plane(stage.GetPrimAtPath("/floor")).CreateLengthAttr(10000)
    scene = latelight.from_usd(stage)
    assert scene.cameras[0].aspect == 1.5
    position = latelight.Renderer(scene, device).render(scene.cameras[0], size, "position")["position"]
    frustum = camera.GetCamera(0).frustum
    aspect, corner = size[0] / size[1], frustum.window.max
    high = Gf.Vec2d(corner[0] * max(aspect / 1.5, 1), corner[1] * max(1.5 / aspect, 1))
    frustum.window = Gf.Range2d(-high, high)
    for row, column in ((0, 0), (size[1] - 1, size[0] - 1), (12, 7)):
        ray = frustum.ComputePickRay((2 * (column + 0.5) / size[0] - 1, 1 - 2 * (row + 0.5) / size[1]))
        start, direction = np.array(ray.startPoint), np.array(ray.direction)
        x, y, _ = (start - direction * start[2] / direction[2]) / 100
        np.testing.assert_allclose(position[row, column], (x, 0, -y), atol=2e-5)


@pytest.mark.parametrize("size, x, y", [((100, 100), 75, 47.5), ((200, 100), 100, 47.5), ((100, 200), 75, 107.5)])
def test_usd_cameras_keep_their_shift_relative_to_the_image(stage, device, size, x, y):
    """The window is 1 x 1 at the distance 1, with its center at (0.25, 0.1), so the center of the projection is at
    (-0.5, -0.2) in half widths and half heights of the image. Images of other shapes show 2 x 1 and 1 x 2."""
    from pxr import UsdGeom

    camera = UsdGeom.Camera.Define(stage, "/camera")
    for attribute in (camera.CreateHorizontalApertureAttr, camera.CreateVerticalApertureAttr):
        attribute(20)
    camera.CreateHorizontalApertureOffsetAttr(5)
    camera.CreateVerticalApertureOffsetAttr(2)
    camera.CreateFocalLengthAttr(20)
    ball = UsdGeom.Sphere.Define(stage, "/ball")  # at (0.5, 0.125) in the plane of the window
    ball.CreateRadiusAttr(10)
    UsdGeom.XformCommonAPI(ball).SetTranslate((200, 50, -400))
    scene = latelight.from_usd(stage)
    rows, columns = np.nonzero(latelight.Renderer(scene, device).render(scene.cameras[0], size, "id")["id"])
    np.testing.assert_allclose((columns.mean() + 0.5, rows.mean() + 0.5), (x, y), atol=0.3)


@pytest.mark.parametrize("scale", [(-1, 1, 1), (2, -3, 4), (-1, -1, -1), (0.5, 2, 3)])
def test_usd_cameras_may_be_mirrored_and_scaled(stage, scale):
    """The camera is where GfFrustum has it, which has no mirrors and no scale."""
    from pxr import UsdGeom

    camera = UsdGeom.Camera.Define(stage, "/camera")
    UsdGeom.XformCommonAPI(camera).SetTranslate((10, 20, 30))
    UsdGeom.XformCommonAPI(camera).SetRotate((25, -40, 70))
    UsdGeom.XformCommonAPI(camera).SetScale(scale)
    expected = np.array(camera.GetCamera(0).frustum.ComputeViewInverse()).T @ np.diag([1, -1, -1, 1])
    expected[:3, 3] /= 100
    (found,) = latelight.from_usd(stage).cameras
    np.testing.assert_allclose(found.camera_to_world, Z_UP @ expected, atol=1e-6)


def test_usd_cameras_may_be_sheared_or_flat(stage):
    """They keep their direction, and a camera without a depth of its own faces as its plane does."""
    from pxr import UsdGeom

    UsdGeom.XformCommonAPI(UsdGeom.Xform.Define(stage, "/wide")).SetScale((1, 3, 1))
    sheared = UsdGeom.Camera.Define(stage, "/wide/camera")
    UsdGeom.XformCommonAPI(sheared).SetRotate((30, 20, 10))
    flat = UsdGeom.Camera.Define(stage, "/flat")
    UsdGeom.XformCommonAPI(flat).SetScale((1, 1, 0))
    directions = [np.asarray(camera.camera_to_world)[:3, 2] for camera in latelight.from_usd(stage).cameras]
    back = np.array(UsdGeom.Imageable(sheared).ComputeLocalToWorldTransform(0))[2, :3]
    np.testing.assert_allclose(directions[0], -Z_UP[:3, :3] @ back / np.linalg.norm(back), atol=1e-6)
    np.testing.assert_allclose(directions[1], (0, -1, 0), atol=1e-6)


def test_usd_cameras_without_a_view_are_refused(stage):
    from pxr import UsdGeom

    camera = UsdGeom.Camera.Define(stage, "/camera")
    camera.CreateFocalLengthAttr(0)
    with pytest.raises(latelight.UsageError, match="/camera has the focalLength 0, but it must be positive"):
        latelight.from_usd(stage)
    camera.CreateProjectionAttr("orthographic")  # which has no use for a focal length
    assert latelight.from_usd(stage).cameras[0].orthographic
    camera.CreateVerticalApertureAttr(-1)
    with pytest.raises(latelight.UsageError, match="/camera has the verticalAperture -1, but it must be positive"):
        latelight.from_usd(stage)


def test_usd_exposures_are_those_of_all_cameras(stage):
    """Also of a camera that appears after the first time code, which is one of the scene's."""
    from pxr import UsdGeom

    for stops, name in enumerate(("first", "second"), 1):
        UsdGeom.Camera.Define(stage, f"/{name}").CreateExposureAttr(stops)
    seen = UsdGeom.Imageable(stage.GetPrimAtPath("/first")).CreateVisibilityAttr()
    seen.Set("invisible", 0)
    seen.Set("inherited", 5)
    assert [camera.name for camera in latelight.from_usd(stage).cameras] == ["first", "second"]
    assert latelight.usd_exposures(stage) == [1, 2]
    assert latelight.usd_exposures(stage, time=0) == [2]


def test_usd_cameras_have_exposures(stage):
    from pxr import UsdGeom

    UsdGeom.Camera.Define(stage, "/plain")
    stops = UsdGeom.Camera.Define(stage, "/stops")
    stops.CreateExposureAttr(-1.5)
    real = UsdGeom.Camera.Define(stage, "/real")
    real.CreateExposureAttr(2)
    real.CreateExposureIsoAttr(400)
    real.CreateExposureFStopAttr(8)
    real.CreateExposureTimeAttr(1 / 50)
    real.CreateExposureResponsivityAttr(0.5)
    UsdGeom.Imageable(UsdGeom.Camera.Define(stage, "/hidden")).MakeInvisible()
    expected = [0, -1.5, 2 + np.log2(400 / 50 / 100 / 64 * 0.5)]
    np.testing.assert_allclose(latelight.usd_exposures(stage), expected, atol=1e-6)
    assert [camera.name for camera in latelight.from_usd(stage).cameras] == ["plain", "stops", "real"]


def test_usd_area_lights_keep_their_shapes(stage):
    from pxr import UsdGeom, UsdLux

    panel = UsdLux.RectLight.Define(stage, "/panel")
    panel.CreateWidthAttr(100)
    panel.CreateHeightAttr(50)
    panel.CreateIntensityAttr(3)
    UsdGeom.XformCommonAPI(panel).SetTranslate((0, 0, 200))
    disk = UsdLux.DiskLight.Define(stage, "/disk")
    disk.CreateRadiusAttr(20)
    disk.CreateIntensityAttr(5)
    disk.CreateNormalizeAttr(True)
    UsdLux.CylinderLight.Define(stage, "/tube").CreateLengthAttr(150)
    scene = latelight.from_usd(stage)
    lights = {light.name: light for light in map(scene.light, scene.lights())}
    assert [lights[name].type for name in ("panel", "disk", "tube")] == ["rect", "disk", "tube"]
    rect = lights["panel"]
    np.testing.assert_allclose((rect.width * rect.scale[0], rect.height * rect.scale[1]), (1, 0.5), atol=1e-6)
    np.testing.assert_allclose(rect.position, (0, 2, 0), atol=1e-6)
    np.testing.assert_allclose(np.array(rect.direction) / np.linalg.norm(rect.direction), (0, -1, 0), atol=1e-6)
    assert rect.intensity == 3 and lights["disk"].intensity == pytest.approx(5 / (np.pi * 20**2))


def test_usd_skeletons_pose_their_meshes(stage):
    """Two bones along Y: the upper one turns by 90 degrees about Z and carries the square at its end."""
    from pxr import Gf, Sdf, UsdGeom, UsdSkel, Vt

    root = UsdSkel.Root.Define(stage, "/figure")
    skeleton = UsdSkel.Skeleton.Define(stage, "/figure/bones")
    skeleton.CreateJointsAttr(["low", "low/high"])
    rest = [Gf.Matrix4d(1), Gf.Matrix4d().SetTranslate((0, 100, 0))]
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(rest))
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(rest))
    pose = UsdSkel.Animation.Define(stage, "/figure/pose")
    pose.CreateJointsAttr(["low/high"])
    pose.CreateTranslationsAttr([(0, 100, 0)])
    pose.CreateScalesAttr([(1, 1, 1)])
    turns = pose.CreateRotationsAttr()
    turns.Set([Gf.Quatf(1, 0, 0, 0)], 0)
    turns.Set([Gf.Quatf(0.5**0.5, 0, 0, 0.5**0.5)], 1)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/figure/pose"])
    mesh = UsdGeom.Mesh.Define(stage, "/figure/flag")
    mesh.CreatePointsAttr([(0, 0, 0), (10, 0, 0), (10, 100, 0), (10, 200, 0), (0, 200, 0), (0, 100, 0)])
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 5, 5, 2, 3, 4])
    mesh.CreateNormalsAttr([(0, 0, 1)] * 3 + [(0, 1, 0)] * 2 + [(0, 0, 1)])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets(["/figure/bones"])
    binding.CreateJointIndicesPrimvar(False, 1).Set([0, 0, 0, 1, 1, 0])
    binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * 6)
    UsdGeom.XformCommonAPI(root).SetTranslate((0, 0, 300))
    at_rest, posed = latelight.from_usd(stage, time=0), latelight.from_usd(stage, time=1)
    assert_bounds(at_rest, (0, 3, -2), (0.1, 3, 0))
    # The points at y = 200 turn about (0, 100): (0, 200) to (-100, 100) and (10, 200) to (-100, 110).
    assert_bounds(posed, (-1, 3, -1.1), (0.1, 3, 0))
    root.CreatePurposeAttr("guide")  # the mesh has a purpose of its own
    mesh.CreatePurposeAttr("render")
    assert_bounds(latelight.from_usd(stage, time=1), (-1, 3, -1.1), (0.1, 3, 0))
    arrays = posed.mesh_arrays(posed.meshes()[0])
    turned = arrays["normals"][np.abs(arrays["positions"][:, 0] + 100) < 1e-3]
    assert len(turned) > 0
    np.testing.assert_allclose(turned, np.tile((-1, 0, 0), (len(turned), 1)), atol=1e-6)
    binding.GetJointIndicesPrimvar().Set([0, 0, 0, 2, 1, 0])
    with pytest.raises(latelight.UsageError, match="/figure/flag has joint influences that do not match"):
        latelight.from_usd(stage, time=0)


def blended_stage(stage):
    """A square with two blend shapes: one with an in-between moves all points, the other moves one."""
    from pxr import UsdGeom, UsdSkel, Vt

    root = UsdSkel.Root.Define(stage, "/face")
    skeleton = UsdSkel.Skeleton.Define(stage, "/face/bones")
    skeleton.CreateJointsAttr([])
    pose = UsdSkel.Animation.Define(stage, "/face/pose")
    pose.CreateBlendShapesAttr(["smile", "wink"])
    weights = pose.CreateBlendShapeWeightsAttr()
    for time, values in ((0, [0, 0]), (1, [1, 0]), (2, [0.25, 1])):
        weights.Set(Vt.FloatArray(values), time)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/face/pose"])
    mesh = UsdGeom.Mesh.Define(stage, "/face/square")
    mesh.CreatePointsAttr([(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateNormalsAttr([(0, 0, 1)] * 4)
    smile = UsdSkel.BlendShape.Define(stage, "/face/square/smile")
    smile.CreateOffsetsAttr([(0, 0, 40)] * 4)
    smile.CreateNormalOffsetsAttr([(1, 0, 0)] * 4)
    between = smile.CreateInbetween("half")
    between.SetWeight(0.5)
    between.SetOffsets([(0, 0, 100)] * 4)
    wink = UsdSkel.BlendShape.Define(stage, "/face/square/wink")
    wink.CreateOffsetsAttr([(50, 0, 0)])
    wink.CreatePointIndicesAttr([2])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets(["/face/bones"])
    binding.CreateBlendShapesAttr(["wink", "smile"])  # in another order than the animation's
    binding.CreateBlendShapeTargetsRel().SetTargets(["/face/square/wink", "/face/square/smile"])
    return root, wink


def test_usd_blend_shapes_follow_their_weights(stage):
    _, wink = blended_stage(stage)
    assert_bounds(latelight.from_usd(stage, time=0), (0, 0, -1), (1, 0, 0))
    smiling = latelight.from_usd(stage, time=1)
    assert_bounds(smiling, (0, 0.4, -1), (1, 0.4, 0))
    normals = smiling.mesh_arrays(smiling.meshes()[0])["normals"]
    np.testing.assert_allclose(normals, np.tile((0.5**0.5, 0, 0.5**0.5), (len(normals), 1)), atol=1e-6)
    # A weight of 0.25 is halfway to the in-between shape at 0.5: 50 units along Z.
    assert_bounds(latelight.from_usd(stage, time=2), (0, 0.5, -1), (1.5, 0.5, 0))
    wink.GetPointIndicesAttr().Set([4])
    with pytest.raises(latelight.UsageError, match="/face/square has a blend shape that does not match its points"):
        latelight.from_usd(stage, time=2)


def test_usd_blend_shapes_come_before_the_skeleton(stage):
    from pxr import Gf, UsdGeom, UsdSkel, Vt

    root, _ = blended_stage(stage)
    skeleton = UsdSkel.Skeleton.Get(stage, "/face/bones")
    skeleton.GetJointsAttr().Set(["head"])
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([Gf.Matrix4d(1)]))
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation((1, 0, 0), 90))
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray([turn]))
    binding = UsdSkel.BindingAPI(stage.GetPrimAtPath("/face/square"))
    binding.CreateJointIndicesPrimvar(False, 1).Set([0] * 4)
    binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * 4)
    UsdGeom.XformCommonAPI(root).SetTranslate((0, 0, 300))
    # (x, y, 40) turns to (x, -40, y), which is (x, y, 40) with Y up, 3 m above the ground.
    assert_bounds(latelight.from_usd(stage, time=1), (0, 3, 0.4), (1, 4, 0.4))


def background(scene, device, direction):
    """The radiance of the environment in a direction of the scene's frame."""
    up = (1, 0, 0) if abs(direction[1]) > 0.9 else (0, 1, 0)
    camera = latelight.Camera.look_at((0, 0, 0), direction, up, vertical_fov=1)
    renderer = latelight.Renderer(scene, device)
    return renderer.render(camera, (1, 1), ("color",), background="hdri")["color"][0, 0, :3]


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_usd_dome_lights_are_environments(up, tmp_path, device):
    image = pytest.importorskip("PIL.Image")
    from pxr import Usd, UsdGeom, UsdLux

    # OpenEXR's convention: the center is +Z, a quarter of the width left of it is +X, and the top row is +Y.
    colors = np.zeros((64, 128, 3), np.uint8)
    colors[:, 48:80, 0] = 255  # +Z is red
    colors[:, 16:48, 1] = 255  # +X is green
    colors[:8] = (0, 0, 255)
    image.fromarray(colors).save(tmp_path / "sky.png")
    stage = Usd.Stage.CreateNew(str(tmp_path / "sky.usda"))
    UsdGeom.SetStageUpAxis(stage, getattr(UsdGeom.Tokens, up.lower()))
    dome = UsdLux.DomeLight_1.Define(stage, "/sky") if up == "Z" else UsdLux.DomeLight.Define(stage, "/sky")
    dome.CreateTextureFileAttr("sky.png")
    dome.CreateIntensityAttr(0.5)
    dome.CreateExposureAttr(3)
    dome.CreateColorAttr((0.5, 1, 1))
    stage.Save()
    # With Z up, the dome is turned about X and the stage back, so both stages have the same sky.
    scene = latelight.from_usd(tmp_path / "sky.usda")
    np.testing.assert_allclose(background(scene, device, (0, 0, 1)), (2, 0, 0), atol=1e-2)
    np.testing.assert_allclose(background(scene, device, (1, 0, 0)), (0, 4, 0), atol=1e-2)
    np.testing.assert_allclose(background(scene, device, (0, 1, 0)), (0, 0, 4), atol=1e-2)
    np.testing.assert_allclose(background(scene, device, (-1, 0, 0)), 0, atol=1e-2)
    turn = dome.AddRotateYOp() if up == "Y" else dome.AddRotateZOp()
    turn.Set(90)  # counter-clockwise from above: +Z goes to +X
    stage.Save()
    np.testing.assert_allclose(background(latelight.Scene(tmp_path / "sky.usda"), device, (1, 0, 0)), (2, 0, 0), atol=1e-2)
    for scale, green in (((-1, 1, 1), -1), ((0, 0, 0), 1)):  # a mirrored sky, and no size that a sky could have
        dome.ClearXformOpOrder()
        dome.AddScaleOp().Set(scale)
        np.testing.assert_allclose(background(latelight.from_usd(stage), device, (green, 0, 0)), (0, 4, 0), atol=1e-2)
    dome.CreateTextureFormatAttr("angular")
    with pytest.raises(latelight.UsageError, match="/sky has a texture that is not latlong"):
        latelight.from_usd(stage)


def test_usd_dome_lights_read_hdr_and_add_up(stage, tmp_path, device):
    from pxr import UsdLux

    UsdLux.DomeLight.Define(stage, "/gray").CreateIntensityAttr(2)
    blue = UsdLux.DomeLight.Define(stage, "/blue")
    blue.CreateColorAttr((0, 0, 1))
    blue.CreateIntensityAttr(100)
    scene = latelight.from_usd(stage)
    np.testing.assert_allclose(background(scene, device, (0.3, 0.2, 1)), (2, 2, 102), rtol=1e-3)
    # RGBE: a value is its byte times 2^(exponent - 136).
    pixels = bytes((128, 64, 0, 129)) * 2
    (tmp_path / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + pixels)
    np.testing.assert_array_equal(latelight.read_environment(tmp_path / "sky.hdr"), [[(1, 0.5, 0)] * 2])
    blue.CreateTextureFileAttr(str(tmp_path / "sky.hdr"))
    blue.GetColorAttr().Set((1, 1, 1))
    scene = latelight.from_usd(stage)
    np.testing.assert_allclose(background(scene, device, (0.3, 0.2, 1)), (102, 52, 2), rtol=1e-3)
    with pytest.raises(latelight.UsageError, match="twice as wide as it is high, and not 3x2"):
        scene.set_environment(np.ones((2, 3, 3), np.float32))


# --- files outside ----------------------------------------------------------------------------------------------------


def test_files_of_urdf_stay_in_its_folder(tmp_path):
    pytest.importorskip("yourdfpy")
    (tmp_path / "robot").mkdir()
    mesh = trimesh.creation.box((1, 1, 1)).export(file_type="stl")
    for folder in (tmp_path, tmp_path / "robot"):
        (folder / "box.stl").write_bytes(mesh)
    urdf = tmp_path / "robot" / "robot.urdf"

    def refer(name):
        urdf.write_text(
            f'<robot name="r"><link name="l"><visual><geometry><mesh filename="{name}"/></geometry></visual></link></robot>'
        )

    refer("box.stl")
    assert latelight.from_urdf(urdf).triangle_count == 12
    for name in ("../box.stl", str(tmp_path / "box.stl"), "file://" + str(tmp_path / "box.stl")):
        refer(name)
        with pytest.raises(latelight.InputError, match="box.stl, which is outside the scene's folder, at .*allow_outside"):
            latelight.from_urdf(urdf)
        assert latelight.from_urdf(urdf, allow_outside=[tmp_path]).triangle_count == 12
        assert latelight.Scene(urdf, allow_outside=[str(tmp_path)]).triangle_count == 12
    (tmp_path / "robot" / "link.stl").symlink_to(tmp_path / "box.stl")
    refer("link.stl")
    with pytest.raises(latelight.InputError, match="outside the scene's folder"):
        latelight.from_urdf(urdf)
    (tmp_path / "package.xml").write_text("<package/>")  # a ROS package, whose files belong together
    refer("package://robot/box.stl")
    assert latelight.from_urdf(urdf).triangle_count == 12
    refer("../box.stl")
    assert latelight.from_urdf(urdf).triangle_count == 12
    with pytest.raises(latelight.UsageError, match="is not a folder: allow_outside requires"):
        latelight.from_urdf(urdf, allow_outside=[tmp_path / "none"])


# yourdfpy logs a warning of such a file and leaves out its geometry.
@pytest.mark.parametrize("kind", ["visual", "collision"])
def test_meshes_of_urdf_that_do_not_exist_are_reported(tmp_path, monkeypatch, kind):
    pytest.importorskip("yourdfpy")
    monkeypatch.chdir(tmp_path)  # to which yourdfpy resolves names that it does not find
    shapes = [f'<{kind}><geometry>{shape}</geometry></{kind}>' for shape in ('<box size="1 1 1"/>', '<mesh filename="a/b.stl"/>')]
    (tmp_path / "robot.urdf").write_text(f'<robot name="r"><link name="l">{"".join(shapes)}</link></robot>')
    with pytest.raises(latelight.InputError, match="robot.urdf: its mesh a/b.stl does not exist"):
        latelight.from_urdf(tmp_path / "robot.urdf", geometry=kind)


@pytest.mark.parametrize("convert", [latelight.from_usd, latelight.usd_exposures, latelight.Scene])
def test_missing_usd_files_are_reported(tmp_path, convert):
    with pytest.raises(latelight.InputError, match="missing.usda does not exist"):
        convert(tmp_path / "missing.usda")


def test_files_of_usd_stay_in_its_folder(tmp_path):
    from pxr import Sdf, Usd, UsdShade

    image = pytest.importorskip("PIL.Image")
    (tmp_path / "stage").mkdir()
    save_mesh_stage(tmp_path / "other.usda")
    path = str(tmp_path / "stage" / "stage.usda")
    stage = Usd.Stage.CreateNew(path)
    stage.DefinePrim("/mesh").GetReferences().AddReference("../other.usda")
    stage.Save()
    with pytest.raises(latelight.InputError, match="other.usda, which is outside the scene's folder"):
        latelight.from_usd(path)
    assert latelight.from_usd(path, allow_outside=[tmp_path]).triangle_count == 4
    with pytest.raises(latelight.UsageError, match="is not a folder: allow_outside requires"):
        latelight.from_usd(path, allow_outside=[tmp_path / "none"])
    assert latelight.from_usd(stage).triangle_count == 4  # a stage that the caller composed
    image.fromarray(np.full((2, 2, 3), 9, np.uint8)).save(tmp_path / "paint.png")
    painted = Usd.Stage.CreateNew(str(tmp_path / "stage" / "painted.usda"))
    shader = UsdShade.Shader.Define(painted, "/paint/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    texture = UsdShade.Shader.Define(painted, "/paint/image")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("../paint.png")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(
        texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    )
    bind(painted, shader)
    painted.Save()
    with pytest.raises(latelight.InputError, match="paint.png, which is outside the scene's folder"):
        latelight.from_usd(tmp_path / "stage" / "painted.usda")
    assert len(latelight.from_usd(tmp_path / "stage" / "painted.usda", allow_outside=[tmp_path]).textures()) == 1


@pytest.mark.parametrize("key", ["assetPaths", "manifestAssetPath", "templateAssetPath"])
def test_clips_of_usd_stay_in_its_folder(tmp_path, key):
    """Value clips, which no reference names: a mesh whose points are in another file."""
    from pxr import Gf, Sdf, Usd, UsdGeom, Vt

    (tmp_path / "stage").mkdir()
    for folder, name in ((tmp_path, "clip.1.usda"), (tmp_path / "stage", "clip.1.usda")):
        clip = Usd.Stage.CreateNew(str(folder / name))
        points = UsdGeom.Mesh.Define(clip, "/mesh").CreatePointsAttr()
        for code in (0, 10):
            points.Set([(0, 0, code), (1, 0, code), (0, 1, code)], code)
        clip.Save()
    path = str(tmp_path / "stage" / "stage.usda")
    stage = Usd.Stage.CreateNew(path)
    mesh = UsdGeom.Mesh.Define(stage, "/mesh")
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    inside = Sdf.AssetPath("./clip.1.usda")
    clips = {"primPath": "/mesh", "assetPaths": Sdf.AssetPathArray([inside]), "manifestAssetPath": inside}
    clips |= {"active": Vt.Vec2dArray([Gf.Vec2d(0, 0)]), "times": Vt.Vec2dArray([Gf.Vec2d(0, 0), Gf.Vec2d(10, 10)])}
    mesh.GetPrim().SetMetadata("clips", {"default": clips})
    stage.Save()
    scene = latelight.from_usd(path)
    assert scene.triangle_count == 1 and len(scene.animations) == 1
    outside = {
        "assetPaths": Sdf.AssetPathArray([Sdf.AssetPath("../clip.1.usda")]),
        "manifestAssetPath": Sdf.AssetPath("../clip.1.usda"),
        "templateAssetPath": "../clip.#.usda",
    }
    mesh.GetPrim().SetMetadata("clips", {"default": {**clips, key: outside[key]}})
    stage.Save()
    with pytest.raises(latelight.InputError, match="clip.*usda, which is outside the scene's folder"):
        latelight.from_usd(path)


def test_expressions_of_usd_stay_in_its_folder(tmp_path, monkeypatch):
    """References whose names are computed from variables, also in the folder of the stage."""
    from pxr import Usd

    (tmp_path / "stage").mkdir()
    for folder in (tmp_path, tmp_path / "stage"):
        save_mesh_stage(folder / "other.usda")
    path = str(tmp_path / "stage" / "stage.usda")
    stage = Usd.Stage.CreateNew(path)
    stage.DefinePrim("/mesh").GetReferences().AddReference('`"${FOLDER}/other.usda"`')
    monkeypatch.chdir(tmp_path / "stage")
    stage.GetRootLayer().expressionVariables = {"FOLDER": "."}
    stage.Save()
    assert latelight.from_usd(path).triangle_count == 4
    stage.GetRootLayer().expressionVariables = {"FOLDER": ".."}
    stage.Save()
    with pytest.raises(latelight.InputError, match="other.usda, which is outside the scene's folder"):
        latelight.from_usd(path)
    assert latelight.from_usd(path, allow_outside=[tmp_path]).triangle_count == 4


def bind(stage, shader, context=None):
    from pxr import UsdShade

    material = UsdShade.Material.Define(stage, shader.GetPath().GetParentPath())
    output = material.CreateSurfaceOutput(context) if context else material.CreateSurfaceOutput()
    output.ConnectToSource(shader.ConnectableAPI(), "out")
    mesh = add_mesh(stage, "/squares")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    return mesh


def only_material(scene):
    (handle,) = scene.materials()
    return handle, scene.material(handle)


def test_usd_standard_surfaces_of_materialx(stage):
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    shader.CreateInput("base", types.Float).Set(0.5)
    shader.CreateInput("metalness", types.Float).Set(0.25)
    shader.CreateInput("specular_roughness", types.Float).Set(0.75)
    shader.CreateInput("specular_IOR", types.Float).Set(2)
    shader.CreateInput("coat", types.Float).Set(0.3)
    shader.CreateInput("sheen", types.Float).Set(0.5)
    shader.CreateInput("sheen_color", types.Color3f).Set((1, 0.5, 0))
    shader.CreateInput("emission", types.Float).Set(4)
    shader.CreateInput("emission_color", types.Color3f).Set((1, 0, 0))
    shader.CreateInput("opacity", types.Color3f).Set((0.5, 0.5, 0.5))
    graph = UsdShade.NodeGraph.Define(stage, "/paint/graph")  # a constant through a node graph
    graph.CreateInput("tint", types.Color3f).Set((0.2, 0.4, 0.6))
    graph.CreateOutput("out", types.Color3f).ConnectToSource(graph.GetInput("tint"))
    shader.CreateInput("base_color", types.Color3f).ConnectToSource(graph.GetOutput("out"))
    bind(stage, shader, "mtlx")
    _, made = only_material(latelight.from_usd(stage))
    np.testing.assert_allclose(made.base_color, (0.1, 0.2, 0.3, 0.5), atol=1e-6)
    assert (made.metallic, made.roughness, made.alpha_mode) == (0.25, 0.75, "blend")
    np.testing.assert_allclose((made.f0, made.clearcoat, made.clearcoat_roughness), (1 / 9, 0.3, 0.1), atol=1e-6)
    np.testing.assert_allclose((*made.sheen_color, *made.emissive), (0.5, 0.25, 0, 4, 0, 0), atol=1e-6)


def test_usd_images_of_scalars_are_packed(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    image.fromarray(np.full((2, 2, 3), (10, 20, 30), np.uint8)).save(tmp_path / "orm.png")
    image.fromarray(np.full((4, 4), 99, np.uint8)).save(tmp_path / "mask.png")
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    inputs = [("occlusion", "orm", "r"), ("roughness", "orm", "g"), ("metallic", "orm", "b"), ("opacity", "mask", "r")]
    for name, file, channel in inputs:
        texture = UsdShade.Shader.Define(stage, f"/paint/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(str(tmp_path / f"{file}.png"))
        output = texture.CreateOutput(channel, types.Float)
        shader.CreateInput(name, types.Float).ConnectToSource(output)
    bind(stage, shader)
    scene = latelight.from_usd(stage)
    _, made = only_material(scene)
    assert (made.metallic, made.roughness, made.alpha_mode) == (1, 1, "blend")
    scene.export(tmp_path / "paint.glb")
    (mesh,) = trimesh.load(tmp_path / "paint.glb").geometry.values()
    paint = mesh.visual.material
    assert np.asarray(paint.metallicRoughnessTexture)[0, 0, 1:3].tolist() == [20, 30]
    assert np.asarray(paint.occlusionTexture)[0, 0, 0] == 10
    assert np.asarray(paint.baseColorTexture)[0, 0].tolist() == [255, 255, 255, 99]


def painted(stage, file):
    """A mesh whose color and roughness are images."""
    from pxr import Sdf, UsdShade

    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    texture = UsdShade.Shader.Define(stage, "/paint/image")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(file))
    for name, channel, kind in (("diffuseColor", "rgb", "Color3f"), ("roughness", "r", "Float")):
        output = texture.CreateOutput(channel, getattr(Sdf.ValueTypeNames, kind))
        shader.CreateInput(name, getattr(Sdf.ValueTypeNames, kind)).ConnectToSource(output)
    bind(stage, shader)


def painted_with(scene, folder):
    """A pixel of the color, and the roughness there."""
    scene.export(folder / "painted.glb")
    (mesh,) = trimesh.load(folder / "painted.glb").geometry.values()
    paint = mesh.visual.material
    color, packed = np.asarray(paint.baseColorTexture), np.asarray(paint.metallicRoughnessTexture)
    return color[0, 0, :3].tolist(), int(packed[0, 0, 1])


@pytest.mark.parametrize("given, mode", [("", "opaque"), ("opacity", "blend"), ("opacityThreshold", "mask")])
def test_usd_colors_exclude_the_alpha_of_their_image(stage, tmp_path, given, mode):
    """The output rgb of a UsdUVTexture has no alpha: the opacity is that of the input of this name, which is 1 by
    default."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 4), (200, 100, 50, 0), np.uint8)).save(tmp_path / "clear.png")
    painted(stage, tmp_path / "clear.png")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    if given:
        surface.CreateInput(given, Sdf.ValueTypeNames.Float).Set(0.5)
    scene = latelight.from_usd(stage)
    handle, made = only_material(scene)
    assert (made.alpha_mode, made.base_color[3]) == (mode, 0.5 if given == "opacity" else 1)
    assert scene.texture_pixels(scene.texture_of(handle, "base_color"))[0, 0].tolist() == [200, 100, 50, 255]


def painted_by_materialx(stage, file):
    """A translucent mesh whose color is an image. Returns the shader of the image."""
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    texture = UsdShade.Shader.Define(stage, "/paint/image")
    texture.CreateIdAttr("ND_image_color3")
    texture.CreateInput("file", types.Asset).Set(str(file))
    shader.CreateInput("base_color", types.Color3f).ConnectToSource(texture.CreateOutput("out", types.Color3f))
    shader.CreateInput("opacity", types.Color3f).Set((0.5, 0.5, 0.5))
    bind(stage, shader, "mtlx")
    return texture


def test_materialx_colors_exclude_the_alpha_of_their_image(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.full((2, 2, 4), (200, 100, 50, 0), np.uint8)).save(tmp_path / "clear.png")
    painted_by_materialx(stage, tmp_path / "clear.png")
    scene = latelight.from_usd(stage)
    handle, made = only_material(scene)
    assert (made.alpha_mode, made.base_color[3]) == ("blend", 0.5)
    assert scene.texture_pixels(scene.texture_of(handle, "base_color"))[0, 0].tolist() == [200, 100, 50, 255]


def test_usd_surfaces_may_have_the_specular_workflow(stage, tmp_path):
    """specularColor is the reflectance at normal incidence, which is f0 times specular_color
    (KHR_materials_specular). metallic and ior do not apply to it."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    surface.CreateInput("ior", types.Float).Set(2)
    surface.CreateInput("metallic", types.Float).ConnectToSource(texture.GetOutput("r"))
    color = surface.CreateInput("specularColor", types.Color3f)
    color.Set((1, 0.5, 0.02))
    workflow = surface.CreateInput("useSpecularWorkflow", types.Int)

    def converted():
        scene = latelight.from_usd(stage)
        handle, made = only_material(scene)
        reflectance = np.multiply(made.specular_color, made.f0)
        texels = scene.texture_pixels(scene.texture_of(handle, "metallic_roughness"))[0, 0, 1:3].tolist()
        return made.metallic, reflectance, texels, scene.texture_of(handle, "specular_color") is not None

    workflow.Set(0)
    metallic, reflectance, texels, has_texture = converted()
    assert (metallic, texels, has_texture) == (1, [200, 200], False)
    np.testing.assert_allclose(reflectance, 1 / 9, atol=1e-6)
    workflow.Set(1)
    metallic, reflectance, texels, has_texture = converted()
    assert (metallic, texels, has_texture) == (0, [200, 255], False)
    np.testing.assert_allclose(reflectance, (1, 0.5, 0.02), atol=1e-6)
    color.ConnectToSource(texture.GetOutput("rgb"))
    _, reflectance, _, has_texture = converted()
    assert has_texture
    np.testing.assert_allclose(reflectance, 1, atol=1e-6)


@pytest.mark.parametrize(
    "file, reason",
    [("gone.png", "does not exist"), ("gone.<UDIM>.png", "consists of UDIM tiles, which are not supported")],
)
def test_usd_images_that_do_not_exist_are_left_out(stage, file, reason):
    from pxr import UsdShade

    painted(stage, file)
    with pytest.warns(UserWarning) as raised:
        scene = latelight.from_usd(stage)
    assert [str(warning.message) for warning in raised] == [f"the image {file} of /paint/image {reason}, and is left out"]
    assert scene.textures() == []
    UsdShade.Shader(stage.GetPrimAtPath("/paint/image")).GetInput("file").Set("")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        latelight.from_usd(stage)


def test_usd_images_may_be_inputs_of_the_material(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 120, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, "")
    given = UsdShade.Material.Define(stage, "/paint").CreateInput("image", Sdf.ValueTypeNames.Asset)
    given.Set(str(tmp_path / "gray.png"))
    file = UsdShade.Shader(stage.GetPrimAtPath("/paint/image")).GetInput("file")
    file.GetAttr().Clear()
    file.ConnectToSource(given)
    assert painted_with(latelight.from_usd(stage), tmp_path) == ([120] * 3, 120)


def test_usd_images_may_have_16_bits(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.full((2, 2), 120 * 257 - 100, np.uint16)).save(tmp_path / "deep.png")  # rounds to 120
    painted(stage, tmp_path / "deep.png")
    assert painted_with(latelight.from_usd(stage), tmp_path) == ([120, 120, 120], 120)


@pytest.mark.parametrize("packaged", [False, True])
def test_usd_images_may_have_linear_values(stage, tmp_path, packaged):
    """Radiance's RGBE: a mantissa m of 8 bits and an exponent e are m / 256 * 2^(e - 128). Colors become sRGB (IEC
    61966-2-1): 0.75, 0.25 and 0.125 are 225, 137 and 99 of 255. The roughness 0.75 is 191."""
    from pxr import Sdf

    texel = bytes((192, 64, 32, 128))
    (tmp_path / "paint.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + 4 * texel)
    file = tmp_path / "paint.hdr"
    if packaged:
        archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / "paint.usdz"))
        archive.AddFile(str(file), "paint.hdr")
        archive.Save()
        file = f"{tmp_path}/paint.usdz[paint.hdr]"
    painted(stage, file)
    assert painted_with(latelight.from_usd(stage), tmp_path) == ([225, 137, 99], 191)


@pytest.mark.parametrize("name", ["paint.png", "paint.jpg", "paint.exr"])
@pytest.mark.parametrize("damage", ["truncated", "garbage", "empty"])
def test_usd_images_that_cannot_be_decoded_are_named(stage, tmp_path, name, damage):
    image = pytest.importorskip("PIL.Image")

    file = tmp_path / name
    if name.endswith(".exr"):
        file.write_bytes(b"\x76\x2f\x31\x01")  # the magic number
    else:
        image.fromarray(np.random.default_rng(1).integers(0, 255, (16, 16, 3), np.uint8)).save(file)
    contents = {"truncated": file.read_bytes()[: file.stat().st_size // 2], "garbage": b"no image", "empty": b""}
    file.write_bytes(contents[damage])
    painted(stage, file)
    with pytest.raises(latelight.InputError, match=re.escape(str(file))):
        latelight.from_usd(stage)
    stage.GetRootLayer().Export(str(tmp_path / "stage.usda"))
    with pytest.raises(latelight.InputError, match=re.escape(str(file))) as raised:
        latelight.from_usd(tmp_path / "stage.usda")
    assert "usd-core" not in str(raised.value)


def test_usd_images_are_scaled(stage, tmp_path):
    """UsdUVTexture: values of an image are multiplied by a scale before they are used."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 255, np.uint8)).save(tmp_path / "white.png")
    painted(stage, tmp_path / "white.png")
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set((0.25, 0.5, 2, 1))
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    emissive = surface.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f)
    emissive.ConnectToSource(texture.GetOutput("rgb"))
    opacity = surface.CreateInput("opacity", Sdf.ValueTypeNames.Float)
    opacity.ConnectToSource(texture.CreateOutput("g", Sdf.ValueTypeNames.Float))
    _, made = only_material(latelight.from_usd(stage))
    np.testing.assert_allclose(made.base_color, (0.25, 0.5, 1, 0.5))  # glTF's colors are at most 1
    assert (made.roughness, tuple(made.emissive)) == (0.25, (0.25, 0.5, 2))
    texture.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set((0.1, 0, 0, 0))
    _, made = only_material(latelight.from_usd(stage))
    np.testing.assert_allclose((*made.base_color, made.roughness), 1)


def samplers(scene, folder):
    """The wrap modes of glTF's samplers: 10497 is REPEAT, 33071 CLAMP_TO_EDGE, 33648 MIRRORED_REPEAT (5.26)."""
    scene.export(folder / "wrapped.glb")
    data = (folder / "wrapped.glb").read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    modes = [(each.get("wrapS", 10497), each.get("wrapT", 10497)) for each in document["samplers"]]
    return {modes[texture["sampler"]] for texture in document["textures"]}


REPEAT, CLAMP, MIRROR = 10497, 33071, 33648


def connect_primvar(stage, shader, name, kind, primvar, fallback=None):
    """Connects an input of a shader to a reader of a primvar. Kinds are float, float2 or float3."""
    from pxr import Sdf, UsdShade

    types, path = Sdf.ValueTypeNames, f"{shader.GetPath().GetParentPath()}/{shader.GetPrim().GetName()}_{name}"
    reader, value_type = UsdShade.Shader.Define(stage, path), getattr(types, kind.capitalize())
    reader.CreateIdAttr(f"UsdPrimvarReader_{kind}")
    reader.CreateInput("varname", types.String).Set(primvar)
    if fallback is not None:
        reader.CreateInput("fallback", value_type).Set(fallback)
    shader.CreateInput(name, value_type).ConnectToSource(reader.CreateOutput("result", value_type))
    return reader


def preview_surface(stage, path="/paint/surface"):
    from pxr import UsdShade

    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr("UsdPreviewSurface")
    return shader


def colors_at(scene, points):
    """The colors of the only instance at corners at these points, of which all corners there have one."""
    (handle,) = scene.instances()
    instance = scene.instance(handle)
    colors, positions = surface_colors(scene, instance), scene.mesh_arrays(instance.mesh)["positions"]
    found = [np.unique(colors[(positions == point).all(axis=1)].round(4), axis=0) for point in points]
    return [same.tolist() for same in found]


@pytest.mark.parametrize("interpolation, values, expected", [
    ("constant", [(0, 1, 0)], [[0, 1, 0]] * 6),
    ("constant", (0, 0.5, 1), [[0, 0.5, 1]] * 6),  # no array
    ("vertex", [(n / 8, 0, 1) for n in range(6)], [[n / 8, 0, 1] for n in range(6)]),
    ("faceVarying", [(n, n / 8, 0) for n in (0, 0, 0, 0, 1, 1, 1, 1)], None),
    ("uniform", [(1, 0, 0), (0, 0, 1)], None),
    ("vertex", [(1, 0, 0)] * 5, [[0.25, 0.5, 0.75]] * 6),  # fewer values than points
    (None, None, [[0.25, 0.5, 0.75]] * 6),
])  # fmt: skip
def test_usd_surfaces_read_colors_of_primvars(stage, interpolation, values, expected):
    shader = preview_surface(stage)
    mesh = bind(stage, shader)
    connect_primvar(stage, shader, "diffuseColor", "float3", "paint", (0.25, 0.5, 0.75))
    if interpolation:
        add_primvar(mesh, "paint", "Color3fArray" if isinstance(values, list) else "Color3f", interpolation, values)
    scene = latelight.from_usd(stage)
    if expected:
        made = colors_at(scene, mesh.GetPointsAttr().Get())
        assert made == [[pytest.approx([*color, 1], abs=1e-4)] for color in expected]
    else:  # points 0 and 3 belong to the first face only, and points 4 and 5 to the second one
        first, second = ([*color, 1] for color in (values[0], values[-1]))
        points = [mesh.GetPointsAttr().Get()[n] for n in (0, 3, 4, 5)]
        assert colors_at(scene, points) == [[first], [first], [second], [second]]
    assert only_material(scene)[1].alpha_mode == "opaque"


def test_usd_surfaces_read_opacities_of_primvars(stage):
    shader = preview_surface(stage)
    mesh = bind(stage, shader)
    connect_primvar(stage, shader, "opacity", "float", "displayOpacity")
    opacity = mesh.CreateDisplayOpacityPrimvar("vertex")
    opacity.Set([0, 0.25, 0.5, 0.75, 1, 1])
    scene = latelight.from_usd(stage)
    made = colors_at(scene, mesh.GetPointsAttr().Get())
    assert made == [[pytest.approx([0.18, 0.18, 0.18, alpha])] for alpha in (0, 0.25, 0.5, 0.75, 1, 1)]
    assert only_material(scene)[1].alpha_mode == "blend"


def test_usd_surfaces_read_constant_primvars(stage, tmp_path):
    """Meshes with a material differ in its constants, which are those of the mesh, inherited or the fallback, and share
    its textures."""
    image = pytest.importorskip("PIL.Image")
    from pxr import UsdGeom, UsdShade

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    shader = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    connect_primvar(stage, shader, "metallic", "float", "metal", 0.75)
    connect_primvar(stage, shader, "emissiveColor", "float3", "glow")
    material = UsdShade.Material(stage.GetPrimAtPath("/paint"))
    for name in ("/group/one", "/two"):
        UsdShade.MaterialBindingAPI.Apply(add_mesh(stage, name).GetPrim()).Bind(material)
    add_primvar(UsdGeom.Xform.Define(stage, "/group"), "metal", "FloatArray", "constant", [0.25])
    add_primvar(stage.GetPrimAtPath("/two"), "metal", "FloatArray", "constant", [0.5])
    add_primvar(stage.GetPrimAtPath("/two"), "glow", "Color3fArray", "constant", [(0, 1, 2)])
    scene = latelight.from_usd(stage)
    materials = {n.path: scene.material(scene.instance(i).material) for n, i in zip(scene.nodes, scene.instances())}
    made = {path: (material.metallic, material.emissive) for path, material in materials.items()}
    assert made == {"/group.one": (0.25, (0, 0, 0)), "/two": (0.5, (0, 1, 2)), "/squares": (0.75, (0, 0, 0))}
    assert len(scene.textures()) == 2  # of color and of roughness
    add_primvar(stage.GetPrimAtPath("/two"), "metal", "FloatArray", "vertex", [0.5] * 6)
    with pytest.warns(UserWarning, match='fallback of the primvar "metal" for metallic of /paint/surface, because only'):
        latelight.from_usd(stage)


def test_usd_copies_of_instancers_have_primvars_of_their_material(stage):
    """The material of a prototype reads a primvar with a value per copy, whose name is an input of the material."""
    from pxr import Sdf, UsdShade

    shader = preview_surface(stage)
    mesh = bind(stage, shader)
    reader = connect_primvar(stage, shader, "diffuseColor", "float3", "", (0.5, 0.5, 0.5))
    named = UsdShade.Material(stage.GetPrimAtPath("/paint")).CreateInput("name", Sdf.ValueTypeNames.String)
    named.Set("peanut")
    reader.GetInput("varname").ConnectToSource(named)
    copies = add_instancer(stage, "/copies", [mesh.GetPath()])
    stage.GetPrimAtPath("/squares").SetSpecifier(Sdf.SpecifierOver)
    add_primvar(copies, "peanut", "Color3fArray", "vertex", [(1, 0, 0), (0, 0, 1)])
    add_primvar(copies, "name", "StringArray", "vertex", ["a", "b"])
    scene = latelight.from_usd(stage)
    assert colors_by_node(scene) == {"/copies.0": [(1, 0, 0, 1)], "/copies.1": [(0, 0, 1, 1)]}
    assert len(scene.meshes()) == 1


def test_materialx_surfaces_read_primvars(stage):
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    reader = UsdShade.Shader.Define(stage, "/paint/graph/reader")
    UsdShade.NodeGraph.Define(stage, "/paint/graph")
    reader.CreateIdAttr("ND_geompropvalue_color3")
    reader.CreateInput("geomprop", types.String).Set("paint")
    reader.CreateInput("default", types.Color3f).Set((0, 0, 0.5))
    output = UsdShade.NodeGraph(stage.GetPrimAtPath("/paint/graph")).CreateOutput("color", types.Color3f)
    output.ConnectToSource(reader.CreateOutput("out", types.Color3f))
    shader.CreateInput("base_color", types.Color3f).ConnectToSource(output)
    mesh = bind(stage, shader, "mtlx")
    points = mesh.GetPointsAttr().Get()
    assert colors_at(latelight.from_usd(stage), points) == [[[0, 0, 0.5, 1]]] * 6
    add_primvar(mesh, "paint", "Color3fArray", "vertex", [(n / 8, 0, 1) for n in range(6)])
    assert colors_at(latelight.from_usd(stage), points) == [[[n / 8, 0, 1, 1]] for n in range(6)]


def texture_coordinates(scene):
    """The coordinates per corner, with v up as in USD; the last vertices are those of the second face."""
    (handle,) = scene.instances()
    uv = np.array(scene.mesh_arrays(scene.instance(handle).mesh)["uv"])
    return np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)


@pytest.mark.parametrize("through", ["", "transform"])
@pytest.mark.parametrize("primvar, scale", [("st", 1), ("uv2", 2), ("map1", 3), ("missing", None), ("", 1)])
def test_usd_images_have_their_own_texture_coordinates(stage, tmp_path, primvar, scale, through):
    """By the name that the reader states; without a name, by the usual ones. A mesh without the primvar has the reader's
    fallback."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    mesh = stage.GetPrimAtPath("/squares")
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)])
    for name, factor in (("st", 1), ("uv2", 2), ("map1", 3)):
        add_primvar(mesh, name, "TexCoord2fArray", "vertex", (corners * factor).tolist())
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    if through:
        turn = UsdShade.Shader.Define(stage, "/paint/turn")
        turn.CreateIdAttr("UsdTransform2d")
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
            turn.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        )
        connect_primvar(stage, turn, "in", "float2", primvar, (0.25, 0.5))
    else:
        connect_primvar(stage, texture, "st", "float2", primvar, (0.25, 0.5))
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        scene = latelight.from_usd(stage)
    messages = ['meshes without the primvar "missing", which their material states'] if scale is None else []
    assert [str(warning.message)[: len(messages[0])] for warning in warned] == messages
    (handle,) = scene.instances()
    points = scene.mesh_arrays(scene.instance(handle).mesh)["positions"][:, :2] / 100
    np.testing.assert_allclose(texture_coordinates(scene), np.tile((0.25, 0.5), (12, 1)) if scale is None else scale * points)


def test_usd_meshes_have_one_set_of_texture_coordinates(stage, tmp_path):
    """That of the base color, and a warning names it. Subsets have sets of their own."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdGeom, UsdShade

    types = Sdf.ValueTypeNames
    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    shader = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    connect_primvar(stage, UsdShade.Shader(stage.GetPrimAtPath("/paint/image")), "st", "float2", "second")
    other = UsdShade.Shader.Define(stage, "/paint/other")
    other.CreateIdAttr("UsdUVTexture")
    other.CreateInput("file", types.Asset).Set(str(tmp_path / "gray.png"))
    shader.CreateInput("emissiveColor", types.Color3f).ConnectToSource(other.CreateOutput("rgb", types.Float3))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/squares"))
    for name, value in (("st", 0.25), ("second", 0.5)):
        add_primvar(mesh, name, "TexCoord2fArray", "vertex", [(value, value)] * 6)
    with pytest.warns(UserWarning, match='coordinates "second" for all images of /paint/surface, because a mesh has one'):
        scene = latelight.from_usd(stage)
    assert np.unique(texture_coordinates(scene)) == [0.5]
    other.CreateInput("st", types.Float2).ConnectToSource(
        UsdShade.Shader(stage.GetPrimAtPath("/paint/image_st")).GetOutput("result")
    )
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "right", UsdGeom.Tokens.face, [1], "materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(add_paint(stage, "/red", (1, 0, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = latelight.from_usd(stage)
    sets = {}
    for instance in map(scene.instance, scene.instances()):
        sets[scene.material(instance.material).name] = np.unique(scene.mesh_arrays(instance.mesh)["uv"]).tolist()
    assert sets == {"red": [0.25, 0.75], "paint": [0.5]}


@pytest.mark.parametrize(
    "wraps, expected, warning",
    [
        (("repeat", "repeat"), REPEAT, ""),
        (("clamp", "clamp"), CLAMP, ""),
        (("mirror", "mirror"), MIRROR, ""),
        (("useMetadata", "useMetadata"), REPEAT, ""),
        (("black", "black"), CLAMP, '"clamp" instead of "black" for diffuseColor of /paint/surface'),
        (("mirror", "clamp"), MIRROR, '"mirror" for roughness of /paint/surface, because'),
    ],
)
def test_usd_images_have_wrap_modes(stage, tmp_path, wraps, expected, warning):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    for name, wrap in zip(("wrapS", "wrapT"), wraps):
        texture.CreateInput(name, Sdf.ValueTypeNames.Token).Set(wrap)
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    surface.CreateInput("normal", Sdf.ValueTypeNames.Normal3f).ConnectToSource(texture.GetOutput("rgb"))
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        scene = latelight.from_usd(stage)
    messages = [str(each.message) for each in given]
    assert len(messages) == (3 if warning else 0)  # one per texture
    assert any(warning in message for message in messages) or not warning
    assert samplers(scene, tmp_path) == {(expected, expected)}


def test_materialx_images_have_wrap_modes(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    texture = painted_by_materialx(stage, tmp_path / "gray.png")
    for name in ("uaddressmode", "vaddressmode"):
        texture.CreateInput(name, Sdf.ValueTypeNames.String).Set("mirror")
    assert samplers(latelight.from_usd(stage), tmp_path) == {(MIRROR, MIRROR)}


def test_usd_archives_hold_their_images(tmp_path, device):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, Usd, UsdLux

    (tmp_path / "textures").mkdir()
    image.fromarray(np.full((2, 2, 3), (10, 20, 30), np.uint8)).save(tmp_path / "textures" / "paint.png")
    pixels = bytes((128, 64, 0, 129)) * 2  # RGBE: a value is its byte times 2^(exponent - 136)
    (tmp_path / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + pixels)
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    painted(stage, "textures/paint.png")
    UsdLux.DomeLight.Define(stage, "/sky").CreateTextureFileAttr("sky.hdr")
    stage.Save()

    def pack(name, *files):
        archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / name))
        for file in files:
            archive.AddFile(str(tmp_path / file), file)
        assert archive.Save()

    pack("inner.usdz", "stage.usda", "textures/paint.png", "sky.hdr")
    outer = Usd.Stage.CreateNew(str(tmp_path / "outer.usda"))
    outer.GetRootLayer().subLayerPaths.append("inner.usdz")
    outer.Save()
    pack("outer.usdz", "outer.usda", "inner.usdz")
    for file in ("textures/paint.png", "sky.hdr", "stage.usda"):
        (tmp_path / file).unlink()
    for name in ("inner.usdz", "outer.usdz", "outer.usda"):
        scene = latelight.from_usd(tmp_path / name)
        assert painted_with(scene, tmp_path) == ([10, 20, 30], 10), name
        np.testing.assert_allclose(background(scene, device, (0.3, 0.2, 1)), (1, 0.5, 0), rtol=1e-3)


def test_compressed_images_in_usd_archives_are_refused(tmp_path):
    """USD's archives are not compressed, so that their size bounds what is read from them."""
    import zipfile

    image = pytest.importorskip("PIL.Image")
    from pxr import Usd

    image.fromarray(np.full((99, 99, 3), 9, np.uint8)).save(tmp_path / "paint.bmp")
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    painted(stage, "paint.bmp")
    stage.Save()
    with zipfile.ZipFile(tmp_path / "stage.usdz", "w") as archive:
        archive.write(tmp_path / "stage.usda", "stage.usda")
        archive.write(tmp_path / "paint.bmp", "paint.bmp", zipfile.ZIP_DEFLATED)
    with pytest.raises(latelight.InputError, match="stage.usdz.paint.bmp. is compressed, which USD's archives do not"):
        latelight.from_usd(tmp_path / "stage.usdz")


def test_images_in_archives_outside_are_refused(tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, Usd

    (tmp_path / "inside").mkdir()
    image.fromarray(np.full((2, 2, 3), 9, np.uint8)).save(tmp_path / "paint.png")
    archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / "images.usdz"))
    archive.AddFile(str(tmp_path / "paint.png"), "paint.png")
    assert archive.Save()
    stage = Usd.Stage.CreateNew(str(tmp_path / "inside" / "stage.usda"))
    painted(stage, "../images.usdz[paint.png]")
    stage.Save()
    with pytest.raises(latelight.InputError, match="images.usdz, which is outside the scene's folder"):
        latelight.from_usd(tmp_path / "inside" / "stage.usda")
    scene = latelight.from_usd(tmp_path / "inside" / "stage.usda", allow_outside=[tmp_path])
    assert painted_with(scene, tmp_path) == ([9, 9, 9], 9)


def test_models_of_other_types_are_refused():
    with pytest.raises(latelight.UsageError, match="from_trimesh requires"):
        latelight.from_trimesh(3)
    with pytest.raises(latelight.UsageError, match='"y" or "z"'):
        latelight.from_trimesh(trimesh.creation.box(), up="x")
    with pytest.raises(latelight.UsageError, match="from_open3d requires"):
        latelight.from_open3d("mesh")


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
