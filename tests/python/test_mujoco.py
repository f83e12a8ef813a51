"""Scenes from MuJoCo models, compared with MuJoCo's own rays and camera geometry; worlds; Gymnasium."""

import contextlib
import sys
import types

import numpy as np
import pytest

import latelight

mujoco = pytest.importorskip("mujoco")

SIZE = (160, 120)
MODEL = """<mujoco>
<asset>
  <texture name="checker" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="64" height="64"/>
  <material name="floor" texture="checker" texrepeat="2 2" texuniform="false"/>
  <material name="steel" rgba="0.5 0.6 0.7 1" shininess="0.8" metallic="0.25" roughness="0.75"/>
  <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
  <hfield name="hill" nrow="3" ncol="5" size="1 0.7 0.4 0.1" elevation="0 0 0 0 0  0 1 2 1 0  0 0 0 0 0"/>
</asset>
<worldbody>
  <light name="sun" type="directional" dir="0.2 0.3 -1" diffuse="1 1 1"/>
  <light name="lamp" pos="0 0 3" diffuse="0.5 0.5 0.5" cutoff="30" dir="0 0 -1"/>
  <geom name="ground" type="plane" size="3 2 0.1" material="floor"/>
  <body name="ball" pos="0 0 0.5"><freejoint/><geom name="ball" type="sphere" size="0.3" rgba="1 0 0 1"/></body>
  <body pos="1 0 0.5" euler="0 30 0"><joint name="hinge" type="hinge" axis="0 1 0"/>
    <geom name="limb" type="capsule" size="0.15 0.4" material="steel"/>
    <geom name="tool" type="box" size="0.1 0.2 0.3" pos="0 0 0.8"/></body>
  <geom name="egg" type="ellipsoid" size="0.2 0.3 0.4" pos="-1 0 0.4" rgba="0 1 0 1"/>
  <geom name="can" type="cylinder" size="0.2 0.3" pos="-1 1 0.3" euler="20 0 0" rgba="0 0 1 1"/>
  <geom name="stone" type="mesh" mesh="wedge" pos="0 1 0" rgba="1 1 0 1"/>
  <geom name="land" type="hfield" hfield="hill" pos="0 -1.2 0.05" rgba="0.3 0.7 0.3 1"/>
  <geom name="ghost" type="box" size="1 1 1" group="3"/>
  <geom name="glass" type="box" size="0.1 0.1 0.1" pos="2 1 0.1" rgba="1 1 1 0.5"/>
  <camera name="eye" pos="0 -4 2.5" xyaxes="1 0 0 0 0.5 0.85" fovy="50"/>
  <camera name="side" pos="4 0.5 1" xyaxes="0 1 0 -0.2 0 1" fovy="70"/>
</worldbody></mujoco>"""


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(MODEL)


@pytest.fixture(scope="module")
def robot(model):
    return latelight.from_mujoco(model)


@pytest.fixture(scope="module")
def robot_renderer(robot):
    return latelight.Renderer(robot.scene, device="cpu")


def data_at(model, hinge, height):
    data = mujoco.MjData(model)
    data.joint("hinge").qpos[0] = hinge
    data.qpos[2] = height
    mujoco.mj_forward(model, data)
    return data


def rays(model, data, camera, pixels):
    """The geom and the depth that MuJoCo's rays find at pixel centers; -1 and infinity for nothing."""
    focal = 0.5 * SIZE[1] / np.tan(np.radians(model.cam_fovy[camera]) / 2)
    matrix, eye = data.cam_xmat[camera].reshape(3, 3), data.cam_xpos[camera]
    geoms, depths = [], []
    for x, y in pixels:
        along = np.array([(x + 0.5 - SIZE[0] / 2) / focal, -(y + 0.5 - SIZE[1] / 2) / focal, -1.0])
        length, geom = np.linalg.norm(along), np.full(1, -1, np.int32)
        shown = np.array([1, 1, 1, 0, 0, 0], np.uint8)
        distance = mujoco.mj_ray(model, data, eye, matrix @ along / length, shown, 1, -1, geom, None)
        geoms.append(geom[0] if distance >= 0 else -1)
        depths.append(distance / length if distance >= 0 else np.inf)
    return np.array(geoms), np.array(depths)


def test_worlds_show_what_rays_of_mujoco_find(model, robot, robot_renderer):
    states = [data_at(model, 0, 0.5), data_at(model, 0.6, 1.1), data_at(model, -0.8, 0.3)]
    frames = robot_renderer.render_worlds(
        3, robot.cameras, SIZE, ("depth", "id"), data_surfaces="any", shadows="none", **robot.worlds(states)
    )
    rng = np.random.default_rng(0)
    pixels = np.stack([rng.integers(0, length, 400) for length in SIZE], 1)
    geom_of = {robot.scene.instance(i).id: geom for i, geom in zip(robot.instances, robot.geoms)} | {0: -1}
    for world, data in enumerate(states):
        for camera in range(2):
            geoms, depths = rays(model, data, camera, pixels)
            frame = frames[world][camera]
            seen = np.array([geom_of[i] for i in frame["id"][pixels[:, 1], pixels[:, 0]]])
            same = seen == geoms
            assert same.mean() > 0.985, "only pixels on the outlines of round shapes differ"
            hit = same & (geoms >= 0)
            assert len(set(geoms[hit])) >= 7
            np.testing.assert_allclose(
                frame["depth"][pixels[:, 1], pixels[:, 0]][hit], depths[hit], rtol=5e-3, err_msg=f"{world} {camera}"
            )


class FakeTensor(np.ndarray):
    """An array that the conversion takes for one of torch, whose device reports the copies to it."""

    device = "cuda:0"


def test_worlds_of_tensors_copy_constants_once(model, robot, monkeypatch):
    """A copy from the host waits for the device, so steady calls make none."""
    FakeTensor.__module__ = "torch"
    copies = []

    def tensor(values, device, dtype):
        copies.append(values)
        return np.array(values, dtype).view(FakeTensor)

    torch = types.ModuleType("torch")
    torch.tensor, torch.int64, torch.concatenate = tensor, np.int64, np.concatenate
    torch.inference_mode = lambda mode: contextlib.nullcontext()
    monkeypatch.setitem(sys.modules, "torch", torch)
    rng = np.random.default_rng(0)
    positions, axes = rng.normal(size=(2, model.ngeom, 3)), rng.normal(size=(2, model.ngeom, 3, 3))
    expected = robot.worlds(geom_xpos=positions, geom_xmat=axes)["transforms"]
    for call in range(2):
        copies.clear()
        found = robot.worlds(geom_xpos=positions.view(FakeTensor), geom_xmat=axes.view(FakeTensor))["transforms"]
        assert isinstance(found, FakeTensor) and np.array_equal(found, expected)
        assert (len(copies) > 0) == (call == 0)


def test_worlds_are_batches_of_mjx():
    """Arrays of JAX on the CPU, which MJX has stepped: the bytes of MjData with the same values, and the images of
    MuJoCo's own kinematics."""
    jax = pytest.importorskip("jax", reason="jax is not installed (pip install jax mujoco-mjx)")
    mjx = pytest.importorskip("mujoco.mjx", reason="mujoco-mjx is not installed")
    # MJX lacks contacts between some of these shapes.
    model = mujoco.MjModel.from_xml_string(
        MODEL.replace("<mujoco>", '<mujoco><default><geom contype="0" conaffinity="0"/></default>'))
    robot = latelight.from_mujoco(model)
    device_model, at_rest = mjx.put_model(model), mjx.make_data(model)
    start = np.tile(np.asarray(at_rest.qpos), (4, 1))
    start[:, 2] = (0.5, 1.1, 0.3, 2)
    start[:, model.joint("hinge").qposadr[0]] = (0, 0.6, -0.8, 1.5)
    batch = jax.vmap(lambda qpos: at_rest.replace(qpos=qpos))(jax.numpy.asarray(start))
    step = jax.jit(jax.vmap(mjx.step, in_axes=(None, 0)))
    renderer = latelight.Renderer(robot.scene, device="cpu")

    def frames_of(**worlds):
        return renderer.render_worlds(4, robot.cameras, SIZE, ("rgba", "depth", "id"), data_surfaces="any", **worlds)

    earlier = None
    for _ in range(3):
        for _ in range(20):
            before, batch = np.asarray(batch.qpos), step(device_model, batch)
        names = ("geom_xpos", "geom_xmat", "cam_xpos", "cam_xmat")
        arrays = {name: getattr(batch, name) for name in names}
        assert all(isinstance(array, jax.Array) for array in arrays.values())
        frames = frames_of(**robot.worlds(**arrays))
        same = frames_of(**robot.worlds(mjx.get_data(model, batch)))
        for name in ("rgba", "depth", "id"):
            assert frames[name].tobytes() == same[name].tobytes(), name
        # A step ends with the poses of its beginning, of which MJX has floats and MuJoCo doubles.
        states = []
        for qpos in before:
            states.append(mujoco.MjData(model))
            states[-1].qpos[:] = qpos
            mujoco.mj_forward(model, states[-1])
        expected = frames_of(**robot.worlds(states))
        equal = frames["id"] == expected["id"]
        assert equal.mean() > 0.999, "only pixels on outlines differ"
        assert np.mean(np.isclose(frames["depth"][equal], expected["depth"][equal], rtol=1e-3)) > 0.999
        assert earlier is None or not np.array_equal(frames["depth"], earlier), "the batch moves"
        earlier = frames["depth"]


def test_materials_lights_and_textures(robot):
    scene = robot.scene

    def of(name):
        return scene.material(scene.instance(scene.instances(f"/{name}")[0]).material)

    assert len(robot.instances) == 9 and not scene.instances("/ground") == []
    np.testing.assert_allclose(of("ball").base_color, (1, 0, 0, 1))
    steel = of("limb")
    assert (steel.name, steel.metallic, steel.roughness) == ("steel", 0.25, 0.75)
    np.testing.assert_allclose(steel.base_color[0], 0.2140411, atol=1e-6)  # 0.5 in sRGB (IEC 61966-2-1)
    assert of("glass").alpha_mode == "blend"
    floor = scene.instance(scene.instances("/ground")[0])
    assert scene.texture(scene.texture_of(floor.material, "base_color")).width == 64
    uv = scene.mesh_arrays(floor.mesh)["uv"]
    np.testing.assert_allclose(uv.max(axis=0) - uv.min(axis=0), (2, 2))
    sun, lamp = (scene.light(light) for light in robot.lights)
    assert (sun.type, lamp.type) == ("directional", "spot")
    np.testing.assert_allclose(sun.direction, np.array([0.2, -1, -0.3]) / np.linalg.norm([0.2, -1, -0.3]), atol=1e-6)
    np.testing.assert_allclose(lamp.position, (0, 3, 0), atol=1e-6)


@pytest.mark.parametrize(
    "version, size, uniform, corners, center",  # texture coordinates of the upper left and the lower right corner
    [
        # A plane of 4 m by 3 m: 2 by 3 images, or 2 by 3 images per 2 m.
        ("3.11.0", "2 1.5", "false", ((-1.5, -2), (0.5, 1)), (-0.5, -0.5)),
        ("3.11.0", "2 1.5", "true", ((-2.5, -2.75), (1.5, 1.75)), (-0.5, -0.5)),
        # MuJoCo 3.12 and newer versions begin at the upper left corner.
        ("3.12.0", "2 1.5", "false", ((0, 0), (2, 3)), (1, 1.5)),
        ("4.0.0", "2 1.5", "true", ((0, 0), (4, 4.5)), (2, 2.25)),
        # Infinite axes have 2 by 3 images per 2 m.
        ("3.11.0", "0 0", "false", None, (-0.5, -0.5)),
        ("4.0.0", "0 0", "true", None, (-0.5, -0.5)),
        ("4.0.0", "0 1.5", "true", None, (-0.5, 1.75)),
    ],
)
def test_planes_have_the_texture_coordinates_of_mujoco(monkeypatch, version, size, uniform, corners, center):
    monkeypatch.setattr(mujoco, "__version__", version)
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <texture name="t" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/>
        <material name="m" texture="t" texrepeat="2 3" texuniform="{uniform}"/></asset>
        <worldbody><geom type="plane" size="{size} .1" material="m"/></worldbody></mujoco>"""))
    made = robot.scene.mesh_arrays(robot.scene.meshes()[0])
    x, y, uv = made["positions"][:, 0], made["positions"][:, 1], made["uv"]
    np.testing.assert_allclose(uv.mean(axis=0), center, atol=1e-4)
    left_top, right_bottom = (int(np.argmax(sign * (y - x))) for sign in (1, -1))
    if corners:
        np.testing.assert_allclose(uv[[left_top, right_bottom]], corners, atol=1e-6)
    else:
        per_meter = (uv[right_bottom] - uv[left_top]) / np.abs([np.ptp(x), np.ptp(y)])
        np.testing.assert_allclose(per_meter, (1, 1.5), rtol=1e-6)


def test_height_fields_have_the_texture_coordinates_of_mujoco():
    """The half sizes are 2 m by 0.5 m, so that the point (1, 0.25) is half way to the upper right corner."""
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string("""<mujoco><asset>
        <texture name="t" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/>
        <material name="m" texture="t" texrepeat="2 3"/>
        <hfield name="hill" nrow="5" ncol="5" size="2 0.5 1 1"/></asset>
        <worldbody><geom type="hfield" hfield="hill" material="m"/></worldbody></mujoco>"""))
    made = robot.scene.mesh_arrays(robot.scene.meshes()[0])
    for position, expected in (((0, 0), (-0.5, -0.5)), ((1, 0.25), (0, -1.25)), ((-2, -0.5), (-1.5, 1))):
        vertex = np.argmin(np.abs(made["positions"][:, :2] - position).sum(axis=1))
        np.testing.assert_allclose(made["uv"][vertex], expected, atol=1e-6, err_msg=str(position))


def test_meshes_without_texture_coordinates_have_those_of_mujoco():
    """Of a cuboid, 2 by 3 images over its extent in X and Y, with the center at (-0.5, -0.5)."""
    corners = " ".join(f"{x} {y} {z}" for x in (-2, 2) for y in (-1, 1) for z in (-0.5, 0.5))
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <texture name="t" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/>
        <material name="m" texture="t" texrepeat="2 3"/><material name="twice" texture="t" texrepeat="4 6"/>
        <mesh name="brick" vertex="{corners}"/></asset>
        <worldbody><geom type="mesh" mesh="brick" material="m"/><geom type="mesh" mesh="brick" material="twice"/>
        <geom type="mesh" mesh="brick"/></worldbody></mujoco>"""))
    first, second, plain = (robot.scene.mesh_arrays(robot.scene.instance(i).mesh) for i in robot.instances)
    for made, scale in ((first, 1), (second, 2)):
        signs = np.sign(made["positions"][:, :2])
        np.testing.assert_allclose(made["uv"], signs * (scale, -1.5 * scale) - 0.5, atol=1e-5)
    assert plain.get("uv") is None or not plain["uv"].any()


@pytest.mark.parametrize(
    "version, repeat, uniform, scale",  # the half extents of the geom are 0.25 m by 0.5 m
    [
        ("3.11.0", "3 2", "true", (1, 1)),
        ("3.12.0", "3 2", "false", (3, 2)),
        ("4.0.0", "1 1", "true", (0.25, 0.5)),
        ("4.0.0", "3 2", "true", (0.75, 1)),
    ],
)
def test_meshes_repeat_textures_like_mujoco(monkeypatch, version, repeat, uniform, scale):
    monkeypatch.setattr(mujoco, "__version__", version)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    text = lambda rows: " ".join(f"{number:.6f}" for row in rows for number in row)
    faces = "0 1 3 0 3 2 4 6 7 4 7 5 0 4 5 0 5 1 2 3 7 2 7 6 0 2 6 0 6 4 1 5 7 1 7 3"
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <texture name="t" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/>
        <material name="m" texture="t" texrepeat="{repeat}" texuniform="{uniform}"/>
        <mesh name="brick" vertex="{text(corners)}" face="{faces}" texcoord="{text(np.tile((0.5, 0.25), (8, 1)))}"
        scale="0.25 0.5 1"/></asset><worldbody><geom type="mesh" mesh="brick" material="m"/>
        <geom type="mesh" mesh="brick"/></worldbody></mujoco>"""))
    textured, plain = (robot.scene.mesh_arrays(robot.scene.instance(i).mesh) for i in robot.instances)
    for made, factors in ((textured, scale), (plain, (1, 1))):
        expected = np.broadcast_to(np.array((0.5, 0.25)) * factors, made["uv"].shape)
        np.testing.assert_allclose(made["uv"], expected, rtol=1e-5)


def test_textures_color_emitted_light():
    """MuJoCo multiplies emitted light by the texture, whose green is 0.5 in sRGB, which is 0.2140411."""
    model = mujoco.MjModel.from_xml_string("""<mujoco><asset>
        <texture name="t" type="2d" builtin="flat" rgb1="1 0.5 0" width="8" height="8"/>
        <material name="bright" texture="t" emission="0.5" rgba="1 1 1 1"/><material name="dark" texture="t"/></asset>
        <worldbody><geom type="plane" size="1 1 1" material="bright"/>
        <geom type="plane" size="1 1 1" material="dark" pos="5 0 0"/><camera pos="0 0 2"/></worldbody></mujoco>""")
    robot = latelight.from_mujoco(model)
    bright, dark = (robot.scene.instance(i).material for i in robot.instances)
    assert robot.scene.texture_of(bright, "emissive") == robot.scene.texture_of(bright, "base_color") is not None
    assert robot.scene.texture_of(dark, "emissive") is None
    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frame = renderer.render(robot.cameras[0], (8, 8), "color")
    np.testing.assert_allclose(frame["color"][4, 4, :3], 0.2140411 * np.array((1, 0.2140411, 0)), atol=1e-3)


@pytest.mark.parametrize("emission, gray, shown", [(0.25, 0.8, 0.2), (0.5, 0.8, 0.4), (1, 0.8, 0.8), (2, 0.4, 0.8)])
def test_emitted_light_is_the_product_of_values_on_screen(emission, gray, shown):
    """MuJoCo shows `emission` times `rgba`."""
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <material name="m" emission="{emission}" rgba="{gray} {gray} {gray} 1"/></asset>
        <worldbody><geom type="plane" size="1 1 1" material="m"/><camera pos="0 0 2"/></worldbody></mujoco>"""))
    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frame = renderer.render(robot.cameras[0], (8, 8), "rgba", tonemap="none")
    np.testing.assert_allclose(frame["rgba"][4, 4, :3] / 255, shown, atol=2 / 255)


def test_specular_scales_the_reflectance_of_materials():
    """The default, 0.5, is the reflectance of other materials. Without any, a surface in the mirror direction of a light
    has its diffuse color: 0.5 times 0.8 in MuJoCo, and the product of their decoded values here."""
    materials = "".join(f'<material name="{s}" specular="{s}" shininess="1" rgba="0.5 0.5 0.5 1"/>'
                        for s in ("0.0", "0.25", "0.5", "1.0"))
    planes = "".join(f'<geom name="{s}" type="plane" size="1 1 1" pos="{x} 0 0" material="{s}"/>'
                     for x, s in ((0, "0.0"), (5, "0.25"), (10, "0.5"), (15, "1.0")))
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>{materials}</asset><worldbody>
        {planes}<light type="directional" dir="0 1 -1" diffuse="0.8 0.8 0.8" castshadow="false"/>
        <camera pos="0 2 2" xyaxes="-1 0 0 0 -1 1"/></worldbody></mujoco>"""))
    made = {values.name: (values.specular, *values.specular_color)
            for values in (robot.scene.material(handle) for handle in robot.scene.materials())}
    assert made == {"0.0": (0, 1, 1, 1), "0.25": (0.5, 1, 1, 1), "0.5": (1, 1, 1, 1), "1.0": (1, 2, 2, 2)}
    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frame = renderer.render(robot.cameras[0], (65, 65), "color")
    expected = 0.2140411 * 0.6038274 * np.sqrt(0.5)  # Lambert's cosine
    np.testing.assert_allclose(frame["color"][32, 32, :3], expected, rtol=5e-3)


def test_meshes_without_texture_coordinates_have_sharp_edges():
    """MuJoCo stores one normal per vertex of a cuboid, and its renderer shows those of the faces. A round shape keeps
    the normals of its vertices, as does a cuboid with texture coordinates and normals along its diagonals."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    index = np.arange(200)
    z, angle = 1 - (2 * index + 1) / 200, np.pi * (3 - 5**0.5) * index
    sphere = np.stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z], 1)
    text = lambda rows: " ".join(f"{number:.6f}" for row in rows for number in row)
    faces = "0 1 3 0 3 2 4 6 7 4 7 5 0 4 5 0 5 1 2 3 7 2 7 6 0 2 6 0 6 4 1 5 7 1 7 3"
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <mesh name="cube" vertex="{text(corners)}"/><mesh name="ball" vertex="{text(sphere)}"/>
        <mesh name="mapped" vertex="{text(corners)}" normal="{text(corners)}" face="{faces}"
        texcoord="{text(np.zeros((8, 2)))}"/></asset><worldbody><geom type="mesh" mesh="cube"/><geom type="mesh" mesh="ball"/><geom type="mesh" mesh="mapped"/>
        </worldbody></mujoco>"""))
    cube, ball, mapped = (robot.scene.mesh_arrays(robot.scene.instance(i).mesh) for i in robot.instances)
    triangles = cube["positions"][cube["indices"]]
    expected = np.sign(triangles.mean(axis=1).round(3)) * (np.abs(triangles.mean(axis=1)) > 0.9)
    np.testing.assert_allclose(cube["normals"][cube["indices"]], np.repeat(expected[:, None], 3, 1), atol=1e-5)
    np.testing.assert_allclose(np.abs(mapped["normals"]), 3**-0.5, atol=1e-5)
    center = np.ptp(ball["positions"], axis=0) / 2 + ball["positions"].min(axis=0)
    radial = (ball["positions"] - center) / np.linalg.norm(ball["positions"] - center, axis=1, keepdims=True)
    assert (radial * ball["normals"]).sum(axis=1).min() > 0.99, "those of the vertices"
    edges = ball["positions"][ball["indices"]]
    flat = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.median((flat[:, None] * ball["normals"][ball["indices"]]).sum(axis=-1)) < 0.995, "not those of faces"


def test_binary_models_have_names_in_any_case(tmp_path, model):
    path = tmp_path / "MODEL.MJB"
    mujoco.mj_saveModel(model, str(path))
    assert len(latelight.from_mujoco(path).scene.nodes) == len(latelight.from_mujoco(model).scene.nodes) > 1


def test_a_white_plane_has_the_diffuse_color_of_a_light_above(tmp_path):
    path = tmp_path / "plane.xml"
    path.write_text(
        """<mujoco><worldbody><light type="directional" dir="0 0 -1" diffuse="0.5 0.5 0.5"/>
        <geom type="plane" size="0 0 1" rgba="1 1 1 1" material="chalk"/><camera pos="0 0 2"/></worldbody>
        <asset><material name="chalk" roughness="1"/></asset></mujoco>"""
    )
    robot = latelight.from_mujoco(path)
    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frame = renderer.render(robot.cameras[0], (8, 8), "color", shadows="none")
    np.testing.assert_allclose(frame["color"][4, 4, :3], 0.2140411, rtol=0.06)  # 0.5 in sRGB


@pytest.mark.parametrize(
    "attributes, factors",  # diffuse color divided by the attenuation
    [
        ('diffuse="2 2 2"', (2, 2, 2)), ('diffuse="3 1.5 0.5"', (3, 1.5, 0.5)),
        ('diffuse="1 1 1" type="spot" exponent="0" attenuation="0.4 0 0"', (2.5, 2.5, 2.5)),
    ],
)
def test_lights_may_be_brighter_than_white(attributes, factors):
    """On screen, a gray surface of 0.3 has 0.3 times the light's color, if that is at most 1."""
    kind = "" if "type=" in attributes else 'type="directional"'
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><statistic center="0 0 0"/><asset>
        <material name="m" rgba="0.3 0.3 0.3 1" specular="0"/></asset><worldbody>
        <light pos="0 0 3" dir="0 0 -1" {kind} {attributes}/><geom type="plane" size="3 3 .1" material="m"/>
        <camera pos="0 0 2"/></worldbody></mujoco>"""))
    assert max(robot.scene.light(robot.lights[0]).color) <= 1
    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frame = renderer.render(robot.cameras[0], (65, 65), "rgba", tonemap="none", shadows="none")
    np.testing.assert_allclose(frame["rgba"][32, 32, :3] / 255, 0.3 * np.array(factors), atol=0.02)


def test_lights_have_the_types_and_shadows_of_mujoco():
    lights = "".join(
        f'<light name="{kind} {shadow}" type="{kind}" castshadow="{shadow}"/>'
        for kind in ("spot", "directional", "point") for shadow in ("true", "false"))
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <texture name="sky" type="cube" builtin="flat" rgb1="1 1 1" width="8" height="8"/></asset>
        <worldbody>{lights}
        <light name="wide" type="spot" cutoff="120"/><light name="uniform" type="spot" cutoff="180"/>
        <light name="half" type="spot" cutoff="90"/><light name="sky" type="image" texture="sky"/></worldbody></mujoco>"""))
    made = [robot.scene.light(light) for light in robot.lights]
    assert {light.name: (light.type, light.cast_shadow) for light in made} == {
        "spot true": ("spot", True), "spot false": ("spot", False), "directional true": ("directional", True),
        "directional false": ("directional", False), "point true": ("point", True), "point false": ("point", False),
        "wide": ("point", True), "uniform": ("point", True), "half": ("spot", True),
    }  # fmt: skip


@pytest.mark.parametrize(
    "attenuation, color",  # on screen, of a white surface that is 2 m from the light
    [("1 0 0", 0.8), ("1 0.5 0", 0.4), ("1 0 0.75", 0.2), ("0 0 0.5", 0.4), ("0 0 0", 0.8)],
)
def test_lights_fade_like_those_of_mujoco(attenuation, color):
    """The model's center is 2 m below the light."""
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><statistic center="0 0 0"/><worldbody>
        <light type="spot" pos="0 0 2" dir="0 0 -1" cutoff="60" attenuation="{attenuation}" diffuse="0.8 0.8 0.8"/>
        <geom type="plane" size="3 3 .1" rgba="1 1 1 1" material="chalk"/><camera pos="0 0 1.5"/></worldbody>
        <asset><material name="chalk" roughness="1"/></asset></mujoco>"""))
    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frame = renderer.render(robot.cameras[0], (65, 65), "color", shadows="none")
    expected = ((color + 0.055) / 1.055) ** 2.4  # sRGB, IEC 61966-2-1
    np.testing.assert_allclose(frame["color"][32, 32, :3], expected, rtol=0.06)


@pytest.mark.parametrize("cutoff, exponent", [(60, 10), (45, 10), (80, 2), (30, 50), (90, 10), (90, 1)])
def test_spot_lights_fade_like_those_of_mujoco(cutoff, exponent):
    """On screen, the color halves where the cosine to the power of the exponent is 0.5, and ends within the cutoff."""
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
        <light type="spot" cutoff="{cutoff}" exponent="{exponent}"/></worldbody></mujoco>"""))
    light = robot.scene.light(robot.lights[0])
    cosines = {name: np.cos(np.radians(getattr(light, name))) for name in ("inner_cone", "outer_cone")}
    cosine = 0.5 ** (1 / exponent)
    # KHR_lights_punctual: the square of the cosine's position between the cones
    falloff = (cosine - cosines["outer_cone"]) / (cosines["inner_cone"] - cosines["outer_cone"])
    np.testing.assert_allclose(falloff**2, 0.2140411, rtol=1e-4)  # 0.5 in sRGB
    assert 0 <= light.inner_cone < light.outer_cone <= cutoff + 1e-6


def test_spot_lights_have_edges_and_may_have_no_cone():
    """Without an exponent, the cone has a sharp edge. A cutoff of 0 lights nothing."""
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string("""<mujoco><worldbody>
        <light name="sharp" type="spot" cutoff="40" exponent="0"/><light type="spot" cutoff="0"/>
        <light type="spot" cutoff="-10"/><light name="half" type="spot" cutoff="90" exponent="0"/>
        </worldbody></mujoco>"""))
    sharp, half = (robot.scene.light(light) for light in robot.lights)
    assert (sharp.name, half.name) == ("sharp", "half")
    np.testing.assert_allclose((half.inner_cone, half.outer_cone), (85.5, 90), rtol=1e-5)
    np.testing.assert_allclose((sharp.inner_cone, sharp.outer_cone), (38, 40), rtol=1e-5)


ORTHOGRAPHIC = 'projection="orthographic"' if hasattr(mujoco, "mjtProjection") else 'orthographic="true"'


@pytest.mark.parametrize(
    "attributes, scale, offset",  # pixels per meter at the box; offset of the optical axis in pixels, x right and y up
    [
        (f'{ORTHOGRAPHIC} fovy="3"', (100 / 3, 100 / 3), (0, 0)),
        (f'{ORTHOGRAPHIC} focal="2 2" sensorsize="2 1"', (100 / 28.0724869, 100 / 28.0724869), (0, 0)),
        ('fovy="40"', (27.4747742, 27.4747742), (0, 0)),
        ('focal="2 2" sensorsize="2 1"', (40, 40), (0, 0)),
        ('focal="2 2" sensorsize="2 1" principal=".2 .1"', (40, 40), (-20, 10)),
        ('focal="2 4" sensorsize="2 1"', (40, 80), (0, 0)),
        ('focal="2 2" sensorsize="1 1" principal="-.1 0"', (80, 40), (20, 0)),
    ],
)
def test_cameras_have_the_projection_of_mujoco(attributes, scale, offset):
    """A box of 1.02 m by 0.52 m, whose upper face is 5 m below the camera. An orthographic camera's `fovy` is a length,
    and intrinsics set one, too. Frusta come from MuJoCo, whose versions place vertical offsets differently."""
    size, half = (200, 100), (0.51, 0.26)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody><geom type="box" size="{half[0]} {half[1]} .05"/>
        <camera pos="0 0 5.05" {attributes} resolution="{size[0]} {size[1]}"/></worldbody></mujoco>""")
    seen, fixed = mujoco.MjvScene(model, 10), mujoco.MjvCamera()
    fixed.type, fixed.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    everything = mujoco.mjtCatBit.mjCAT_ALL
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, fixed, everything, seen)
    frustum = seen.camera[0]
    if frustum.frustum_top > -frustum.frustum_bottom:
        offset = (offset[0], -offset[1])

    robot = latelight.from_mujoco(model)
    frame = latelight.Renderer(robot.scene, device="cpu").render(robot.cameras[0], size, "id", shadows="none")
    rows, columns = np.nonzero(frame["id"])
    center = (size[0] / 2 + offset[0], size[1] / 2 - offset[1])
    for found, middle, extent, factor in zip((columns, rows), center, half, scale):
        low, high = middle - extent * factor, middle + extent * factor
        assert (found.min(), found.max() + 1) == (round(low), round(high)), attributes


def test_cameras_have_the_near_and_far_planes_of_mujoco():
    """`znear` and `zfar` are in extents of the model, here 2 m: 1 m and 8 m. Boxes of 0.2 m are left, in the center and
    right, at 0.5, 4 and 9 m."""
    boxes = "".join(f'<geom type="box" size=".1 .1 .1" pos="{x} 0 {-z}"/>' for x, z in ((-0.2, 0.5), (0, 4), (3, 9)))
    fixed = 'pos="0 0 0" xyaxes="1 0 0 0 1 0"'
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><statistic extent="2"/>
        <visual><map znear="0.5" zfar="4"/></visual><worldbody>{boxes}<camera {fixed} fovy="60"/>
        <camera {fixed} focal="2 2" sensorsize="2 2" resolution="99 99"/><camera {fixed} {ORTHOGRAPHIC} fovy="7"/>
        </worldbody></mujoco>"""))
    assert [(camera.near_clip, camera.far_clip) for camera in robot.cameras] == [(1, 8)] * 3
    renderer = latelight.Renderer(robot.scene, device="cpu")
    for camera in robot.cameras:
        depth = renderer.render(camera, (99, 99), "depth", shadows="none")["depth"]
        np.testing.assert_allclose(depth[49, 49], 3.9, rtol=1e-4)
        assert not (np.isfinite(depth) & (np.abs(depth - 3.9) > 0.3)).any(), "only the box between the planes"


def test_planes_in_wrong_order_clip_nothing():
    """MuJoCo compiles such models."""
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string("""<mujoco><visual><map znear="1" zfar=".5"/></visual>
        <worldbody><geom size="1"/><camera pos="0 0 3"/></worldbody></mujoco>"""))
    frame = latelight.Renderer(robot.scene, device="cpu").render(robot.cameras[0], (9, 9), "depth", shadows="none")
    np.testing.assert_allclose(frame["depth"][4, 4], 2, rtol=1e-2)


def test_signed_distance_fields_show_their_mesh():
    """MuJoCo shows the mesh from which it makes the field, with a projected texture."""
    corners = " ".join(f"{x} {y} {z}" for x in (-2, 2) for y in (-1, 1) for z in (-0.5, 0.5))
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
        <texture name="t" type="2d" builtin="checker" rgb1="1 1 1" rgb2="0 0 0" width="8" height="8"/>
        <material name="m" texture="t" texrepeat="2 3"/><mesh name="brick" vertex="{corners}"/></asset>
        <worldbody><geom type="mesh" mesh="brick" material="m"/>
        <geom type="sdf" mesh="brick" material="m" pos="9 0 0"/></worldbody></mujoco>"""))
    assert robot.geoms.tolist() == [0, 1]
    solid, field = (robot.scene.instance(instance) for instance in robot.instances)
    expected, arrays = robot.scene.mesh_arrays(solid.mesh), robot.scene.mesh_arrays(field.mesh)
    for name in ("positions", "normals", "uv", "indices"):
        np.testing.assert_array_equal(arrays[name], expected[name])
    assert np.ptp(arrays["uv"], axis=0).min() > 1
    assert robot.scene.texture_of(field.material, "base_color") is not None
    np.testing.assert_allclose(robot.scene.bounds[1][0], 11, atol=1e-5)


LAMPS = """<mujoco><statistic center="0 0 0"/><worldbody>
<geom name="floor" type="plane" size="3 3 .1" rgba="1 1 1 1"/>
<light name="fixed" type="directional" dir="0 0 -1" diffuse="0.1 0.1 0.1" castshadow="false"/>
<light name="off" active="false"/>
<body name="cart" pos="0 0 0.5"><joint name="x" type="slide" axis="1 0 0"/><joint name="turn" type="hinge" axis="0 0 1"/>
  <geom type="sphere" size="0.1" pos="0 0 5"/>
  <light name="lamp" pos="0 0 1.5" dir="0 0 -1" cutoff="10" castshadow="false"/>
  <light name="beam" type="directional" dir="1 0 0" diffuse="0 0 0"/></body>
<light name="follower" type="spot" pos="0 0 4.5" mode="targetbody" target="cart" diffuse="0 0 0"/>
<body name="hand" mocap="true"><light name="torch" type="point" pos="0 1 0" diffuse="0 0 0"/></body>
<camera pos="0 0 4" xyaxes="1 0 0 0 1 0" fovy="60"/>
</worldbody></mujoco>"""


def lamp_states(model):
    states = []
    for x, turn in ((0, 0), (0.8, np.pi / 2), (-1, np.pi)):
        states.append(mujoco.MjData(model))
        states[-1].qpos[:] = x, turn
        states[-1].mocap_pos[0] = 0, 0, 1 + x
        mujoco.mj_forward(model, states[-1])
    return states


def test_lights_follow_their_bodies():
    """Positions are those of the bodies, and directions turn with them, with (x, y, z) as (x, z, -y)."""
    model = mujoco.MjModel.from_xml_string(LAMPS)
    robot, states = latelight.from_mujoco(model), lamp_states(model)
    assert robot.light_ids.tolist() == [0, 2, 3, 4, 5]
    worlds = robot.worlds(states)
    assert [robot.scene.light(light).name for light in worlds["lights"]] == ["follower", "lamp", "beam", "torch"]
    positions = [[(0, 4.5, 0), (x, 2, 0), (0, 1 + x, -1)] for x in (0, 0.8, -1)]
    np.testing.assert_allclose(worlds["light_position"][:, [0, 1, 3]], positions, atol=1e-6)
    follower = [np.array((x, -4, 0)) / np.hypot(x, 4) for x in (0, 0.8, -1)]
    np.testing.assert_allclose(worlds["light_direction"][:, 0], follower, atol=1e-6)
    np.testing.assert_allclose(worlds["light_direction"][:, 1], [(0, -1, 0)] * 3, atol=1e-6)
    np.testing.assert_allclose(worlds["light_direction"][:, 2], [(1, 0, 0), (0, 0, -1), (-1, 0, 0)], atol=1e-6)

    renderer = latelight.Renderer(robot.scene, device="cpu", environment="none")
    frames = renderer.render_worlds(3, robot.cameras, (96, 96), "color", shadows="none", **worlds)
    focal = 48 / np.tan(np.radians(30))
    for x, color in zip((0, 0.8, -1), frames["color"][:, 0, :, :, 0]):
        columns = np.nonzero((color > 0.3).any(axis=0))[0]
        middle = (columns.min() + columns.max() + 1) / 2
        assert abs(middle - (48 + x * focal / 4)) < 1.5, "the lamp illuminates the floor below it"


def test_arrays_of_lights_are_those_of_states():
    model = mujoco.MjModel.from_xml_string(LAMPS)
    robot, states = latelight.from_mujoco(model), lamp_states(model)
    names = ("geom_xpos", "geom_xmat", "cam_xpos", "cam_xmat", "light_xpos", "light_xdir")
    arrays = {name: np.stack([getattr(data, name) for data in states]).astype(np.float32) for name in names}
    expected, made = robot.worlds(states), robot.worlds(**arrays)
    assert made.keys() == expected.keys() and made["lights"] == expected["lights"]
    for name in ("transforms", "light_position", "light_direction"):
        np.testing.assert_allclose(made[name], expected[name], atol=1e-6)
        assert made[name].dtype == np.float32
    # Without arrays of lights, and with no lights chosen, the lights are the scene's.
    for without in (robot.worlds(geom_xpos=arrays["geom_xpos"], geom_xmat=arrays["geom_xmat"]),
                    robot.worlds(states, light_ids=[]), robot.worlds(**arrays, light_ids=())):
        assert not {"lights", "light_position", "light_direction"} & without.keys()
    chosen = robot.worlds(states, light_ids=[5, 0])
    assert [robot.scene.light(light).name for light in chosen["lights"]] == ["torch", "fixed"]
    np.testing.assert_allclose(chosen["light_direction"][:, 1], [(0, -1, 0)] * 3, atol=1e-6)
    wrong = [
        ({"light_xpos": arrays["light_xpos"]}, "light_xpos and light_xdir require each other"),
        ({"light_xpos": np.zeros((3, 6)), "light_xdir": np.zeros((3, 6))}, r"must have the shape \(N, nlight, 3\)"),
        ({"light_xpos": np.zeros((3, 2, 3)), "light_xdir": np.zeros((3, 2, 3))}, "all of the model's lights, 6, and has 2"),
        ({"data": states, "light_ids": [1]}, r"among those of the scene, \[0, 2, 3, 4, 5\], and one is 1"),
        ({"data": states, "light_ids": ["lamp"]}, "light_ids must be a list of integers"),
    ]
    for arguments, message in wrong:
        with pytest.raises(latelight.UsageError, match=message):
            robot.worlds(**arguments)


def test_vector_environments_may_describe_lights():
    """Lights that the caller describes do not follow their bodies."""
    gymnasium = pytest.importorskip("gymnasium")
    xml = MODEL.replace('rgba="1 0 0 1"/></body>', 'rgba="1 0 0 1"/><light name="spark" pos="0 0 1"/></body>', 1)
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(xml))
    assert len(robot.worlds(data_at(mujoco.MjModel.from_xml_string(xml), 0, 1))["lights"]) == 1
    images = []
    for options in ({}, {"lights": robot.lights, "light_intensity": np.zeros((2, 3))}):
        envs = latelight.add_pixels(
            gymnasium.vector.SyncVectorEnv([falling(gymnasium, xml)] * 2), scene=robot, size=(32, 24), device="cpu",
            shadows="none", **options)
        images.append(envs.reset(seed=3)[0]["pixels"])
    assert images[0].mean() > images[1].mean()


def test_wrong_arguments_are_refused(model, robot, tmp_path):
    with pytest.raises(latelight.UsageError, match="requires a mujoco.MjModel or a file, not int"):
        latelight.from_mujoco(3)
    with pytest.raises(latelight.InputError, match="does not exist"):
        latelight.from_mujoco(tmp_path / "missing.xml")
    (tmp_path / "broken.xml").write_text('<mujoco>\n<worldbody><geom size="x"/></worldbody></mujoco>')
    with pytest.raises(latelight.InputError, match="MuJoCo cannot load it") as error:
        latelight.from_mujoco(tmp_path / "broken.xml")
    assert "\n" not in str(error.value)
    with pytest.raises(latelight.InputError, match=f"{tmp_path} is a folder: give"):
        latelight.from_mujoco(tmp_path)
    with pytest.raises(latelight.UsageError, match="require each other"):
        robot.worlds(geom_xpos=np.zeros((1, model.ngeom, 3)))
    with pytest.raises(latelight.UsageError, match="data must be an MjData, or a list with one per world"):
        robot.worlds([])
    with pytest.raises(latelight.UsageError, match="must have the shape"):
        robot.worlds(geom_xpos=np.zeros((model.ngeom, 3)), geom_xmat=np.zeros((model.ngeom, 9)))
    for elements in (2, model.ngeom + 1):
        with pytest.raises(latelight.UsageError, match=f"all of the model's elements, .*, and has {elements}"):
            robot.worlds(geom_xpos=np.zeros((1, elements, 3)), geom_xmat=np.zeros((1, elements, 9)))
    with pytest.raises(latelight.UsageError, match="geom_xmat must have the shape"):
        robot.worlds(geom_xpos=np.zeros((2, model.ngeom, 3)), geom_xmat=np.zeros((3, model.ngeom, 9)))
    for groups in (3, "012", [0.5]):
        with pytest.raises(latelight.ArgumentTypeError, match="groups must be a list of integers"):
            latelight.from_mujoco(model, groups=groups)


def test_states_of_wrong_types_are_refused(model, robot):
    data = data_at(model, 0, 1)
    for wrong in (3, model, [data, 3]):
        with pytest.raises(latelight.ArgumentTypeError, match="data must be an? .*MjData.* per world, not "):
            robot.worlds(wrong)
    other = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")
    with pytest.raises(latelight.UsageError, match="must be of one model"):
        robot.worlds([data, mujoco.MjData(other)])
    with pytest.raises(latelight.UsageError, match="must be of one model, the scene's"):
        latelight.from_mujoco(other).worlds(data)
    with pytest.raises(latelight.ArgumentTypeError, match="must be an array of numbers, not str"):
        robot.worlds(geom_xpos="x", geom_xmat=np.zeros((1, model.ngeom, 9)))
    for ids in (0, ["eye"], [0.7]):
        with pytest.raises(latelight.ArgumentTypeError, match="camera_ids must be a list of integers"):
            robot.worlds(data, camera_ids=ids)
    for ids in ([-1], [2]):
        with pytest.raises(latelight.UsageError, match="indices of the model's cameras, of which there are 2"):
            robot.worlds(data, camera_ids=ids)
    # Lists of arrays, tuples, generators and arrays of objects are lists, too.
    expected = robot.worlds([data, data])
    given = {name: np.stack([getattr(data, name)] * 2).tolist()
             for name in ("geom_xpos", "geom_xmat", "cam_xpos", "cam_xmat")}
    for same in (robot.worlds(d for d in (data, data)), robot.worlds(np.array([data, data], object)),
                 robot.worlds((data, data)), robot.worlds(**given)):
        for name in ("transforms", "camera_to_world"):
            np.testing.assert_array_equal(same[name], expected[name])


def falling(gymnasium, xml):
    """The class of an environment with a ball that an action pushes up."""

    class Fall(gymnasium.Env):
        observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (1,), np.float64)
        action_space = gymnasium.spaces.Box(-1, 1, (1,), np.float32)

        def __init__(self):
            self.model = mujoco.MjModel.from_xml_string(xml)
            self.data = mujoco.MjData(self.model)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            mujoco.mj_resetData(self.model, self.data)
            self.data.qpos[2] += self.np_random.uniform(0, 1)
            mujoco.mj_forward(self.model, self.data)
            return self.data.qpos[2:3].copy(), {}

        def step(self, action):
            self.data.qpos[2] += float(action[0])
            mujoco.mj_forward(self.model, self.data)
            return self.data.qpos[2:3].copy(), 0.0, False, False, {}

    return Fall


def test_vector_environments_have_pixels():
    gymnasium = pytest.importorskip("gymnasium")
    Fall = falling(gymnasium, MODEL)
    envs = latelight.add_pixels(
        gymnasium.vector.SyncVectorEnv([Fall, Fall]), size=(32, 24), device="cpu", shadows="none"
    )
    seen, _ = envs.reset(seed=3)
    assert seen["pixels"].shape == (2, 24, 32, 3) and seen["pixels"].dtype == np.uint8
    assert envs.observation_space.contains(seen)
    assert (seen["pixels"][0] != seen["pixels"][1]).any()
    same, *_ = envs.step(np.zeros((2, 1), np.float32))
    np.testing.assert_array_equal(same["pixels"], seen["pixels"])
    moved, *_ = envs.step(np.array([[0.3], [0]], np.float32))
    assert (moved["pixels"][0] != seen["pixels"][0]).any()
    np.testing.assert_array_equal(moved["pixels"][1], seen["pixels"][1])
    with pytest.raises(latelight.UsageError, match="SyncVectorEnv of MuJoCo environments"):
        latelight.add_pixels(gymnasium.make_vec("CartPole-v1", 2))
    wrong = [
        ({"size": 64}, "size must be a list of integers"), ({"size": (64.0, 64)}, "size must be a list of integers"),
        ({"size": (0, 64)}, "size must be a width and a height above 0"), ({"cameras": 0}, "cameras must be a Camera"),
        ({"cameras": []}, "cameras must have at least one"), ({"scene": 3}, "scene must be a MujocoScene, not int"),
    ]
    for arguments, message in wrong:
        with pytest.raises(latelight.UsageError, match=message):
            latelight.add_pixels(gymnasium.vector.SyncVectorEnv([Fall, Fall]), device="cpu", **arguments)
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(MODEL))
    own, given, camera = latelight.Renderer(robot.scene, "cpu"), envs.renderer, latelight.Camera()
    arguments_of = dict
    wrong = [
        ({"worlds": 5, "renderer": given, "cameras": camera}, latelight.ArgumentTypeError,
         "worlds must be a function of the environments, not int"),
        ({"worlds": arguments_of, "renderer": given, "cameras": camera, "scene": robot}, latelight.UsageError,
         "omit `scene`"),
        ({"worlds": arguments_of, "renderer": given, "cameras": camera, "device": "cpu"}, latelight.UsageError,
         "omit `device`"),
        ({"scene": robot, "renderer": own, "device": "cpu"}, latelight.UsageError, "omit `device`"),
        ({"renderer": own}, latelight.UsageError, "`renderer` requires `scene`"),
        ({"shadow": "none"}, latelight.ArgumentTypeError, 'no option "shadow": do you mean "shadows"'),
        ({"anisotropy": "much"}, latelight.ArgumentTypeError, "anisotropy must be a"),
        ({"exposure": "bright"}, latelight.UsageError, "^exposure takes a number"),
        ({"pixels": [(0, 0)]}, latelight.ArgumentTypeError, '"pixels" does not apply'),
    ]
    for arguments, kind, message in wrong:
        with pytest.raises(kind, match=message):
            latelight.add_pixels(gymnasium.vector.SyncVectorEnv([Fall, Fall]), **arguments)
    again = latelight.add_pixels(
        gymnasium.vector.SyncVectorEnv([Fall, Fall]), scene=robot, renderer=own, size=(32, 24), shadows="none")
    np.testing.assert_array_equal(again.reset(seed=3)[0]["pixels"], seen["pixels"])
    nothing = latelight.add_pixels(
        gymnasium.vector.SyncVectorEnv([Fall, Fall]), renderer=envs.renderer, cameras=latelight.Camera(),
        worlds=lambda envs: None)
    with pytest.raises(latelight.ArgumentTypeError, match="worlds must return a dict .*, not NoneType"):
        nothing.reset()
    for name, value in (("channels_first", True), ("on_device", True), ("outputs", "id"), ("out", {})):
        with pytest.raises(latelight.UsageError, match=f"so it has no option {name}$"):
            latelight.add_pixels(gymnasium.vector.SyncVectorEnv([Fall, Fall]), device="cpu", **{name: value})


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ('size="0.15 0.4"', 'size="0.15 0.5"', "geom_size"),
        ('rgba="0 1 0 1"', 'rgba="0 1 1 1"', "geom_rgba"),
        ('name="tool" type="box"', 'name="tool" type="ellipsoid"', "geom_type"),
        ('name="glass" type="box"', 'name="glass" group="3" type="box"', "geom_group"),
        ('metallic="0.25"', 'metallic="0.5"', "mat_metallic"),
        ('rgb1="1 1 1"', 'rgb1="1 0 1"', "tex_data"),
        ("0 1 2 1 0", "0 1 2 2 0", "hfield_data"),
        ("0 1 0  0 0 1", "0 1 0  0 0 2", "mesh_vert"),
        ('cutoff="30"', 'cutoff="40"', "light_cutoff"),
        ('name="lamp" pos="0 0 3"', 'name="lamp" pos="1 0 3"', "light_pos"),
        ('fovy="50"', 'fovy="60"', "cam_fovy"),
    ],
)
def test_data_of_models_that_look_different_is_refused(model, robot, old, new, field):
    assert MODEL.count(old) == 1
    other = mujoco.MjModel.from_xml_string(MODEL.replace(old, new))
    for world, states in enumerate(([other], [model, other])):
        with pytest.raises(latelight.UsageError, match=f"of world {world} differs in .*{field}"):
            robot.worlds([data_at(each, 0, 1) for each in states])


def test_data_of_models_that_look_equal_is_accepted(model, robot):
    """Masses, positions, and geoms that the scene does not show may differ."""
    xml = MODEL
    for old, new in (
        ('size="1 1 1" group="3"', 'size="2 1 1" group="3"'),
        ('<body pos="1 0 0.5"', '<body pos="1 0.2 0.5"'),
        ('size="0.3" rgba="1 0 0 1"', 'size="0.3" rgba="1 0 0 1" mass="9" friction="2 0.1 0.1"'),
        ('name="eye" pos="0 -4 2.5"', 'name="eye" pos="0 -4 3"'),
    ):
        assert xml.count(old) == 1
        xml = xml.replace(old, new)
    states = [data_at(each, 0, 1) for each in (model, mujoco.MjModel.from_xml_string(xml))]
    for _ in range(2):
        worlds = robot.worlds(states)
        limb = list(robot.geoms).index(model.geom("limb").id)
        np.testing.assert_allclose(worlds["transforms"][1, limb, :, 3] - worlds["transforms"][0, limb, :, 3],
                                   (0, 0, -0.2), atol=1e-12)


def test_environments_show_one_model():
    gymnasium = pytest.importorskip("gymnasium")
    kinds = [falling(gymnasium, xml) for xml in (MODEL, MODEL.replace('type="sphere" size="0.3"', 'type="sphere" size="0.6"'))]
    with pytest.raises(latelight.UsageError, match="that of world 1 differs in geom_size"):
        latelight.add_pixels(gymnasium.vector.SyncVectorEnv(kinds), device="cpu")


def test_options_do_not_repeat_what_environments_define():
    gymnasium = pytest.importorskip("gymnasium")
    Fall = falling(gymnasium, MODEL)
    model = mujoco.MjModel.from_xml_string(MODEL)
    robot = latelight.from_mujoco(model)
    given = robot.worlds([data_at(model, 0, 1)] * 2)
    for name in ("instances", "transforms", "camera_to_world"):
        with pytest.raises(latelight.UsageError, match=f"the environments' data defines {name}: omit the option"):
            latelight.add_pixels(
                gymnasium.vector.SyncVectorEnv([Fall, Fall]), scene=robot, device="cpu", **{name: given[name]})
    # Cameras that keep their poses may have poses of the caller's.
    envs = latelight.add_pixels(
        gymnasium.vector.SyncVectorEnv([Fall, Fall]), scene=robot, cameras=latelight.Camera(), size=(8, 8), device="cpu",
        shadows="none", camera_to_world=given["camera_to_world"][:, :1])
    assert envs.reset(seed=3)[0]["pixels"].shape == (2, 8, 8, 3)
    own = latelight.add_pixels(
        gymnasium.vector.SyncVectorEnv([Fall, Fall]), renderer=envs.renderer, cameras=latelight.Camera(), size=(8, 8),
        worlds=lambda envs: given, instances=robot.instances)
    with pytest.raises(latelight.UsageError, match="the result of `worlds` defines instances: omit the option"):
        own.reset(seed=3)


def test_vector_environments_may_replace_their_data():
    """Images show the data of an environment that makes its own in reset()."""
    gymnasium = pytest.importorskip("gymnasium")

    class Renewed(falling(gymnasium, MODEL)):
        def reset(self, **arguments):
            self.data = mujoco.MjData(self.model)
            return super().reset(**arguments)

    images = []
    for kind in (falling(gymnasium, MODEL), Renewed):
        envs = latelight.add_pixels(
            gymnasium.vector.SyncVectorEnv([kind, kind]), size=(32, 24), device="cpu", shadows="none")
        seen, _ = envs.reset(seed=3)
        moved, *_ = envs.step(np.array([[0.3], [-0.2]], np.float32))
        images.append((seen["pixels"], moved["pixels"]))
    assert (images[0][0] != images[0][1]).any()
    np.testing.assert_array_equal(images[1], images[0])


def test_cameras_of_vector_environments_follow_their_bodies():
    """A camera on the ball stays at the same distance from it, and other cameras stay where they are."""
    gymnasium = pytest.importorskip("gymnasium")
    xml = MODEL.replace('rgba="1 0 0 1"/></body>', 'rgba="1 0 0 1"/><camera name="rider" pos="0 0 2"/></body>', 1)
    robot = latelight.from_mujoco(mujoco.MjModel.from_xml_string(xml))
    (rider,) = (camera for camera in robot.cameras if camera.name == "rider")
    eye = next(camera for camera in robot.cameras if camera.name == "eye")
    own = latelight.Camera.look_at((0, 2.5, 0), (0, 0, 0), up=(0, 0, -1))  # where the rider is at first, in the scene

    def depths(cameras):
        environments = gymnasium.vector.SyncVectorEnv([falling(gymnasium, xml)] * 2)
        envs = latelight.add_pixels(
            environments, scene=robot, cameras=cameras, size=(32, 24), device="cpu", shadows="none")
        envs.reset(seed=3)
        envs.step(np.array([[0.5], [0]], np.float32))
        arguments = envs._worlds(envs.env)
        count = 1 if isinstance(cameras, latelight.Camera) else len(cameras)
        frames = envs.renderer.render_worlds(2, cameras, (32, 24), "depth", **arguments)["depth"]
        return frames.reshape(2, count, 24, 32)[:, :, 12, 16]

    np.testing.assert_allclose(depths(rider), 1.7, atol=0.01)  # 2 m from the center of a sphere of 0.3 m
    np.testing.assert_allclose(depths([eye, rider])[:, 1], 1.7, atol=0.01)
    assert np.ptp(depths(own)) > 0.1
