"""latelight.newton against Newton's own camera sensor, which traces rays: on the CPU, or with LATELIGHT_TEST_CUDA=1 on
a GPU."""

import math
import os

import latelight
import numpy as np
import pytest

newton = pytest.importorskip("newton", reason="skipped: the package newton is not installed")
import warp as wp  # noqa: E402
from latelight.newton import SensorCamera  # noqa: E402

DEVICE = "cuda:0" if os.environ.get("LATELIGHT_TEST_CUDA") else "cpu"
WIDTH, HEIGHT = 96, 72
IMAGES = {
    "color_image": "color",
    "depth_image": "depth",
    "forward_depth_image": "depth_forward",
    "shape_index_image": "shape_index",
    "normal_image": "normal",
    "albedo_image": "albedo",
    "hdr_color_image": "color_hdr",
}
SHAPES = [
    ("box", {"hx": 0.3, "hy": 0.4, "hz": 0.2}),
    ("sphere", {"radius": 0.35}),
    ("capsule", {"radius": 0.2, "half_height": 0.3}),
    ("cylinder", {"radius": 0.25, "half_height": 0.3}),
    ("cone", {"radius": 0.3, "half_height": 0.3}),
    ("ellipsoid", {"rx": 0.4, "ry": 0.2, "rz": 0.3}),
]


def ring(shapes, up="z"):
    """A world whose bodies stand in a circle."""
    builder = newton.ModelBuilder(up_axis=newton.Axis.from_any(up))
    for i, (shape, sizes) in enumerate(shapes):
        angle = 2 * math.pi * i / len(shapes)
        place = np.roll([1.2 * math.cos(angle), 1.2 * math.sin(angle), 0.6], {"z": 0, "x": 1, "y": 2}[up])
        turn = wp.quat_from_axis_angle(wp.normalize(wp.vec3(1.0, 0.3 * i, 0.5)), 0.7 * i)
        body = builder.add_body(xform=wp.transform(wp.vec3(*place), turn))
        getattr(builder, f"add_shape_{shape}")(body, **sizes)
    return builder


def looking(eye, target, up=(0, 0, 1)):
    """The transform of a camera that looks along -Z with Y up."""
    back = np.subtract(eye, target) / np.linalg.norm(np.subtract(eye, target))
    right = np.cross(up, back) / np.linalg.norm(np.cross(up, back))
    turn = np.stack([right, np.cross(back, right), back], 1)
    return wp.transform(wp.vec3(*map(float, eye)), wp.quat_from_matrix(wp.mat33(*turn.ravel().tolist())))


def around(count, up="z"):
    """Cameras around the middle."""
    turned = {"z": 0, "x": 1, "y": 2}[up]
    poses = []
    for i in range(count):
        eye, target = (3 * math.cos(1.1 * i), 3 * math.sin(1.1 * i), 2.0), (0, 0, 0.4)
        poses.append(looking(np.roll(eye, turned), np.roll(target, turned), np.roll([0, 0, 1], turned)))
    return wp.array(poses, dtype=wp.transformf, device=DEVICE)


def rays(width=WIDTH, height=HEIGHT, **lens):
    return SensorCamera.compute_camera_rays_pinhole(width, height, device=DEVICE, **(lens or {"camera_fov": 0.9}))


def shot(sensor, state, cameras, bundle, names=tuple(IMAGES), fill=0, **options):
    height, width = bundle.shape[:2]
    images = {name: getattr(sensor, f"allocate_image_{IMAGES[name]}")(len(cameras), width, height) for name in names}
    for image in images.values():
        image.fill_(fill)
    sensor.update(state, cameras, bundle, **images, **options)
    return {name: image.numpy() for name, image in images.items()}


def levels(packed):
    return packed.view(np.uint8).reshape(*packed.shape, 4).astype(int)


def both(model, state, cameras, bundle, **options):
    """The images of Newton and of Latelight."""
    model.bvh_refit_shapes(state)
    results = []
    for sensor in (newton.sensors.SensorCamera(model), SensorCamera(model)):
        sensor.create_default_light()
        results.append(shot(sensor, state, cameras, bundle, **options))
    return results


def expect_alike(theirs, ours, other_shapes=0.003):
    same = theirs["shape_index_image"] == ours["shape_index_image"]
    assert same.mean() >= 1 - other_shapes
    for name in ("depth_image", "forward_depth_image"):
        difference = np.abs(theirs[name] - ours[name])[same]
        assert np.median(difference) < (2e-5 if DEVICE != "cpu" else 5e-6)  # Newton has fast math there
        assert np.percentile(difference, 98) < 0.01  # round shapes have 32 sides
    normals = np.linalg.norm(theirs["normal_image"] - ours["normal_image"], axis=-1)[same]
    assert np.median(normals) < 1e-4 and np.percentile(normals, 95) < 0.12
    assert np.abs(levels(theirs["albedo_image"]) - levels(ours["albedo_image"]))[same].max() <= 1
    # Newton's surfaces have no specular lobe: ours add up to 4 % of the light.
    added = (ours["hdr_color_image"] - theirs["hdr_color_image"])[same]
    assert 0 < added.mean() < 0.04 and np.percentile(np.abs(added), 95) < 0.1
    assert (levels(ours["color_image"])[..., 3] == np.where(ours["shape_index_image"] == 0xFFFFFFFF, 0, 255)).all()


def moved(model, seed):
    state = model.state()
    poses = state.body_q.numpy()
    poses[:, :3] += np.random.default_rng(seed).uniform(-0.15, 0.15, (len(poses), 3)).astype(np.float32)
    state.body_q.assign(poses)
    return state


@pytest.fixture(scope="module")
def rings():
    builder = newton.ModelBuilder()
    builder.replicate(ring(SHAPES), 3)
    builder.add_ground_plane()
    return builder.finalize(device=DEVICE)


def test_images_are_those_of_newton(rings):
    expect_alike(*both(rings, moved(rings, 1), around(3), rays()))


def test_worlds_may_differ_and_views_choose_theirs():
    builder = newton.ModelBuilder()
    for shapes in (SHAPES, SHAPES[2:], [*SHAPES[1::-1], SHAPES[0], SHAPES[0]], []):
        builder.add_world(ring(shapes))
    builder.add_ground_plane()
    model = builder.finalize(device=DEVICE)
    flags = SensorCamera.WorldRenderFlag
    worlds = wp.array(
        [2, 0, 3, 1, 2, int(flags.DISABLE_CLEAR), int(flags.DISABLE_PRESERVE), -1, 4], dtype=wp.int32, device=DEVICE
    )
    theirs, ours = both(model, moved(model, 2), around(9), rays(), world_indices=worlds, fill=1)
    for name in IMAGES:
        assert (ours[name][6] == 1).all()  # preserved
        assert (ours[name][[5, 7, 8]] == theirs[name][[5, 7, 8]]).all()  # cleared
    expect_alike({n: i[:5] for n, i in theirs.items()}, {n: i[:5] for n, i in ours.items()})


def test_meshes_height_fields_and_planes():
    builder = newton.ModelBuilder()
    mesh = newton.Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2], color=(0.9, 0.3, 0.1)
    )
    for x, scale in ((-1.0, (0.5, 0.7, 0.9)), (0.2, (-0.6, 0.6, 0.6))):
        builder.add_shape_mesh(
            builder.add_body(xform=wp.transform(wp.vec3(x, 0, 0.6), wp.quat_identity())), mesh=mesh, scale=scale
        )
    rows, columns = np.mgrid[0:9, 0:13]
    builder.add_shape_heightfield(
        heightfield=newton.Heightfield(0.2 * np.sin(rows) * np.cos(columns), 9, 13, hx=2.0, hy=1.5)
    )
    builder.add_shape_plane(width=6.0, length=5.0, xform=wp.transform(wp.vec3(0, 0, -0.5), wp.quat_identity()))
    model = builder.finalize(device=DEVICE)
    expect_alike(*both(model, model.state(), around(1), rays()), other_shapes=0.01)


def test_up_axes():
    model = ring(SHAPES[:3], up="y").finalize(device=DEVICE)
    expect_alike(*both(model, model.state(), around(1, up="y"), rays()))


def test_off_center_cameras_and_odd_sizes(rings):
    lens = {
        "focal_length": 20.0, "horizontal_aperture": 24.0, "vertical_aperture": 15.0,
        "horizontal_aperture_offset": 2.0, "vertical_aperture_offset": -1.5,
    }  # fmt: skip
    expect_alike(*both(rings, moved(rings, 3), around(2), rays(61, 33, **lens)), other_shapes=0.01)


def test_bodies_move_between_updates(rings):
    sensor = SensorCamera(rings)
    names, cameras, bundle = ("shape_index_image", "depth_image"), around(3), rays()
    pictures = [shot(sensor, moved(rings, seed), cameras, bundle, names) for seed in (4, 5, 4)]
    assert (pictures[0]["depth_image"] != pictures[1]["depth_image"]).any()
    for name in names:
        assert (pictures[0][name] == pictures[2][name]).all()


def test_colors_of_shapes_change_between_updates():
    """Each world has its own colors, and Newton's albedo follows them, too."""
    builder = newton.ModelBuilder()
    builder.replicate(ring(SHAPES), 2)
    builder.add_ground_plane()
    model = builder.finalize(device=DEVICE)
    state, cameras, bundle = model.state(), around(2), rays()
    model.bvh_refit_shapes(state)
    theirs, ours = newton.sensors.SensorCamera(model), SensorCamera(model)
    random = np.random.default_rng(5)
    names = ("shape_index_image", "albedo_image")
    for colors in (None, random.random((model.shape_count, 3)), random.random((model.shape_count, 3))):
        if colors is not None:
            model.shape_color.assign(colors.astype(np.float32))
        expected = np.rint(255 * model.shape_color.numpy())
        images = shot(ours, state, cameras, bundle, names)
        shapes = images["shape_index_image"]
        seen = shapes != 0xFFFFFFFF
        assert seen.mean() > 0.5 and len(np.unique(shapes[seen])) == model.shape_count
        assert np.abs(levels(images["albedo_image"])[..., :3][seen] - expected[shapes[seen]]).max() <= 1
        rays_of_newton = shot(theirs, state, cameras, bundle, names)
        same = seen & (shapes == rays_of_newton["shape_index_image"])
        difference = levels(images["albedo_image"]) - levels(rays_of_newton["albedo_image"])
        assert np.abs(difference)[same].max() <= 1


def test_shadows_and_light(rings):
    state, cameras, bundle = moved(rings, 6), around(1), rays()
    pictures = {}
    for shadows in ("none", "d32"):
        sensor = SensorCamera(rings, shadows=shadows)
        sensor.create_default_light(color=(2, 1, 1), direction=(0.5, 0.2, -1))
        sensor.set_ambient_light((0, 0, 0))
        pictures[shadows] = shot(sensor, state, cameras, bundle, ("hdr_color_image",))["hdr_color_image"]
    dark = (pictures["d32"] < 0.1 * pictures["none"]).all(-1)
    assert 0.02 < dark.mean() < 0.3
    ground = pictures["none"][0, 2, 2]
    assert ground[0] == pytest.approx(2 * ground[1], rel=0.02)


def test_ambient_light_may_be_an_array(rings):
    """Colors of the upper and the lower half of the surroundings. The lower one may be black, and is that of the upper
    one by default."""
    state, bundle = moved(rings, 7), rays()
    images = {}
    for ground in ((0.1, 0.2, 0.3), (0, 0, 0), None):
        sensor = SensorCamera(rings)
        sensor.set_ambient_light(np.array([0.2, 0.2, 0.2]), None if ground is None else np.array(ground))
        images[ground] = shot(sensor, state, around(1), bundle, ("hdr_color_image",))["hdr_color_image"]
    assert images[(0.1, 0.2, 0.3)].sum() > images[(0, 0, 0)].sum()
    assert images[None].sum() > images[(0, 0, 0)].sum()


def test_arguments_of_newton_are_accepted(rings):
    """Settings that change no image have no effect, and others are errors."""
    config = SensorCamera.RenderConfig(
        tile_width=8, enable_particles=False, enable_textures=True, render_order=SensorCamera.RenderOrder.TILED)
    sensor = SensorCamera(
        rings, default_render_config=config, deformable_surface_mode=SensorCamera.DeformableSurfaceMode.VISUAL_ONLY)
    state, cameras, bundle = moved(rings, 8), around(1), rays()
    sensor.sync_deformable_meshes(state)
    plain = shot(SensorCamera(rings), state, cameras, bundle, ("color_image",))
    same = shot(sensor, state, cameras, bundle, ("color_image",), render_config=config, sync_deformables=False)
    np.testing.assert_array_equal(same["color_image"], plain["color_image"])
    shadows = SensorCamera.RenderConfig(enable_shadows=True, max_distance=10)
    for refused in (
        lambda: SensorCamera(rings, default_render_config=shadows),
        lambda: sensor.update(state, cameras, bundle, render_config=shadows),
    ):
        with pytest.raises(latelight.UsageError, match="default enable_shadows, max_distance"):
            refused()
    for option in ({"channels_first": True}, {"axes": "z-up"}, {"formats": {"id": "uint16"}}, {"out": {}}):
        (name,) = option
        with pytest.raises(latelight.UsageError, match=f"so it has no option {name}$"):
            SensorCamera(rings, **option)
    with pytest.raises(latelight.UsageError, match="deformable_visuals must be None"):
        sensor.update(state, cameras, bundle, deformable_visuals=3)


def test_poses_of_usd_cameras(rings):
    usd_geom = pytest.importorskip("pxr.UsdGeom")
    stage = pytest.importorskip("pxr.Usd").Stage.CreateInMemory()
    usd_geom.SetStageUpAxis(stage, usd_geom.Tokens.y)
    camera = usd_geom.Camera.Define(stage, "/camera")
    camera.AddTranslateOp().Set((1, 2, 3))
    (pose,) = SensorCamera(rings).compute_camera_transforms_usd(camera).numpy()
    np.testing.assert_allclose(pose[:3], (1, -3, 2), atol=1e-5)  # from Y up to the model's Z up


def test_wrong_arguments_are_sentences(rings):
    sensor, state, cameras, bundle = SensorCamera(rings), rings.state(), around(3), rays()
    color = sensor.allocate_image_color(3, WIDTH, HEIGHT)

    def refused(words, *arguments, **images):
        with pytest.raises(latelight.UsageError, match=words):
            sensor.update(*arguments, **images)

    refused("transformf", state, np.zeros((3, 7)), bundle, color_image=color)
    refused("world_indices", state, around(4), bundle, color_image=sensor.allocate_image_color(4, WIDTH, HEIGHT))
    two = wp.array([0, 1], dtype=wp.int32, device=DEVICE)
    refused("int32", state, cameras, bundle, color_image=color, world_indices=two)
    refused("shape", state, cameras, bundle, color_image=sensor.allocate_image_color(2, WIDTH, HEIGHT))
    refused("uint32", state, cameras, bundle, color_image=sensor.allocate_image_depth(3, WIDTH, HEIGHT))
    refused("samples", state, cameras, rays(WIDTH, HEIGHT, camera_fov=0.9, sample_count=4), color_image=color)
    bent = bundle.numpy().copy()
    bent[5, 7, 0, 1, 0] += 0.1
    refused("pinhole", state, cameras, wp.array(bent, dtype=wp.vec3f, device=DEVICE), color_image=color)
    sensor.update(state, cameras, bundle)  # without images
    sensor.update(state, cameras, bundle, color_image=color)
    assert color.numpy().any()


def test_a_model_without_shapes_is_background():
    model = newton.ModelBuilder().finalize(device=DEVICE)
    images = shot(SensorCamera(model), model.state(), around(1), rays())
    assert (images["shape_index_image"] == 0xFFFFFFFF).all() and not images["color_image"].any()
