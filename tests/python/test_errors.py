"""What is refused: by kind, in one sentence that names the argument; and nothing crashes the interpreter."""

import numpy as np
import pytest

import latelight
from latelight import lidar

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.fixture(scope="module")
def scene():
    return latelight.Scene()


def refused(words, call, kind=latelight.UsageError):
    with pytest.raises(kind, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


ERRORS = (
    latelight.UsageError,
    latelight.InputError,
    latelight.NoDeviceError,
    latelight.DeviceLostError,
    latelight.OutOfMemoryError,
)


def test_kinds():
    assert issubclass(latelight.UsageError, ValueError)
    assert issubclass(latelight.ArgumentTypeError, TypeError)
    assert [k.exit_code for k in ERRORS] == [2, 3, 4, 5, 7]
    assert issubclass(latelight.OutOfMemoryError, MemoryError)
    refused("nowhere.glb", lambda: latelight.Scene("nowhere.glb"), latelight.InputError)
    refused("no such", lambda: latelight.Renderer(latelight.Scene(), "no such"), latelight.NoDeviceError)


@pytest.mark.parametrize(
    "words, arguments",
    [
        (r"positions must be an array of shape \(N, 3\), not \(2, 2\)", dict(positions=np.zeros((2, 2)))),
        ("positions must be an array of numbers, not complex128", dict(positions=np.zeros((3, 3), complex))),
        ("positions must be an array", dict(positions=[[1, 2], [3]])),
        ("positions must be an array of shape", dict(positions=None)),
        ("positions must hold finite numbers, not nan", dict(positions=np.full((3, 3), np.nan))),
        ("positions must hold finite numbers, not inf", dict(positions=np.full((3, 3), np.inf))),
        ("2 positions and no indices, which is not a multiple of three", dict(positions=TRIANGLE[:2])),
        ("indices must be an array of whole numbers, not float64", dict(positions=TRIANGLE, indices=[[0.0, 1, 2]])),
        ("indices must lie from 0 to 2.*one is 3", dict(positions=TRIANGLE, indices=[[0, 1, 3]])),
        ("indices must lie from 0 to 2.*one is -1", dict(positions=TRIANGLE, indices=[[0, 1, -1]])),
        (r"indices must be an array of shape \(N, 3\)", dict(positions=TRIANGLE, indices=[0, 1, 2])),
        ("normals must have a row for each of the 3", dict(positions=TRIANGLE, normals=[[0, 0, 1]])),
        ("uv must be an array of shape", dict(positions=TRIANGLE, uv=TRIANGLE)),
        ("colors must hold finite", dict(positions=TRIANGLE, colors=np.full((3, 4), np.inf))),
        ("name must be a text", dict(positions=TRIANGLE, name=3)),
    ],
)
def test_meshes(scene, words, arguments):
    refused(words, lambda: scene.add_mesh(**arguments))
    assert scene.meshes() == []


@pytest.mark.parametrize(
    "words, pixels",
    [
        ("pixels must be an array of uint8, not float64", np.zeros((2, 2, 3))),
        ("pixels must be an array of uint8", np.zeros((2, 2, 3), np.uint16)),
        (r"pixels must be an array of shape \(H, W, C\), not \(2, 2\)", np.zeros((2, 2), np.uint8)),
        ("pixels must have 1 to 4 channels, not 5", np.zeros((2, 2, 5), np.uint8)),
        ("pixels must not be empty", np.zeros((0, 2, 3), np.uint8)),
        ("20000x1 pixels; width and height are limited to 16384", np.zeros((1, 20000, 1), np.uint8)),
    ],
)
def test_textures(scene, words, pixels):
    refused(words, lambda: scene.add_texture(pixels))
    assert scene.textures() == []


def test_arrays_need_not_be_contiguous():
    wide = np.zeros((3, 6))
    wide[:, ::2] = TRIANGLE
    other = latelight.Scene()
    read = other.mesh_arrays(other.add_mesh(wide[:, ::2]))["positions"]
    np.testing.assert_array_equal(read, np.float32(TRIANGLE))


def test_elements(scene):
    material = latelight.Material()
    refused("roughness must be a number, not str", lambda: setattr(material, "roughness", "rough"))
    refused(r"base_color must be an array of shape \(4,\), not \(3,\)", lambda: setattr(material, "base_color", (1, 1, 1)))
    refused('Material has no "colour"', lambda: latelight.Material(colour=1))
    refused("roughness", lambda: scene.add_material(latelight.Material(roughness=2)))
    refused("values must be a Material, not dict", lambda: scene.add_material({}))
    refused("alpha_mode must be opaque, mask or blend", lambda: latelight.Material(alpha_mode="glass"))
    refused('unknown type "sun"', lambda: scene.add_light(latelight.Light(type="sun")))
    refused("cast_shadow must be True or False", lambda: latelight.Light(cast_shadow=1))
    refused("mesh must be the handle of mesh, not int", lambda: scene.add_instance(1, 2))
    refused('no node "/no"', lambda: scene.instances("/no"))
    handle = scene.add_material(material)
    refused("slot must be one of base_color", lambda: scene.set_texture(handle, "bump", None))
    refused("texture must be the handle of texture", lambda: scene.set_texture(handle, "normal", 3))


def test_arguments_of_other_calls(renderer, boxes):
    camera, origins, directions = boxes.default_camera(), [[0, 0, 0]], [[1, 0, 0]]
    pixels = [[0, 0]]
    refused('"size" does not apply to this call: omit it', lambda: renderer.cast(origins, directions, size=3))
    refused('no option "sizes"$', lambda: renderer.cast(origins, directions, sizes=3))
    refused('no option "sizes": do you mean "size"', lambda: renderer.render(camera, sizes=3))
    refused('"outputs" does not apply', lambda: renderer.pick(camera, pixels, (8, 8), outputs="id"))
    refused('"on_device" does not apply', lambda: renderer.labels(camera, (8, 8), on_device=True))
    refused('"max_distance" does not apply', lambda: renderer.render(camera, (8, 8), max_distance=3))
    refused('"transforms" does not apply', lambda: renderer.render(camera, (8, 8), transforms=np.eye(4)))
    with pytest.raises(latelight.UsageError, match='"outputs" does not apply to this call'):
        lidar.scan(renderer, lidar.vlp16(), np.eye(4), outputs=("distance",))


def test_limits_of_rays(renderer):
    rays, rays_of_worlds = ([[0, 5, 0]], [[0, -1, 0]]), ([[[0, 5, 0]]], [[[0, -1, 0]]])
    for value, kind in ((None, "NoneType"), ("1", "str")):
        words = f"^max_distance must be a number, not {kind}$"
        for call in (renderer.cast, renderer.submit_cast):
            refused(words, lambda: call(*rays, max_distance=value), latelight.ArgumentTypeError)
        for call in (renderer.cast_worlds, renderer.submit_cast_worlds):
            refused(words, lambda: call(1, *rays_of_worlds, max_distance=value), latelight.ArgumentTypeError)


def test_options(renderer, boxes):
    camera = boxes.default_camera()
    size = (8, 8)
    refused('no option "exposre": do you mean "exposure"', lambda: renderer.render(camera, size, exposre=1))
    refused("exposure takes a number from -60 to 60 EV", lambda: renderer.render(camera, size, exposure=100))
    refused("exposure takes a number from -60 to 60 EV, auto", lambda: renderer.render(camera, size, exposure="bright"))
    refused("bloom must be a number, not str", lambda: renderer.render(camera, size, bloom="1"))
    refused("environment_rotation", lambda: renderer.render(camera, size, environment_rotation=float("nan")))
    refused("loop must be True or False, not int", lambda: renderer.render(camera, size, loop=1))
    refused("^animation and loop require time$", lambda: renderer.render(camera, size, loop=True))
    refused("^animation and loop require time$", lambda: renderer.render(camera, size, animation="Foo"))
    refused("^animation and loop require time$", lambda: renderer.cast([[0, 5, 0]], [[0, -1, 0]], animation="Foo"))
    refused("tonemap takes one of these", lambda: renderer.render(camera, size, tonemap="film"))
    refused("anisotropy must be a whole number", lambda: renderer.render(camera, size, anisotropy=1.5))
    refused("anisotropy takes a whole number from 1 to 16", lambda: renderer.render(camera, size, anisotropy=99))
    refused("sun takes azimuth and elevation", lambda: renderer.render(camera, size, sun=(1,)))
    refused('outputs takes no "dpth"', lambda: renderer.render(camera, size, "dpth"))
    refused("outputs must name something", lambda: renderer.render(camera, size, ()))
    refused("outputs must be a text", lambda: renderer.render(camera, size, [1]))
    refused("the width of size", lambda: renderer.render(camera, (0, 8)))
    refused("size must be a width and a height", lambda: renderer.render(camera, 8))
    refused("cameras must be a Camera or a list", lambda: renderer.render(3, size))
    refused("each of cameras must be a Camera, not int", lambda: renderer.render([camera, 1], size))
    refused("cameras must have at least one", lambda: renderer.render([], size))
    refused("continues must be True or False", lambda: renderer.render(camera, size, continues=None))
    refused("pixels must lie in the picture of 8x8", lambda: renderer.pick(camera, [[8, 0]], size))
    refused("pixels must be an array of whole numbers", lambda: renderer.pick(camera, [[0.5, 0]], size))
    refused("environment must be an array of shape", lambda: latelight.Renderer(boxes, "cpu", np.zeros(3)))
    refused("twice as wide", lambda: latelight.Renderer(boxes, "cpu", np.zeros((4, 4, 3))))
    refused("scene must be a Scene, not str", lambda: latelight.Renderer("builtin:boxes"))
    refused("device must be a text", lambda: latelight.Renderer(boxes, 1.5))
