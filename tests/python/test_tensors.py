"""Arrays of other libraries as arguments of worlds. GPUs are tested by tests/gpu/world_tensors, which needs one."""

import latelight
import numpy as np
import pytest

SIZE = (16, 12)


@pytest.fixture(scope="module")
def scene():
    made = latelight.Scene()
    square = made.add_mesh(np.float32([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), [[0, 1, 2], [0, 2, 3]])
    made.add_instance(square, made.add_material(latelight.Material(unlit=True)))
    return made


@pytest.fixture(scope="module")
def square_renderer(scene):
    return latelight.Renderer(scene, device="cpu")


class Exported:
    """An array of another library on the CPU: NumPy reads it by the protocol that the library has."""

    def __init__(self, array, protocol):
        self.array, self.protocol = array, protocol

    def __getattr__(self, name):
        if name in {"dlpack": ("__array__", "__dlpack__", "__dlpack_device__"), "array": ("__array__",)}[self.protocol]:
            return getattr(self.array, name)
        raise AttributeError(name)

    def __array__(self, *arguments, **keywords):
        return self.array.__array__(*arguments, **keywords)


class OnCuda:
    """As an array in CUDA's memory presents itself."""

    def __init__(self, interface=None):
        if interface is None:
            self.__dlpack__ = lambda **asked: None
            self.__dlpack_device__ = lambda: (2, 0)
        else:
            self.__cuda_array_interface__ = interface


def transforms(dtype=np.float64, rows=4):
    matrices = np.tile(np.eye(4, dtype=dtype), (3, 1, 1, 1))
    matrices[:, 0, 0, 3] = (0, 0.5, -0.75)
    return matrices[:, :, :rows]


@pytest.mark.parametrize("raster", ["compute", "hardware"])
@pytest.mark.parametrize("protocol", ["dlpack", "array"])
def test_arrays_of_every_kind_give_the_same_images(scene, square_renderer, raster, protocol):
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    options = {"instances": scene.instances(), "raster": raster}
    usual = square_renderer.render_worlds(3, camera, SIZE, "id", transforms=transforms(), **options)["id"]
    assert len({frame.tobytes() for frame in usual}) == 3
    for dtype in (np.float32, np.float64, np.float16):
        for rows in (3, 4):
            given = Exported(transforms(dtype, rows), protocol)
            frames = square_renderer.render_worlds(3, camera, SIZE, "id", transforms=given, **options)
            np.testing.assert_array_equal(frames["id"], usual)
    turned = np.asfortranarray(transforms())  # other strides
    frames = square_renderer.render_worlds(3, camera, SIZE, "id", transforms=turned, **options)
    np.testing.assert_array_equal(frames["id"], usual)
    exists = Exported(np.array([[True], [False], [True]]), protocol)
    some = square_renderer.render_worlds(3, camera, SIZE, "id", exists=exists, **options)["id"]
    assert some[0].any() and not some[1].any() and some[2].any()


def test_the_call_may_change_its_arrays_afterward(scene, square_renderer):
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    given = transforms(np.float32)
    options = {"instances": scene.instances(), "raster": "compute"}
    expected = square_renderer.render_worlds(3, camera, SIZE, "id", transforms=given, **options)["id"]
    ticket = square_renderer.submit_worlds(3, camera, SIZE, "id", transforms=given, **options)
    given[:] = np.nan
    np.testing.assert_array_equal(ticket.take()["id"], expected)


def test_cuda_arrays_require_cuda(scene, square_renderer):
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    interface = {"shape": (3, 1, 4, 4), "typestr": "<f4", "data": (256, False), "version": 3}
    for given in (OnCuda(), OnCuda(interface)):
        with pytest.raises(latelight.NoDeviceError, match="CUDA"):
            square_renderer.render_worlds(3, camera, SIZE, instances=scene.instances(), transforms=given)
    with pytest.raises(latelight.ArgumentTypeError, match="stream must be a whole number"):
        square_renderer.render_worlds(3, camera, SIZE, stream="mine")


@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_wrong_values_are_refused_with_their_world(scene, square_renderer, raster):
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    wrong = transforms()
    wrong[1, 0, 3] = (0, 0, 0, 2)
    with pytest.raises(latelight.UsageError, match="last row 0 0 0 1"):
        square_renderer.render_worlds(3, camera, SIZE, instances=scene.instances(), transforms=wrong, raster=raster)
    poses = np.tile(camera.camera_to_world, (3, 1, 1, 1))
    poses[2, 0, :3, :3] *= 2
    with pytest.raises(latelight.UsageError, match="must be a rotation and a translation"):
        square_renderer.render_worlds(3, camera, SIZE, camera_to_world=poses, raster=raster)
    k = np.tile([[20.0, 1, 8], [0, 20, 6], [0, 0, 1]], (3, 1, 1, 1))
    with pytest.raises(latelight.UsageError, match="no skew and the last row 0 0 1"):
        square_renderer.render_worlds(3, camera, SIZE, k=k, raster=raster)
    mirrored = transforms()
    mirrored[0, 0, 0, 0] = -1
    with pytest.raises(latelight.UsageError, match="mirrors"):
        square_renderer.render_worlds(
            3, camera, SIZE, instances=scene.instances(), transforms=mirrored, camera_instances=scene.instances(),
            raster=raster,
        )
    fine = square_renderer.render_worlds(3, camera, SIZE, "id", instances=scene.instances(), transforms=transforms())
    assert fine["id"].any()
