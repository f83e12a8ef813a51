"""Arguments: integers are what glTF makes of them, or are refused by name; and an argument's own exceptions pass."""

import copy
import decimal
import gc
import json
import pickle
import struct
import weakref

import numpy as np
import pytest

import latelight

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
FACES = [[0, 1, 2], [0, 2, 3]]
FRONT = latelight.Camera.look_at((0, 0, 2), (0, 0, 0), vertical_fov=np.degrees(2 * np.arctan(0.5)))


def arrays_of(**arguments):
    scene = latelight.Scene()
    arguments.setdefault("normals", np.tile(np.float32([0, 0, 1]), (4, 1)))  # or triangles share no vertices
    return scene.mesh_arrays(scene.add_mesh(**{"positions": SQUARE, "indices": FACES, **arguments}))


def refused(words, call, kind=latelight.UsageError):
    with pytest.raises(kind, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


# --- integers -------------------------------------------------------------------------------------------------------


def test_colors_of_uint8_show_as_their_share_of_255(device):
    scene = latelight.Scene()
    paint = scene.add_material(latelight.Material(metallic=0, roughness=1))
    colors = np.tile(np.array([[200, 100, 50, 255]], np.uint8), (4, 1))
    scene.add_instance(scene.add_mesh(SQUARE, FACES, colors=colors), paint)
    albedo = latelight.Renderer(scene, device).render(FRONT, (8, 8), "albedo")["albedo"]
    np.testing.assert_allclose(albedo[4, 4], np.array([200, 100, 50]) / 255, atol=2e-3)


@pytest.mark.parametrize(
    "name, dtype, given, stored",
    [
        ("colors", np.uint8, [0, 51, 255, 255], [0, 0.2, 1, 1]),
        ("colors", np.uint16, [0, 13107, 65535, 65535], [0, 0.2, 1, 1]),
        ("colors", ">u2", [0, 13107, 65535, 65535], [0, 0.2, 1, 1]),
        ("colors", np.int64, [0, 1, 1, 1], [0, 1, 1, 1]),
        ("colors", np.float64, [0, 0.5, 1, 1], [0, 0.5, 1, 1]),
        ("uv", np.uint8, [51, 255], [0.2, 1]),
        ("uv", np.uint16, [13107, 65535], [0.2, 1]),
        ("uv", np.int32, [3, -2], [3, -2]),
        ("uv1", np.uint8, [51, 255], [0.2, 1]),
        ("normals", np.int8, [0, -128, 0], [0, -1, 0]),
        ("normals", np.int16, [0, 0, 32767], [0, 0, 1]),
        ("normals", np.int64, [0, 0, 1], [0, 0, 1]),
        ("tangents", np.int8, [127, 0, 0, -127], [1, 0, 0, -1]),
    ],
)
def test_integers_are_normalized_as_in_gltf(name, dtype, given, stored):
    with_uv = {"uv": np.zeros((4, 2), np.float32)} if name == "tangents" else {}
    read = arrays_of(**with_uv, **{name: np.tile(np.array([given]).astype(dtype), (4, 1))})[name]
    np.testing.assert_allclose(read, np.tile(np.float32([stored]), (4, 1)), rtol=1e-6)


@pytest.mark.parametrize(
    "words, arguments",
    [
        ("colors must lie from 0 to 1.*one is 200", dict(colors=np.full((4, 4), 200.0))),
        ("colors must lie from 0 to 1.*one is 200", dict(colors=np.full((4, 4), 200))),
        ("colors must lie from 0 to 1.*one is -0.5", dict(colors=np.full((4, 4), -0.5))),
        ("colors must be an array of floats, uint8 or uint16, not int8", dict(colors=np.zeros((4, 4), np.int8))),
        ("colors must be an array of numbers, not bool", dict(colors=np.zeros((4, 4), bool))),
        (r"colors must be an array of shape \(N, 4\), not \(4, 3\)", dict(colors=np.zeros((4, 3), np.uint8))),
        ("uv must be an array of floats, uint8 or uint16, not int16", dict(uv=np.zeros((4, 2), np.int16))),
        ("uv must be an array of numbers, not bool", dict(uv=np.zeros((4, 2), bool))),
        ("normals must be an array of floats, int8 or int16, not uint8", dict(normals=np.zeros((4, 3), np.uint8))),
        ("tangents must be an array of floats, int8 or int16, not uint16", dict(tangents=np.zeros((4, 4), np.uint16))),
        ("uv has a number that is too large: 1e\\+300", dict(uv=np.full((4, 2), 1e300))),
        ("uv has masked values", dict(uv=np.ma.masked_greater(np.arange(8.0).reshape(4, 2), 6))),
        ("uv has masked values", dict(uv=[np.ma.masked_greater(np.arange(2.0), 0)] * 4)),
        ("uv must be an array of numbers, not object", dict(uv=np.zeros((4, 2), object))),
    ],
)
def test_other_arrays_are_refused_by_name(words, arguments):
    refused(words, lambda: arrays_of(**arguments))


def test_indices():
    scene = latelight.Scene()
    for wrong in (np.zeros((1, 3)), np.zeros((1, 3), bool), np.array([["0", "1", "2"]])):
        refused("indices must be an array of whole numbers", lambda: scene.add_mesh(SQUARE, wrong))
    refused("one is -1", lambda: scene.add_mesh(SQUARE, np.array([[0, 1, -1]], np.int8)))
    refused("indices must lie from 0 to 3", lambda: scene.add_mesh(SQUARE, np.array([[0, 1, 1 << 63]], np.uint64)))
    refused("indices has masked", lambda: scene.add_mesh(SQUARE, np.ma.masked_equal([[0, 1, 2]], 2)))
    for right in (np.array([[0, 1, 2]], ">i2"), np.array([[0, 1, 2]], np.uint8), np.array([[0, 9, 1, 9, 2]])[:, ::2]):
        np.testing.assert_array_equal(scene.mesh_arrays(scene.add_mesh(SQUARE, right))["indices"], [[0, 1, 2]])


def test_environments_are_floats(boxes):
    for dtype in (np.uint8, np.uint16, int, bool):
        refused(
            "environment must be an array of floats, not", lambda: latelight.Renderer(boxes, "cpu", np.ones((2, 4, 3), dtype))
        )
    masked = np.ma.masked_greater(np.ones((2, 4, 3)), 0)
    refused("environment has masked values", lambda: latelight.Renderer(boxes, "cpu", masked))


def test_textures_are_uint8(boxes):
    scene = latelight.Scene()
    for dtype in (np.uint16, np.int8, bool, float):
        refused("pixels must be an array of uint8, not", lambda: scene.add_texture(np.zeros((2, 2, 3), dtype)))
    refused("pixels has masked", lambda: scene.add_texture(np.ma.masked_equal(np.zeros((2, 2, 3), np.uint8), 0)))
    whole = np.arange(2 * 6 * 3, dtype=np.uint8).reshape(2, 6, 3)
    read = scene.texture_pixels(scene.add_texture(whole[::-1, ::2]))
    np.testing.assert_array_equal(read[..., :3], whole[::-1, ::2])


def test_an_array_without_masked_values_is_taken():
    filled = np.ma.masked_greater(np.zeros((4, 2)), 5)
    np.testing.assert_array_equal(np.zeros((4, 2)), arrays_of(uv=filled).get("uv", np.zeros((4, 2))))


@pytest.mark.parametrize("dtype", [np.float64, ">f4", ">f8", np.float16, np.longdouble, np.int8])
def test_positions_of_any_type_and_strides(dtype):
    wide = np.zeros((8, 6), dtype)
    wide[::2, ::2] = SQUARE
    np.testing.assert_array_equal(arrays_of(positions=wide[::2, ::2])["positions"], SQUARE)


def test_vectors_have_their_length():
    for value in ((1, 2), (1, 2, 3, 4), [[1, 2, 3]], 5, np.zeros(0)):
        refused(r"position must be an array of shape \(3,\)", lambda: latelight.Light(position=value))
    refused("base_color must be", lambda: latelight.Material(base_color=(1, 1, 1)))
    refused("eye must be", lambda: latelight.Camera.look_at((0, 0, 1, 1), (0, 0, 0)))
    refused(r"k must be an array of shape \(3, 3\)", lambda: latelight.Camera.from_k(np.eye(4), np.eye(4), (8, 8)))
    refused("size must be", lambda: latelight.Camera.from_k(np.eye(3), np.eye(4), (8, 8, 8)))
    scene = latelight.Scene("builtin:boxes")
    for wrong in (np.eye(3), np.ones((3, 4)), np.ones(16), np.eye(4, dtype=bool)):
        refused("transform must be", lambda: scene.set_transform(scene.instances()[0], wrong))
    masked = np.ma.masked_equal(np.eye(4), 1)
    refused("transform has masked", lambda: scene.set_transform(scene.instances()[0], masked))


@pytest.mark.parametrize(
    "value", [np.True_, np.complex64(1), 1j, "1", None, [1], np.ones(1), np.datetime64("2020-01-01"), b"1", 1 << 2000]
)
def test_what_is_no_number(value):
    refused("roughness", lambda: latelight.Material(roughness=value))


def test_numbers_of_other_types():
    for value in (np.float32(0.5), np.array(0.5), decimal.Decimal("0.5"), np.float16(0.5)):
        assert latelight.Material(roughness=value).roughness == 0.5
    assert latelight.Material(metallic=np.uint8(1)).metallic == 1
    refused("roughness has masked", lambda: latelight.Material(roughness=np.ma.masked))


def test_paths_without_null_characters():
    refused("source must be a path, which has no null", lambda: latelight.Scene("builtin:boxes\0.glb"))
    refused("allow_outside must be a path", lambda: latelight.Scene("builtin:boxes", allow_outside=["/tmp\0"]))
    refused("source must be a path, not bytes", lambda: latelight.Scene(b"builtin:boxes"))


def test_a_files_colors_are_clamped(tmp_path):
    """glTF 2.0, section 3.7.2.1: all components of COLOR_0 are clamped to [0, 1]."""
    positions = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]).tobytes()
    colors = np.float32([[2, -1, 0.5, 1]] * 3).tobytes()
    (tmp_path / "data.bin").write_bytes(positions + colors)
    file = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "data.bin", "byteLength": len(positions + colors)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(colors)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC4"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    (tmp_path / "colors.gltf").write_text(json.dumps(file))
    scene = latelight.Scene(tmp_path / "colors.gltf")
    arrays = scene.mesh_arrays(scene.meshes()[0])
    np.testing.assert_array_equal(arrays["colors"], [[1, 0, 0.5, 1]] * 3)
    scene.set_mesh(scene.meshes()[0], **arrays)  # what is read can be set


# --- exceptions of an argument's own code ---------------------------------------------------------------------------


class Raises:
    """Each of its conversions raises the exception."""

    def __init__(self, error):
        self.error = error

    def fail(self, *_, **__):
        raise self.error

    __float__ = __index__ = __fspath__ = __iter__ = __array__ = fail


ERRORS = [TypeError("mine"), ValueError("mine"), OverflowError("mine"), KeyboardInterrupt(), MemoryError(), ZeroDivisionError()]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
@pytest.mark.parametrize(
    "call",
    [
        lambda value, scene, renderer: latelight.Material(roughness=value),
        lambda value, scene, renderer: latelight.Light(position=value),
        lambda value, scene, renderer: latelight.Light(size=value),
        lambda value, scene, renderer: latelight.Scene(value),
        lambda value, scene, renderer: latelight.Scene(id_depth=value),
        lambda value, scene, renderer: latelight.Scene(id_nodes=value),
        lambda value, scene, renderer: latelight.Scene(allow_outside=[value]),
        lambda value, scene, renderer: scene.add_mesh(value),
        lambda value, scene, renderer: scene.add_mesh([[value, 0, 0]] * 3),
        lambda value, scene, renderer: scene.add_mesh(SQUARE, indices=value),
        lambda value, scene, renderer: scene.add_texture(value),
        lambda value, scene, renderer: scene.set_transform(scene.instances()[0], value),
        lambda value, scene, renderer: scene.look_at(value, (0, 0, 0)),
        lambda value, scene, renderer: latelight.Camera(camera_to_world=value),
        lambda value, scene, renderer: latelight.Camera.from_k(value, np.eye(4), (8, 8)),
        lambda value, scene, renderer: latelight.Lens(distortion=value),
        lambda value, scene, renderer: renderer.render(value),
        lambda value, scene, renderer: renderer.render(latelight.Camera(), value),
        lambda value, scene, renderer: renderer.render(latelight.Camera(), (value, 8)),
        lambda value, scene, renderer: renderer.render(latelight.Camera(), (8, 8), value),
        lambda value, scene, renderer: renderer.render(latelight.Camera(), (8, 8), exposure=value),
        lambda value, scene, renderer: renderer.render(latelight.Camera(), (8, 8), sun=value),
        lambda value, scene, renderer: renderer.render(latelight.Camera(), (8, 8), anisotropy=value),
        lambda value, scene, renderer: renderer.pick(latelight.Camera(), value, (8, 8)),
        lambda value, scene, renderer: latelight.Renderer(scene, "cpu", value),
        lambda value, scene, renderer: latelight.set_memory_limit(value),
    ],
)
def test_pass_unchanged(error, call, boxes, renderer):
    with pytest.raises(type(error)) as caught:
        call(Raises(error), boxes, renderer)
    assert caught.value is error


def test_generators_raise_their_own():
    def cameras():
        yield latelight.Camera()
        raise LookupError("no more")

    with pytest.raises(LookupError, match="no more"):
        latelight.Renderer(latelight.Scene(), "cpu").render(cameras(), (8, 8))


def test_texts_are_no_arrays(boxes, renderer):
    """NumPy converts any object to an array without axes."""
    camera, mistake = latelight.Camera(), latelight.ArgumentTypeError
    refused(r"^sun must be an array of shape \(N,\), not a text$",
            lambda: renderer.render(camera, (8, 8), sun="30,40"), mistake)
    refused("^camera_to_world must be .*, not a text$",
            lambda: renderer.render_worlds(2, camera, (8, 8), camera_to_world="x"), mistake)
    refused("^positions must be .*, not a text$", lambda: boxes.add_mesh("x", FACES), mistake)
    refused("^positions must be .*, not dict$", lambda: boxes.add_mesh({}, FACES), mistake)
    refused(r"^positions must be .*, not \(\)$", lambda: boxes.add_mesh(3.5, FACES))


# --- copies, pickles, references ------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [latelight.Camera, latelight.Material, latelight.Light, latelight.Lens])
def test_states_that_do_not_fit_are_refused(kind):
    good = kind().__getstate__()
    name = next(iter(good))
    for state, words in (
        ({}, f"the state of a {kind.__name__} must have"),
        ({k: v for k, v in good.items() if k != name}, f'must have "{name}"'),
        ({**good, "more": 1}, "nothing but its fields"),
        ([], "must be a dict, not list"),
        (None, "must be a dict, not NoneType"),
    ):
        refused(words, lambda: kind().__setstate__(state))
    made = kind.__new__(kind)
    made.__setstate__(good)
    assert repr(made) == repr(kind())
    assert repr(copy.deepcopy(made)) == repr(pickle.loads(pickle.dumps(made))) == repr(kind())


def test_pickles_cut_short_are_refused():
    """The state of a Camera in another class's pickle."""

    class Fake:
        def __reduce__(self):
            return latelight.Light, (), latelight.Camera().__getstate__()

    with pytest.raises(latelight.UsageError, match="the state of a Light must have"):
        copy.copy(Fake())


def test_scenes_and_renderers_are_not_copied(boxes, renderer):
    for value in (boxes, renderer, renderer.submit(latelight.Camera(), (8, 8))):
        with pytest.raises(TypeError, match="pickle"):
            pickle.dumps(value)
        with pytest.raises(TypeError):
            copy.deepcopy(value)


def test_handles_are_copied_but_stay_in_their_process(boxes):
    handle = boxes.instances()[0]
    assert copy.copy(handle) == copy.deepcopy({"of": handle})["of"] == handle
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(handle)


def test_frames_are_pickled(renderer, boxes):
    frames = renderer.render([boxes.default_camera()] * 2, (8, 8), ("rgba", "depth"))
    read = pickle.loads(pickle.dumps(frames))
    for name in ("rgba", "depth"):
        np.testing.assert_array_equal(read[1][name], frames[1][name])
        np.testing.assert_array_equal(copy.deepcopy(frames)[name], frames[name])


def test_weak_references(device):
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    ticket = renderer.submit(scene.default_camera(), (8, 8))
    references = [weakref.ref(value) for value in (scene, renderer, ticket)]
    assert [reference() is not None for reference in references] == [True] * 3
    del scene, renderer, ticket
    gc.collect()
    assert [reference() for reference in references] == [None] * 3


def test_parts_outlive_what_they_are_of(device):
    ticket = latelight.Renderer(latelight.Scene("builtin:boxes"), device).submit(latelight.Camera(), (8, 8))
    gc.collect()
    assert ticket.take()["rgba"].shape == (8, 8, 4)
    scene = latelight.Renderer(latelight.Scene("builtin:boxes"), device).scene
    assert scene.instances()
