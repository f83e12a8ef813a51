"""Cameras, against projections computed here with NumPy."""

import copy
import json
import pickle

import numpy as np
import pytest

import latelight

SIZE = (64, 48)


def positions_match(renderer, camera, k, world_to_camera):
    """Each position that is rendered projects to the center of its pixel."""
    frame = renderer.render(camera, SIZE, ("position", "depth", "id"))
    rows, columns = np.nonzero(frame["id"])
    assert len(rows) > 50
    points = np.c_[frame["position"][rows, columns], np.ones(len(rows))] @ world_to_camera.T
    pixels = points[:, :3] @ np.asarray(k).T
    np.testing.assert_allclose(pixels[:, :2] / pixels[:, 2:], np.c_[columns, rows] + 0.5, atol=2e-3)
    np.testing.assert_allclose(points[:, 2], frame["depth"][rows, columns], rtol=1e-5)


def pose_looking_at_boxes():
    """OpenCV's frame, from (4, -5, 3) to the origin, with the scene's Z axis upward in the image."""
    eye = np.array([4.0, -5.0, 3.0])
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3] = np.c_[right, np.cross(forward, right), forward, eye]
    return pose


@pytest.mark.parametrize("principal", [(32, 24), (20.5, 30.25)])
def test_k_and_a_pose(renderer, principal):
    k = [[70, 0, principal[0]], [0, 70, principal[1]], [0, 0, 1]]
    pose = pose_looking_at_boxes()
    camera = latelight.Camera.from_k(k, pose, SIZE)
    positions_match(renderer, camera, k, np.linalg.inv(pose))
    np.testing.assert_allclose(camera.k(SIZE), k, rtol=1e-6)


def test_a_pose_in_opengls_frame(renderer):
    k = [[60, 0, 32], [0, 60, 24], [0, 0, 1]]
    pose = pose_looking_at_boxes()
    opengl = pose @ np.diag([1, -1, -1, 1])
    camera = latelight.Camera.from_k(k, opengl, SIZE, frame="opengl")
    np.testing.assert_allclose(camera.camera_to_world, pose, atol=1e-12)


def test_look_at(renderer):
    camera = latelight.Camera.look_at((4, -5, 3), (0, 0, 0), up=(0, 0, 1), vertical_fov=50)
    np.testing.assert_allclose(camera.camera_to_world, pose_looking_at_boxes(), atol=1e-12)
    positions_match(renderer, camera, camera.k(SIZE), np.linalg.inv(camera.camera_to_world))


def test_orthographic(renderer):
    camera = latelight.Camera(
        camera_to_world=pose_looking_at_boxes(), orthographic=True, half_height=3, near_clip=0.1, far_clip=100
    )
    frame = renderer.render(camera, SIZE, ("position", "id"))
    rows, columns = np.nonzero(frame["id"])
    world_to_camera = np.linalg.inv(camera.camera_to_world)
    points = np.c_[frame["position"][rows, columns], np.ones(len(rows))] @ world_to_camera.T
    pixels = np.c_[points[:, :2], np.ones(len(rows))] @ camera.k(SIZE).T
    np.testing.assert_allclose(pixels[:, :2], np.c_[columns, rows] + 0.5, atol=2e-3)


def test_focal_lengths_that_differ_are_kept_as_a_lens():
    k = [[70, 0, 30], [0, 60, 25], [0, 0, 1]]
    camera = latelight.Camera.from_k(k, np.eye(4), SIZE)
    assert (camera.lens.fx, camera.lens.fy, camera.lens.width) == (70, 60, 64)
    np.testing.assert_allclose(camera.k((128, 96)), [[140, 0, 60], [0, 120, 50], [0, 0, 1]])


def test_a_scenes_cameras():
    scene = latelight.Scene()
    scene.add_camera(latelight.Camera.look_at((0, 0, 3), (0, 0, 0)))
    assert len(scene.cameras) == 1
    np.testing.assert_allclose(scene.default_camera().camera_to_world[:3, 3], (0, 0, 3))


def test_a_scenes_cameras_have_their_own_exposure():
    scene = latelight.Scene()
    arm = scene.add_node("arm")
    for node in (None, arm):
        camera = latelight.Camera.look_at((0, 0, 3), (0, 0, 0))
        camera.exposure, camera.shutter, camera.readout = 2, 0.125, -0.25
        scene.add_camera(camera, node=node)
    scene.add_camera(latelight.Camera())

    def values(camera):
        return camera.exposure, camera.shutter, camera.readout

    own, none = (2, 0.125, -0.25), (None, None, None)
    assert [values(camera) for camera in scene.cameras] == [own, own, none]
    assert [values(camera) for camera in scene.cameras_at(1)] == [own, own, none]
    assert values(scene.default_camera()) == values(scene.default_camera(time=1)) == own
    scene.set_node_transform(arm, np.eye(4))
    assert values(scene.cameras[1]) == own
    for field in ("exposure", "shutter", "readout"):
        camera = latelight.Camera()
        setattr(camera, field, 1e9)
        with pytest.raises(latelight.UsageError, match=f"a camera's {field} must be from"):
            scene.add_camera(camera)
    assert len(scene.cameras) == 3


def k_of(model, **lens):
    return latelight.Camera(lens=latelight.Lens(model=model, **lens)).k(SIZE)


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: latelight.Camera.look_at((0, 0, 0), (0, 0, 0)), "eye and target"),
        (lambda: latelight.Camera.look_at((0, 0, 0), (0, 1, 0)), "up must not"),
        (lambda: latelight.Camera.look_at((0, 0), (0, 1, 0)), "eye must be an array of shape"),
        (lambda: latelight.Camera.from_k(np.eye(3), np.eye(4), (0, 3)), "size must"),
        (lambda: latelight.Camera.from_k(np.diag([1, -1, 1]), np.eye(4), SIZE), "focal lengths"),
        (lambda: latelight.Camera.from_k([[1, 2, 0], [0, 1, 0], [0, 0, 1]], np.eye(4), SIZE), "no skew"),
        (lambda: latelight.Camera.from_k(np.eye(3), np.eye(3), SIZE), "camera_to_world"),
        (lambda: latelight.Camera.from_k(np.eye(3), np.eye(4), SIZE, "blender"), "frame must be"),
        (lambda: latelight.Camera(vertical_fov="wide"), "vertical_fov must be a number"),
        (lambda: latelight.Camera(fov=40), 'Camera has no "fov"'),
        (lambda: latelight.Lens(model="wide"), "model must be one of pinhole"),
        (lambda: latelight.Lens(distortion=range(9)), "at most 8"),
        (lambda: k_of("equirectangular", width=64, height=32), "the model equirectangular has no matrix K$"),
        (lambda: k_of("cubemap"), "the model cubemap has no matrix K$"),
        (lambda: k_of("fisheye", fx=30, fy=30), "the model fisheye has no matrix K without the lens's width and height"),
    ],
)
def test_refused(make, words):
    with pytest.raises(latelight.UsageError, match=words):
        make()


def test_copies_and_pickles():
    camera = latelight.Camera.from_k([[70, 0, 30], [0, 60, 25], [0, 0, 1]], pose_looking_at_boxes(), SIZE)
    for copied in (copy.copy(camera), copy.deepcopy(camera), pickle.loads(pickle.dumps(camera))):
        assert repr(copied) == repr(camera)
        copied.name = "other"
        assert camera.name == ""


def test_a_scaled_pose_is_refused_when_it_is_rendered(renderer):
    camera = latelight.Camera(camera_to_world=np.diag([2, 2, 2, 1]))
    with pytest.raises(latelight.UsageError, match="rotation and a translation"):
        renderer.render(camera, SIZE)


@pytest.mark.parametrize("degrees", [1e-7, 179.999])
def test_the_limits_of_fields_of_view_are_accepted(renderer, degrees):
    camera = latelight.Camera.look_at((4, -5, 3), (0, 0, 0), up=(0, 0, 1), vertical_fov=degrees)
    assert renderer.render(camera, SIZE)["rgba"].shape == (48, 64, 4)


@pytest.mark.parametrize(
    "model, distortion, words",
    [
        ("pinhole", [0.5, 0.2], "the model pinhole has no distortion coefficients: number 1 must be 0, not 0.5"),
        ("fisheye", [0.1, 0, 0, 0, 0, 0.5], "the model fisheye has 4 distortion coefficients: number 6 must be 0"),
        ("ftheta", [0, 0.02, 0, 0, 0, 0, 7], "the model ftheta has 6 distortion coefficients: number 7 must be 0"),
        ("equirectangular", [1], "the model equirectangular has no distortion coefficients: number 1 must be 0"),
    ],
)
def test_surplus_distortion_coefficients_are_refused_when_they_are_rendered(renderer, model, distortion, words):
    lens = latelight.Lens(model=model, width=64, height=48, fx=30, fy=30, cx=32, cy=24, distortion=distortion)
    with pytest.raises(latelight.UsageError, match=words):
        renderer.render(latelight.Camera(lens=lens), SIZE)


def test_lenses_need_the_size_of_their_calibration(renderer):
    lens = latelight.Lens(model="opencv", width=0, height=48, fx=30, fy=30, cx=32, cy=24)
    with pytest.raises(latelight.UsageError, match="a lens of the model opencv needs the image size of its calibration"):
        renderer.render(latelight.Camera(lens=lens), SIZE)


@pytest.mark.parametrize(
    "near, far, words",
    [
        (0, 10, "a perspective camera's near and far planes must be above 0 meters, not 0 and 10"),
        (0.1, 0, "a perspective camera's near and far planes must be above 0 meters, not 0.1 and 0"),
        (5, 3, "near plane must be in front of its far plane, not at 5 and 3 meters"),
    ],
)
def test_clip_planes_that_are_refused(renderer, near, far, words):
    with pytest.raises(latelight.UsageError, match=words):
        renderer.render(latelight.Camera(near_clip=near, far_clip=far), SIZE)


def test_pictures_of_any_shape_show_the_whole_frame(renderer):
    camera = latelight.Camera.look_at((4, -5, 3), (0, 0, 0), up=(0, 0, 1), vertical_fov=50)
    camera.aspect = 2
    world_to_camera = np.linalg.inv(camera.camera_to_world)
    half = np.tan(np.radians(25))  # of the frame's height at 1 m
    for size, focal in {(64, 48): 32 / (2 * half), (96, 48): 24 / half, (144, 48): 24 / half}.items():
        np.testing.assert_allclose(camera.k(size)[0, 0], focal, rtol=1e-6)
        np.testing.assert_allclose(camera.k(size)[1, 1], focal, rtol=1e-6)
    positions_match(renderer, camera, camera.k(SIZE), world_to_camera)
    camera.aspect = None
    cropped = renderer.render(camera, SIZE, "depth")["depth"]
    np.testing.assert_allclose(camera.k(SIZE)[1, 1], 24 / half, rtol=1e-6)
    camera.aspect = 2
    np.testing.assert_array_equal(renderer.render(camera, SIZE, "depth", camera_fit="vertical")["depth"], cropped)
    assert (renderer.render(camera, SIZE, "depth")["depth"] != cropped).any()


def test_the_default_camera_follows_its_animation(tmp_path):
    """From x = 1 at 0 s to x = 11 at 10 s."""
    buffer = np.array([0, 10, 1, 0, 0, 11, 0, 0], np.float32).tobytes()
    (tmp_path / "moves.bin").write_bytes(buffer)
    times = {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [10]}
    target = {"node": 0, "path": "translation"}
    gltf = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"camera": 0, "translation": [5, 0, 0]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
        "buffers": [{"uri": "moves.bin", "byteLength": 32}],
        "bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 24}],
        "accessors": [times, {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}],
        "animations": [{"samplers": [{"input": 0, "output": 1}], "channels": [{"sampler": 0, "target": target}]}],
    }
    (tmp_path / "moves.gltf").write_text(json.dumps(gltf))
    scene = latelight.Scene(tmp_path / "moves.gltf")
    for time, loop, x in [(None, False, 5), (0, False, 1), (2.5, False, 3.5), (12, False, 11), (12, True, 3)]:
        camera = scene.default_camera(time=time, loop=loop)
        np.testing.assert_allclose(camera.camera_to_world[:3, 3], (x, 0, 0), atol=1e-6)
