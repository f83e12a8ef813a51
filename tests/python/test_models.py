"""Scenes from trimesh, yourdfpy, usd-core and Open3D. Open3D is too large to be installed for every test."""

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


def test_trimesh_colors_are_decoded():
    mesh = trimesh.creation.box((1, 1, 1))
    mesh.visual.face_colors = np.tile([255, 188, 0, 255], (12, 1))
    scene = latelight.from_trimesh(mesh)
    arrays = scene.mesh_arrays(scene.meshes()[0])
    np.testing.assert_allclose(arrays["colors"][0], (1, 0.50289, 0, 1), atol=1e-4)  # IEC 61966-2-1
    assert scene.material(scene.materials()[0]).base_color == (1, 1, 1, 1)


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


def test_robots_move_their_joints(tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    path = tmp_path / "crane.urdf"
    path.write_text(URDF)
    scene = latelight.from_urdf(path)
    assert [node.path for node in scene.nodes] == ["/base", "/arm 0", "/arm 1"]
    assert_bounds(scene, (-0.5, -0.25, -1), (0.5, 2.75, 1))  # 2.5 m above the shoulder, which is at 0.25 m
    robot = yourdfpy.URDF.load(str(path))
    posed = latelight.from_urdf(robot, {"shoulder": np.pi / 2})
    assert_bounds(posed, (-0.5, -0.25, -1), (0.5, 0.5, 2.5))  # the arm points along -Y, which is +Z with Y up
    latelight.pose_urdf(posed, robot, [0])
    assert_bounds(posed, (-0.5, -0.25, -1), (0.5, 2.75, 1))
    with pytest.raises(latelight.UsageError, match='no joint "elbow": its joints are shoulder'):
        latelight.pose_urdf(posed, robot, {"elbow": 1})
    with pytest.raises(latelight.UsageError, match="does not exist"):
        latelight.from_urdf(tmp_path / "missing.urdf")


# --- USD ------------------------------------------------------------------------------------------------------------


def add_mesh(stage, path):
    """Two squares of 1 m, in a stage in centimeters."""
    UsdGeom = pytest.importorskip("pxr.UsdGeom")
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0), (200, 0, 0), (200, 100, 0)])
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 4, 5, 2])
    return mesh


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


def test_models_of_other_types_are_refused():
    with pytest.raises(latelight.UsageError, match="from_trimesh requires"):
        latelight.from_trimesh(3)
    with pytest.raises(latelight.UsageError, match='"y" or "z"'):
        latelight.from_trimesh(trimesh.creation.box(), up="x")
    with pytest.raises(latelight.UsageError, match="from_open3d requires"):
        latelight.from_open3d("mesh")


def test_open3d_meshes_have_colors_and_textures():
    o3d = pytest.importorskip("open3d", reason="Open3D is too large to be installed for every test")
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
    np.testing.assert_allclose(scene.mesh_arrays(scene.meshes()[0])["uv"], [[0, 1], [1, 1], [1, 0.75]])
    assert scene.texture(scene.textures()[0]).width == 4
