"""Scenes from arrays, read back, and edited between frames."""

import os

import numpy as np
import pytest

import latelight

SIZE = (16, 16)
FRONT = latelight.Camera.look_at((0, 0, 2), (0, 0, 0), vertical_fov=np.degrees(2 * np.arctan(0.5)))


@pytest.fixture
def wall(square):
    """An instance of the square that fills the picture of FRONT."""
    scene = latelight.Scene()
    material = scene.add_material(latelight.Material(name="paint", base_color=(0.5, 0.25, 1, 1), roughness=1))
    instance = scene.add_instance(scene.add_mesh(**square, name="wall"), material)
    return scene, instance, material


def test_a_mesh_shows_where_it_is(wall, device):
    scene, instance, material = wall
    frame = latelight.Renderer(scene, device).render(FRONT, SIZE, ("depth", "albedo", "normal", "id", "material"))
    np.testing.assert_allclose(frame["depth"], 2, rtol=1e-5)
    np.testing.assert_allclose(frame["albedo"], np.tile((0.5, 0.25, 1), (16, 16, 1)), atol=1e-3)
    np.testing.assert_allclose(frame["normal"], np.tile((0, 0, 1), (16, 16, 1)), atol=1e-3)
    assert (frame["id"] == scene.instance(instance).id).all()
    assert (frame["material"] == scene.material(material).id).all()
    assert scene.id_manifest()["ids"][str(scene.instance(instance).id)]["node"] == "/wall"


def test_edits_show_in_the_next_frame(wall, device):
    scene, instance, material = wall
    renderer = latelight.Renderer(scene, device)
    renderer.render(FRONT, SIZE, "depth")
    transform = np.eye(4)
    transform[2, 3] = -1
    scene.set_transform(instance, transform)
    np.testing.assert_allclose(renderer.render(FRONT, SIZE, "depth")["depth"][8, 8], 3, rtol=1e-5)
    np.testing.assert_array_equal(scene.instance(instance).transform, transform)
    paint = scene.material(material)
    paint.base_color = (0, 1, 0, 1)
    scene.set_material(material, paint)
    np.testing.assert_allclose(renderer.render(FRONT, SIZE, "albedo")["albedo"][8, 8], (0, 1, 0), atol=1e-3)
    scene.remove_instance(instance)
    assert np.isinf(renderer.render(FRONT, SIZE, "depth")["depth"]).all()
    with pytest.raises(latelight.UsageError, match="removed"):
        scene.instance(instance)


def test_textures_texel_by_texel(wall, device):
    scene, _, material = wall
    scene.set_material(material, latelight.Material(base_color=(1, 1, 1, 1)))
    pixels = np.random.default_rng(1).integers(0, 256, (16, 16, 3), np.uint8)
    texture = scene.add_texture(pixels, srgb=False, name="noise")
    scene.set_texture(material, "base_color", texture, smooth=False, wrap="clamp")
    albedo = latelight.Renderer(scene, device).render(FRONT, SIZE, "albedo")["albedo"]
    np.testing.assert_allclose(albedo * 255, pixels, atol=0.2)
    np.testing.assert_array_equal(scene.texture_pixels(texture)[..., :3], pixels)
    assert scene.texture_of(material, "base_color") == texture
    assert scene.texture_of(material, "normal") is None


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_textures_of_any_number_of_channels(channels):
    pixels = np.arange(2 * 3 * channels, dtype=np.uint8).reshape(2, 3, channels)
    scene = latelight.Scene()
    read = scene.texture_pixels(scene.add_texture(pixels))
    grey = channels < 3
    np.testing.assert_array_equal(read[..., :3], np.repeat(pixels[..., :1], 3, -1) if grey else pixels[..., :3])
    np.testing.assert_array_equal(read[..., 3], pixels[..., -1] if channels in (2, 4) else np.full((2, 3), 255))


def test_lights_fall_off_with_the_square_of_distance(square, device):
    scene = latelight.Scene()
    material = scene.add_material(latelight.Material(base_color=(1, 1, 1, 1), metallic=0, roughness=1, specular=0))
    scene.add_instance(scene.add_mesh(**square), material)
    light = scene.add_light(latelight.Light(position=(0, 0, 1), intensity=np.pi))
    renderer = latelight.Renderer(scene, device, environment="none")
    center = lambda: renderer.render(FRONT, (15, 15), "color", shadows="none")["color"][7, 7, 0]
    assert center() == pytest.approx(1, rel=2e-3)  # albedo / pi times pi candela at one metre
    moved = scene.light(light)
    moved.position = (0, 0, 2)
    scene.set_light(light, moved)
    assert center() == pytest.approx(0.25, rel=2e-3)
    scene.remove_light(light)
    assert scene.lights() == []
    assert center() == 0


@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_area_lights_have_the_form_factors_of_their_shapes(square, device, raster):
    scene = latelight.Scene()
    material = scene.add_material(latelight.Material(base_color=(1, 1, 1, 1), metallic=0, roughness=1, specular=0))
    scene.add_instance(scene.add_mesh(**square), material)
    renderer = latelight.Renderer(scene, device, environment="none")
    center = lambda: renderer.render(FRONT, (15, 15), "color", raster=raster)["color"][7, 7, 0]
    side = np.sqrt(2) / 2  # of a square of half side 1 at distance 1, seen from below its center
    for values, expected in (
        (dict(type="rect", width=2, height=2), 8 / (2 * np.pi) * side * np.arctan(side)),
        (dict(type="disk", size=0.5), 0.25 / 1.25),
        (dict(type="sphere", size=0.5), 0.25),
        (dict(type="tube", size=0.3, length=1e4), 0.3),
    ):
        light = scene.add_light(latelight.Light(position=(0, 0, 1), direction=(0, 0, -1), intensity=2, **values))
        assert center() == pytest.approx(2 * expected, rel=2e-3), values
        if values["type"] == "rect":
            back = scene.light(light)
            assert (back.width, back.height, back.two_sided) == (2, 2, False)
            back.direction = (0, 0, 1)
            scene.set_light(light, back)
            assert center() == 0
        scene.remove_light(light)


def test_an_environment_of_pixels(device):
    scene = latelight.Scene()
    sky = np.full((8, 16, 3), (0.5, 1, 2), np.float32)
    color = latelight.Renderer(scene, device, sky).render(FRONT, SIZE, "color", background="hdri")["color"]
    np.testing.assert_allclose(color[..., :3], np.tile((0.5, 1, 2), (16, 16, 1)))


def test_meshes_are_read_back(wall, square):
    scene, instance, _ = wall
    mesh = scene.instance(instance).mesh
    arrays = scene.mesh_arrays(mesh)
    for name, values in square.items():
        np.testing.assert_array_equal(arrays[name], values)
    assert (scene.mesh(mesh).name, scene.mesh(mesh).vertices, scene.mesh(mesh).triangles) == ("wall", 4, 2)
    assert scene.mesh(mesh).bounds == ((-1, -1, 0), (1, 1, 0))
    scene.set_mesh(mesh, arrays["positions"] * 2, arrays["indices"])
    assert scene.mesh(mesh).bounds == ((-2, -2, 0), (2, 2, 0))


def test_bounds_are_those_of_vertices():
    """An octahedron's corners on the axes, turned by 45 degrees, reach 1 / sqrt(2); its box would reach sqrt(2)."""
    corners = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32)
    scene = latelight.Scene()
    assert scene.bounds is None
    mesh = scene.add_mesh(corners, [[0, 1, 2], [3, 4, 5]])
    turned = np.eye(4)
    turned[:2, :2] = np.array([(1, -1), (1, 1)]) / np.sqrt(2)
    turned[:3, 3] = 10, 20, 30
    handle = scene.add_instance(mesh, scene.add_material(latelight.Material()), turned)
    half = np.array([np.sqrt(0.5), np.sqrt(0.5), 1])
    np.testing.assert_allclose(scene.bounds, (turned[:3, 3] - half, turned[:3, 3] + half), rtol=1e-12)
    scene.set_transform(handle, np.eye(4))
    assert scene.bounds == ((-1, -1, -1), (1, 1, 1))


def test_a_file_is_read_back(model):
    scene = latelight.Scene(model("Fox.glb"))
    assert [animation.name for animation in scene.animations] == ["Survey", "Walk", "Run"]
    paths = {node.path for node in scene.nodes}
    assert all(node.parent in paths or node.parent == "" for node in scene.nodes)
    instance = scene.instance(scene.instances()[0])
    arrays = scene.mesh_arrays(instance.mesh)
    low, high = np.array(scene.bounds)
    assert arrays["positions"].shape == (scene.mesh(instance.mesh).vertices, 3)
    placed = np.c_[arrays["positions"], np.ones(len(arrays["positions"]))] @ instance.transform.T
    np.testing.assert_allclose(placed[:, :3].min(0), low, rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(placed[:, :3].max(0), high, rtol=1e-4, atol=1e-3)
    texture = scene.texture_of(instance.material, "base_color")
    assert scene.texture_pixels(texture).shape == (scene.texture(texture).height, scene.texture(texture).width, 4)


def test_handles_are_values(wall):
    scene, instance, material = wall
    assert instance == scene.instances()[0] and instance == scene.instances("/wall")[0]
    assert {instance: 1}[scene.instances()[0]] == 1
    assert instance != material
    other = latelight.Scene()
    with pytest.raises(latelight.UsageError, match="another scene"):
        other.set_transform(instance, np.eye(4))


def test_materials_and_lights_come_back_as_they_were(wall):
    scene, _, _ = wall
    values = dict(
        name="glass", base_color=(0.1, 0.2, 0.3, 0.4), metallic=0.5, roughness=0.25, emissive=(1, 2, 3),
        alpha_mode="blend", double_sided=True, f0=0.08,
    )
    read = scene.material(scene.add_material(latelight.Material(**values)))
    for name, value in values.items():
        assert getattr(read, name) == (pytest.approx(value) if not isinstance(value, str) else value), name
    light = latelight.Light(name="lamp", type="spot", position=(1, 2, 3), direction=(0, -1, 0), range=5.0, cast_shadow=False)
    back = scene.light(scene.add_light(light))
    assert (back.type, back.range, back.cast_shadow, back.name) == ("spot", 5.0, False, "lamp")
    assert back.position == pytest.approx((1, 2, 3)) and back.direction == pytest.approx((0, -1, 0))


def test_what_is_used_is_not_removed(wall):
    scene, instance, material = wall
    mesh = scene.instance(instance).mesh
    texture = scene.add_texture(np.zeros((2, 2, 3), np.uint8), name="black")
    scene.set_texture(material, "base_color", texture)
    for words, call in (
        ('the mesh "wall" cannot be removed, since the instance /wall shows it', lambda: scene.remove_mesh(mesh)),
        ('the material "paint" cannot be removed, since the instance /wall', lambda: scene.remove_material(material)),
        ('the texture "black" cannot be removed, since the material "paint"', lambda: scene.remove_texture(texture)),
    ):
        with pytest.raises(latelight.UsageError, match=words):
            call()
    scene.remove_instance(instance)
    scene.remove_mesh(mesh)
    scene.remove_material(material)
    scene.remove_texture(texture)
    assert scene.meshes() == scene.materials() == scene.textures() == []
    for call in (lambda: scene.mesh(mesh), lambda: scene.material(material), lambda: scene.texture(texture)):
        with pytest.raises(latelight.UsageError, match="removed"):
            call()


def test_pixels_are_replaced(wall, device):
    scene, _, material = wall
    scene.set_material(material, latelight.Material(base_color=(1, 1, 1, 1)))
    texture = scene.add_texture(np.full((4, 4, 3), 255, np.uint8), srgb=False, name="screen")
    scene.set_texture(material, "base_color", texture)
    renderer = latelight.Renderer(scene, device)
    for height, width, value in ((4, 4, 51), (8, 2, 102), (3, 5, 204)):
        scene.set_texture_pixels(texture, np.full((height, width, 1), value, np.uint8))
        read = scene.texture(texture)
        assert (read.width, read.height, read.srgb, read.name) == (width, height, False, "screen")
        albedo = renderer.render(FRONT, SIZE, "albedo")["albedo"]
        np.testing.assert_allclose(albedo, np.full((16, 16, 3), value / 255), atol=2e-3)
    scene.set_texture_pixels(texture, np.full((2, 2, 3), 188, np.uint8), srgb=True, name="film")
    assert scene.texture(texture).srgb and scene.texture(texture).name == "film"
    linear = ((188 / 255 + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(renderer.render(FRONT, SIZE, "albedo")["albedo"][8, 8], [linear] * 3, atol=2e-3)
    with pytest.raises(latelight.UsageError, match="pixels must be an array of uint8, not float64"):
        scene.set_texture_pixels(texture, np.zeros((2, 2, 3)))


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


@pytest.mark.parametrize("way", ["removed", "replaced"])
def test_a_texture_per_frame_takes_no_memory(wall, device, way):
    """A texture of 512 x 512 and its levels are 1.4 MB on the host and as much on the device."""
    scene, _, material = wall
    renderer = latelight.Renderer(scene, device)
    texture = scene.add_texture(np.zeros((512, 512, 3), np.uint8))
    after = []
    for step in range(150):
        pixels = np.full((512, 512, 3), step, np.uint8)
        if way == "replaced":
            scene.set_texture_pixels(texture, pixels)
            scene.set_texture(material, "base_color", texture)
        else:
            added = scene.add_texture(pixels)
            scene.set_texture(material, "base_color", added)
            scene.remove_texture(texture)
            texture = added
        renderer.render(FRONT, (8, 8), "albedo")
        after.append(resident_bytes())
    assert len(scene.textures()) == 1
    assert after[-1] - after[49] < 50e6  # of 280 MB


def test_mesh_files_have_the_given_unit_and_axes(tmp_path):
    path = tmp_path / "square.obj"
    path.write_text("v 0 0 0\nv 100 0 0\nv 100 200 0\nv 0 200 0\nf 1 2 3 4\n")
    np.testing.assert_allclose(latelight.Scene(path).bounds, ((0, 0, 0), (100, 200, 0)))
    scene = latelight.Scene(path, unit="cm", up_axis="z")
    np.testing.assert_allclose(scene.bounds, ((0, 0, 0), (1, 2, 0)), atol=1e-12)
    with pytest.raises(latelight.UsageError, match="mm, cm, m, in or ft"):
        latelight.Scene(path, unit="yard")
    with pytest.raises(latelight.UsageError, match="--unit"):
        latelight.Scene("builtin:boxes", unit="mm")
    with pytest.raises(latelight.InputError, match="line 1"):
        path.write_text("f 1 2 3\n")
        latelight.Scene(path)


def test_points_are_spheres(tmp_path):
    path = tmp_path / "cloud.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        "0 0 0\n1 2 3\n"
    )
    assert latelight.Scene(path, point_radius=0.5).triangle_count == 40  # two icosahedra
    with pytest.raises(latelight.InputError, match="--point-radius"):
        latelight.Scene(path)


def test_exported_scenes_have_their_edits(wall, tmp_path):
    scene, instance, material = wall
    transform = np.eye(4)
    transform[:3, 3] = (1, 2, 3)
    scene.set_transform(instance, transform)
    scene.export(tmp_path / "wall.glb")
    again = latelight.Scene(tmp_path / "wall.glb")
    (same,) = again.instances()
    np.testing.assert_array_equal(again.instance(same).transform, transform)
    assert again.instance(same).id == scene.instance(instance).id
    assert again.material(again.materials()[0]).base_color == scene.material(material).base_color
    with pytest.raises(latelight.UsageError, match=".glb, .obj or .ply"):
        scene.export(tmp_path / "wall.fbx")


def test_names_of_old_files_are_text(tmp_path):
    """The names are in Latin-1."""
    path = tmp_path / "map.obj"
    path.write_bytes(b"o B\xe6k\nusemtl f\xf8\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = latelight.Scene(path)
    assert [node.path for node in scene.nodes] == ["/map", "/map/Bæk"]
    (instance,) = (scene.instance(handle) for handle in scene.instances())
    assert scene.material(instance.material).name == "fø"
    assert scene.mesh(instance.mesh).name == "Bæk"
    assert {entry["node"] for entry in scene.id_manifest()["ids"].values()} == {"/map", "/map/Bæk"}
