"""Arrays of other libraries as arguments of worlds. GPUs are tested by tests/gpu/world_tensors, which needs one."""

import gc
import signal
import time
import tracemalloc

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
        with pytest.raises(latelight.NoDeviceError, match="CUDA"):
            square_renderer.submit_cast(given, np.zeros((1, 3), np.float32))
        with pytest.raises(latelight.NoDeviceError, match="CUDA"):
            square_renderer.submit_cast_worlds(1, np.zeros((1, 1, 3), np.float32), given)
    with pytest.raises(latelight.ArgumentTypeError, match="stream must be a whole number"):
        square_renderer.render_worlds(3, camera, SIZE, stream="mine")
    with pytest.raises(latelight.ArgumentTypeError, match="stream must be a whole number"):
        square_renderer.submit_cast(*np.ones((2, 1, 3)), stream="mine")


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


# --- memory on the CPU ------------------------------------------------------------------------------------------------


def of_torch():
    torch = pytest.importorskip("torch")
    return torch.from_numpy, torch.from_dlpack, lambda array: array.data_ptr()


def of_jax():
    jax = pytest.importorskip("jax")
    jax.config.update("jax_platforms", "cpu")
    return jax.numpy.asarray, jax.dlpack.from_dlpack, lambda array: array.unsafe_buffer_pointer()


def of_warp():
    warp = pytest.importorskip("warp")
    warp.config.quiet = True
    return lambda array: warp.array(array, device="cpu"), warp.from_dlpack, lambda array: array.ptr


def of_numpy():
    return np.asarray, np.from_dlpack, lambda array: array.ctypes.data


LIBRARIES = pytest.mark.parametrize("library", [of_numpy, of_torch, of_jax, of_warp], ids=lambda of: of.__name__[3:])


@LIBRARIES
def test_arguments_are_read_where_they_are(scene, square_renderer, library):
    """NumPy, which reads the arrays of other libraries on the CPU, allocates no copies of them."""
    converted, _, _ = library()
    rays = 60_000
    origins = np.zeros((3, rays, 3), np.float32)
    origins[..., :2] = np.random.default_rng(2).uniform(-2, 2, (3, rays, 2))
    origins[..., 2] = 4
    directions = np.broadcast_to(np.float32([0, 0, -1]), origins.shape).copy()
    given = {"instances": scene.instances(), "outputs": "distance", "on_device": True}
    hits = square_renderer.cast_worlds(3, origins, directions, transforms=transforms(np.float32), **given)["distance"]
    expected = hits.numpy().copy()
    assert np.isfinite(expected).any() and np.isinf(expected).any()
    arrays = [converted(array) for array in (origins, directions, transforms(np.float32))]
    tracemalloc.start()
    again = square_renderer.cast_worlds(3, *arrays[:2], transforms=arrays[2], **given)["distance"]
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    np.testing.assert_array_equal(again.numpy(), expected)
    assert peak < origins.nbytes / 8


@LIBRARIES
def test_results_are_read_where_they_are(scene, square_renderer, library):
    _, shared, address = library()
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    given = {"instances": scene.instances(), "on_device": True}
    out = square_renderer.render_worlds(3, camera, SIZE, "depth", transforms=transforms(), **given)
    array = shared(out["depth"])
    assert address(array) == out["depth"].numpy().ctypes.data
    before = np.asarray(out["depth"].numpy()).copy()
    moved = transforms()
    moved[..., 2, 3] = 1  # nearer
    square_renderer.render_worlds(3, camera, SIZE, "depth", transforms=moved, out=out, **given)
    after = out["depth"].numpy()
    assert address(array) == after.ctypes.data
    visible = np.isfinite(before) & np.isfinite(after)
    assert visible.any() and (after[visible] < before[visible]).all()


# --- calls that fail --------------------------------------------------------------------------------------------------


def test_arrays_may_be_freed_while_the_device_works(scene, square_renderer):
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    options = {"instances": scene.instances(), "raster": "compute"}
    expected = square_renderer.render_worlds(3, camera, SIZE, "id", transforms=transforms(), **options)["id"]
    tickets = []
    for _ in range(4):
        given = transforms()
        tickets.append(square_renderer.submit_worlds(3, camera, SIZE, "id", transforms=given, **options))
        del given
        gc.collect()
        _ = [np.full((3, 1, 4, 4), np.nan) for _ in range(64)]  # likely in the memory of the array
    for ticket in tickets:
        np.testing.assert_array_equal(ticket.take()["id"], expected)


class Raises:
    def __init__(self, error):
        self.error = error

    def __array__(self, *_, **__):
        raise self.error


@pytest.mark.parametrize("error", [KeyboardInterrupt(), MemoryError(), LookupError("mine")], ids=lambda e: type(e).__name__)
@pytest.mark.parametrize("name", ["transforms", "exists", "camera_to_world", "k", "base_color", "environment_rotation"])
def test_exceptions_of_arrays_leave_the_renderer_usable(scene, square_renderer, error, name):
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    options = {"instances": scene.instances(), "transforms": transforms()}
    expected = square_renderer.render_worlds(3, camera, SIZE, "id", **options)["id"]
    with pytest.raises(type(error)) as caught:
        square_renderer.render_worlds(3, camera, SIZE, "id", **options | {name: Raises(error)})
    assert caught.value is error
    np.testing.assert_array_equal(square_renderer.render_worlds(3, camera, SIZE, "id", **options)["id"], expected)


@pytest.mark.parametrize("on_device", [False, True])
def test_interrupts_leave_the_renderer_usable(scene, square_renderer, on_device):
    """Signals arrive at different times of calls."""
    camera = latelight.Camera.look_at((0, 0, 4), (0, 0, 0))
    options = {"instances": scene.instances(), "transforms": np.tile(transforms(), (40, 1, 1, 1))}

    def ids():
        frames = square_renderer.render_worlds(120, camera, SIZE, "id", on_device=on_device, **options)
        return frames["id"].numpy().copy() if on_device else frames["id"]

    expected = ids()
    start = time.perf_counter()
    ids()
    duration, interrupted = time.perf_counter() - start, 0
    for share in np.linspace(0.05, 0.95, 8):
        signal.setitimer(signal.ITIMER_REAL, max(share * duration, 1e-4))
        try:
            while True:
                np.testing.assert_array_equal(ids(), expected)
        except KeyboardInterrupt:
            interrupted += 1
        np.testing.assert_array_equal(ids(), expected)
    assert interrupted == 8


@pytest.fixture(autouse=True)
def alarms_interrupt():
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)
