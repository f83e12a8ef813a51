"""Cameras from USD, with their exposures."""

import numpy as np
import pytest

import latelight
from model_checks import Z_UP
from usd_stages import add_mesh


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
