"""Worlds: each one's images are those of the scene edited to its state."""

import latelight
import numpy as np
import pytest

SIZE = (24, 16)
OUTPUTS = ("rgba", "depth", "id")
CORNERS = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)  # a square that faces +Z
TRIANGLES = [[0, 1, 2], [0, 2, 3]]


@pytest.fixture(scope="module")
def scene():
    made = latelight.Scene()
    square = made.add_mesh(CORNERS, TRIANGLES)
    for x, color in ((-1, (1, 0, 0)), (1, (0, 1, 0))):
        paint = made.add_material(latelight.Material(base_color=(*color, 1), unlit=True))
        made.add_instance(square, paint, at(x))
    return made


@pytest.fixture(scope="module")
def worlds_renderer(scene):
    return latelight.Renderer(scene)


@pytest.fixture
def camera():
    return latelight.Camera.look_at((0, 0, 4), (0, 0, 0))


def at(x, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def test_move_instances(scene, worlds_renderer, camera):
    red, green = scene.instances()
    transforms = np.array([[at(-1), at(1)], [at(-0.5, 1), at(0.25, -1, 1)]], np.float32)[:, :, :3]
    exists = np.array([[True, True], [True, False]])
    given = {"instances": [red, green], "transforms": transforms, "exists": exists}
    frames = worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS, **given)
    assert len(frames) == 2 and frames.invalid_worlds == ()
    assert frames["depth"].shape == (2, 1, 16, 24) and frames["rgba"].shape == (2, 1, 16, 24, 4)
    expected = worlds_renderer.render(camera, SIZE, OUTPUTS)
    for name in OUTPUTS:
        np.testing.assert_array_equal(frames[0][0][name], expected[name])
    ids = set(np.unique(frames[1][0]["id"]))
    assert ids == {0, scene.instance(red).id}
    arrays = worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS, **given, on_device=True)
    for name in OUTPUTS:
        assert arrays[name].shape == frames[name].shape
        if arrays[name].device == "cpu":
            np.testing.assert_array_equal(arrays[name].numpy(), frames[name])


def test_outputs_are_found_by_name(scene, worlds_renderer, camera):
    worlds = worlds_renderer.render_worlds(3, [camera, camera], SIZE, OUTPUTS)
    for frames, shape in ((worlds, (3, 2)), (worlds[1], (2,)), (worlds[1][0], ())):
        assert list(frames.keys()) == list(OUTPUTS)
        assert all(name in frames for name in OUTPUTS)
        assert "normal" not in frames and "" not in frames
        assert {name: array.shape[: len(shape)] for name, array in dict(frames).items()} == dict.fromkeys(OUTPUTS, shape)
        with pytest.raises(KeyError, match="there is no 'normal'"):
            frames["normal"]
    assert worlds[1] in worlds and worlds[1][0] in worlds[1] and worlds[1][0] not in worlds


def test_empty_lists_have_empty_arrays(scene, worlds_renderer, camera):
    """A scene without the elements that worlds describe, such as a model without geoms, needs no other call."""
    expected = worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS)
    nothing = {
        "instances": {"transforms": (0, 3, 4), "previous_transforms": (0, 4, 4), "base_color": (0, 4), "metallic": (0,)},
        "lights": {"light_position": (0, 3), "light_intensity": (0,)},
        "joints": {"joint_transforms": (0, 4, 4)},
        "meshes": {"vertices": (0, 3)},
    }
    for name, arrays in nothing.items():
        given = {array: np.zeros((2, *shape)) for array, shape in arrays.items()}
        for empty in ([], ()):
            frames = worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS, **{name: empty}, **given)
            for output in OUTPUTS:
                np.testing.assert_array_equal(frames[output], expected[output])
        for array in arrays:
            for wrong in (np.zeros((2, 1, *arrays[array][1:])), np.zeros((3, *arrays[array])), 1.0):
                with pytest.raises(latelight.UsageError, match=rf"{array} must have the shape \(2, 0, ...\), .*{name} is"):
                    worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS, **{name: []}, **{array: wrong})
    none = latelight.Scene()
    frames = latelight.Renderer(none).render_worlds(
        2, camera, SIZE, OUTPUTS, instances=[], transforms=np.zeros((2, 0, 3, 4)), exists=np.zeros((2, 0), bool),
        materials=[none.add_material(latelight.Material())], material_choice=np.zeros((2, 0), np.int64))
    assert not frames["id"].any()


def test_casts_ignore_cameras(scene, worlds_renderer):
    """The arguments that describe worlds of images with several cameras also describe those of a cast."""
    transforms = np.array([[at(-1), at(1)], [at(-1, 0, 1), at(1)]])
    given = {"instances": scene.instances(), "transforms": transforms}
    cameras = {"camera_to_world": np.zeros((2, 7, 3, 4)), "k": np.zeros((2, 7, 3, 3)), "camera_instances": [None] * 7}
    origins, directions = np.tile((-1.0, 0, 5), (2, 1, 1)), np.tile((0.0, 0, -1), (2, 1, 1))
    hits = worlds_renderer.cast_worlds(2, origins, directions, outputs="distance", **given, **cameras)
    np.testing.assert_allclose(hits["distance"], [[5], [4]], rtol=1e-6)
    ticket = worlds_renderer.submit_cast_worlds(2, origins, directions, outputs="distance", **given, **cameras)
    np.testing.assert_allclose(ticket.take()["distance"], [[5], [4]], rtol=1e-6)


def test_lights_are_listed_once(camera):
    lit = latelight.Scene("builtin:boxes")
    light = lit.add_light(latelight.Light(position=(1, 3, 1), intensity=20))
    with pytest.raises(latelight.UsageError, match="lights of worlds must be listed once each"):
        latelight.Renderer(lit).render_worlds(
            1, camera, SIZE, "rgba", lights=[light, light], light_intensity=np.ones((1, 2)))


def test_cameras_have_poses_and_matrices(worlds_renderer, camera):
    poses = np.stack([[latelight.Camera.look_at((x, 1, 4), (0, 0, 0)).camera_to_world] for x in (-1.0, 0.5, 2.0)])
    k = np.tile([[20.0, 0, 11], [0, 20, 9], [0, 0, 1]], (3, 1, 1, 1))
    frames = worlds_renderer.render_worlds(3, [camera], SIZE, OUTPUTS, camera_to_world=poses, k=k)
    for world in range(3):
        expected = worlds_renderer.render(latelight.Camera.from_k(k[world, 0], poses[world, 0], SIZE), SIZE, OUTPUTS)
        for name in OUTPUTS:
            np.testing.assert_allclose(frames[world][0][name], expected[name], rtol=1e-5)


def matrices(*each):
    """Camera matrices of worlds with one camera: fx, fy, cx, cy."""
    return np.array([[[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]] for fx, fy, cx, cy in each], float)


@pytest.mark.parametrize(
    ("model", "distortion"),
    [("pinhole", ()), ("opencv", (-0.35, 0.1, 0.002, -0.001)), ("fisheye", (-0.05, 0.01)), ("ftheta", (0, 1, 0.02))],
)
@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_matrices_keep_the_distortion_of_lenses(worlds_renderer, camera, model, distortion, raster):
    calibrations = ((20, 21, 12, 8), (16, 15, 11, 9))
    camera.lens = latelight.Lens(model=model, width=48, height=32, fx=50, fy=50, cx=20, cy=10, distortion=distortion)
    frames = worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS, k=matrices(*calibrations), raster=raster)
    for world, (fx, fy, cx, cy) in enumerate(calibrations):
        camera.lens = latelight.Lens(
            model=model, width=SIZE[0], height=SIZE[1], fx=fx, fy=fy, cx=cx, cy=cy, distortion=distortion
        )
        expected = worlds_renderer.render(camera, SIZE, OUTPUTS, raster=raster)
        for name in OUTPUTS:
            np.testing.assert_array_equal(frames[world][0][name], expected[name])


def test_matrices_require_focal_lengths(worlds_renderer, camera):
    k = matrices((20, 20, 12, 8))
    for model in ("equirectangular", "cubemap"):
        camera.lens = latelight.Lens(model=model, width=24, height=12)
        with pytest.raises(latelight.UsageError, match=f"the lens model {model} has no focal lengths"):
            worlds_renderer.render_worlds(1, camera, SIZE, k=k)
    flat = latelight.Camera(orthographic=True, near_clip=0.1, far_clip=9)
    with pytest.raises(latelight.UsageError, match="an orthographic camera has no focal lengths"):
        worlds_renderer.render_worlds(1, flat, SIZE, k=k)


@pytest.mark.parametrize("raster", ["compute", "hardware", "rays"])
@pytest.mark.parametrize("entry", [(0, 0), (0, 1), (1, 2), (2, 2), (2, 0)])
def test_a_matrix_that_is_not_finite_spoils_only_its_world(worlds_renderer, camera, raster, entry):
    """Any of its nine numbers, also those that must be 0 and 1."""
    k = matrices(*[(20, 20, 12, 8)] * 3)
    expected = worlds_renderer.render_worlds(3, camera, SIZE, "id", k=k, raster=raster)["id"]
    for wrong in (np.nan, np.inf, 1e39):
        k[1, 0][entry] = wrong
        frames = worlds_renderer.render_worlds(3, camera, SIZE, "id", k=k, raster=raster)
        assert frames.invalid_worlds == (1,)
        assert expected[1].any() and not frames["id"][1].any()
        np.testing.assert_array_equal(frames["id"][::2], expected[::2])
    labels = worlds_renderer.labels_of_worlds(3, camera, SIZE, k=k)
    assert labels.present.any(-1)[:, 0].tolist() == [True, False, True]


def test_nan_spoils_only_its_world(scene, worlds_renderer, camera):
    transforms = np.tile(at(-1), (3, 1, 1, 1))
    transforms[1, 0, 0, 3] = np.nan
    moved = scene.instances()[:1]
    frames = worlds_renderer.submit_worlds(3, camera, SIZE, "id", instances=moved, transforms=transforms).take()
    assert frames.invalid_worlds == (1,)
    assert not frames[1][0]["id"].any()
    np.testing.assert_array_equal(frames[0][0]["id"], frames[2][0]["id"])
    assert frames[0][0]["id"].any()


@pytest.mark.parametrize("raster", ["compute", "hardware", "rays"])
@pytest.mark.parametrize("name", ["environment_rotation", "environment_intensity"])
def test_environments_of_worlds_are_finite_as_floats(worlds_renderer, camera, raster, name):
    expected = worlds_renderer.render_worlds(3, camera, SIZE, "id", raster=raster)["id"]
    for wrong in (np.nan, -np.inf, 1e39, -1e300):
        frames = worlds_renderer.render_worlds(3, camera, SIZE, "id", raster=raster, **{name: [0, wrong, 0]})
        assert frames.invalid_worlds == (1,), wrong
        assert not frames["id"][1].any()
        np.testing.assert_array_equal(frames["id"][::2], expected[::2])


@pytest.mark.parametrize("raster", ["hardware", "compute"])
def test_materials_that_an_edit_makes_translucent(square, camera, raster):
    scene = latelight.Scene()
    mesh = scene.add_mesh(square["positions"], square["indices"], colors=np.ones((4, 4), np.float32))
    front = scene.add_instance(mesh, scene.add_material(latelight.Material(alpha_mode="blend", unlit=True)), np.eye(4))
    back = scene.add_mesh(2 * square["positions"], square["indices"])
    scene.add_instance(back, scene.add_material(latelight.Material(base_color=(1, 0, 0, 1), unlit=True)), at(0, z=-1))
    renderer = latelight.Renderer(scene, "cpu", environment="none")
    call = {"instances": [front], "base_color": np.array([[[0, 1, 0, 1]]], np.float32), "raster": raster}
    renderer.render_worlds(1, camera, SIZE, "rgba", **call)
    scene.set_mesh(mesh, square["positions"], square["indices"], colors=np.full((4, 4), 0.3, np.float32))
    edited = renderer.render_worlds(1, camera, SIZE, "rgba", **call)[0][0]["rgba"]
    fresh = latelight.Renderer(scene, "cpu", environment="none").render_worlds(1, camera, SIZE, "rgba", **call)
    np.testing.assert_array_equal(edited, fresh[0][0]["rgba"])
    assert edited[SIZE[1] // 2, SIZE[0] // 2, 0] > 0  # the red square behind


def test_materials(scene, worlds_renderer, camera):
    red, green = scene.instances()
    paints = [scene.instance(square).material for square in (red, green)]
    swapped = worlds_renderer.render_worlds(
        2, camera, SIZE, OUTPUTS, instances=[red, green], materials=paints, material_choice=[[0, 1], [1, 0]]
    )
    expected = worlds_renderer.render(camera, SIZE, OUTPUTS)
    np.testing.assert_array_equal(swapped[0][0]["rgba"], expected["rgba"])
    np.testing.assert_array_equal(swapped[1][0]["rgba"], expected["rgba"][..., [1, 0, 2, 3]])
    for wrong in (2, -1):
        with pytest.raises(latelight.UsageError, match="indices in the list of materials"):
            worlds_renderer.render_worlds(2, camera, SIZE, instances=[red], materials=paints,
                                          material_choice=[[0], [wrong]])
    with pytest.raises(latelight.ArgumentTypeError, match="material_choice must be an array of"):
        worlds_renderer.render_worlds(2, camera, SIZE, instances=[red], materials=paints,
                                      material_choice=[[0.5], [0]])
    colors = np.array([[[0, 0, 0.5, 1]], [[1, 1, 0, 1]]])
    colored = worlds_renderer.render_worlds(2, camera, SIZE, OUTPUTS, instances=[red], base_color=colors)
    for world in range(2):
        paint = scene.material(paints[0])
        before, paint.base_color = paint.base_color, tuple(colors[world, 0])
        scene.set_material(paints[0], paint)
        frame = worlds_renderer.render(camera, SIZE, OUTPUTS)
        np.testing.assert_array_equal(colored[world][0]["rgba"], frame["rgba"])
        paint.base_color = before
        scene.set_material(paints[0], paint)


def test_lights_and_environment(camera):
    scene = latelight.Scene()
    square = scene.add_mesh(CORNERS, TRIANGLES)
    scene.add_instance(square, scene.add_material(latelight.Material(metallic=0)))
    lamp = scene.add_light(latelight.Light(position=(0, 0, 2), intensity=4))
    renderer = latelight.Renderer(scene, environment="studio")
    frames = renderer.render_worlds(
        2, camera, SIZE, "color", lights=[lamp], light_position=[[(0, 0, 2)], [(0.5, 0, 1)]],
        light_intensity=[[4], [2]], environment_intensity=[0, 1], environment_rotation=[0, 90],
    )
    for world, (position, intensity, options) in enumerate(
        [((0, 0, 2), 4, {"environment_intensity": 0}), ((0.5, 0, 1), 2, {"environment_rotation": 90})]
    ):
        scene.set_light(lamp, latelight.Light(position=position, intensity=intensity))
        expected = renderer.render(camera, SIZE, "color", **options)["color"]
        np.testing.assert_array_equal(frames[world][0]["color"], expected)


def test_lights_without_shadows(camera):
    scene = latelight.Scene()
    square = scene.add_mesh(CORNERS, TRIANGLES)
    scene.add_instance(square, scene.add_material(latelight.Material(metallic=0)))
    lights = [scene.add_light(latelight.Light(type=kind)) for kind in ("point", "spot", "directional")]
    renderer = latelight.Renderer(scene, environment="none")
    rng = np.random.default_rng(4)
    position = rng.uniform(-1, 1, (5, 3, 3)) + (0, 0, 2)
    direction = rng.uniform(-1, 1, (5, 3, 3)).astype(np.float32) - np.float32([0, 0, 1.5])
    direction[1, 0] = 0  # a point light has no direction
    color = rng.uniform(0, 1, (5, 3, 3)).astype(np.float32)
    intensity = rng.uniform(0, 4, (5, 3)).astype(np.float32)
    intensity[2, 1] = 0
    given = {"light_position": position, "light_direction": direction, "light_color": color,
             "light_intensity": intensity, "shadows": "none", "raster": "compute"}
    frames = renderer.render_worlds(5, camera, SIZE, "color", lights=lights, **given)
    for world in range(5):
        for i, light in enumerate(lights):
            value = scene.light(light)
            value.position, value.direction = tuple(position[world, i]), tuple(direction[world, i])
            value.color, value.intensity = tuple(color[world, i]), intensity[world, i]
            scene.set_light(light, value)
        expected = renderer.render(camera, SIZE, "color", shadows="none", raster="compute")["color"]
        assert expected[..., :3].max() > 0
        np.testing.assert_array_equal(frames[world][0]["color"], expected)
    with pytest.raises(latelight.UsageError, match="colors and intensities of lights must be at least 0"):
        renderer.render_worlds(5, camera, SIZE, lights=lights, **given | {"light_intensity": -intensity})
    direction[3, 1] = 0
    with pytest.raises(latelight.UsageError, match="direction of a light must .* one in world 3 "):
        renderer.render_worlds(5, camera, SIZE, lights=lights, **given | {"light_direction": direction})


def test_environments(scene, camera, tmp_path):
    names = ["studio", str(tmp_path / "red.hdr")]
    with open(names[1], "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + bytes([200, 20, 20, 129]) * 128)
    renderer = latelight.Renderer(scene, environment="none")
    frames = renderer.render_worlds(
        3, camera, SIZE, "color", environments=names, environment_index=np.int32([1, 0, 1]), background="hdri"
    )
    for world, index in enumerate((1, 0, 1)):
        alone = latelight.Renderer(scene, environment=names[index])
        expected = alone.render(camera, SIZE, "color", background="hdri")["color"]
        np.testing.assert_array_equal(frames[world][0]["color"], expected)
    for wrong in (2, -1):
        with pytest.raises(latelight.UsageError, match="indices in the list of environments"):
            renderer.render_worlds(1, camera, SIZE, environments=names, environment_index=[wrong])
    with pytest.raises(latelight.UsageError, match="require each other"):
        renderer.render_worlds(1, camera, SIZE, environments=names)
    with pytest.raises(latelight.InputError, match="nowhere.hdr"):
        renderer.render_worlds(1, camera, SIZE, environments="nowhere.hdr", environment_index=[0])


class Producer:
    """Shares an array through DLPack, the only protocol that it has."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, *, stream=None):
        return self.array.__dlpack__(stream=stream)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


@pytest.mark.parametrize("number", [np.float32, np.float64])
def test_arrays_of_any_producer_of_dlpack(camera, number):
    """Each array is replaced by a producer that shares its memory: the images and hits are the same."""
    light = latelight.Light(type="directional", direction=(0, 0, -1))
    made = latelight.Scene()
    square = made.add_mesh(CORNERS, TRIANGLES, normals=np.tile(np.float32([0, 0, 1]), (4, 1)))
    materials = [made.add_material(latelight.Material(base_color=(*color, 1))) for color in ((1, 0, 0), (0, 1, 0))]
    for x in (-1, 1):
        made.add_instance(square, materials[0], at(x))
    lists = {"instances": made.instances(), "materials": materials, "lights": [made.add_light(light)], "meshes": [square]}
    random = np.random.default_rng(3)
    arrays = {
        "transforms": np.array([[at(-1), at(1)], [at(0.5, 1), at(0.25, -1, 1)]], number),
        "exists": np.array([[True, True], [False, True]]),
        "base_color": random.uniform(0, 1, (2, 2, 4)).astype(number),
        "roughness": random.uniform(0, 1, (2, 2)).astype(number),
        "material_choice": np.array([[0, 1], [1, 1]], np.int32),
        "light_direction": random.normal(size=(2, 1, 3)).astype(number) - number([0, 0, 3]),
        "environment_intensity": np.array([0.5, 1], number),
        "vertices": np.array([CORNERS, 0.5 * CORNERS], number),
        "camera_to_world": np.array([[camera.camera_to_world], [at(0, 0.25) @ camera.camera_to_world]], number),
        "k": np.array([[camera.k(SIZE)]] * 2, number),
    }
    shared = {name: Producer(array) for name, array in arrays.items()}
    renderer = latelight.Renderer(made)
    expected = renderer.render_worlds(2, camera, SIZE, OUTPUTS, **lists, **arrays)
    frames = renderer.render_worlds(2, camera, SIZE, OUTPUTS, **lists, **shared)
    for name in OUTPUTS:
        np.testing.assert_array_equal(frames[name], expected[name])
    assert (expected["rgba"][0] != expected["rgba"][1]).any()
    rays = np.tile(number([[-1, 0.25, 4], [1, 0, 4]]), (2, 1, 1)), np.tile(number([0, 0, -1]), (2, 2, 1))
    for array in (arrays, shared):
        for name in ("camera_to_world", "k"):
            del array[name]
    hits = renderer.cast_worlds(2, *map(Producer, rays), **lists, **shared)
    for name, values in renderer.cast_worlds(2, *rays, **lists, **arrays).items():
        np.testing.assert_array_equal(hits[name], values)
    wrong = Producer(np.eye(4))
    with pytest.raises(latelight.UsageError, match=r"shape \(2, 2, 3 or 4, 4\), not \(4, 4\)"):
        renderer.render_worlds(2, camera, SIZE, instances=made.instances(), transforms=wrong)
    with pytest.raises(latelight.ArgumentTypeError, match="exists must be an array of bool, not of float64"):
        renderer.render_worlds(2, camera, SIZE, instances=made.instances(), exists=Producer(np.ones((2, 2))))


@pytest.mark.parametrize("raster, when", [("hardware", "submitted"), ("compute", "taken")])
def test_rejected_arrays_name_their_world(scene, worlds_renderer, camera, raster, when):
    """The host rejects arrays that it converts at once, and the device when the results are taken."""
    red, green = scene.instances()
    wrong_row = np.tile(np.eye(4), (3, 2, 1, 1))
    wrong_row[1, 0, 3] = 0, 0, 0, 2
    mirrored = np.tile(np.eye(4), (3, 2, 1, 1))
    mirrored[1, 1, 0, 0] = -1
    sheared = np.tile(np.eye(4), (3, 2, 1, 1))
    sheared[1, 1, 0, 1] = 0.5
    mirrored_poses = np.tile(camera.camera_to_world, (3, 1, 1, 1))
    mirrored_poses[1, 0, :3, 0] *= -1
    behind = np.tile(np.array([[20.0, 0, 12], [0, 20, 8], [0, 0, 1]]), (3, 1, 1, 1))
    behind[1, 0, 0, 0] = -20
    choices = {"instances": [red, green], "materials": scene.materials()[:2]}
    for arguments, sentence in (
        ({"instances": [red, green], "transforms": wrong_row}, "transform of an instance must have the last row"),
        ({"instances": [red, green], "transforms": mirrored, "camera_instances": [green]}, "rides on an instance"),
        ({"instances": [red, green], "transforms": sheared, "camera_instances": [green]}, "mirrors, shears"),
        ({"camera_to_world": mirrored_poses}, "camera's pose must be a rotation"),
        ({"k": behind}, "^a camera matrix k must have focal lengths above 0"),
        (choices | {"material_choice": np.int64([[0, 1], [1, 2], [0, 0]])}, "^material choices must be indices"),
        (choices | {"material_choice": np.uint64([[0, 1], [1, 2**63], [0, 0]])}, "^material choices must be indices"),
        ({"environments": ["studio"], "environment_index": [0, 1, 0]}, "^the environments of worlds must be indices"),
    ):
        tickets = []
        with pytest.raises(latelight.UsageError, match=sentence) as caught:
            tickets.append(worlds_renderer.submit_worlds(
                3, camera, SIZE, "depth", raster=raster, shadows="none", **arguments))
            tickets[0].take()
        assert "world 1" in str(caught.value)
        assert (when == "submitted") == (tickets == [])


@pytest.mark.parametrize(
    ("arguments", "error", "sentence"),
    [
        ({"transforms": np.zeros((3, 1, 4, 4))}, latelight.UsageError, "transforms must"),
        ({"transforms": np.zeros((2, 1, 2, 4))}, latelight.UsageError, "matrices of 3 or 4 rows, not of 2"),
        ({"transforms": "here"}, latelight.UsageError, "transforms must"),
        ({"exists": np.ones((2, 1))}, latelight.ArgumentTypeError, "exists must be an array of bool, not of float64"),
        ({"exists": np.ones((2, 2), bool)}, latelight.UsageError, "exists must"),
        ({"exists": np.ma.masked_array(np.ones((2, 1), bool), True)}, latelight.UsageError, "exists has masked values"),
        ({"camera_instances": [1]}, latelight.ArgumentTypeError, "an InstanceHandle or None"),
        ({"k": np.zeros((2, 1, 3, 3))}, latelight.UsageError, "last row 0 0 1"),
        ({"instances": None, "exists": np.ones((2, 1), bool)}, latelight.UsageError, "requires the list of instances"),
        ({"material_choice": [[0], [0]]}, latelight.UsageError, "require each other"),
        ({"roughness": [[0.5], [2]]}, latelight.UsageError, "roughness"),
        ({"material_choice": [[0.5], [0]], "materials": []}, latelight.UsageError, "require each other"),
        ({"metallic": np.zeros((2, 2))}, latelight.UsageError, "metallic must"),
        ({"base_color": -np.ones((2, 1, 4))}, latelight.UsageError, "at least 0"),
        ({"light_color": np.zeros((2, 1, 3))}, latelight.UsageError, "requires the list of lights"),
        ({"environment_intensity": [1, 2, 3]}, latelight.UsageError, "environment_intensity must"),
        ({"environment_intensity": [1, -2]}, latelight.UsageError, "at least 0"),
        ({"transfroms": 1}, latelight.ArgumentTypeError, "transfroms"),
        ({"transforms": np.zeros((2, 4, 4))}, latelight.UsageError, r"shape \(2, 1, 3 or 4, 4\), not \(2, 4, 4\)"),
        ({"camera_instances": [None, None]}, latelight.UsageError, "one value per camera, 1, not 2"),
        ({"environments": "none", "environment_index": [0, 0]}, latelight.UsageError, "^the environments of worlds"),
    ],
)
def test_wrong_arrays_are_refused(scene, worlds_renderer, camera, arguments, error, sentence):
    arguments = {"instances": scene.instances()[:1], **arguments}
    with pytest.raises(error, match=sentence):
        worlds_renderer.render_worlds(2, camera, SIZE, **arguments)


@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_messages_name_no_members_of_cplusplus(scene, worlds_renderer, camera, raster):
    first, red = scene.instances()[0], np.eye(4)[None, None]

    def refused(sentence, **arguments):
        with pytest.raises(latelight.UsageError, match=f"^{sentence}") as caught:
            worlds_renderer.render_worlds(1, camera, SIZE, **{"instances": [first]} | arguments, raster=raster)
        assert "::" not in str(caught.value)

    refused("the instances of worlds must be listed once each", instances=[first, first])
    meshes = scene.meshes()[:1] * 2
    refused("the meshes of worlds must be listed once each", meshes=meshes, vertices=np.zeros((1, 12, 3)))
    refused("the intensity of the environment must be at least 0, and that of world 0", environment_intensity=[-1])
    for name, shape in (("base_color", (4,)), ("metallic", ()), ("roughness", ()), ("emissive", (3,))):
        refused("factors of materials must be at least 0", **{name: -np.ones((1, 1, *shape))})
    refused("previous and next transforms of worlds require transforms", previous_transforms=red)


def cloth(size=9):
    """A flat square of size x size vertices in the plane z = 0, 2 m wide, and its triangles."""
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(-1, 1, size))
    positions = np.stack([x, y, 0 * x], -1).reshape(-1, 3).astype(np.float32)
    at = np.arange(size * size).reshape(size, size)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    return positions, np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)


@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_vertices_are_those_of_an_edited_mesh(camera, raster):
    rest, triangles = cloth()
    made, edited = latelight.Scene(), latelight.Scene()
    for each in (made, edited):
        mesh = each.add_mesh(rest, triangles, normals=np.tile(np.float32([0, 0, 1]), (len(rest), 1)))
        each.add_instance(mesh, each.add_material(latelight.Material(base_color=(0.2, 0.5, 0.8, 1), double_sided=True)))
        each.add_light(latelight.Light(position=(1, 2, 3), intensity=40))
    vertices = np.tile(rest, (4, 1, 1))
    for world, height in enumerate((0.1, 0.3, 0.5, 0.7)):
        vertices[world, :, 2] = height * np.sin(4 * rest[:, 0] + world) * rest[:, 1]
    renderer = latelight.Renderer(made)
    alone = latelight.Renderer(edited)
    outputs = (*OUTPUTS, "normal")
    options = {"raster": raster, "shadows": "none"}
    for given in (vertices, vertices.astype(np.float64)):
        frames = renderer.render_worlds(4, camera, SIZE, outputs, meshes=made.meshes(), vertices=given, **options)
        for world in range(4):
            # Zeros become the normals of the triangles around, weighted by their areas.
            edited.set_mesh(edited.meshes()[0], vertices[world], triangles, normals=0 * vertices[world])
            expected = alone.render(camera, SIZE, outputs, **options)
            for name in outputs:
                np.testing.assert_array_equal(frames[world][0][name], expected[name])
    vertices[2, 5, 1] = np.nan
    frames = renderer.render_worlds(4, camera, SIZE, "id", meshes=made.meshes(), vertices=vertices, **options)
    assert frames.invalid_worlds == (2,) and not frames[2][0]["id"].any()


def finger(path):
    """Writes a glTF file of a strip along +Y from 0 to 2, whose upper half follows a joint at y = 1."""
    import base64
    import json

    positions = np.float32([[x, y, 0] for y in (0, 1, 1, 2) for x in (-0.3, 0.3)])
    joints = np.uint8([[joint, 0, 0, 0] for joint in (0, 0, 0, 0, 1, 1, 1, 1)])
    weights = np.tile(np.float32([1, 0, 0, 0]), (8, 1))
    indices = np.uint16([0, 1, 2, 1, 3, 2, 4, 5, 6, 5, 7, 6])
    bind = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
    bind[1, 3, 1] = -1  # column by column
    data, views = b"", []
    for array in (positions, joints, weights, indices, bind):
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        data += array.tobytes()
    accessors = [
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8,
         "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
        {"bufferView": 1, "componentType": 5121, "type": "VEC4", "count": 8},
        {"bufferView": 2, "componentType": 5126, "type": "VEC4", "count": 8},
        {"bufferView": 3, "componentType": 5123, "type": "SCALAR", "count": 12},
        {"bufferView": 4, "componentType": 5126, "type": "MAT4", "count": 2},
    ]
    root = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [{"name": "knuckle", "children": [1]}, {"name": "tip", "translation": [0, 1, 0]},
                  {"name": "finger", "mesh": 0, "skin": 0}],
        "skins": [{"joints": [0, 1], "inverseBindMatrices": 4}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(data),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    }
    path.write_text(json.dumps(root))
    return str(path)


@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_joints_pose_a_skin(tmp_path, raster):
    """The tip is pulled away to the left, turned by 90 degrees, so its part of the strip lies along X."""
    scene = latelight.Scene(finger(tmp_path / "finger.gltf"))
    assert scene.joints(scene.instances()[0]) == ["/knuckle", "/knuckle/tip"]
    renderer = latelight.Renderer(scene)
    camera = latelight.Camera.look_at((0, 1, 6), (0, 1, 0))
    poses = np.tile(np.eye(4), (3, 2, 1, 1))
    poses[:, 1, 1, 3] = 1
    poses[1, 1, :3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    poses[2, 1, 0, 3] = np.nan
    options = {"raster": raster, "shadows": "none"}
    frames = renderer.render_worlds(3, camera, (64, 64), ("id", "position"), joints=["/knuckle", "/knuckle/tip"],
                                    joint_transforms=poses, **options)
    assert frames.invalid_worlds == (2,)
    straight, bent, none = frames["id"][:, 0] != 0
    np.testing.assert_array_equal(frames["id"][0, 0], renderer.render(camera, (64, 64), "id", **options)["id"])
    assert not none.any()
    position = frames["position"][1, 0]
    left = bent & (position[..., 0] < -0.4)  # the strip at rest ends at x = -0.3
    assert left.any() and not (straight & left).any()
    assert abs(position[left][:, 0].min() + 1) < 0.1 and np.abs(position[left][:, 1] - 1).max() < 0.31
    with pytest.raises(latelight.UsageError, match="the last row 0 0 0 1"):
        poses[2, 1] = 1
        renderer.render_worlds(3, camera, (64, 64), "id", joints=["/knuckle", "/knuckle/tip"], joint_transforms=poses,
                               **options)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"joints": ["/a"]}, "require each other"),
        ({"joints": ["/a"], "joint_transforms": np.zeros((2, 1, 4, 4))}, "no joint"),
        ({"vertices": np.zeros((2, 4, 3))}, "require each other"),
        ({"previous_vertices": np.zeros((2, 4, 3))}, "list of meshes"),
        ({"meshes": "all", "vertices": np.zeros((2, 5, 3))}, "vertices must be"),
    ],
)
def test_wrong_deformations_are_refused(scene, worlds_renderer, camera, arguments, sentence):
    arguments = {key: scene.meshes() if isinstance(value, str) else value for key, value in arguments.items()}
    with pytest.raises(latelight.UsageError, match=sentence):
        worlds_renderer.render_worlds(2, camera, SIZE, **arguments)


def test_cast_rays_through_worlds(scene, worlds_renderer):
    """Rays along -Z at the red square, which worlds move and remove: distances in closed form."""
    red = scene.instances()[0]
    transforms = np.array([[at(-1)], [at(-1, 0, 1.5)], [at(-1)], [at(-1, np.nan)]])
    exists = np.array([[True], [True], [False], [True]])
    origins = np.tile([[-1.0, 0.25, 4], [-1, 5, 4]], (4, 1, 1))
    directions = np.broadcast_to([0.0, 0, -3], origins.shape)
    given = {"instances": [red], "transforms": transforms, "exists": exists}
    for dtype in (np.float64, np.float32):
        rays = origins.astype(dtype), directions.astype(dtype)
        hits = worlds_renderer.cast_worlds(4, *rays, **given)
        np.testing.assert_allclose(hits["distance"], [[4, np.inf], [2.5, np.inf], [np.inf] * 2, [np.inf] * 2], rtol=1e-6)
        assert hits["distance"].shape == (4, 2) and hits["position"].shape == (4, 2, 3) and hits["uv"].shape == (4, 2, 2)
        np.testing.assert_array_equal(hits["id"][:2, 0], scene.instance(red).id)
        np.testing.assert_array_equal(hits["normal"][:2, 0], [[0, 0, 1]] * 2)
    placed = worlds_renderer.cast_worlds(4, *rays, outputs="distance", on_device=True, **given)
    assert list(placed) == ["distance"] and placed["distance"].shape == (4, 2)
    given["transforms"] = transforms + np.array(at(0, 0, 0.5)) - np.eye(4)
    again = worlds_renderer.cast_worlds(4, *rays, out=placed, on_device=True, **given)
    if again["distance"].device == "cpu":
        np.testing.assert_allclose(placed["distance"].numpy()[:2, 0], [3.5, 2], rtol=1e-6)
    flat = worlds_renderer.cast(origins[0], directions[0], on_device=True, outputs=("distance", "id"))
    assert flat["distance"].shape == (2,) and flat["id"].dtype == "uint32"


def moved_rays(scene, seed):
    """Random rays through three worlds, in which both squares are elsewhere or absent."""
    random = np.random.default_rng(seed)
    transforms = np.tile(np.eye(4), (3, 2, 1, 1))
    transforms[:, :, :3, 3] = random.uniform(-1, 1, (3, 2, 3))
    arrays = {"instances": scene.instances(), "transforms": transforms, "exists": random.uniform(size=(3, 2)) > 0.2}
    origins, directions = random.uniform(-0.5, 0.5, (3, 400, 3)) + [0, 0, 4], random.normal(size=(3, 400, 3))
    return origins, directions - [0, 0, 3], arrays


@pytest.mark.parametrize("on_device", [False, True])
def test_tickets_of_rays_through_worlds(scene, worlds_renderer, camera, on_device):
    """Three calls in flight have the hits of the same calls one after the other, in whatever order they are taken."""

    def read(hits):
        return {name: np.array(array.numpy() if on_device else array) for name, array in hits.items()}

    if on_device and worlds_renderer.cast_worlds(1, *np.ones((2, 1, 1, 3)), on_device=True)["id"].device != "cpu":
        pytest.skip("NumPy reads the arrays of CPU devices; tests/gpu/world_rays.py reads others")
    calls = [moved_rays(scene, seed) for seed in range(4)]
    expected = [read(worlds_renderer.cast_worlds(3, *rays, on_device=on_device, **arrays))
                for *rays, arrays in calls]
    tickets = []
    for origins, directions, arrays in calls:
        tickets.append(worlds_renderer.submit_cast_worlds(3, origins, directions, on_device=on_device, **arrays))
        for array in (origins, directions, arrays["transforms"]):
            array[:] = np.nan  # they were copied
        arrays["exists"][:] = False
    picture = worlds_renderer.submit(camera, SIZE, "id")
    del tickets[1]
    for index in (2, 0, 1):
        hits, call = read(tickets[index].take()), (0, 2, 3)[index]
        assert tickets[index].done and len(hits) == 10
        for name, array in hits.items():
            assert array.tobytes() == expected[call][name].tobytes(), name
        hit = np.isfinite(hits["distance"])
        assert 0 < hit.mean() < 1
    assert len({array["distance"].tobytes() for array in expected}) == 4
    np.testing.assert_array_equal(picture.take()["id"], worlds_renderer.render(camera, SIZE, "id")["id"])
    with pytest.raises(latelight.UsageError, match="taken already"):
        tickets[0].take()


def test_calls_in_flight_may_differ_in_everything(scene, device):
    """Other numbers of worlds and rays, other arrays, edits in between, types and places of the hits."""
    renderer, alone = (latelight.Renderer(scene, device, environment="none") for _ in range(2))
    red, green = scene.instances()
    square, before, calls = scene.instance(red).mesh, scene.instance(red).transform, []
    rest = scene.mesh_arrays(square)["positions"]
    for turn, seed in enumerate(range(20, 32)):
        random = np.random.default_rng(seed)
        count, rays, dtype = 1 + turn % 4, 50 * (1 + turn % 3), (np.float64, np.float32)[turn % 2]
        origins = (random.uniform(-1, 1, (count, rays, 3)) + [0, 0, 4]).astype(dtype)
        directions = (random.normal(size=origins.shape) - [0, 0, 3]).astype(dtype)
        moved = np.tile(np.eye(4), (count, 1, 1, 1))
        moved[:, 0, :3, 3] = random.uniform(-1, 1, (count, 3))
        vertices = rest + random.uniform(-0.5, 0.5, (count, *rest.shape)).astype(np.float32)
        arrays = (
            {"instances": [green], "transforms": moved},
            {"meshes": [square], "vertices": vertices},
            {"instances": [red], "exists": random.uniform(size=(count, 1)) > 0.5},
            {},
            {"instances": [red], "materials": scene.materials(), "material_choice": random.integers(0, 2, (count, 1))},
        )[turn % 5]
        calls.append((count, origins, directions, arrays, ("distance", ("distance", "id", "material"))[turn % 2]))
    tickets, expected = [], []
    for turn, (count, *rays, arrays, outputs) in enumerate(calls):
        scene.set_transform(red, at(-1 + 0.05 * turn))
        expected.append(alone.cast_worlds(count, *rays, outputs=outputs, **arrays))
        tickets.append(renderer.submit_cast_worlds(count, *rays, outputs=outputs, on_device=turn % 3 == 0, **arrays))
        if turn % 4 == 3:
            tickets.append(renderer.submit_cast(rays[0][0], rays[1][0], outputs=outputs))
            expected.append(alone.cast(rays[0][0], rays[1][0], outputs=outputs))
    scene.set_transform(red, before)
    for index in np.random.default_rng(1).permutation(len(tickets)):
        hits = tickets[index].take()
        assert hits.keys() == expected[index].keys()
        for name, array in hits.items():
            if isinstance(array, latelight.DeviceArray):
                array = array.numpy() if array.device == "cpu" else expected[index][name]
            assert array.tobytes() == expected[index][name].tobytes(), (index, name)
    assert sum(np.isfinite(hits["distance"]).sum() for hits in expected) > 500
    assert renderer.validation_messages() == []


def test_tickets_of_rays_store_hits_in_arrays_of_the_caller(scene, worlds_renderer):
    origins, directions, arrays = moved_rays(scene, 5)
    outs = [worlds_renderer.cast_worlds(3, origins, directions, outputs=("id", "position"), **arrays) for _ in range(2)]
    calls = [moved_rays(scene, seed) for seed in (6, 7)]
    expected = [worlds_renderer.cast_worlds(3, *rays, outputs=("id", "position"), **given) for *rays, given in calls]
    tickets = [worlds_renderer.submit_cast_worlds(3, *rays, out=out, **given)
               for out, (*rays, given) in zip(outs, calls)]
    for out, ticket, hits in reversed([*zip(outs, tickets, expected)]):
        taken = ticket.take()
        for name, array in hits.items():
            assert taken[name] is out[name] and array.tobytes() == out[name].tobytes()
    for wrong in (np.zeros((3, 399), np.uint32), np.zeros((400, 3), np.uint32), np.zeros((3, 400), np.int64)):
        with pytest.raises(latelight.UsageError, match=r"contiguous array of uint32 of shape \(3, 400\)"):
            worlds_renderer.submit_cast_worlds(3, origins, directions, out={"id": wrong}, **arrays)
    placed = worlds_renderer.cast_worlds(3, origins, directions, outputs="id", on_device=True, **arrays)
    with pytest.raises(latelight.UsageError, match="out requires on_device=True"):
        worlds_renderer.cast_worlds(3, origins, directions, out=placed, **arrays)


def test_tickets_of_rays_store_hits_in_out(scene, worlds_renderer):
    origins, directions, arrays = moved_rays(scene, 5)
    outs = [worlds_renderer.cast_worlds(3, origins, directions, outputs=("id", "distance"), on_device=True, **arrays)
            for _ in range(2)]
    if outs[0]["id"].device != "cpu":
        pytest.skip("NumPy reads the arrays of CPU devices")
    calls, tickets = [moved_rays(scene, seed) for seed in (6, 7)], []
    for out, (*rays, given) in zip(outs, calls):
        tickets.append(worlds_renderer.submit_cast_worlds(3, *rays, out=out, on_device=True, **given))
    for out, ticket in zip(outs, tickets):
        for name, array in ticket.take().items():
            assert array.numpy().ctypes.data == out[name].numpy().ctypes.data
    for out, (*rays, given) in zip(outs, calls):
        expected = worlds_renderer.cast_worlds(3, *rays, outputs=("id", "distance"), **given)
        for name, array in expected.items():
            np.testing.assert_array_equal(out[name].numpy(), array)


def test_tickets_of_rays_outlive_their_renderer(scene, device):
    renderer = latelight.Renderer(scene, device, environment="none")
    origins, directions, arrays = moved_rays(scene, 8)
    expected = renderer.cast_worlds(3, origins, directions, outputs="distance", **arrays)["distance"]
    tickets = [renderer.submit_cast_worlds(3, origins, directions, outputs="distance", **arrays),
               renderer.submit_cast(origins[0], directions[0], outputs="distance")]
    flat = renderer.cast(origins[0], directions[0], outputs="distance")["distance"]
    del renderer
    np.testing.assert_array_equal(tickets[0].take()["distance"], expected)
    np.testing.assert_array_equal(tickets[1].take()["distance"], flat)


def test_wrong_transforms_are_reported_when_hits_are_taken(scene, worlds_renderer):
    origins, directions, arrays = moved_rays(scene, 9)
    arrays["transforms"][1, 0, 3] = 0, 0, 0, 2
    ticket = worlds_renderer.submit_cast_worlds(3, origins, directions, **arrays)
    with pytest.raises(latelight.UsageError, match="last row 0 0 0 1, and one of world 1 has another") as raised:
        ticket.take()
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"origins": np.zeros((3, 1, 3))}, "origins"),
        ({"directions": np.zeros((2, 2, 3))}, "directions"),
        ({"directions": np.zeros((2, 1, 3), np.float32)}, "the same type, float32 or float64"),
        ({"max_distance": -1}, "at least 0, not -1"),
        ({"outputs": "color"}, "no output"),
        ({"out": {}, "on_device": 1}, "on_device"),
        ({"normal_frame": "opencv"}, "normal_frame world"),
    ],
)
def test_cast_worlds_rejects_wrong_arguments(worlds_renderer, wrong, message):
    rays = {"origins": np.zeros((2, 1, 3)), "directions": np.ones((2, 1, 3))}
    for cast in (worlds_renderer.cast_worlds, worlds_renderer.submit_cast_worlds):
        with pytest.raises((latelight.UsageError, TypeError), match=message) as raised:
            cast(2, **{**rays, **wrong})
        assert "\n" not in str(raised.value)
