"""Lidar scans against closed forms: planes, spheres, motion, echoes, and the statistics of noise."""

import dataclasses
import math

import numpy as np
import pytest

import latelight
from latelight import lidar

X = np.array([1.0, 0.0, 0.0])


def ideal(pattern, **changes):
    """The pattern without limits of range, signal and resolution."""
    free = dict(min_range=0.0, max_range=math.inf, rated_range=math.inf, range_resolution=0.0, range_noise=0.0)
    return dataclasses.replace(pattern, **{**free, **changes})


def firings(directions, **properties):
    directions = np.asarray(directions, np.float64)
    count = len(directions)
    times = np.arange(count) * 1e-5
    return lidar.Pattern("test", directions, times, np.zeros(count, np.uint16), 0.1, **properties)


def wall(scene, x, reflectance=1.0, low=-500.0, high=500.0):
    """A matte surface in the plane of this x, which faces -X, from low to high along Z. Both sides reflect."""
    corners = np.array([[x, -500, low], [x, 500, low], [x, 500, high], [x, -500, high]], np.float32)
    mesh = scene.add_mesh(corners, indices=[[0, 1, 2], [0, 2, 3]])
    # Metals reflect their base color, so that the reflectance is exact.
    values = latelight.Material(base_color=(reflectance,) * 3 + (1,), metallic=1, double_sided=True)
    scene.add_instance(mesh, scene.add_material(values))


def sphere(scene, radius):
    rows, columns = 256, 512
    polar, turn = np.meshgrid(np.linspace(0, np.pi, rows + 1), 0.1 + np.linspace(0, 2 * np.pi, columns + 1), indexing="ij")
    points = np.stack([np.sin(polar) * np.cos(turn), np.cos(polar), np.sin(polar) * np.sin(turn)], -1).reshape(-1, 3)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    right, below = first + 1, first + columns + 1
    triangles = np.concatenate([np.stack([first, right, below], 1), np.stack([right, below + 1, below], 1)])
    mesh = scene.add_mesh((radius * points).astype(np.float32), indices=triangles, normals=points.astype(np.float32))
    scene.add_instance(mesh, scene.add_material(latelight.Material(metallic=1, double_sided=True)))


def rendererOf(build, device):
    scene = latelight.Scene()
    build(scene)
    return latelight.Renderer(scene, device)


# A sensor whose X axis is the scene's, and whose Z axis points up (+Y).
POSE = lidar.sensor_pose((0, 0, 0), forward=(1, 0, 0))


def test_a_plane(device):
    renderer = rendererOf(lambda scene: wall(scene, 12.0), device)
    pattern = ideal(lidar.os1_64(columns=512))
    scan = lidar.scan(renderer, pattern, POSE, seed=None)
    ahead = np.flatnonzero(pattern.directions @ X > 0.05)
    inside = ahead[12 / (pattern.directions[ahead] @ X) < 300]
    assert set(inside) <= set(scan.firing)
    assert (pattern.directions[scan.firing] @ X > 0).all()
    np.testing.assert_allclose(scan.range, 12 / (pattern.directions[scan.firing] @ X), rtol=1e-6)
    np.testing.assert_allclose(scan.position[:, 0], 12, rtol=1e-6)
    np.testing.assert_allclose(scan.world_position[:, 0], 12, rtol=1e-6)
    # Lambert's law: the cosine between the ray and the normal.
    np.testing.assert_allclose(scan.intensity, pattern.directions[scan.firing] @ X, atol=2e-6)
    assert np.array_equal(scan.ring, pattern.rings[scan.firing])
    assert (scan.id == scan.id[0]).all() and scan.id[0] > 0


def test_a_sphere_around_the_sensor(device):
    renderer = rendererOf(lambda scene: sphere(scene, 7.0), device)
    for pattern in (lidar.vlp16(rate=20), lidar.livox_mid40()):
        scan = lidar.scan(renderer, ideal(pattern), POSE, seed=None)
        assert len(scan) == len(pattern)
        np.testing.assert_allclose(scan.range, 7, rtol=1e-4)
        np.testing.assert_allclose(np.linalg.norm(scan.world_position, axis=1), 7, rtol=1e-4)


def test_a_box_around_the_sensor(device):
    """Ranges by the slabs of the box, from a place off its center and with a tilted sensor."""
    half = np.array([6.0, 3.0, 9.0])

    def room(scene):
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
        sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
        triangles = [[s[0], s[i], s[i + 1]] for s in sides for i in (1, 2)]
        mesh = scene.add_mesh(corners.astype(np.float32), indices=triangles)
        scene.add_instance(mesh, scene.add_material(latelight.Material(metallic=1, double_sided=True)))

    renderer = rendererOf(room, device)
    place = np.array([1.5, -0.75, 4.0])
    pose = lidar.sensor_pose(place, forward=(1, 0.3, -0.5), up=(0.2, 1, 0.1))
    for pattern in (lidar.os1_128(columns=512), lidar.hdl64e(), lidar.livox_mid40()):
        scan = lidar.scan(renderer, ideal(pattern), pose, seed=None)
        assert len(scan) == len(pattern)
        rays = pattern.directions @ pose[:3, :3].T
        with np.errstate(divide="ignore"):
            expected = ((np.sign(rays) * half - place) / rays).min(axis=1)
        np.testing.assert_allclose(scan.range, expected, rtol=2e-6)
        np.testing.assert_allclose(scan.world_position, place + rays * expected[:, None], atol=3e-5)


def test_motion_distorts_as_the_sensor_moves(device):
    renderer = rendererOf(lambda scene: wall(scene, 40.0), device)
    pattern = ideal(lidar.vlp16())
    scan = lidar.scan(renderer, pattern, lidar.Motion(POSE, velocity=(30, 0, 0)), start=0.2, seed=None)
    traveled = 30 * (0.2 + scan.time)
    np.testing.assert_allclose(scan.position[:, 0], 40 - traveled, rtol=1e-5)
    np.testing.assert_allclose(scan.world_position[:, 0], 40, rtol=1e-6)
    assert np.ptp(scan.position[:, 0]) > 2.5  # 3 m per scan


def test_a_turning_sensor(device):
    renderer = rendererOf(lambda scene: sphere(scene, 9.0), device)
    pattern = ideal(lidar.hdl32e())
    rate = 2 * np.pi * 10  # counter-clockwise as fast as the rotor turns clockwise: all firings look ahead
    scan = lidar.scan(renderer, pattern, lidar.Motion(POSE, angular_velocity=(0, rate, 0)), seed=None)
    assert len(scan) == len(pattern)
    across = np.hypot(scan.world_position[:, 0], scan.world_position[:, 2])
    np.testing.assert_allclose(scan.world_position[:, 0], across, rtol=1e-6)
    np.testing.assert_allclose(scan.world_position[:, 2], 0, atol=1e-3)
    turned = np.arctan2(-scan.position[:, 1], scan.position[:, 0]) % (2 * np.pi)
    np.testing.assert_allclose(turned, rate * scan.time % (2 * np.pi), atol=1e-4)


def test_positions_in_the_world_are_relative_to_the_origin(device):
    renderer = rendererOf(lambda scene: wall(scene, 12.0), device)
    pattern = firings([X, [0.8, 0.6, 0], [0.8, 0, 0.6]])
    scan = lidar.scan(renderer, pattern, POSE, seed=None, position_origin="10,20,-30")
    np.testing.assert_allclose(scan.position, [[12, 0, 0], [12, 9, 0], [12, 0, 9]], atol=1e-5)
    # The sensor's Y axis points to the left, which is the scene's -Z, and its Z axis up.
    np.testing.assert_allclose(scan.world_position, [[2, -20, 30], [2, -20, 21], [2, -11, 30]], atol=1e-5)


def test_a_trajectory_interpolates():
    quarter = lidar.sensor_pose((2, 0, 4), forward=(0, 0, -1))  # 90 degrees to the left of POSE
    path = lidar.Trajectory([1.0, 3.0], [POSE, quarter])
    (middle,) = path.at([2.0])
    np.testing.assert_allclose(middle[:3, 0], [math.sqrt(0.5), 0, -math.sqrt(0.5)], atol=1e-12)
    np.testing.assert_allclose(middle[:3, 3], [1, 0, 2], atol=1e-12)
    np.testing.assert_allclose(path.at([1, 3]), [POSE, quarter], atol=1e-12)
    half = lidar.Trajectory([0.0, 1.0], [POSE, lidar.sensor_pose((0, 0, 0), forward=(-1, 0, 0))])
    (third,) = half.at([1 / 3])  # of half a turn, about either direction of the axis
    np.testing.assert_allclose(third[:3, 0] @ POSE[:3, 0], 0.5, atol=1e-9)
    np.testing.assert_allclose(third[:3, 2], POSE[:3, 2], atol=1e-9)


# --- echoes and signal ----------------------------------------------------------------------------------------------


def near_half_and_far(scene):
    """A wall at 5 m that hides what is to the right (+Z) of the X axis of one at 20 m."""
    wall(scene, 5.0, low=0.0)
    wall(scene, 20.0)


def test_an_edge_returns_two_echoes(device):
    renderer = rendererOf(near_half_and_far, device)
    pattern = firings([X], divergence=(4e-3, 4e-3), rated_range=100.0)
    scans = {r: lidar.scan(renderer, pattern, POSE, samples=64, returns=r, seed=None) for r in lidar.RETURNS}
    assert {r: np.round(scan.range, 2).tolist() for r, scan in scans.items()} == {
        "first": [5], "last": [20], "strongest": [5], "dual": [5, 20], "all": [5, 20],
    }  # fmt: skip
    assert scans["all"].echo.tolist() == [0, 1] and scans["last"].echo.tolist() == [1]
    # Half of the beam's energy each.
    np.testing.assert_allclose(scans["all"].intensity, 0.5, atol=0.04)
    assert len(set(scans["all"].id)) == 2
    whole = lidar.scan(renderer, firings([[0.99, 0.141067, 0]]), POSE, samples=64, returns="all", seed=None)
    assert len(whole) == 1 and abs(whole.intensity[0] - 0.99) < 1e-3
    one = lidar.scan(renderer, dataclasses.replace(pattern, echo_separation=30.0), POSE, samples=64, seed=None)
    # One pulse: the mean weighs each half by the light that it returns, 1 / range^2.
    assert abs(one.range[0] - (5 / 25 + 20 / 400) / (1 / 25 + 1 / 400)) < 0.2


@pytest.mark.parametrize("rated_range", [100.0, math.inf])
def test_the_strongest_echo_may_be_a_far_one(device, rated_range):
    """Powers are reflectance times the share of the beam, over the square of the range: 0.02 * 0.5 / 5**2 = 0.0004 of
    the dark wall, 1 * 0.25 / 10**2 = 0.0025 of the middle one, and 1 * 0.25 / 20**2 = 0.0006 of the last one."""

    def walls(scene):
        wall(scene, 5.0, reflectance=0.02, low=0.0)
        # A Gaussian beam has a quarter of its energy beyond 0.6745 standard deviations, which are a quarter of the
        # divergence.
        wall(scene, 10.0, high=-10 * 0.6744898 * 1e-3)
        wall(scene, 20.0)

    renderer = rendererOf(walls, device)
    pattern = firings([X], divergence=(4e-3, 4e-3), rated_range=rated_range)
    scans = {r: lidar.scan(renderer, pattern, POSE, samples=256, returns=r, seed=None) for r in lidar.RETURNS}
    assert {r: np.round(scan.range, 2).tolist() for r, scan in scans.items()} == {
        "first": [5], "last": [20], "strongest": [10], "dual": [10, 20], "all": [5, 10, 20],
    }  # fmt: skip
    np.testing.assert_allclose(scans["all"].intensity, (0.01, 0.25, 0.25), rtol=0.1)


def test_the_energy_of_a_beam_is_gaussian(device):
    """A wall that begins one radius (1/e^2) beside the axis receives (1 - erf(sqrt(2))) / 2 = 2.3 % of the beam."""
    renderer = rendererOf(lambda scene: wall(scene, 10.0, low=10 * 2e-3), device)
    pattern = firings([X], divergence=(4e-3, 4e-3))
    scan = lidar.scan(renderer, pattern, POSE, samples=1024, seed=None)
    assert abs(scan.intensity[0] - 0.5 * math.erfc(math.sqrt(2))) < 0.004


@pytest.mark.parametrize("reflectance, distance", [(0.8, 100.0), (0.2, 50.0), (0.8, 110.0), (0.1, 30.0), (0.4, 90.0)])
def test_surfaces_drop_out_by_reflectance_and_range(device, reflectance, distance):
    """90 % of the rated signal is detected; other signals by the normal distribution of the receiver's noise."""
    renderer = rendererOf(lambda scene: wall(scene, distance, reflectance), device)
    count = 20000
    scan = lidar.scan(renderer, firings(np.tile(X, (count, 1)), rated_range=100.0), POSE, seed=3)
    signal = reflectance / 0.8 * (100 / distance) ** 2
    noise = 1 / (4.5 + 1.2815515655446004)
    expected = 0.5 * math.erfc(-(signal - 4.5 * noise) / noise / math.sqrt(2))
    if signal == 1:
        assert abs(expected - 0.9) < 1e-9
    deviation = math.sqrt(expected * (1 - expected) / count)
    assert abs(len(scan) / count - expected) < 4 * deviation + 1e-3


def test_ranges_have_noise_limits_and_steps(device):
    renderer = rendererOf(lambda scene: wall(scene, 20.0), device)
    count = 20000
    ahead = np.tile(X, (count, 1))
    noisy = lidar.scan(renderer, firings(ahead, range_noise=0.03), POSE, seed=5).range.astype(np.float64) - 20
    assert abs(noisy.mean()) < 4 * 0.03 / math.sqrt(count)
    assert abs(noisy.std() / 0.03 - 1) < 4 / math.sqrt(2 * count)
    stepped = lidar.scan(renderer, firings(ahead[:500], range_noise=0.03, range_resolution=0.02), POSE, seed=5)
    assert np.allclose(stepped.range / 0.02, np.round(stepped.range / 0.02), atol=1e-3)
    assert len(np.unique(stepped.range)) > 3
    for limits, some in ((dict(max_range=19.0), 0), (dict(min_range=21.0), 0), (dict(min_range=19.0, max_range=21.0), 500)):
        assert len(lidar.scan(renderer, firings(ahead[:500], **limits), POSE, seed=5)) == some


def test_seeds(device):
    renderer = rendererOf(lambda scene: wall(scene, 95.0), device)
    pattern = lidar.vlp16(rate=20)
    scans = [lidar.scan(renderer, pattern, POSE, samples=2, seed=seed) for seed in (1, 1, 2)]
    for field in dataclasses.fields(lidar.Scan):
        assert np.array_equal(getattr(scans[0], field.name), getattr(scans[1], field.name)), field.name
    assert not np.array_equal(scans[0].range, scans[2].range)


def test_an_animated_scene_moves_during_the_scan(model, device):
    """Poses of Fox: with as many slices as times, parts of a scan are those of scans at these times."""
    renderer = latelight.Renderer(latelight.Scene(model("Fox.glb")), device)
    pose = lidar.sensor_pose((250, 60, 0), forward=(-1, 0, 0))
    pattern = ideal(dataclasses.replace(lidar.vlp16(), divergence=(0.0, 0.0)))
    moving = lidar.scan(renderer, pattern, pose, seed=None, slices=2, time=0.3)
    still = lidar.scan(renderer, pattern, pose, seed=None, time=0.3 + 0.75 * pattern.period)
    late = moving.time > pattern.period / 2
    assert late.any()
    assert np.array_equal(moving.range[late], still.range[still.time > pattern.period / 2])


def moving_wall(scene):
    """A wall in the plane x = 12 at rest. From time 0 on it is at x = 20 + 5 per second."""
    corners = np.array([[12, -500, -500], [12, 500, -500], [12, 500, 500], [12, -500, 500]], np.float32)
    mesh = scene.add_mesh(corners, indices=[[0, 1, 2], [0, 2, 3]])
    node = scene.add_node("wall", parts=[(mesh, scene.add_material(latelight.Material(double_sided=True)))])
    scene.add_animation(
        "move",
        [latelight.AnimationChannel(node=node, property="translation", times=[0, 10], values=[[8, 0, 0], [58, 0, 0]])],
    )


def test_slices_show_the_scene_at_the_times_of_their_middles(device):
    renderer = rendererOf(moving_wall, device)
    pattern = firings(np.tile(X, (7, 1)))
    pattern = dataclasses.replace(pattern, times=np.array([0.0, 0.04, 0.06, 0.09, 0.14, 1.23, -0.01]))

    def ranges(**options):
        return lidar.scan(renderer, pattern, POSE, seed=None, **options).range

    halves = np.array([0.025, 0.025, 0.075, 0.075, 0.125, 1.225, -0.025])  # also before and after the period of 0.1 s
    np.testing.assert_allclose(ranges(slices=2, time=2), 20 + 5 * (2 + halves), rtol=1e-6)
    np.testing.assert_allclose(ranges(slices=1, time=2), 30, rtol=1e-6)  # the whole scan shows one time
    for slices in (1, 2):  # at rest, and not at the beginning of the animation
        np.testing.assert_allclose(ranges(slices=slices), 12, rtol=1e-6)


# --- patterns -------------------------------------------------------------------------------------------------------


def elevations(pattern, lasers):
    return np.degrees(np.arcsin(pattern.directions[:lasers, 2]))


def test_elevations_are_those_of_the_manuals():
    vlp = [-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15]
    np.testing.assert_allclose(elevations(lidar.vlp16(), 16), vlp, atol=1e-9)
    hdl = [-30.67, -9.33, -29.33, -8, -28, -6.67, -26.67, -5.33, -25.33, -4, -24, -2.67, -22.67, -1.33, -21.33, 0,
           -20, 1.33, -18.67, 2.67, -17.33, 4, -16, 5.33, -14.67, 6.67, -13.33, 8, -12, 9.33, -10.67, 10.67]  # fmt: skip
    np.testing.assert_allclose(elevations(lidar.hdl32e(), 32), hdl, atol=0.005)
    s2 = np.sort(elevations(lidar.hdl64e(), 64))
    assert abs(s2[-1] - 2) < 1e-9 and abs(s2[0] + 24.33) < 1e-9
    np.testing.assert_allclose(np.diff(s2[-32:]), 1 / 3, atol=1e-9)
    np.testing.assert_allclose(np.diff(s2[:32]), 0.5, atol=1e-9)
    np.testing.assert_allclose(elevations(lidar.os1_64(), 64)[[0, 63]], [16.6, -16.6], atol=1e-9)
    np.testing.assert_allclose(elevations(lidar.os1_128(), 128)[[0, 127]], [22.5, -22.5], atol=1e-9)


def test_azimuths_of_ouster_are_those_of_its_sdk():
    """The SDK's design values of the first generation, beam_azimuth_angles, repeat these from the top. Its lookup table
    of points has x = cos(h) and y = -sin(h) with h = azimuth + 2 pi column / columns: positive is to the right."""
    for pattern, lasers in ((lidar.os1_64(), 64), (lidar.os1_128(), 128)):
        x, y, _ = pattern.directions[:lasers].T
        right = np.degrees(np.arctan2(-y, x))
        np.testing.assert_allclose(right, np.tile([3.164, 1.055, -1.055, -3.164], lasers // 4), atol=1e-9)


def test_rates_and_rings():
    rates = {"VLP-16": 289_000, "HDL-32E": 694_000, "HDL-64E S2": 1_333_000, "OS1-64": 655_360,
             "OS1-128": 1_310_720, "Livox Mid-40": 100_000}  # fmt: skip
    for name, pattern in lidar.patterns().items():
        assert abs(len(pattern) / pattern.period / rates[name] - 1) < 0.002, name
        assert np.allclose(np.linalg.norm(pattern.directions, axis=1), 1)
        assert (np.diff(pattern.times) >= 0).all() and 0 <= pattern.times[0] and pattern.times[-1] < pattern.period
        if name != "Livox Mid-40":
            lasers = len(set(pattern.rings))
            order = np.argsort(pattern.rings[:lasers])
            assert (np.diff(pattern.directions[:lasers][order, 2]) > 0).all()
    clockwise = lidar.vlp16().directions[16 * 400]  # after 22 ms of 100 ms: 80 degrees to the right
    assert np.degrees(np.arctan2(-clockwise[1], clockwise[0])) == pytest.approx(360 * 400 * 55.296e-6 / 0.1)


def test_the_rosette():
    pattern = lidar.livox_mid40(period=1.0)
    angles = np.degrees(np.arccos(pattern.directions[:, 0]))
    assert 19.1 < angles.max() <= 19.2 + 1e-9 and angles.min() < 0.2
    following = lidar.livox_mid40(period=0.5, start=0.5)
    np.testing.assert_allclose(following.directions, pattern.directions[50000:], atol=1e-9)
    repeated = np.linalg.norm(pattern.directions[10000:20000] - pattern.directions[:10000], axis=1)
    assert np.median(repeated) > 0.05  # the next tenth of a second does not repeat the first one


# --- files ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scanned():
    renderer = rendererOf(near_half_and_far, "cpu")
    return lidar.scan(renderer, lidar.vlp16(), lidar.sensor_pose((1, 2, 3), (1, 0, 0)), samples=4, returns="all")


def header_and_rows(path, end, types):
    text, _, data = path.read_bytes().partition(end)
    names = text.decode()
    return names, np.frombuffer(data, np.dtype(types))


TYPES = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("time", "<f8"), ("ring", "<u2"), ("range", "<f4"),
         ("echo", "u1"), ("firing", "<u4"), ("id", "<u4"), ("part", "<u4"), ("material", "<u4")]  # fmt: skip


def test_ply_pcd_kitti_and_npz(scanned, tmp_path):
    for name in ("a.ply", "a.pcd", "a.bin", "a.npz"):
        scanned.write(tmp_path / name)
    ply, vertices = header_and_rows(tmp_path / "a.ply", b"end_header\n", TYPES)
    assert f"element vertex {len(scanned)}\n" in ply and "property uint16 ring\n" in ply and "double time" in ply
    pcd, points = header_and_rows(tmp_path / "a.pcd", b"DATA binary\n", TYPES)
    assert "FIELDS x y z intensity time ring range echo firing id part material\n" in pcd
    assert "SIZE 4 4 4 4 8 2 4 1 4 4 4 4\n" in pcd and "TYPE F F F F F U F U U U U U\n" in pcd
    npz = np.load(tmp_path / "a.npz")
    assert set(npz) == {name for name, _ in TYPES}
    for rows in (vertices, points, npz):
        for axis, name in enumerate("xyz"):
            assert np.array_equal(rows[name], scanned.position[:, axis])
        for name, _ in TYPES[3:]:
            assert np.array_equal(rows[name], getattr(scanned, name)), name
    kitti = np.fromfile(tmp_path / "a.bin", np.float32).reshape(-1, 4)
    assert np.array_equal(kitti, np.column_stack([scanned.position, scanned.intensity]))
    scanned.write(tmp_path / "world.bin", frame="world")
    world = np.fromfile(tmp_path / "world.bin", np.float32).reshape(-1, 4)
    assert np.array_equal(world[:, :3], scanned.world_position.astype(np.float32))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.bin", "a.npz", "a.pcd", "a.ply", "world.bin"]


def test_open3d_reads_the_files(scanned, tmp_path):
    open3d = pytest.importorskip("open3d", reason="Open3D is not installed")
    for name in ("a.ply", "a.pcd"):
        scanned.write(tmp_path / name)
        read = open3d.io.read_point_cloud(str(tmp_path / name))
        assert np.array_equal(np.asarray(read.points, np.float32), scanned.position), name
        tensors = open3d.t.io.read_point_cloud(str(tmp_path / name)).point
        # Open3D skips unsigned integers of 32 bits in .ply files.
        whole = [field for field, kind in TYPES[3:] if name == "a.pcd" or kind != "<u4"]
        assert set(tensors) == {"positions", *whole}, name
        for field in whole:
            assert np.array_equal(tensors[field].numpy().ravel(), getattr(scanned, field)), (name, field)


@pytest.mark.parametrize("value, kind", [(None, "NoneType"), ("cpu", "str")])
def test_scans_need_a_renderer(value, kind):
    with pytest.raises(latelight.ArgumentTypeError, match=f"^renderer must be a Renderer, not {kind}$"):
        lidar.scan(value, firings([X]), POSE)


@pytest.mark.parametrize("value, kind", [(None, "NoneType"), ("1", "str")])
def test_arguments_that_are_no_numbers(renderer, value, kind):
    pattern = firings([X])
    calls = {
        "max_distance": lambda: lidar.scan(renderer, pattern, POSE, max_distance=value),
        "start": lambda: lidar.scan(renderer, pattern, POSE, start=value),
        "rate": lambda: lidar.vlp16(rate=value),
        "period": lambda: lidar.livox_mid40(period=value),
        "cycle": lambda: lidar.spinning("sensor", [0.0], value, 10),
        "min_range": lambda: dataclasses.replace(pattern, min_range=value),
        "max_range": lambda: dataclasses.replace(pattern, max_range=value),
        "divergence": lambda: dataclasses.replace(pattern, divergence=(0, value)),
    }
    for name, call in calls.items():
        with pytest.raises(latelight.ArgumentTypeError, match=f"^{name} must be a number, not {kind}$"):
            call()


def test_values_of_wrong_types_raise_type_errors(device):
    scan = lidar.scan(latelight.Renderer(latelight.Scene("builtin:boxes"), device), firings([X]), POSE)
    calls = {
        "name must be a text, not int": lambda: lidar.spinning(3, [0.0], 1e-4, 10),
        "columns must be a whole number, not str": lambda: lidar.spinning("sensor", [0.0], 1e-4, 10, columns="all"),
        "path must be a path, not int": lambda: scan.write(3),
    }
    for message, call in calls.items():
        with pytest.raises(latelight.ArgumentTypeError, match=f"^{message}$"):
            call()


def test_patterns_accept_lists():
    pattern = lidar.Pattern("lists", [[1, 0, 0], [0, 1, 0]], [0, 0.01], [3, 65535], 0.1)
    arrays = (pattern.directions, pattern.times, pattern.rings)
    assert [array.dtype for array in arrays] == ["float64", "float64", "uint16"]
    assert [array.tolist() for array in arrays] == [[[1, 0, 0], [0, 1, 0]], [0, 0.01], [3, 65535]]


def test_numbers_of_numpy_are_numbers():
    plain = lidar.spinning("sensor", [-1.0, 0.0, 1.0], 1e-3, 10, firing=1e-5, azimuths=2.0)
    numpy = lidar.spinning("sensor", np.arange(-1, 2), np.float64(1e-3), 10, np.float64(1e-5), np.array(2.0))
    for name in ("directions", "times", "rings"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(numpy, name))
    assert plain.times[:3].tolist() == [0, 1e-5, 2e-5]
    single = lidar.spinning("sensor", [0.0, 1.0], 1e-3, 10, firing=np.float32(0.25e-3))
    assert single.times[1] == np.float32(0.25e-3)


class WithProperty:
    """A matrix with a property "at" that is not a function, such as an array of JAX."""

    at = None

    def __array__(self, dtype=None, copy=None):
        return POSE


def test_poses_may_have_other_properties(renderer):
    pattern = firings([X])
    scans = [lidar.scan(renderer, pattern, pose, seed=None) for pose in (POSE, WithProperty())]
    assert np.array_equal(scans[0].position, scans[1].position)


@pytest.mark.parametrize("value, kind", [(None, "NoneType"), ("vlp-16", "str"), (4, "int")])
def test_arguments_of_other_classes(renderer, value, kind):
    with pytest.raises(latelight.ArgumentTypeError, match=f"^pattern must be a Pattern, not {kind}$"):
        lidar.scan(renderer, value, POSE)


@pytest.mark.parametrize(
    "value, kind", [(None, "NoneType"), ("abc", "str"), ([[1], [2, 3]], "list"), ([True] * 3, "bool")]
)
def test_arguments_that_are_no_arrays(renderer, value, kind):
    pattern, vector = firings([X]), (0, 0, 1)
    calls = {
        "pose": lambda: lidar.scan(renderer, pattern, value),
        "poses": lambda: lidar.Trajectory([0, 1], value),
        "times": lambda: lidar.Trajectory(value, [POSE, POSE]),
        "velocity": lambda: lidar.Motion(POSE, velocity=value),
        "angular_velocity": lambda: lidar.Motion(POSE, angular_velocity=value),
        "position": lambda: lidar.sensor_pose(value, vector),
        "forward": lambda: lidar.sensor_pose(vector, value),
        "up": lambda: lidar.sensor_pose(vector, vector, value),
        "directions": lambda: dataclasses.replace(pattern, directions=value),
        "elevations": lambda: lidar.spinning("sensor", value, 1e-3, 10),
        "firing": lambda: lidar.spinning("sensor", [0.0], 1e-3, 10, firing=value),
        "azimuths": lambda: lidar.spinning("sensor", [0.0], 1e-3, 10, azimuths=value),
    }
    for name, call in calls.items():
        with pytest.raises(latelight.ArgumentTypeError, match=f"^{name} must be an array of numbers, not {kind}$"):
            call()
    for call in (lidar.Motion(POSE).at, lidar.Trajectory([0, 1], [POSE, POSE]).at):
        with pytest.raises(latelight.ArgumentTypeError, match=f"^times must be an array of numbers, not {kind}$"):
            call(value)


def test_wrong_arguments(renderer, tmp_path, scanned):
    def refused(text, call):
        with pytest.raises(latelight.UsageError, match=text):
            call()

    pattern = firings([X])
    refused("rigid", lambda: lidar.scan(renderer, pattern, np.diag([2, 2, 2, 1])))
    refused("4x4", lambda: lidar.scan(renderer, pattern, np.eye(3)))
    refused("returns must be one of strongest", lambda: lidar.scan(renderer, pattern, POSE, returns="weakest"))
    for samples in (-1, 0, 1025, 2**70):
        text = f"samples must be a whole number from 1 to 1024, not {samples}$"
        refused(text, lambda: lidar.scan(renderer, pattern, POSE, samples=samples))
    for slices in (-1, 0, 100_001):
        text = f"slices must be a whole number from 1 to 100000, not {slices}$"
        refused(text, lambda: lidar.scan(renderer, pattern, POSE, slices=slices))
    refused("unit vectors", lambda: firings([[2, 0, 0]]))
    for ring in (-1, 65536, 70000, 2**63):
        text = f"each value of rings must be a whole number from 0 to 65535, not {ring}$"
        refused(text, lambda: dataclasses.replace(pattern, rings=np.array([ring])))
    refused("rings must be an array of whole numbers, not float64", lambda: dataclasses.replace(pattern, rings=[0.5]))
    refused(r"needs directions \(N, 3\), and times", lambda: dataclasses.replace(pattern, times=[0, 1]))
    for divergence in (0.1, (0.1,), (0.1, 0.1, 0.1), "12", None):
        refused("divergence must be 2 numbers", lambda: dataclasses.replace(pattern, divergence=divergence))
    refused("2 lasers needs as many azimuths", lambda: lidar.spinning("x", [0.0, 1.0], 1e-3, 10, azimuths=[1.0] * 3))
    for name, limit in (("ring", 65535), ("echo", 255), ("firing", 2**32 - 1)):
        wrong = dataclasses.replace(scanned, **{name: np.full(len(scanned), limit + 1)})
        text = f"each value of {name} must be a whole number from 0 to {limit}, not {limit + 1}$"
        refused(text, lambda: wrong.write(tmp_path / "a.ply"))
    refused("must increase", lambda: lidar.Trajectory([0, 0], [POSE, POSE]))
    refused("known from 0 to 0.01 s", lambda: lidar.scan(
        renderer, lidar.vlp16(), lidar.Trajectory([0, 0.01], [POSE, POSE])))  # fmt: skip
    refused("different directions", lambda: lidar.sensor_pose((0, 0, 0), (0, 1, 0)))
    for wrong in (math.nan, math.inf):
        vector = (0, 0, wrong)
        refused("position must be three finite numbers", lambda: lidar.sensor_pose(vector, (0, 0, -1)))
        refused("forward must be three finite numbers", lambda: lidar.sensor_pose((0, 0, 0), vector))
        refused("up must be three finite numbers", lambda: lidar.sensor_pose((0, 0, 0), (0, 0, -1), vector))
        refused(f"start must be a finite number.*not {wrong}$", lambda: lidar.scan(renderer, pattern, POSE, start=wrong))
        refused(f"start must be a finite number.*not {wrong}$", lambda: lidar.livox_mid40(0.1, wrong))
    refused('written as .ply, .pcd, .bin, .npz, not ".las"', lambda: scanned.write(tmp_path / "a.las"))
    refused("no extension: points are written as .ply, .pcd, .bin, .npz$", lambda: scanned.write(tmp_path / "a"))
    refused("No such file", lambda: scanned.write(tmp_path / "none" / "a.ply"))
    refused('"sensor" or "world"', lambda: scanned.write(tmp_path / "a.ply", frame="map"))
    refused("normals require normal_frame world", lambda: lidar.scan(renderer, pattern, POSE, normal_frame="opencv"))
    refused("no option", lambda: lidar.scan(renderer, pattern, POSE, sample=3))
    refused("animation and loop require time", lambda: lidar.scan(renderer, pattern, POSE, loop=True))
    refused("max_distance must be above 0 meters, not nan", lambda: lidar.scan(
        renderer, pattern, POSE, max_distance=math.nan))  # fmt: skip
    refused("max_distance must be above 0 meters, not -1", lambda: lidar.scan(renderer, pattern, POSE, max_distance=-1))
    assert list(tmp_path.iterdir()) == []


def test_a_scan_that_hits_nothing(device, tmp_path):
    renderer = rendererOf(lambda scene: wall(scene, 10.0), device)
    scan = lidar.scan(renderer, firings([-X, -X]), POSE, returns="dual")
    assert len(scan) == 0 and scan.position.shape == (0, 3)
    scan.write(tmp_path / "empty.pcd")
    assert b"POINTS 0\n" in (tmp_path / "empty.pcd").read_bytes()
