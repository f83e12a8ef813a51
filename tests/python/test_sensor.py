"""Exposure, aperture, readout and sensor, against closed forms computed here."""

import latelight
import numpy as np
import pytest

SIZE = (48, 32)


@pytest.fixture
def half_plane(square, device):
    """A renderer of a white half plane, x <= 0 in the plane z = 0, and a camera that shows 2 m of it, high."""
    scene = latelight.Scene()
    white = scene.add_material(latelight.Material(base_color=(1, 1, 1, 1), unlit=True))
    corners = square["positions"] * 50 - np.array([50, 0, 0], np.float32)
    mesh = scene.add_mesh(corners, indices=square["indices"], normals=square["normals"])
    scene.add_instance(mesh, white)
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    camera.orthographic, camera.half_height = True, 1
    camera.near_clip, camera.far_clip = 0.1, 10
    return latelight.Renderer(scene, device, environment="none"), camera


def moved(camera, x):
    pose = camera.camera_to_world.copy()
    pose[0, 3] += x
    return latelight.Camera(
        camera_to_world=pose, orthographic=True, half_height=camera.half_height, near_clip=0.1, far_clip=10
    )


def test_exposure_and_readout(half_plane):
    renderer, camera = half_plane
    step = 8 * 2 / SIZE[1]  # 8 pixels per frame, to the left; so the plane moves to the right
    frames = {"previous_cameras": [moved(camera, step)], "next_cameras": [moved(camera, -step)]}
    frames["frames_per_second"] = 10
    x = np.arange(SIZE[0]) + 0.5 - SIZE[0] / 2
    blurred = renderer.render(camera, SIZE, "color", shutter=0.1, camera_samples=64, **frames)["color"]
    np.testing.assert_allclose(blurred[:, :, 0], np.tile(np.clip(0.5 - x / 8, 0, 1), (SIZE[1], 1)), atol=1.01 / 64)
    rows = ((np.arange(SIZE[1]) + 0.5) / SIZE[1] - 0.5)[:, None] * 8
    rolling = renderer.render(camera, SIZE, ("color", "id"), readout=0.1, **frames)
    away = np.abs(x - rows) > 0.01
    np.testing.assert_array_equal((rolling["color"][:, :, 0] == 1)[away], (x < rows)[away])
    np.testing.assert_array_equal((rolling["id"] != 0)[away], (x < rows)[away])
    arrays = renderer.render(camera, SIZE, ("color", "id"), readout=0.1, on_device=True, **frames)
    if arrays["id"].device == "cpu":
        np.testing.assert_array_equal(arrays["id"].numpy(), rolling["id"])
        np.testing.assert_array_equal(arrays["color"].numpy(), rolling["color"])
    short = renderer.render(
        [camera] * 2, SIZE, ("depth", "id"), readout=0.1, formats={"depth": "float16", "id": "uint16"},
        **{name: value * 2 if isinstance(value, list) else value for name, value in frames.items()},
    )  # fmt: skip
    whole = renderer.render(camera, SIZE, "depth", readout=0.1, **frames)["depth"]
    for each in short:
        np.testing.assert_array_equal(each["id"], np.minimum(rolling["id"], 65535))
        np.testing.assert_array_equal(each["depth"], whole.astype(np.float16))
    with pytest.raises(latelight.UsageError, match="channels first"):
        renderer.render(camera, SIZE, "color", readout=0.1, channels_first=True, **frames)


def test_cameras_have_apertures_of_their_own(boxes, renderer):
    camera = boxes.default_camera(SIZE[0] / SIZE[1])
    sharp = renderer.render(camera, SIZE, "color")["color"]
    camera.aperture, camera.focus_distance = "0.3", 2.5
    assert (camera.aperture, camera.focus_distance) == ("0.3", 2.5)
    blurred = renderer.render(camera, SIZE, "color", camera_samples=32)["color"]
    camera.aperture, camera.focus_distance = "", None
    by_options = renderer.render(camera, SIZE, "color", camera_samples=32, aperture="0.3", focus_distance=2.5)["color"]
    np.testing.assert_array_equal(blurred, by_options)
    gradients = [np.abs(np.diff(image[:, :, 1], axis=1)).max() for image in (sharp, blurred)]
    assert gradients[1] < 0.7 * gradients[0]
    camera.aperture = "wide"
    with pytest.raises(latelight.UsageError, match="aperture"):
        renderer.render(camera, SIZE, "color")


def test_raw_and_its_noise(boxes, renderer):
    cameras = [boxes.default_camera(SIZE[0] / SIZE[1]) for _ in range(3)]
    cameras[1].noise_seed = 1
    sensor = {"full_well": 1000, "read_noise": 4, "bit_depth": 10, "black_level": 60, "bayer": "grbg"}
    frames = renderer.render(cameras, SIZE, ("rgba", "color", "raw"), **sensor)
    raw = frames["raw"]
    assert raw.shape == (3, SIZE[1], SIZE[0]) and raw.dtype == np.float32
    np.testing.assert_array_equal(raw, np.round(raw))
    assert raw.min() >= 0 and raw.max() <= 1023
    np.testing.assert_array_equal(raw[0], raw[2])
    assert (raw[0] != raw[1]).mean() > 0.5
    clean = renderer.render(cameras[0], SIZE, ("color", "raw"), bit_depth=10, black_level=60)
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    channel = np.array([[0, 1], [1, 2]])[rows % 2, columns % 2]  # without bayer: rggb
    light = np.take_along_axis(clean["color"], channel[:, :, None], 2)[:, :, 0]
    np.testing.assert_allclose(clean["raw"], np.clip(np.round(60 + 963 * light), 0, 1023), atol=1)
    for form in ({"on_device": True}, {"formats": {"raw": "float16"}}, {"channels_first": True}):
        with pytest.raises(latelight.UsageError, match="neither arrays on the device, nor formats or channels first"):
            renderer.render(cameras, SIZE, "raw", **form)


def test_raw_has_the_light_of_the_background(half_plane):
    renderer, camera = half_plane
    linear = ((0x80 / 255 + 0.055) / 1.055) ** 2.4  # of sRGB
    for options in ({}, {"bayer": "rggb"}):
        frame = renderer.render(camera, SIZE, ("color", "raw"), background="#808080", **options)
        assert frame["raw"][0, -1] == round(4095 * linear)  # 12 bits
    transparent = renderer.render(camera, SIZE, ("color", "raw"), background="#808080")["color"]
    np.testing.assert_array_equal(transparent[0, -1], 0)


def test_cameras_have_stops_of_their_own(boxes, renderer):
    """The factors of a call's pictures are 2^EV, or with metered exposure its factor times 2^EV."""
    cameras = [boxes.default_camera(SIZE[0] / SIZE[1]) for _ in range(3)]
    plain = renderer.render(cameras[0], SIZE, "color")
    metered = renderer.render(cameras[0], SIZE, "color", exposure="auto")
    cameras[0].exposure, cameras[2].exposure = 2.0, -1.5
    assert (cameras[0].exposure, cameras[1].exposure) == (2.0, None)
    frames = renderer.render(cameras, SIZE, "color", exposure=1)
    for frame, stops in zip(frames, (2, 1, -1.5), strict=True):
        assert frame.exposure == pytest.approx(2**stops)
        np.testing.assert_allclose(frame["color"][..., :3], plain["color"][..., :3] * 2**stops, rtol=2e-3, atol=1e-6)
    for frame, stops in zip(renderer.render(cameras, SIZE, "color", exposure="auto"), (2, 0, -1.5), strict=True):
        assert frame.exposure == pytest.approx(metered.exposure * 2**stops, rel=1e-3)
    one = renderer.render(cameras[2], SIZE, "color", exposure=1)
    np.testing.assert_array_equal(one["color"], frames[2]["color"])
    cameras[0].exposure = 61
    with pytest.raises(latelight.UsageError, match="a camera's exposure must be from -60 to 60 EV, not 61"):
        renderer.render(cameras[0], SIZE)
    with pytest.raises(latelight.UsageError, match="the cameras of worlds have the exposure of the options"):
        renderer.render_worlds(1, cameras[2], SIZE)


def test_cameras_with_their_own_exposure(half_plane):
    """Each picture of a call equals that of a call with the camera's exposure as options."""
    renderer, camera = half_plane
    step = 8 * 2 / SIZE[1]
    options = {"camera_samples": 16, "frames_per_second": 10}
    neighbors = {"previous_cameras": [moved(camera, step)], "next_cameras": [moved(camera, -step)]}
    many = {name: cameras * 3 for name, cameras in neighbors.items()}
    outputs = ("color", "id")

    def exposed(**exposure):
        own = moved(camera, 0)
        for name, value in exposure.items():
            setattr(own, name, value)
        return own

    def alone(**exposure):
        return renderer.render(camera, SIZE, outputs, **options, **neighbors, **exposure)

    cases = [{"shutter": 0.1}, {"shutter": 0.05}, {}]
    for result in (
        renderer.render([exposed(**case) for case in cases], SIZE, outputs, **options, **many),
        renderer.render(
            [exposed(**({"shutter": 0.0} | case)) for case in cases], SIZE, outputs, shutter=0.2, **options, **many
        ),
    ):
        for case, frame in zip(cases, result, strict=True):
            expected = alone(**case)
            np.testing.assert_allclose(frame["color"], expected["color"], atol=1e-3)
            np.testing.assert_array_equal(frame["id"], expected["id"])
    rows = [{"readout": 0.1}, {"readout": -0.05}, {"readout": 0.0}]
    result = renderer.render([exposed(**case) for case in rows], SIZE, outputs, **options, **many)
    for case, frame in zip(rows, result, strict=True):
        expected = alone(**case)
        np.testing.assert_array_equal(frame["color"], expected["color"])
        np.testing.assert_array_equal(frame["id"], expected["id"])
    assert (result[0]["id"] != result[2]["id"]).any() and (result[1]["id"] != result[2]["id"]).any()
    with pytest.raises(latelight.UsageError, match="a camera's shutter must be from 0 to 10000 seconds, not -1"):
        renderer.render(exposed(shutter=-1.0), SIZE)
    with pytest.raises(latelight.UsageError, match="a camera's readout must be from -10000 to 10000 seconds, not 1e"):
        renderer.render(exposed(readout=1e20), SIZE)
    with pytest.raises(latelight.UsageError, match="worlds are rendered at an instant"):
        renderer.render_worlds(1, exposed(shutter=0.1), SIZE)
