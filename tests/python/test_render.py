"""Rendering: shapes, types, batches, tickets, options; and against the command line's files."""

import gc
import json
import os
import subprocess

import numpy as np
import pytest

import latelight

SIZE = (48, 32)


@pytest.fixture
def camera(boxes):
    return boxes.default_camera(SIZE[0] / SIZE[1])


@pytest.mark.parametrize("raster", ["hardware", "compute"])
def test_grooves_are_the_same_from_both_sides(square, device, raster):
    """The direction of anisotropy belongs to the surface: a mirrored quad that faces the camera looks alike."""

    def picture(facing, rotation):
        scene = latelight.Scene()
        indices = square["indices"] if facing > 0 else square["indices"][:, ::-1]
        normals = np.tile(np.array([0, 0, facing], np.float32), (4, 1))
        tangents = np.tile(np.array([1, 0, 0, 1], np.float32), (4, 1))
        mesh = scene.add_mesh(square["positions"], indices, normals=normals, tangents=tangents)
        metal = latelight.Material(
            metallic=1, roughness=0.35, anisotropy=0.9, anisotropy_rotation=rotation, double_sided=True
        )
        scene.add_instance(mesh, scene.add_material(metal), np.eye(4))
        scene.add_light(latelight.Light(position=(0.2, 0.3, -3), intensity=10))
        renderer = latelight.Renderer(scene, device, environment="none")
        eye = latelight.Camera.look_at((0, 0, -3), (0, 0, 0))
        return renderer.render(eye, SIZE, raster=raster, shadows="none")["rgba"].astype(int)

    back, front = picture(1, 30), picture(-1, -30)
    assert np.abs(back - front).max() <= 1
    assert np.abs(back - picture(-1, 30)).max() > 50


def test_shapes_and_types(renderer, camera):
    frame = renderer.render(camera, SIZE, ("rgba", "color", "depth", "normal", "id", "uv"))
    assert {name: (array.shape, array.dtype.name) for name, array in frame.items()} == {
        "rgba": ((32, 48, 4), "uint8"),
        "color": ((32, 48, 4), "float32"),
        "depth": ((32, 48), "float32"),
        "normal": ((32, 48, 3), "float32"),
        "id": ((32, 48), "uint32"),
        "uv": ((32, 48, 2), "float32"),
    }
    with pytest.raises(KeyError, match="albedo"):
        frame["albedo"]


def test_data_alone_are_not_lit(renderer, camera):
    assert list(renderer.render(camera, SIZE, "depth")) == ["depth"]


def test_the_same_as_the_command_line(renderer, camera, tmp_path):
    program = os.environ.get("LATELIGHT_PROGRAM")
    if not program:
        pytest.skip("LATELIGHT_PROGRAM names no program to compare with")
    names = ["depth", "normal", "id"]
    subprocess.run(
        [program, "render", "builtin:boxes", "--size", "48x32", "--device", "cpu", "--aov", ",".join(names)]
        + ["-o", str(tmp_path / "{aov}.npy"), "--exposure", "1", "--quiet"],
        check=True,
    )
    frame = renderer.render(camera, SIZE, names, exposure=1)
    for name in names:
        np.testing.assert_array_equal(frame[name], np.load(tmp_path / f"{name}.npy"))
    meta = json.loads((tmp_path / "meta.json").read_text())
    np.testing.assert_allclose(camera.camera_to_world, meta["camera"]["cameraToWorld"], atol=1e-6)
    np.testing.assert_allclose(camera.k(SIZE), meta["camera"]["K"], rtol=1e-6)


def test_arrays_outlive_all_else(device):
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, device)
    depth = renderer.render(scene.default_camera(), SIZE, "depth")["depth"]
    kept = depth.copy()
    assert not depth.flags.owndata and depth.flags.writeable
    del scene, renderer
    gc.collect()
    np.testing.assert_array_equal(depth, kept)
    np.testing.assert_array_equal(np.from_dlpack(depth), kept)


def test_cameras_at_once_are_the_same_as_one_by_one(renderer, boxes):
    cameras = [boxes.look_at((3, 2 + i, 4), (0, 0.5, 0)) for i in range(3)]
    frames = renderer.render(cameras, SIZE, ("rgba", "depth"))
    assert len(frames) == 3
    assert frames["depth"].shape == (3, 32, 48)
    assert frames["rgba"].shape == (3, 32, 48, 4)
    assert len(frames[1:]) == 2
    for camera, frame in zip(cameras, frames):
        np.testing.assert_array_equal(frame["rgba"], renderer.render(camera, SIZE)["rgba"])


def test_tickets_are_taken_once_and_in_any_order(renderer, boxes, camera):
    other = boxes.look_at((3, 2, 4), (0, 0, 0))
    first = renderer.submit(camera, SIZE, "depth")
    second = renderer.submit([other], SIZE, "depth")
    assert isinstance(second.take(), latelight.Frames)
    np.testing.assert_array_equal(first.take()["depth"], renderer.render(camera, SIZE, "depth")["depth"])
    assert first.done
    with pytest.raises(latelight.UsageError, match="taken already"):
        first.take()


def test_a_ticket_keeps_its_renderer(device, boxes, camera):
    ticket = latelight.Renderer(boxes, device).submit(camera, SIZE, "depth")
    gc.collect()
    assert np.isfinite(ticket.take()["depth"]).any()


def test_options_do_what_they_say(renderer, camera):
    plain = renderer.render(camera, SIZE, "color")["color"]
    brighter = renderer.render(camera, SIZE, "color", exposure=2.0)["color"]
    np.testing.assert_allclose(brighter[..., :3], 4 * plain[..., :3], rtol=1e-3)
    sunny = renderer.render(camera, SIZE, "color", sun=(30, 40, 10))["color"]
    assert sunny[..., :3].sum() > 1.1 * plain[..., :3].sum()
    opaque = renderer.render(camera, SIZE, background="#ff0000")["rgba"]
    assert (opaque[..., 3] == 255).all()
    default = renderer.render(camera, SIZE, "color", anisotropy=None, time=None, sun=None)["color"]
    np.testing.assert_array_equal(default, plain)


def test_every_option_takes_its_default(renderer, camera):
    """The signature's own defaults, each given by name, change nothing."""
    import inspect
    import re

    signature = renderer.render.__doc__.split("\n")[0]
    given = dict(re.findall(r", (\w+): [^=]+? = (None|True|False|\"[^\"]*\"|[-\d.e]+)(?=,|\))", signature))
    options = {name: eval(value) for name, value in given.items() if name not in ("size", "outputs")}
    assert len(options) > 40
    plain = renderer.render(camera, SIZE)["rgba"]
    np.testing.assert_array_equal(renderer.render(camera, SIZE, **options)["rgba"], plain)


def test_motion_takes_the_cameras_before_and_after(renderer, boxes):
    now, before = boxes.look_at((3, 2, 4), (0, 0.5, 0)), boxes.look_at((3.1, 2, 4), (0, 0.5, 0))
    still = renderer.render(now, SIZE, ("motion", "id"))
    moved = renderer.render(now, SIZE, "motion", previous_cameras=[before])["motion"]
    seen = still["id"] > 0
    assert (still["motion"][seen] == 0).all()
    assert (abs(moved[seen][:, :2]).max(axis=1) > 0).all()
    with pytest.raises(latelight.UsageError, match="1 cameras are rendered, but 2"):
        renderer.render(now, SIZE, "motion", previous_cameras=[before, before])


def test_picks(renderer, boxes, camera):
    frame = renderer.render(camera, SIZE, ("id", "depth", "position"))
    y, x = np.argwhere(frame["id"] > 0)[0]
    shown, outside = renderer.pick(camera, [[x, y], [0, 0]], SIZE)
    assert shown.id == frame["id"][y, x]
    assert shown.depth == frame["depth"][y, x]
    np.testing.assert_array_equal(np.float32(shown.position), frame["position"][y, x])
    assert boxes.instances(shown.node)
    assert outside.id == frame["id"][0, 0]


def test_frames_show_themselves(renderer, camera):
    frame = renderer.render(camera, SIZE)
    assert frame._repr_png_().startswith(b"\x89PNG\r\n\x1a\n")
    assert renderer.render(camera, SIZE, "depth")._repr_png_() is None
    assert repr(frame) == "Frame(rgba: uint8(32, 48, 4))"


def test_the_models_of_the_machine(model, device):
    scene = latelight.Scene(model("DamagedHelmet.glb"))
    frame = latelight.Renderer(scene, device).render(scene.default_camera(1), (64, 64), ("rgba", "depth"))
    assert 0.1 < np.isfinite(frame["depth"]).mean() < 0.9
    assert frame["rgba"][..., :3].std() > 10


def rays_of(camera, width, height):
    """Origins and directions through the centers of a picture's pixels, in the scene file's frame."""
    focal = height / 2 / np.tan(np.radians(camera.vertical_fov) / 2)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    pose = np.asarray(camera.camera_to_world)
    directions = np.stack([x / focal, y / focal, np.ones_like(x)], axis=-1).reshape(-1, 3) @ pose[:3, :3].T
    return np.broadcast_to(pose[:3, 3], directions.shape), directions


def test_rays_hit_what_pixels_show(renderer, camera):
    frame = renderer.render(camera, SIZE, ("distance", "position", "id", "part", "material"))
    hits = renderer.cast(*rays_of(camera, *SIZE))
    assert {name: (array.shape, array.dtype.name) for name, array in hits.items()} == {
        "distance": ((1536,), "float32"),
        "position": ((1536, 3), "float32"),
        "normal": ((1536, 3), "float32"),
        "geonormal": ((1536, 3), "float32"),
        "uv": ((1536, 2), "float32"),
        "id": ((1536,), "uint32"),
        "part": ((1536,), "uint32"),
        "material": ((1536,), "uint32"),
        "triangle": ((1536,), "uint32"),
        "intensity": ((1536,), "float32"),
    }
    same = hits["part"] == frame["part"].ravel()
    assert np.mean(same) > 0.99
    for name in ("id", "material"):
        assert np.array_equal(hits[name][same], frame[name].ravel()[same])
    assert np.mean(np.isclose(hits["distance"], frame["distance"].ravel(), rtol=1e-5)) > 0.99
    close = np.isclose(hits["position"], frame["position"].reshape(-1, 3), atol=1e-4).all(axis=1)
    assert np.mean(close) > 0.99


def test_rays_of_any_numbers(renderer):
    up = np.array([[0, 1, 0]], dtype=np.float32)
    assert len(renderer.cast(np.zeros((0, 3)), np.zeros((0, 3)))["distance"]) == 0
    assert np.isinf(renderer.cast([[0, 1000, 0]], up)["distance"]).all()
    assert np.isinf(renderer.cast([[0, np.nan, 0]], up)["distance"]).all()
    nearest = renderer.cast([[0, 1000, 0]], -up)["distance"][0]
    assert np.isinf(renderer.cast([[0, 1000, 0]], -up, max_distance=nearest - 1)["distance"]).all()
    for wrong in (dict(origins=[[0, 0]], directions=up), dict(origins=[[0, 0, 0]] * 2, directions=up)):
        with pytest.raises(latelight.UsageError):
            renderer.cast(**wrong)
    with pytest.raises(latelight.UsageError, match="max_distance|maximum distance"):
        renderer.cast([[0, 0, 0]], up, max_distance=-1)
    with pytest.raises(latelight.UsageError, match="normal_frame"):
        renderer.cast([[0, 0, 0]], up, normal_frame="opencv")


def test_tickets_of_rays(renderer):
    origins, directions = np.tile([0.0, 1.0, 4.0], (500, 1)), np.random.default_rng(2).normal(size=(500, 3))
    expected = renderer.cast(origins, directions), renderer.cast(origins + [0, 0.25, 0], directions)
    moving = origins.copy()
    first = renderer.submit_cast(moving, directions)
    moving += [0, 0.25, 0]  # the rays were copied
    second = renderer.submit_cast(moving, directions, outputs=("id", "position"))
    renderer.submit_cast(moving, directions)  # is dropped
    hits = second.take()
    assert second.done and list(hits) == ["id", "position"]
    assert all(np.array_equal(hits[name], expected[1][name]) for name in hits)
    every = first.take()
    assert list(every) == list(expected[0])
    assert all(np.array_equal(every[name], expected[0][name]) for name in every)
    assert not np.array_equal(every["position"], hits["position"])
    with pytest.raises(latelight.UsageError, match="taken already"):
        first.take()
    again = renderer.submit_cast(origins, directions, out=hits).take()
    assert again["id"] is hits["id"] and np.array_equal(again["position"], every["position"])
    with pytest.raises(latelight.UsageError):
        renderer.submit_cast(origins, directions[:3])


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_tickets_of_rays_on_the_device(renderer, dtype):
    origins = np.tile(np.array([0, 1, 4], dtype), (500, 1))
    directions = np.random.default_rng(3).normal(size=(500, 3)).astype(dtype)
    upper = origins + np.array([0, 0.25, 0], dtype)
    expected = renderer.cast(origins, directions), renderer.cast(upper, directions)
    moving = origins.copy()
    first = renderer.submit_cast(moving, directions, on_device=True)
    moving[:] = upper  # the rays were copied
    second = renderer.submit_cast(moving, directions, outputs=("id", "position"), on_device=True)
    renderer.submit_cast(moving, directions, on_device=True)  # is dropped
    for ticket, rays in ((second, expected[1]), (first, expected[0])):
        hits = ticket.take()
        assert ticket.done
        for name, array in hits.items():
            assert array.shape == rays[name].shape and array.dtype == rays[name].dtype
            if array.device == "cpu":
                np.testing.assert_array_equal(array.numpy(), rays[name])
    assert len(hits) == 10
    with pytest.raises(latelight.UsageError, match="taken already"):
        first.take()
    again = renderer.submit_cast(upper, directions, out=hits, on_device=True)
    other = renderer.submit_cast(origins, directions, outputs="distance", on_device=True)
    for ticket, distance in ((again, expected[1]["distance"]), (other, expected[0]["distance"])):
        array = ticket.take()["distance"]
        if array.device == "cpu":
            np.testing.assert_array_equal(array.numpy(), distance)
    with pytest.raises(latelight.UsageError, match="out requires on_device=True"):
        renderer.submit_cast(origins, directions, out=hits, stream=1)
    with pytest.raises(latelight.UsageError, match=r"directions must be an array of shape \(500, 3\)"):
        renderer.submit_cast(origins, directions[:3], on_device=True)


def test_rays_and_hits_on_the_host_need_no_device_arrays(renderer):
    origins, directions = np.tile([0.0, 1.0, 4.0], (20, 1)), np.random.default_rng(4).normal(size=(20, 3))
    hits = renderer.cast(origins, directions, outputs="distance")
    again = renderer.submit_cast(origins, -directions, out=hits, on_device=False, stream=None).take()
    assert again["distance"] is hits["distance"]


def test_cast_returns_the_arrays_that_are_needed(renderer):
    origins, directions = np.tile([0.0, 1.0, 4.0], (500, 1)), np.random.default_rng(1).normal(size=(500, 3))
    every = renderer.cast(origins, directions)
    assert len(every) == 10 and np.isfinite(every["distance"]).any()
    some = renderer.cast(origins.astype(np.float32), directions, outputs=("id", "position"))
    assert list(some) == ["id", "position"] and np.array_equal(some["id"], every["id"])
    assert list(renderer.cast(origins, directions, outputs="uv")) == ["uv"]
    short = directions.astype(np.float32)
    floats, doubles = (renderer.cast(origins.astype(t), short.astype(t)) for t in (np.float32, np.float64))
    assert all(np.array_equal(floats[name], doubles[name]) for name in every)
    again = renderer.cast(origins + [0, 0.25, 0], directions, out=some)
    assert again["position"] is some["position"] and not np.array_equal(some["position"], every["position"])
    renderer.cast(origins, directions, out=some)
    assert np.array_equal(some["position"], every["position"]) and np.array_equal(some["id"], every["id"])
    for wrong in (
        dict(outputs="depth"),
        dict(outputs=("id",), out=some),
        dict(out={"id": some["id"][:3]}),
        dict(out={"id": some["id"].astype(np.int64)}),
        dict(out={"position": some["position"][:, :2]}),
        dict(out=[]),
    ):
        with pytest.raises(latelight.UsageError):
            renderer.cast(origins, directions, **wrong)


def test_metered_exposures(device):
    scene = latelight.Scene()
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    mesh = scene.add_mesh(points, indices=[[0, 1, 2], [0, 2, 3]])
    for x, radiance in ((0, 4000.0), (10, 0.02)):
        material = scene.add_material(latelight.Material(base_color=(0, 0, 0, 1), emissive=(radiance,) * 3, specular=0))
        scene.add_instance(mesh, material, np.array([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]))
    cameras = [scene.look_at((x, 0, 3), (x, 0, 0)) for x in (0, 10)]
    renderer = latelight.Renderer(scene, device, environment="none")
    frames = renderer.render(cameras, (16, 16), "color", exposure="auto")
    for frame, radiance in zip(frames, (4000.0, 0.02)):
        assert frame["color"][8, 8, :3] == pytest.approx([0.18] * 3, rel=2e-3)  # of a half float
        assert frame.exposure == pytest.approx(0.18 / radiance, rel=1e-3)
    darker = renderer.render(cameras, (16, 16), "color", exposure="auto-1", on_device=True)
    assert darker.exposures == pytest.approx([frame.exposure / 2 for frame in frames])
    assert renderer.render(cameras[0], (16, 16), "color", exposure=1).exposure == 2
    assert renderer.validation_messages() == []


@pytest.mark.parametrize("empty", [[], (), np.array([]), np.zeros((0, 3))])
def test_no_rays_hit_nothing(renderer, empty):
    for options in ({}, {"on_device": True}):
        hits = renderer.cast(empty, empty, **options)
        assert hits["distance"].shape == (0,) and hits["uv"].shape == (0, 2)
    assert renderer.submit_cast(empty, empty, outputs="position").take()["position"].shape == (0, 3)
    with pytest.raises(latelight.UsageError, match=r"shape \(N, 3\), not \(1, 2\)"):
        renderer.cast([[0, 0]], [[0, 0]])


def test_no_pixels_show_nothing(renderer, boxes):
    camera = boxes.default_camera()
    for empty in ([], (), np.array([]), np.zeros((0, 2), int)):
        assert renderer.pick(camera, empty, (8, 8)) == []
    with pytest.raises(latelight.UsageError, match=r"shape \(N, 2\), not \(0, 3\)"):
        renderer.pick(camera, np.zeros((0, 3), int), (8, 8))
