"""Lights and dome lights from USD."""

import numpy as np
import pytest

import latelight
from model_checks import background


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
