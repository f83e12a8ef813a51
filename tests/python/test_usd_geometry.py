"""Meshes, shapes, skeletons and blend shapes from USD."""

import numpy as np
import pytest

import latelight
from model_checks import assert_bounds, assert_seen_as_exported, surface_colors
from usd_stages import add_mesh


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
