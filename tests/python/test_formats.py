"""Formats of results: the values of the usual ones, in fewer bits or another order, on the host and on the device."""

import io

import latelight
import numpy as np
import pytest

SIZE = (21, 13)  # an odd number of bytes per image, so that images share words of memory
OUTPUTS = ("rgba", "depth", "normal", "id", "color")
SHORTER = {"rgba": "rgb8", "depth": "float16", "normal": "float16", "id": "uint16", "color": "float16"}


@pytest.fixture(scope="module")
def made():
    scene = latelight.Scene("builtin:boxes")
    return latelight.Renderer(scene, device="cpu"), [scene.default_camera(), scene.look_at((3, 2, 4), (0, 0, 0))]


def shortened(name, values):
    if name == "rgba":
        return values[..., :3]
    if values.dtype == np.uint32:
        return np.minimum(values, 65535).astype(np.uint16)
    with np.errstate(over="ignore"):
        return values.astype(np.float16)  # rounds to nearest even


def channels_first(values, rank):
    return np.moveaxis(values, -1, rank - 3) if values.ndim == rank else values


def render(made, worlds, **options):
    renderer, cameras = made
    if not worlds:
        return renderer.render(cameras, SIZE, OUTPUTS, **options)
    poses = np.stack([[camera.camera_to_world for camera in cameras]] * 3)
    poses[:, :, 0, 3] += np.linspace(0, 1, 3)[:, None]
    return renderer.render_worlds(3, cameras, SIZE, OUTPUTS, camera_to_world=poses, **options)


@pytest.mark.parametrize("worlds", [False, True])
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_formats_hold_the_usual_values(made, worlds, first, raster):
    usual = render(made, worlds, raster=raster)
    rank = 5 if worlds else 4
    for formats in ({}, SHORTER):
        options = {"formats": formats, "channels_first": first, "raster": raster}
        here, there = render(made, worlds, **options), render(made, worlds, **options, on_device=True)
        for name in OUTPUTS:
            expected = shortened(name, usual[name]) if formats else usual[name]
            expected = channels_first(expected, rank) if first else expected
            for array in (here[name], there[name].numpy()):
                assert array.dtype == expected.dtype and array.shape == expected.shape, name
                np.testing.assert_array_equal(array, expected, name)


def test_frames_have_their_parts(made):
    frames = render(made, True, formats=SHORTER)
    usual = render(made, True)
    np.testing.assert_array_equal(frames[2][1]["rgba"], usual[2][1]["rgba"][..., :3])
    assert frames[0][0].png() == usual[0][0].png()
    one = made[0].render(made[1][0], SIZE, formats={"rgba": "rgb8"}, channels_first=True)
    assert one["rgba"].shape == (3, SIZE[1], SIZE[0]) and one.png() == usual[0][0].png()


@pytest.mark.parametrize("size", [(3, 8), (4, 8), (4, 4), (3, 3), (8, 3)])
@pytest.mark.parametrize("formats", [{}, {"rgba": "rgb8"}])
def test_png_has_the_picture_in_each_order_of_axes(made, size, formats):
    """Widths and heights of 3 and 4 look like numbers of channels."""
    image = pytest.importorskip("PIL.Image")
    renderer, (camera, other) = made
    options = {"formats": formats, "channels_first": True}
    one = renderer.render(camera, size, "rgba", background="#ff8000", **options)
    frames = renderer.render([other, camera], size, "rgba", background="#ff8000", **options)
    worlds = renderer.render_worlds(1, camera, size, "rgba", background="#ff8000", **options)
    for frame in (one, frames[1], frames[1:][0], worlds[0][0]):
        pixels = np.asarray(image.open(io.BytesIO(frame.png())).convert("RGBA"))
        expected = np.moveaxis(frame["rgba"], 0, 2)
        assert pixels.shape == (size[1], size[0], 4)
        np.testing.assert_array_equal(pixels[..., : expected.shape[2]], expected)
        assert formats == {} or (pixels[..., 3] == 255).all()


def test_half_floats_are_rounded_to_nearest_even():
    """Depths of a plane that faces the camera: each is one number. Beyond 65504, the largest half, only the background
    is infinite."""
    scene = latelight.Scene()
    square = scene.add_mesh(np.float32([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]), [[0, 1, 2], [0, 2, 3]])
    plane = scene.add_instance(square, scene.add_material(latelight.Material()))
    renderer = latelight.Renderer(scene, device="cpu")
    camera = latelight.Camera.look_at((0, 0, 0), (0, 0, -1), vertical_fov=10)
    distances = np.concatenate([np.linspace(0.2, 3, 40), [2049, 2051, 65519, 65521, 2e5, 1e-1]])
    transforms = np.tile(np.eye(4), (len(distances), 1, 1, 1))
    transforms[:, 0, 2, 3] = -distances
    transforms[:, 0, 0, 0] = transforms[:, 0, 1, 1] = 1 + distances
    given = {"instances": [plane], "transforms": transforms}
    exact = renderer.render_worlds(len(distances), camera, (2, 2), "depth", **given)["depth"]
    half = renderer.render_worlds(len(distances), camera, (2, 2), "depth", **given, formats={"depth": "float16"})
    np.testing.assert_array_equal(half["depth"], np.minimum(exact, 65504).astype(np.float16))
    np.testing.assert_allclose(exact[:, 0, 0, 0], distances, rtol=1e-5)
    away = latelight.Camera.look_at((0, 0, 0), (0, 0, 1))
    for seen, low, high in ((camera, -65504, 65504), (away, 0, np.inf)):
        frame = renderer.render_worlds(
            1, seen, (2, 2), ("depth", "distance", "position"), instances=[plane], transforms=transforms[-2:-1],
            formats={"depth": "float16", "distance": "float16", "position": "float16"},
        )
        assert (frame["depth"] == high).all() and (frame["distance"] == high).all()
        assert (frame["position"][..., 2] == low).all()


def test_out_is_rendered_into_again(made):
    options = {"formats": SHORTER, "on_device": True}
    first = render(made, True, **options)
    addresses = {name: first[name].numpy().ctypes.data for name in OUTPUTS}
    kept = first["rgba"].numpy().copy()
    first["rgba"].numpy()[:] = 0
    again = render(made, True, **options, out=first)
    for name in OUTPUTS:
        assert again[name].numpy().ctypes.data == addresses[name]
    np.testing.assert_array_equal(first["rgba"].numpy(), kept)


@pytest.mark.parametrize(
    ("options", "error", "sentence"),
    [
        ({"formats": {"rgba": "rgb9"}}, latelight.UsageError, 'the format of rgba must be rgba8 or rgb8, not "rgb9"'),
        ({"formats": {"depth": "uint16"}}, latelight.UsageError, "depth must be float32 or float16"),
        ({"formats": {"flow": "float16"}}, latelight.UsageError, 'formats has "flow", which is not one of'),
        ({"formats": "rgb8"}, latelight.ArgumentTypeError, "formats must map outputs to formats, not str"),
        ({"channels_first": 1}, latelight.ArgumentTypeError, "channels_first must be True or False"),
        ({"out": 3, "on_device": True}, latelight.ArgumentTypeError, "out must be what a call with on_device"),
        ({"out": {"rgba": 3}, "on_device": True}, latelight.ArgumentTypeError, "must be a DeviceArray, not int"),
    ],
)
def test_wrong_formats_are_refused(made, options, error, sentence):
    with pytest.raises(error, match=sentence):
        render(made, False, **options)


def test_out_must_fit(made):
    renderer, cameras = made
    small = renderer.render(cameras[0], (4, 4), on_device=True)
    with pytest.raises(latelight.UsageError, match="smaller than the output"):
        renderer.render(cameras[0], (400, 400), on_device=True, out=small)
    with pytest.raises(latelight.UsageError, match="out requires on_device=True"):
        renderer.render(cameras[0], (4, 4), out=small)


def test_out_must_be_the_renderers_own(made):
    renderer, cameras = made
    arrays = renderer.render(cameras[0], SIZE, "depth", on_device=True)
    before = arrays["depth"].numpy().copy()
    other = latelight.Renderer(latelight.Scene("builtin:spheres"), device="cpu")
    sentence = "the array to render depth into belongs to another renderer"
    with pytest.raises(latelight.UsageError, match=sentence):
        other.render(cameras[0], SIZE, "depth", on_device=True, out=arrays)
    with pytest.raises(latelight.UsageError, match=sentence):
        other.render_worlds(1, cameras[0], SIZE, "depth", on_device=True, out=arrays)
    np.testing.assert_array_equal(arrays["depth"].numpy(), before)
    hits = renderer.cast([[0, 0, 9]], [[0, 0, -1]], outputs="id", on_device=True)
    with pytest.raises(latelight.UsageError, match="the array to store id in belongs to another renderer"):
        other.cast([[0, 0, 9]], [[0, 0, -1]], on_device=True, out=hits)


def test_each_output_needs_its_own_array(made):
    renderer, cameras = made
    depth = renderer.render(cameras[0], SIZE, "depth", on_device=True)["depth"]
    sentence = "depth and distance have the same array: use one array per output"
    with pytest.raises(latelight.UsageError, match=sentence):
        renderer.render(
            cameras[0], SIZE, ("depth", "distance"), on_device=True, out={"depth": depth, "distance": depth}
        )
    rays = np.zeros((5, 3)), np.ones((5, 3))
    distance = renderer.cast(*rays, outputs="distance", on_device=True)["distance"]
    with pytest.raises(latelight.UsageError, match="distance and intensity have the same array"):
        renderer.cast(*rays, on_device=True, out={"distance": distance, "intensity": distance})
    memory = np.empty(9, np.float32)
    with pytest.raises(latelight.UsageError, match="distance and intensity overlap: use one array per output"):
        renderer.cast(*rays, out={"distance": memory[:5], "intensity": memory[4:]})
    renderer.cast(*rays, out={"distance": memory[:5], "id": np.empty(5, np.uint32)})
