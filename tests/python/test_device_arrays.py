"""Outputs that stay in the memory of the device."""

import gc

import latelight
import numpy as np
import pytest

OUTPUTS = ("rgba", "depth", "normal", "id")


@pytest.fixture(autouse=True)
def on_the_host(renderer, cameras):
    device = renderer.render(cameras[0], (8, 8), "depth", on_device=True)["depth"].device
    if device != "cpu":
        pytest.skip(f"the host has no arrays of {device}")


@pytest.fixture
def cameras(boxes):
    return [boxes.look_at((3 + i, 2, 4), (0, 0, 0)) for i in range(3)]


def test_hold_what_frames_hold(renderer, cameras):
    frames = renderer.render(cameras, (40, 24), OUTPUTS)
    arrays = renderer.render(cameras, (40, 24), OUTPUTS, on_device=True)
    assert set(arrays) == set(OUTPUTS)
    for name in OUTPUTS:
        array = np.from_dlpack(arrays[name])
        assert array.shape == arrays[name].shape == frames[name].shape
        assert array.dtype == frames[name].dtype == arrays[name].dtype
        np.testing.assert_array_equal(array, frames[name])
        np.testing.assert_array_equal(arrays[name].numpy(), frames[name])


def test_have_dtypes_of_numpy(renderer, cameras):
    formats = {"id": "uint16", "normal": "float16"}
    arrays = renderer.render(
        cameras[0], (4, 4), ("rgba", "depth", "part", "id", "normal"), on_device=True, formats=formats)
    expected = {"rgba": "uint8", "depth": "float32", "part": "uint32", "id": "uint16", "normal": "float16"}
    for name, dtype in expected.items():
        assert isinstance(arrays[name].dtype, np.dtype) and arrays[name].dtype == dtype
        assert arrays[name].dtype == np.dtype(dtype) and f"{name}: {dtype}(" in repr(arrays)


def test_jax_converts_them(renderer, cameras):
    numpy = pytest.importorskip("jax.numpy", reason="jax is not installed")
    arrays = renderer.render(cameras[0], (8, 4), ("rgba", "depth"), on_device=True)
    for array in arrays.values():
        np.testing.assert_array_equal(numpy.asarray(array), array.numpy())


def test_numpy_reads_them_as_arrays(renderer, cameras):
    """Not as an array of shape () that holds the object."""
    depth = renderer.render(cameras, (40, 24), "depth", on_device=True)["depth"]
    array = np.asarray(depth)
    assert array.shape == (3, 24, 40) and array.dtype == np.float32
    assert array.ctypes.data == depth.numpy().ctypes.data
    np.testing.assert_array_equal(np.array(depth), array)
    assert np.array(depth).ctypes.data != array.ctypes.data
    np.testing.assert_array_equal(np.asarray(depth, np.float64), array.astype(np.float64))
    assert np.asarray(depth, np.float64).dtype == np.float64
    assert np.isfinite(depth).sum() == np.isfinite(array).sum() > 0
    with pytest.raises(latelight.UsageError, match="copy=False is impossible"):
        depth.__array__(np.float64, copy=False)


def test_of_one_camera_have_no_axis_of_views(renderer, cameras):
    arrays = renderer.render(cameras[0], (40, 24), ("depth", "normal"), on_device=True)
    assert arrays["depth"].shape == (24, 40)
    assert arrays["normal"].shape == (24, 40, 3)
    assert arrays["depth"].device == "cpu"
    assert arrays["depth"].__dlpack_device__() == (1, 0)
    assert not hasattr(arrays["depth"], "__cuda_array_interface__")


def test_share_memory_that_lives_as_long_as_they_are_used(renderer, cameras):
    first = np.from_dlpack(renderer.render(cameras, (40, 24), "depth", on_device=True)["depth"])
    expected = first.copy()
    gc.collect()
    second = np.from_dlpack(renderer.render(cameras[::-1], (40, 24), "depth", on_device=True)["depth"])
    np.testing.assert_array_equal(first, expected)
    assert first.ctypes.data != second.ctypes.data
    place = first.ctypes.data
    del first
    gc.collect()
    third = renderer.render(cameras, (40, 24), "depth", on_device=True)["depth"]
    assert third.numpy().ctypes.data == place, "the memory is used again"


def test_outlive_their_renderer(boxes, cameras):
    renderer = latelight.Renderer(boxes, device="cpu")
    array = renderer.render(cameras, (40, 24), "depth", on_device=True)["depth"].numpy()
    expected = array.copy()
    del renderer
    gc.collect()
    np.testing.assert_array_equal(array, expected)


def test_of_tickets(renderer, cameras):
    tickets = [renderer.submit(camera, (40, 24), "depth", on_device=True) for camera in cameras]
    for ticket, camera in zip(tickets, cameras):
        expected = renderer.render(camera, (40, 24), "depth")["depth"]
        np.testing.assert_array_equal(ticket.take()["depth"].numpy(), expected)


def test_refuse_what_is_no_flag(renderer, cameras):
    with pytest.raises(latelight.UsageError, match="on_device must be"):
        renderer.render(cameras, (40, 24), "depth", on_device="yes")
