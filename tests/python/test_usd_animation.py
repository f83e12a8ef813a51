"""Animations of USD stages, against the points and transforms that usd-core computes for each time."""

import linecache
import warnings

import numpy as np
import pytest

import latelight

pytest.importorskip("pxr.Usd")
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel, Vt  # noqa: E402

RATE = 24.0
UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]]) @ np.diag([0.01, 0.01, 0.01, 1])


@pytest.fixture
def stage():
    made = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(made, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(made, 0.01)
    made.SetTimeCodesPerSecond(RATE)
    return made


def world_of(prim, code):
    return UP @ np.array(UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(code)).T


def moved(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def add_tube(stage, path, rings=13, around=8):
    """A tube of 120 units along Z of quads."""
    angles = np.arange(around) / around * 2 * np.pi
    points = [(20 * np.cos(a), 20 * np.sin(a), 10 * ring) for ring in range(rings) for a in angles]
    faces = [
        (ring * around + i, ring * around + (i + 1) % around, (ring + 1) * around + (i + 1) % around, (ring + 1) * around + i)
        for ring in range(rings - 1)
        for i in range(around)
    ]
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.array(points, np.float32)))
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr(np.ravel(faces).tolist())
    mesh.CreateDoubleSidedAttr(True)
    return mesh


def add_skeleton(stage, root):
    """Three joints along Z, of which the upper two bend."""
    skeleton = UsdSkel.Skeleton.Define(stage, f"{root}/bones")
    skeleton.CreateJointsAttr(["low", "low/middle", "low/middle/high"])
    local = [Gf.Matrix4d(1), Gf.Matrix4d().SetTranslate((0, 0, 40)), Gf.Matrix4d().SetTranslate((0, 0, 40))]
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(local))
    skeleton.CreateBindTransformsAttr(
        Vt.Matrix4dArray([local[0], local[1], Gf.Matrix4d().SetTranslate((0, 0, 80))])
    )
    pose = UsdSkel.Animation.Define(stage, f"{root}/pose")
    pose.CreateJointsAttr(["low/middle/high", "low/middle"])
    turns, moves, scales = pose.CreateRotationsAttr(), pose.CreateTranslationsAttr(), pose.CreateScalesAttr()
    scales.Set(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * 2))
    for code, high, middle in ((0, 0, 0), (6, 70, -30), (18, -40, 50)):
        turns.Set(Vt.QuatfArray([Gf.Quatf(Gf.Rotation(axis, angle).GetQuat()) for axis, angle in (((1, 0, 0), high), ((0, 1, 0.5), middle))]), code)
    moves.Set(Vt.Vec3fArray([(0, 0, 40), (0, 0, 40)]), 0)
    moves.Set(Vt.Vec3fArray([(0, 0, 60), (5, 0, 30)]), 12)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([f"{root}/pose"])
    return skeleton, pose


def bind(mesh, skeleton, joints=None):
    """Each point follows the two joints next to it."""
    z = np.array(mesh.GetPointsAttr().Get())[:, 2] / 40
    low = np.clip(np.floor(z).astype(int), 0, 1)
    share = np.clip(z - low, 0, 1)
    indices = np.stack([low, low + 1], axis=1)
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    if joints:
        names = list(skeleton.GetJointsAttr().Get())
        binding.CreateJointsAttr(joints)
        indices = np.array([joints.index(name) for name in names])[indices]
    binding.CreateJointIndicesPrimvar(False, 2).Set(indices.ravel().tolist())
    binding.CreateJointWeightsPrimvar(False, 2).Set(np.stack([1 - share, share], axis=1).ravel().tolist())
    return binding


def add_shapes(stage, mesh, binding, pose):
    """Two blend shapes, one with two in-betweens; the other moves some points only."""
    count = len(mesh.GetPointsAttr().Get())
    wide = UsdSkel.BlendShape.Define(stage, f"{mesh.GetPath()}/wide")
    points = np.array(mesh.GetPointsAttr().Get())
    outward = points * [1, 1, 0]
    wide.CreateNormalOffsetsAttr([(0, 0, 1)] * count)  # without effect, because the mesh has no normals
    wide.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(outward, np.float32)))
    for weight, scale in ((0.25, -0.5), (0.5, 2.0)):
        between = wide.CreateInbetween(f"at{int(100 * weight)}")
        between.SetWeight(weight)
        between.SetOffsets(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(scale * outward, np.float32)))
    dent = UsdSkel.BlendShape.Define(stage, f"{mesh.GetPath()}/dent")
    dent.CreateOffsetsAttr([(0, -30, 0)] * 16)
    dent.CreatePointIndicesAttr(list(range(count - 16, count)))
    binding.CreateBlendShapesAttr(["dent", "wide"])
    binding.CreateBlendShapeTargetsRel().SetTargets([dent.GetPath(), wide.GetPath()])
    pose.CreateBlendShapesAttr(["wide", "dent"])
    weights = pose.CreateBlendShapeWeightsAttr()
    for code, values in ((0, [0, 0]), (12, [1, 0.5]), (18, [0.1, -0.5])):
        weights.Set(Vt.FloatArray(values), code)


def reference_points(mesh, code):
    """World points of a mesh with a skeleton, by UsdSkel."""
    prim, cache = mesh.GetPrim(), UsdSkel.Cache()
    cache.Populate(UsdSkel.Root.Find(prim), Usd.TraverseInstanceProxies())
    skinning, skeleton = cache.GetSkinningQuery(prim), UsdSkel.BindingAPI(prim).GetInheritedSkeleton()
    query = cache.GetSkelQuery(skeleton)
    points = Vt.Vec3fArray(mesh.GetPointsAttr().Get())
    if skinning.HasBlendShapes():
        shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
        weights = skinning.GetBlendShapeMapper().Remap(query.GetAnimQuery().ComputeBlendShapeWeights(code))
        values = np.array(points)
        for weight, shape, part in zip(*shapes.ComputeSubShapeWeights(weights)):
            offsets = np.array(shapes.ComputeSubShapePointOffsets()[part])
            indices = shapes.ComputeBlendShapePointIndices()[shape]
            np.add.at(values, np.arange(len(values)) if len(indices) == 0 else np.array(indices), weight * offsets)
        points = Vt.Vec3fArray.FromNumpy(values.astype(np.float32))
    frame = prim
    if skinning.HasJointInfluences():
        # The mapping of a mesh's own order of joints is part of ComputeSkinnedPoints().
        assert skinning.ComputeSkinnedPoints(query.ComputeSkinningTransforms(code), points, code)
        frame = skeleton.GetPrim()
    return moved(world_of(frame, code), np.array(points, np.float64))


def assert_shows(scene, device, time, mesh, points, tolerance=2e-5):
    """Rays to the centers of all triangles, from several sides, hit these triangles there."""
    quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
    corners = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    centers = points[corners].mean(axis=1)
    renderer, seen = latelight.Renderer(scene, device), np.zeros(len(centers), bool)
    for side in np.concatenate([np.eye(3), -np.eye(3)]) + [0.1, 0.07, 0.13]:
        origins = centers + 0.02 * side  # close enough that most rays pass by all other triangles
        hits = renderer.cast(origins, np.tile(-side / np.linalg.norm(side), (len(centers), 1)), time=time)
        same = (hits["triangle"] == np.arange(len(centers))) & np.isfinite(hits["distance"])
        found = origins - side / np.linalg.norm(side) * hits["distance"][:, None]
        close = same & (np.linalg.norm(found - centers, axis=1) < tolerance)
        seen |= close
    assert seen.mean() > 0.97, seen.mean()


@pytest.mark.parametrize("reordered", [False, True])
def test_skeletons_play(stage, device, reordered):
    root = UsdSkel.Root.Define(stage, "/figure")
    skeleton, _ = add_skeleton(stage, "/figure")
    mesh = add_tube(stage, "/figure/tube")
    binding = bind(mesh, skeleton, ["low/middle/high", "low", "low/middle"] if reordered else None)
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d().SetScale(1.25))
    UsdGeom.XformCommonAPI(root).SetTranslate((0, 0, 300))
    scene = latelight.from_usd(stage)
    assert [(a.name, a.duration) for a in scene.animations] == [("stage", 18 / RATE)]
    assert scene.joints(scene.instances("/figure.tube")[0])[-1].endswith("middle" if reordered else "middle/high")
    for code in (0, 3, 6, 9, 15, 18):
        assert_shows(scene, device, code / RATE, mesh, reference_points(mesh, code))
    still = latelight.from_usd(stage, time=9)
    assert still.animations == []
    assert_shows(still, device, None, mesh, reference_points(mesh, 9))


def add_crowd(stage, poses):
    """An instance of a figure for each pose, which is a rotation of its upper joint at some time codes."""
    stage.CreateClassPrim("/kind")
    UsdSkel.Root.Define(stage, "/kind/figure")
    skeleton, _ = add_skeleton(stage, "/kind/figure")
    UsdGeom.XformCommonAPI(skeleton).SetTranslate((0, 30, 0))
    skeleton.GetPrim().RemoveProperty("skel:animationSource")
    bind(add_tube(stage, "/kind/figure/tube"), skeleton)
    for number, angles in enumerate(poses):
        pose = UsdSkel.Animation.Define(stage, f"/pose{number}")
        pose.CreateJointsAttr(["low/middle"])
        pose.CreateTranslationsAttr([(0, 0, 40)])
        pose.CreateScalesAttr([(1, 1, 1)])
        for code, angle in angles.items():
            turn = Vt.QuatfArray([Gf.Quatf(Gf.Rotation((1, 0, 0), angle).GetQuat())])
            pose.CreateRotationsAttr().Set(turn, Usd.TimeCode.Default() if code is None else code)
        person = UsdGeom.Xform.Define(stage, f"/person{number}")
        person.GetPrim().GetInherits().AddInherit("/kind")
        person.GetPrim().SetInstanceable(True)
        UsdGeom.XformCommonAPI(person).SetTranslate((200 * number, 0, 50))
        UsdSkel.BindingAPI.Apply(person.GetPrim()).CreateAnimationSourceRel().SetTargets([f"/pose{number}"])
    return [UsdGeom.Mesh(stage.GetPrimAtPath(f"/person{number}/figure/tube")) for number in range(len(poses))]


def test_skeletons_of_native_instances_play(stage, device):
    people = add_crowd(stage, [{0: 0, 12: 60}, {0: 40, 12: -40}])
    scene = latelight.from_usd(stage)
    for code in (0, 6, 12):
        for person in people:
            assert_shows(scene, device, code / RATE, person, reference_points(person, code))


def test_skeletons_of_native_instances_pose(stage, device):
    """Instances in the same pose share their mesh."""
    people = add_crowd(stage, [{None: 30}, {None: -50}, {None: 0}])
    UsdSkel.BindingAPI(stage.GetPrimAtPath("/person2")).GetAnimationSourceRel().SetTargets(["/pose0"])
    scene = latelight.from_usd(stage)
    assert len(scene.meshes()) == 2 and len(scene.instances()) == 3
    for person in people:
        assert_shows(scene, device, None, person, reference_points(person, 0))


@pytest.mark.parametrize("top", ["/figure", "/figure/tube"])
@pytest.mark.parametrize("specifier", [Sdf.SpecifierDef, Sdf.SpecifierClass])
def test_copies_of_instancers_are_posed(stage, top, specifier, device):
    """The skeleton may be outside of the prototype. Copies of a moving figure show it at the start of the stage."""
    root = UsdSkel.Root.Define(stage, "/figure")
    skeleton, pose = add_skeleton(stage, "/figure")
    mesh = add_tube(stage, "/figure/tube")
    add_shapes(stage, mesh, bind(mesh, skeleton), pose)
    UsdGeom.XformCommonAPI(skeleton).SetTranslate((0, 30, 0))
    copies = UsdGeom.PointInstancer.Define(stage, "/copies")
    copies.CreatePrototypesRel().SetTargets([top])
    copies.CreateProtoIndicesAttr([0, 0])
    copies.CreatePositionsAttr([(300, 0, 0), (600, 0, 0)])
    points = reference_points(mesh, 6)
    root.GetPrim().SetSpecifier(specifier)
    assert np.ptp(points, axis=0).min() > 0.5  # the pose bends the tube
    scenes = [latelight.from_usd(stage, time=6)]
    if specifier == Sdf.SpecifierDef:
        stage.SetStartTimeCode(6)
        stage.SetEndTimeCode(18)
        with pytest.warns(UserWarning, match="time samples of /figure/tube only at the time code 6"):
            scenes.append(latelight.from_usd(stage))
    for scene in scenes:
        for offset in (3, 6):
            assert_shows(scene, device, None, mesh, points + (offset, 0, 0))


def test_blend_shapes_play_with_in_betweens(stage, device):
    UsdSkel.Root.Define(stage, "/figure")
    skeleton, pose = add_skeleton(stage, "/figure")
    mesh = add_tube(stage, "/figure/tube")
    add_shapes(stage, mesh, bind(mesh, skeleton), pose)
    scene = latelight.from_usd(stage)
    # The weight of `wide` rises from 0 to 1 in 12 time codes, past its in-betweens at 3 and 6.
    for code in (0, 1.5, 3, 4.5, 7, 12, 14, 17, 18):
        assert_shows(scene, device, code / RATE, mesh, reference_points(mesh, code))


def test_blend_shapes_play_without_joints(stage, device):
    root = UsdSkel.Root.Define(stage, "/face")
    skeleton = UsdSkel.Skeleton.Define(stage, "/face/bones")
    skeleton.CreateJointsAttr([])
    pose = UsdSkel.Animation.Define(stage, "/face/pose")
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/face/pose"])
    mesh = add_tube(stage, "/face/tube")
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    add_shapes(stage, mesh, binding, pose)
    turn = UsdGeom.Xformable(root).AddRotateZOp()
    turn.Set(0.0, 0)
    turn.Set(180.0, 18)
    scene = latelight.from_usd(stage)
    assert "/stage/face/tube" in [node.path for node in scene.nodes]
    for code in (0, 1.5, 4.5, 14, 18):
        assert_shows(scene, device, code / RATE, mesh, reference_points(mesh, code))


def test_transforms_play(stage, device):
    """Nested Xforms with Euler angles, pivots, several turns and a scale, under static ones."""
    lift = UsdGeom.Xform.Define(stage, "/world")
    UsdGeom.XformCommonAPI(lift).SetTranslate((10, 20, 30))
    arm = UsdGeom.Xform.Define(stage, "/world/arm")
    angles = arm.AddRotateXYZOp()
    for code, value in ((0, (0, 0, 0)), (10, (90, 40, -60)), (20, (720, 0, 180))):
        angles.Set(Gf.Vec3f(*value), code)
    hand = UsdGeom.Xform.Define(stage, "/world/arm/hand")
    pivot = hand.AddTranslateOp(opSuffix="pivot")
    pivot.Set((15, 0, 0))
    spin = hand.AddRotateZOp()
    spin.Set(0.0, 5)
    spin.Set(1080.0, 20)
    grow = hand.AddScaleOp()
    grow.Set(Gf.Vec3f(1, 1, 1), 0)
    grow.Set(Gf.Vec3f(2, 2, 2), 20)
    hand.AddTranslateOp(opSuffix="pivot", isInverseOp=True)
    mesh = add_tube(stage, "/world/arm/hand/tube", rings=3)
    stage.SetStartTimeCode(2)  # samples before it are cut
    stage.SetEndTimeCode(20)
    scene = latelight.from_usd(stage)
    assert scene.animations[0].duration == pytest.approx(18 / RATE)
    assert "/stage/world/arm/hand/tube" in [node.path for node in scene.nodes]
    for code in (2, 3.7, 5, 9, 12.3, 16.8, 20):
        points = moved(world_of(mesh.GetPrim(), code), np.array(mesh.GetPointsAttr().Get(), np.float64))
        assert_shows(scene, device, (code - 2) / RATE, mesh, points, 2e-4)  # keys follow a path of 1 m by 1e-4
    arm.AddScaleOp().Set(Gf.Vec3f(1, 1, 3))  # the hand turns under a scale along Z, which shears nothing of its own
    latelight.from_usd(stage)
    shear = UsdGeom.Xform.Define(stage, "/sheared")
    matrix = shear.AddTransformOp()
    matrix.Set(Gf.Matrix4d(1), 0)
    matrix.Set(Gf.Matrix4d(1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1), 20)
    UsdGeom.Cube.Define(stage, "/sheared/cube")
    with pytest.raises(latelight.UsageError, match="/sheared is sheared at the time code 2, .*give a time"):
        latelight.from_usd(stage)
    assert len(latelight.from_usd(stage, time=20).instances()) == 2


@pytest.mark.parametrize("flat", [(1, 0, 1), (0, 1, 1), (2, 0, 0), (0, 0, 0)])
def test_transforms_that_begin_flat_play(stage, device, flat):
    """A scale of zero is not a shear."""
    form = UsdGeom.Xform.Define(stage, "/form")
    form.AddRotateXYZOp().Set(Gf.Vec3f(20, 30, -50))
    grow = form.AddScaleOp()
    grow.Set(Gf.Vec3f(flat), 0)
    grow.Set(Gf.Vec3f(2, 1, 1), 24)
    mesh = add_tube(stage, "/form/tube", rings=3)
    scene = latelight.from_usd(stage)
    for code in (3, 7.7, 24):
        points = moved(world_of(mesh.GetPrim(), code), np.array(mesh.GetPointsAttr().Get(), np.float64))
        assert_shows(scene, device, code / RATE, mesh, points, 2e-4)


def test_lights_that_begin_flat_shine_later(stage, device):
    """A panel and a bulb that grow from nothing light a floor as those that have always had their size."""
    floor = UsdGeom.Plane.Define(stage, "/floor")
    floor.CreateWidthAttr(400)
    floor.CreateLengthAttr(400)
    grow = UsdGeom.Xform.Define(stage, "/grow").AddScaleOp()
    for light in (UsdLux.RectLight.Define(stage, "/grow/panel"), UsdLux.SphereLight.Define(stage, "/grow/bulb")):
        light.CreateIntensityAttr(1000)
        UsdGeom.XformCommonAPI(light).SetTranslate((30, 0, 100))

    def picture(time):
        scene = latelight.from_usd(stage)
        camera = latelight.Camera.look_at((0, 5, 0), (0, 0, 0), (0, 0, -1))
        return latelight.Renderer(scene, device).render(camera, (16, 16), ("color",), shadows="none", time=time)["color"]

    grow.Set(Gf.Vec3f(1, 1, 1))
    expected = picture(0)
    assert expected[..., :3].max() > 0.01
    grow.GetAttr().Clear()
    grow.Set(Gf.Vec3f(0, 0, 0), 0)
    grow.Set(Gf.Vec3f(1, 1, 1), 24)
    np.testing.assert_allclose(picture(24 / RATE), expected, rtol=1e-3, atol=1e-5)


def test_what_rides_on_transforms_plays(stage, device):
    """A camera, a light, an instancer and a mesh posed once, below a moving Xform; and visibility in steps."""
    base = UsdGeom.Xform.Define(stage, "/base")
    move = base.AddTranslateOp()
    move.Set((0, 0, 0), 0)
    move.Set((100, 0, 200), RATE)
    camera = UsdGeom.Camera.Define(stage, "/base/eye")
    UsdGeom.XformCommonAPI(camera).SetTranslate((0, -500, 0))
    UsdGeom.XformCommonAPI(camera).SetRotate((90, 0, 0))  # looks along +Y of the stage
    lamp = UsdLux.SphereLight.Define(stage, "/base/lamp")
    lamp.CreateRadiusAttr(5)
    UsdGeom.Cube.Define(stage, "/base/cube").CreateSizeAttr(100)
    copies = UsdGeom.PointInstancer.Define(stage, "/base/copies")
    UsdGeom.Cube.Define(stage, "/base/copies/small").CreateSizeAttr(10)
    copies.CreatePrototypesRel().SetTargets(["/base/copies/small"])
    copies.CreateProtoIndicesAttr([0, 0])
    copies.CreatePositionsAttr([(200, 0, 0), (300, 0, 0)])
    blink = UsdGeom.Cube.Define(stage, "/blink")
    blink.CreateSizeAttr(50)
    UsdGeom.XformCommonAPI(blink).SetTranslate((-1000, 0, 0))
    seen = blink.CreateVisibilityAttr()
    seen.Set("invisible", 0)
    seen.Set("inherited", RATE / 2)
    scene = latelight.from_usd(stage)
    for time in (0, 0.5, 1):
        ride = np.array([1, 2, 0]) * time  # (100, 0, 200) cm, with Y up
        np.testing.assert_allclose(scene.cameras_at(time)[0].camera_to_world[:3, 3], ride + [0, 0, 5], atol=1e-6)
        np.testing.assert_allclose(scene.cameras_at(time)[0].camera_to_world[:3, 2], (0, 0, -1), atol=1e-6)
        renderer = latelight.Renderer(scene, device)
        origins = np.array([[0, 0, 9], [2, 0, 9], [3, 0, 9]]) + ride
        distance = renderer.cast(np.vstack([origins, [[-10, 0, 9]]]), np.tile((0, 0, -1), (4, 1)), time=time)["distance"]
        np.testing.assert_allclose(distance[:3], (8.5, 8.95, 8.95), atol=1e-5)
        assert np.isfinite(distance[3]) == (time >= 0.5)
    np.testing.assert_allclose(scene.light(scene.lights()[0]).position, (0, 0, 0), atol=1e-9)


def points_of(mesh, code):
    return moved(world_of(mesh.GetPrim(), code), np.array(mesh.GetPointsAttr().Get(code), np.float64))


def set_waves(mesh, codes):
    """Samples of points, each unlike the others."""
    still = np.array(mesh.GetPointsAttr().Get())
    mesh.GetPointsAttr().Clear()
    for code in codes:
        wave = still + 15 * np.sin(still[:, [2, 2, 0]] / 30 + np.array([0, 1, 2]) + code)
        mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(wave.astype(np.float32)), code)


def test_points_play(stage, device, tmp_path):
    mesh = add_tube(stage, "/cloth")
    set_waves(mesh, (4, 6, 13, 20))
    scene = latelight.from_usd(stage)
    assert scene.animations[0].duration == pytest.approx(16 / RATE)
    scene.export(tmp_path / "cloth.glb")
    for shown in (scene, latelight.Scene(tmp_path / "cloth.glb")):
        for code in (4, 4.7, 6, 9, 13, 18.5, 20):
            assert_shows(shown, device, (code - 4) / RATE, mesh, points_of(mesh, code))
    assert_shows(latelight.from_usd(stage, time=9), device, None, mesh, points_of(mesh, 9))


def test_points_play_within_the_range_of_the_stage(stage, device):
    mesh = add_tube(stage, "/cloth")
    set_waves(mesh, (0, 10, 20))
    move = UsdGeom.Xformable(mesh).AddTranslateOp()
    move.Set((0, 0, 0), 0)
    move.Set((0, 0, 100), 20)
    stage.SetStartTimeCode(5)
    stage.SetEndTimeCode(17)
    scene = latelight.from_usd(stage)
    assert scene.animations[0].duration == pytest.approx(12 / RATE)
    for code in (5, 9, 10, 14, 17):
        assert_shows(scene, device, (code - 5) / RATE, mesh, points_of(mesh, code))


@pytest.mark.parametrize("interpolation", ["vertex", "faceVarying", "uniform", None])
def test_normals_play_with_their_points(stage, device, interpolation):
    """A square that turns by 60 degrees about Y in two linear steps."""
    mesh = UsdGeom.Mesh.Define(stage, "/square")
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    count = {"vertex": 4, "faceVarying": 4, "uniform": 1}.get(interpolation)
    for code, angle in ((0, 0), (1, 30), (2, 60)):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        corners = [(x * c, y, -x * s) for x, y in ((-100, -100), (100, -100), (100, 100), (-100, 100))]
        mesh.CreatePointsAttr().Set(corners, code)
        if interpolation:
            mesh.CreateNormalsAttr().Set([(s, 0, c)] * count, code)
            mesh.SetNormalsInterpolation(interpolation)
    scene = latelight.from_usd(stage)
    renderer = latelight.Renderer(scene, device)
    camera = scene.look_at((0, 9, 0.01), (0, 0, 0))  # down the Z axis of the stage
    for code in (0, 0.5, 1, 2):
        normal = renderer.render(camera, (9, 9), "normal", time=code / RATE)["normal"][4, 4]
        angles = np.radians((0, 30, 60))
        blended = [np.interp(code, (0, 1, 2), f(angles)) for f in (np.sin, np.cos)]
        expected = np.array([blended[0], blended[1], 0]) / np.hypot(*blended)  # Z of the stage is Y
        np.testing.assert_allclose(normal, expected, atol=2e-4)


def test_instances_of_changing_meshes_play(stage, device):
    prototype = UsdGeom.Xform.Define(stage, "/library/cloth")
    set_waves(add_tube(stage, "/library/cloth/tube"), (0, 10))
    stage.GetPrimAtPath("/library").SetSpecifier(Sdf.SpecifierClass)
    for name, x in (("a", 0), ("b", 500)):
        copy = UsdGeom.Xform.Define(stage, f"/{name}")
        copy.GetPrim().GetReferences().AddInternalReference(prototype.GetPath())
        copy.GetPrim().SetInstanceable(True)
        UsdGeom.XformCommonAPI(copy).SetTranslate((x, 0, 0))
    scene = latelight.from_usd(stage)
    assert len(scene.instances()) == 2
    for name in "ab":
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/{name}/tube"))
        assert_shows(scene, device, 5 / RATE, mesh, points_of(mesh, 5))


@pytest.mark.filterwarnings("error")
def test_a_single_sample_is_the_value_at_all_times(stage, device):
    mesh = add_tube(stage, "/tube")
    set_waves(mesh, (7,))
    lamp = UsdLux.SphereLight.Define(stage, "/lamp")
    lamp.CreateRadiusAttr(100)
    lamp.CreateIntensityAttr().Set(25.0, 7)
    copies = UsdGeom.PointInstancer.Define(stage, "/copies")
    UsdGeom.Cube.Define(stage, "/copies/cube").CreateSizeAttr(10)
    copies.CreatePrototypesRel().SetTargets(["/copies/cube"])
    copies.CreateProtoIndicesAttr([0])
    copies.CreatePositionsAttr().Set([(500, 0, 0)], 7)
    copies.CreateVelocitiesAttr().Set([(1, 2, 3)], 7)
    scene = latelight.from_usd(stage)
    assert scene.animations == []
    assert scene.light(scene.lights()[0]).intensity == pytest.approx(25 * np.pi)
    np.testing.assert_allclose(scene.instance(scene.instances()[-1]).transform[:3, 3], (5, 0, 0), atol=1e-6)
    assert_shows(scene, device, None, mesh, points_of(mesh, 7))


def add_copies(stage, velocities=False):
    """Two boxes with a transform of their own that fly, turn and grow, and a third one that is hidden."""
    copies = UsdGeom.PointInstancer.Define(stage, "/swarm/copies")
    boxes = UsdGeom.Xform.Define(stage, "/swarm/copies/kind")
    UsdGeom.XformCommonAPI(boxes).SetScale((1, 2, 4))
    for name, x in (("left", -20), ("right", 20)):
        box = UsdGeom.Cube.Define(stage, f"/swarm/copies/kind/{name}")
        box.CreateSizeAttr(10)
        UsdGeom.XformCommonAPI(box).SetTranslate((x, 0, 0))
        UsdGeom.XformCommonAPI(box).SetRotate((0, 0, 30))
    copies.CreatePrototypesRel().SetTargets(["/swarm/copies/kind"])
    copies.CreateProtoIndicesAttr([0, 0, 0])
    copies.CreateInvisibleIdsAttr([1])
    for code, y in ((0, 0), (8, 100), (24, -50)):
        copies.CreatePositionsAttr().Set([(0, y, 0), (0, 0, 900), (300, 0, y)], code)
        turns = [Gf.Quath(Gf.Rotation((1, 1, 0), a).GetQuat()) for a in (y, 0, 2 * y)]
        copies.CreateOrientationsAttr().Set(Vt.QuathArray(turns), code)
        copies.CreateScalesAttr().Set([(1, 1, 1), (1, 1, 1), (1 + code / 24, 1, 1)], code)
        if velocities:
            copies.CreateVelocitiesAttr().Set([(0, 240, 0), (0, 0, 0), (0, 0, -240)], code)
    return copies


@pytest.mark.parametrize("velocities", [False, True])
def test_copies_of_instancers_play(stage, device, velocities):
    copies = add_copies(stage, velocities)
    turn = UsdGeom.Xformable(copies).AddRotateZOp()
    turn.Set(0.0, 0)
    turn.Set(90.0, 24)
    scene = latelight.from_usd(stage)
    paths = [node.path for node in scene.nodes]
    assert "/stage/swarm/copies/2/right" in paths and "/stage/swarm/copies/1" not in paths
    assert len(scene.instances()) == 4
    kind = stage.GetPrimAtPath("/swarm/copies/kind")
    relative = UsdGeom.XformCache(0).ComputeRelativeTransform
    inner = [np.array(relative(prim, copies.GetPrim())[0]).T for prim in kind.GetChildren()]
    renderer = latelight.Renderer(scene, device)
    for code in (0, 3, 8, 15, 23.5):
        outside = UsdGeom.PointInstancer.ExcludeProtoXform
        matrices = np.array(copies.ComputeInstanceTransformsAtTime(code, code, outside))
        assert len(matrices) == 2
        for matrix in [world_of(copies.GetPrim(), code) @ m.T @ part for m in matrices for part in inner]:
            # Rays along the axes of the box hit the centers of its faces.
            starts = moved(matrix, 6 * np.concatenate([np.eye(3), -np.eye(3)]))
            ends = moved(matrix, 5 * np.concatenate([np.eye(3), -np.eye(3)]))
            hits = renderer.cast(starts, ends - starts, time=code / RATE)
            np.testing.assert_allclose(hits["distance"], np.linalg.norm(ends - starts, axis=1), atol=2e-3)


def test_changes_within_prototypes_are_named(stage):
    """A part that appears, a part that moves, and a nested instancer; the instancer itself plays."""
    copies = add_copies(stage)
    seen = UsdGeom.Imageable(stage.GetPrimAtPath("/swarm/copies/kind/left")).CreateVisibilityAttr()
    seen.Set("invisible", 0)
    seen.Set("inherited", 8)
    shift = UsdGeom.Xformable(stage.GetPrimAtPath("/swarm/copies/kind/right")).AddTranslateOp(opSuffix="late")
    shift.Set((0, 0, 0), 0)
    shift.Set((0, 0, 5), 24)
    inner = UsdGeom.PointInstancer.Define(stage, "/swarm/copies/kind/inner")
    UsdGeom.Cube.Define(stage, "/swarm/copies/kind/inner/cube")
    inner.CreatePrototypesRel().SetTargets(["/swarm/copies/kind/inner/cube"])
    inner.CreateProtoIndicesAttr([0])
    inner.CreatePositionsAttr().Set([(0, 0, 0)], 0)
    inner.CreatePositionsAttr().Set([(0, 0, 9)], 24)
    with pytest.warns(UserWarning) as warned:
        scene = latelight.from_usd(stage)
    kind = copies.GetPath().AppendChild("kind")
    names = f"{kind}/left.visibility, {kind}/right, {kind}/inner"
    assert [str(warning.message).count(names) for warning in warned] == [1]
    assert len(scene.instances()) == 4  # of two copies, the part that is seen at first and the nested cube


def test_values_that_are_read_once_are_named(stage):
    cube = UsdGeom.Cube.Define(stage, "/cube")
    size = cube.CreateSizeAttr()
    lamp = UsdLux.SphereLight.Define(stage, "/lamp")
    power = lamp.CreateIntensityAttr()
    lamp.CreateRadiusAttr(100)
    for code, value in ((3, 10.0), (9, 20.0)):
        size.Set(value, code)
        power.Set(value, code)
    with pytest.warns(UserWarning, match="/cube.size, /lamp.inputs:intensity only at the time code 3: animations do not"):
        scene = latelight.from_usd(stage)
    assert scene.light(scene.lights()[0]).intensity == pytest.approx(10 * np.pi) and scene.animations == []
    later = latelight.from_usd(stage, time=6)
    assert later.light(later.lights()[0]).intensity == pytest.approx(15 * np.pi)


def test_primvars_that_are_read_once_are_named(stage):
    """Those that a material or an instancer states, and no others."""
    mesh = add_tube(stage, "/tube")
    reader = UsdShade.Shader.Define(stage, "/paint/reader")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("tint")
    copies = UsdGeom.PointInstancer.Define(stage, "/copies")
    for prim, name in ((mesh, "tint"), (mesh, "other"), (copies, "displayColor")):
        primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, Sdf.ValueTypeNames.Color3fArray, "vertex")
        for code in (0, 24):
            primvar.Set([(code / 24, 0, 0)], code)
    names = "/tube.primvars:tint, /copies.primvars:displayColor"
    with pytest.warns(UserWarning, match=f"time samples of {names} only at the time code 0"):
        latelight.from_usd(stage)


def test_warnings_name_the_line_of_the_caller(stage, tmp_path):
    """Of from_usd() and of Scene(). A warning that is an error remains one, also for a file."""
    size = UsdGeom.Cube.Define(stage, "/cube").CreateSizeAttr()
    for code in (3, 9):
        size.Set(float(code), code)
    file = str(tmp_path / "cube.usda")
    stage.Export(file)
    with pytest.warns(UserWarning, match="/cube.size") as warned:
        latelight.from_usd(stage)
        latelight.from_usd(file)
        latelight.Scene(file)
    lines = [linecache.getline(warning.filename, warning.lineno).strip() for warning in warned]
    assert lines == ["latelight.from_usd(stage)", "latelight.from_usd(file)", "latelight.Scene(file)"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="/cube.size"):
            latelight.from_usd(file)


def test_changing_numbers_are_read_once(stage, device):
    """Meshes whose topology changes, and instancers whose copies come and go."""
    fluid = add_tube(stage, "/fluid", rings=4)
    few = np.array(fluid.GetPointsAttr().Get())
    fluid.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(few), 0)
    fluid.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(few[:24]), 1)
    sparks = UsdGeom.PointInstancer.Define(stage, "/sparks")
    UsdGeom.Cube.Define(stage, "/sparks/cube").CreateSizeAttr(10)
    sparks.CreatePrototypesRel().SetTargets(["/sparks/cube"])
    for code, count in ((0, 3), (1, 2)):
        sparks.CreateProtoIndicesAttr().Set([0] * count, code)
        sparks.CreatePositionsAttr().Set([(500, 0, 50 * i) for i in range(count)], code)
    with pytest.warns(UserWarning, match="/fluid.points, /sparks only at the time code 0"):
        scene = latelight.from_usd(stage)
    assert len(scene.instances()) == 4
    assert_shows(scene, device, None, fluid, points_of(fluid, 0))


def test_small_files_do_not_take_much_memory(stage):
    """A thousand samples of three points that 100,000 triangles share would take 7 GB."""
    mesh = UsdGeom.Mesh.Define(stage, "/bomb")
    mesh.CreateFaceVertexCountsAttr([3] * 100_000)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2] * 100_000)
    for code in range(1000):
        mesh.CreatePointsAttr().Set([(0, 0, code), (1, 0, 0), (0, 1, 0)], code)
    with pytest.warns(UserWarning, match="/bomb.points only at the time code 0"):
        assert latelight.from_usd(stage).triangle_count == 100_000


def test_held_stages_play_in_steps(stage, device):
    cube = UsdGeom.Cube.Define(stage, "/cube")
    cube.CreateSizeAttr(200)
    move = cube.AddTranslateOp()
    move.Set((0, 0, 0), 0)
    move.Set((0, -100, 0), RATE)
    stage.SetInterpolationType(Usd.InterpolationTypeHeld)
    renderer = latelight.Renderer(latelight.from_usd(stage), device)
    distances = [renderer.cast([(0, 0, 9)], [(0, 0, -1)], time=time)["distance"][0] for time in (0, 0.9, 1)]
    np.testing.assert_allclose(distances, (8, 8, 7), atol=1e-5)


def test_animations_of_stages_are_exported(stage, tmp_path, device):
    UsdSkel.Root.Define(stage, "/figure")
    skeleton, pose = add_skeleton(stage, "/figure")
    mesh = add_tube(stage, "/figure/tube")
    add_shapes(stage, mesh, bind(mesh, skeleton), pose)
    latelight.from_usd(stage).export(tmp_path / "figure.glb")
    loaded = latelight.Scene(tmp_path / "figure.glb")
    for code in (4.5, 14):
        assert_shows(loaded, device, code / RATE, mesh, reference_points(mesh, code))
