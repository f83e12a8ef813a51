"""Depth sensors: the statistics of the noise models' formulas, disparities, and the shadow of structured light."""

import dataclasses
import math

import numpy as np
import pytest

import latelight
from latelight import depth_sensor


def plane(z, degrees, shape=(200, 300)):
    return np.full(shape, z), np.full(shape, math.radians(degrees))


@pytest.mark.parametrize("z, degrees", [(0.8, 0), (2.0, 30), (3.5, 50), (1.0, 75)])
def test_the_kinect_has_the_axial_noise_of_its_paper(z, degrees):
    continuous = dataclasses.replace(depth_sensor.kinect(), disparity_step=0.0, max_range=20.0)
    measured = depth_sensor.measure(continuous, *plane(z, degrees), focal=585.0, seed=1).astype(np.float64)
    angle = math.radians(degrees)
    # Nguyen, Izadi and Lovell 2012, equations 2 and 4, in meters.
    sigma = 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / math.sqrt(z) * angle**2 / (math.pi / 2 - angle) ** 2
    assert abs(measured.std() / sigma - 1) < 4 / math.sqrt(2 * measured.size)
    assert abs(measured.mean() - z) < 4 * sigma / math.sqrt(measured.size)


def test_lateral_noise_moves_edges():
    """A step between two depths: rows choose the side by a normal distribution of the columns."""
    sensor = dataclasses.replace(depth_sensor.kinect(), axial=(0.0, 0.0, 0.0, 0.0), disparity_step=0.0)
    depth = np.where(np.arange(40) < 20, 1.0, 2.0) * np.ones((20000, 1))
    measured = depth_sensor.measure(sensor, depth, np.zeros(depth.shape), focal=585.0, seed=2)
    far = (measured == 2).mean(axis=0)
    for column in range(16, 24):
        # The column whose center is at `column` is moved to one of at least 20 where it passes 19.5.
        expected = 0.5 * math.erfc((19.5 - column) / 0.8 / math.sqrt(2))
        assert abs(far[column] - expected) < 0.015, column


def test_stereo_noise_grows_with_the_square_of_depth():
    sensor = dataclasses.replace(depth_sensor.realsense_d435(), disparity_step=0.0, max_range=50.0)
    for z in (0.5, 2.0, 6.0):
        measured = depth_sensor.measure(sensor, *plane(z, 0), focal=640.0, seed=3)
        assert abs(measured.std() / (0.08 * z * z / (640 * 0.05)) - 1) < 0.02


def test_disparities_are_multiples_of_the_step():
    depth = np.linspace(0.6, 4.9, 5000)[None]
    measured = depth_sensor.measure(depth_sensor.kinect(), depth, np.zeros(depth.shape), focal=580.0, seed=None)
    steps = 580 * 0.075 / measured.astype(np.float64) * 8
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-4)
    # At most half a step: z^2 / (f b) / 16.
    assert (np.abs(measured - depth) <= depth**2 / (580 * 0.075) / 16 * 1.02).all()


def test_values_that_the_sensor_does_not_have():
    depth = np.array([[0.2, 2.0, 9.0, np.inf, 2.0, 2.0]])
    angles = np.radians([[0, 0, 0, 0, 85, 0]])
    shadow = np.array([[False] * 5 + [True]])
    measured = depth_sensor.measure(depth_sensor.kinect(), depth, angles, 580.0, None, shadow)
    assert (measured > 0).tolist() == [[False, True, False, False, False, False]]


@pytest.mark.parametrize("seed", [None, 1])
def test_pixels_without_a_surface_may_lack_an_incidence(seed):
    """Lateral noise moves pixels, but not by a whole one with a deviation of 0.01."""
    sensor = dataclasses.replace(depth_sensor.kinect(), lateral=(0.01, 0.0))
    depth, angles = plane(2.0, 0, (4, 6))
    depth[0, 0], angles[0, 0] = np.inf, np.nan  # the background
    depth[1, 1], angles[1, 1] = 0, np.nan
    angles[2, 2] = np.nan  # a surface without an angle
    measured = depth_sensor.measure(sensor, depth, angles, 525.0, seed)
    assert np.argwhere(measured == 0).tolist() == [[0, 0], [1, 1], [2, 2]]
    if seed is not None:  # the random numbers of the other pixels do not depend on it
        depth[:], angles[:] = plane(2.0, 0, (4, 6))
        whole = depth_sensor.measure(sensor, depth, angles, 525.0, seed)
        np.testing.assert_array_equal(measured[measured > 0], whole[measured > 0])


def quad(scene, x, z, at):
    """A surface in the plane of this z, which faces +Z, from x[0] to x[1], moved by `at`."""
    points = np.array([[x[0], -5, z], [x[1], -5, z], [x[1], 5, z], [x[0], 5, z]], np.float32)
    move = np.eye(4)
    move[:3, 3] = at
    mesh = scene.add_mesh(points, indices=[[0, 1, 2], [0, 2, 3]])
    scene.add_instance(mesh, scene.add_material(latelight.Material()), move)


@pytest.mark.parametrize("at", [(0, 0, 0), (5e5, 0, 0), (3e6, 0, -2e6)])
@pytest.mark.parametrize("vertical_focal", [100, 80])
def test_the_projector_casts_a_shadow(device, at, vertical_focal):
    """A plate at 1 m before a wall at 3 m, seen along -Z, with the projector 0.3 m to the right.

    Far from the origin, floats are up to 0.25 m apart. Unequal focal lengths are a pinhole lens.
    """
    scene = latelight.Scene()
    quad(scene, (-10, 10), -3.0, at)
    quad(scene, (-0.2, 0.2), -1.0, at)
    renderer = latelight.Renderer(scene, device)
    pose = np.diag([1.0, -1, -1, 1])
    pose[:3, 3] = at
    camera = latelight.Camera.from_k([[100, 0, 100], [0, vertical_focal, 20], [0, 0, 1]], pose, (200, 40))
    assert (camera.lens is not None) == (vertical_focal != 100)
    sensor = dataclasses.replace(depth_sensor.kinect(), baseline=0.3)
    frame = depth_sensor.capture(renderer, camera, (200, 40), sensor, seed=None)
    x = np.arange(200) + 0.5 - 100
    on_plate = np.abs(x) < 20
    # The plate's edges at -0.2 and 0.2 m, seen from x = 0.3 m, lie at 0.3 + 3 (edge - 0.3) on the wall: -1.2 and 0 m.
    wall_x = 3 * x / 100
    expected = ~on_plate & (wall_x > -1.2) & (wall_x < 0)
    clear = np.abs(wall_x + 1.2) > 0.05
    assert np.array_equal(frame.shadow[20][clear], expected[clear])
    assert frame.shadow[20].any() and (frame.depth[frame.shadow] == 0).all()
    np.testing.assert_allclose(frame.true_depth[20], np.where(on_plate, 1, 3), rtol=1e-5)
    slope = np.hypot(x / 100, 0.5 / vertical_focal)
    np.testing.assert_allclose(frame.incidence[20], np.arctan(slope), atol=1e-4)
    seen = frame.depth > 0
    assert (np.abs(frame.depth - frame.true_depth)[seen] < 9 / (100 * 0.3) / 16 * 1.1).all()


@pytest.mark.parametrize("own", [False, True])
def test_rows_of_a_rolling_shutter_have_their_own_shadows(device, own):
    """The plate of the test above moves to the right by 0.4 m per second, and row y of 20 is exposed at the time
    5 + ((y + 0.5) / 20 - 0.5) * 1.5."""
    scene = latelight.Scene()
    quad(scene, (-10, 10), -3.0, (0, 0, 0))
    points = np.array([[-0.2, -5, -1], [0.2, -5, -1], [0.2, 5, -1], [-0.2, 5, -1]], np.float32)
    mesh = scene.add_mesh(points, indices=[[0, 1, 2], [0, 2, 3]])
    plate = scene.add_node("plate", parts=[(mesh, scene.add_material(latelight.Material()))])
    path = dict(times=[0, 10], values=[[-2, 0, 0], [2, 0, 0]])
    scene.add_animation("move", [latelight.AnimationChannel(node=plate, property="translation", **path)])
    camera = latelight.Camera.from_k([[100, 0, 100], [0, 100, 10], [0, 0, 1]], np.diag([1.0, -1, -1, 1]), (200, 20))
    options = dict(readout=1.5)
    if own:  # replaces the option's
        camera.readout, options["readout"] = 1.5, 9.0
    sensor = dataclasses.replace(depth_sensor.kinect(), baseline=0.3)
    renderer = latelight.Renderer(scene, device)
    frame = depth_sensor.capture(renderer, camera, (200, 20), sensor, seed=None, time=5, **options)
    x = np.arange(200) + 0.5 - 100
    for y in range(20):
        left, right = (edge + 0.4 * ((y + 0.5) / 20 - 0.5) * 1.5 for edge in (-0.2, 0.2))
        on_plate = (x > 100 * left) & (x < 100 * right)
        wall_x, edges = 3 * x / 100, [0.3 + 3 * (edge - 0.3) for edge in (left, right)]
        expected = ~on_plate & (wall_x > edges[0]) & (wall_x < edges[1])
        clear = (np.abs(x - 100 * left) > 0.5) & (np.abs(x - 100 * right) > 0.5)
        clear &= (np.abs(wall_x - edges[0]) > 0.05) & (np.abs(wall_x - edges[1]) > 0.05)
        assert np.array_equal(frame.shadow[y][clear], expected[clear]), y
        np.testing.assert_allclose(frame.true_depth[y][clear], np.where(on_plate, 1, 3)[clear], rtol=1e-5)


@pytest.mark.parametrize("fit, focal", [("whole", 16 * math.sqrt(3)), ("vertical", 32 * math.sqrt(3))])
def test_the_fit_of_the_camera_defines_the_focal_length(device, fit, focal):
    """A wall at 2 m fills a square image of a camera with 60 degrees of vertical field of view and the aspect 2.

    The whole frame is 32 pixels high, and the image of the vertical field of view is 64 pixels high.
    """
    scene = latelight.Scene()
    quad(scene, (-10, 10), -2.0, (0, 0, 0))
    camera = latelight.Camera.look_at((0, 0, 0), (0, 0, -1), vertical_fov=60)
    camera.aspect = 2.0
    renderer = latelight.Renderer(scene, device)
    frame = depth_sensor.capture(renderer, camera, (64, 64), depth_sensor.kinect(), seed=None, camera_fit=fit)
    offsets = np.arange(64) + 0.5 - 32
    slope = np.hypot(offsets, offsets[:, None]) / focal
    np.testing.assert_allclose(frame.incidence, np.arctan(slope), atol=1e-4)
    # Depths are quotients of focal length times baseline and multiples of 1/8 of a pixel of disparity.
    scale = focal * 0.075 * 8
    np.testing.assert_allclose(frame.depth, scale / round(scale / 2), rtol=1e-6)
    assert camera.aspect == 2


def test_captures_are_the_same_in_each_run(renderer, boxes):
    camera = boxes.default_camera()
    sensor = dataclasses.replace(depth_sensor.kinect(), max_range=50.0)
    frames = [depth_sensor.capture(renderer, camera, (64, 48), sensor, seed=seed) for seed in (1, 1, 2)]
    assert np.array_equal(frames[0].depth, frames[1].depth)
    assert not np.array_equal(frames[0].depth, frames[2].depth)
    assert (frames[0].depth > 0).any()


def test_wrong_arguments(renderer):
    def refused(text, call, *arguments):
        with pytest.raises(latelight.UsageError, match=text):
            call(*arguments)

    kinect = depth_sensor.kinect()
    refused("same shape", lambda: depth_sensor.measure(kinect, np.ones((4, 4)), np.ones((4, 5)), 500.0))
    for shape in ((6, 6), (2, 2), (4,), ()):
        for seed in (None, 1):
            refused(
                r"shadow must have the shape of depth, \(4, 4\), not",
                lambda: depth_sensor.measure(kinect, *plane(1, 0, (4, 4)), 500.0, seed, np.ones(shape, bool)),
            )
    for focal in (0.0, -1.0, math.inf, math.nan, "x"):
        refused("focal", lambda: depth_sensor.measure(kinect, np.ones((4, 4)), np.ones((4, 4)), focal))
    refused("depth must be", lambda: depth_sensor.measure(kinect, "x", np.ones((4, 4)), 500.0))
    refused("incidence must be", lambda: depth_sensor.measure(kinect, np.ones((4, 4)), [[1], [2, 3]], 500.0))
    for angle in (-0.5, 2.0, math.inf):
        refused(
            f"incidence must be from 0 to pi/2 radians, or NaN, not {angle:g}",
            lambda: depth_sensor.measure(kinect, np.ones((4, 4)), np.full((4, 4), angle), 500.0),
        )
    right = np.full((4, 4), np.pi / 2, np.float32)  # above pi/2 in double precision
    assert not depth_sensor.measure(kinect, np.ones((4, 4)), right, 500.0, None).any()
    for value, kind in ((None, "NoneType"), ("kinect", "str"), ([latelight.Camera()], "list")):
        for name, call in (
            ("renderer must be a Renderer", lambda: depth_sensor.capture(value, latelight.Camera(), (8, 8), kinect)),
            ("camera must be a Camera", lambda: depth_sensor.capture(renderer, value, (8, 8), kinect)),
            ("sensor must be a DepthSensor", lambda: depth_sensor.capture(renderer, latelight.Camera(), (8, 8), value)),
            ("sensor must be a DepthSensor", lambda: depth_sensor.measure(value, *plane(1, 0, (4, 4)), 500.0)),
        ):  # fmt: skip
            with pytest.raises(latelight.ArgumentTypeError, match=f"^{name}, not {kind}$"):
                call()
    for size in (8, (8,), None, "8x8"):
        refused("size must be", lambda: depth_sensor.capture(renderer, latelight.Camera(), size, kinect))
    for seed in (-1, 1.5, "x", 2**63, True):
        refused("seed must be a whole number", lambda: depth_sensor.measure(kinect, *plane(1, 0), 500.0, seed))
        refused(
            "seed must be a whole number",
            lambda: depth_sensor.capture(renderer, latelight.Camera(), (8, 8), kinect, seed=seed),
        )
    for name, values, text in (
        ("baseline", (0.0, math.nan, math.inf, "x", None), "baseline"),
        ("lateral", ((-1.0, 0.0), (math.nan, 0.0)), "noise"),
        ("lateral", ((), (1.0,), (1.0, 2.0, 3.0), 1.0, None, "12", ("a", "b")), "lateral must be"),
        ("axial", ((1, 2), (0.0,) * 5, None, "1234", (0.0, 0.0, 0.0, "x")), "axial must be"),
        ("disparity_noise", (-1.0, math.nan), "noise"),
        ("disparity_step", ("x", None), "disparity_step must be a number"),
        ("min_range", (-1.0, 6.0, math.nan), "range"),
        ("max_range", (0.1, math.nan), "range"),
        ("max_incidence", (math.nan, math.inf, -5, 90.5, "x", None), "max_incidence must be"),
    ):  # fmt: skip
        for value in values:
            refused(text, lambda: dataclasses.replace(kinect, **{name: value}))
    lens = latelight.Camera(lens=latelight.Lens(model="fisheye"))
    refused("perspective", lambda: depth_sensor.capture(renderer, lens, (8, 8), kinect))
    camera = latelight.Camera()
    for name, value in (
        ("axes", "z-up"), ("position_origin", "1,2,3"), ("normal_frame", "opencv"), ("outputs", "color"), ("out", {}),
        ("on_device", True), ("formats", {"depth": "float16"}), ("channels_first", True),
        ("previous_cameras", [camera]), ("next_cameras", [camera]),
    ):  # fmt: skip
        refused(
            f"a depth sensor .*, so it has no option {name}$",
            lambda option: depth_sensor.capture(renderer, camera, (8, 8), kinect, **option), {name: value},
        )  # fmt: skip
    refused(
        '"max_distance" does not apply',
        lambda: depth_sensor.capture(renderer, camera, (8, 8), kinect, max_distance=3),
    )
