"""Nodes, skins, morph targets and animations of scenes in memory: against closed forms, and against the same scene that
is loaded from a glTF file."""

import base64
import json

import numpy as np
import pytest

import latelight
from latelight import AnimationChannel, Camera, Light, Material, Scene

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
FACES = [[0, 1, 2], [0, 2, 3]]
NORMALS = np.tile(np.float32([0, 0, 1]), (4, 1))
HALF = 0.5**0.5
OUTPUTS = ("rgba", "color", "depth", "normal", "id", "part", "motion")


def paint(scene, name="paint", **values):
    return scene.add_material(Material(name=name, metallic=0, roughness=0.5, double_sided=True, **values))


def distance_at(scene, device, time, origin=(0, 0, 10), direction=(0, 0, -1)):
    renderer = latelight.Renderer(scene, device)
    return float(renderer.cast([origin], [direction], time=time)["distance"][0])


def moving_square(scene, property, times, values, interpolation="linear", **mesh):
    made = scene.add_mesh(SQUARE, FACES, normals=NORMALS, **mesh)
    node = scene.add_node("square", parts=[(made, paint(scene))])
    scene.add_animation(
        "play", [AnimationChannel(node=node, property=property, interpolation=interpolation, times=times, values=values)]
    )
    return scene


# --- closed forms -----------------------------------------------------------------------------------------------------


def test_translations_are_interpolated(device):
    keys = ([0, 2], [[0, 0, 0], [0, 0, 4]])
    linear = moving_square(Scene(), "translation", *keys)
    assert [(a.name, a.duration) for a in linear.animations] == [("play", 2)]
    for time, z in ((0, 0), (0.5, 1), (1.75, 3.5), (2, 4), (9, 4)):
        assert distance_at(linear, device, time) == pytest.approx(10 - z, abs=1e-5)
    steps = moving_square(Scene(), "translation", *keys, "step")
    assert [distance_at(steps, device, time) for time in (0, 1.99, 2)] == pytest.approx([10, 10, 6], abs=1e-5)


def test_cubic_splines_are_hermite_curves(device):
    """glTF 2.0, appendix C: p(u) = h00 p0 + h10 d m0 + h01 p1 + h11 d m1, with d the seconds between the keys."""
    z0, out, into, z1, span = 0.5, 3.0, -2.0, 2.0, 2.0
    rows = [[0, 0, 0], [0, 0, z0], [0, 0, out], [0, 0, into], [0, 0, z1], [0, 0, 0]]
    scene = moving_square(Scene(), "translation", [1, 1 + span], rows, "cubicspline")
    for u in (0, 0.25, 0.5, 0.9, 1):
        h00, h10, h01, h11 = 2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, -2 * u**3 + 3 * u**2, u**3 - u**2
        z = h00 * z0 + h10 * span * out + h01 * z1 + h11 * span * into
        assert distance_at(scene, device, 1 + u * span) == pytest.approx(10 - z, abs=1e-5)


def test_rotations_turn_at_constant_speed(device):
    scene = moving_square(Scene(), "rotation", [0, 1], [[0, 0, 0, 1], [0, HALF, 0, HALF]])  # 90 degrees about Y
    for degrees in (0, 30, 45, 60):
        angle = np.radians(degrees)  # at x = 0.5 the plane z cos a + x sin a = 0 has z = -x tan a
        assert distance_at(scene, device, degrees / 90, (0.25, 0, 10)) == pytest.approx(
            10 + 0.25 * np.tan(angle), abs=1e-5
        )


def limb(scene):
    """A hand below an arm below a base that doubles sizes, and the hand's part."""
    square = scene.add_mesh(SQUARE, FACES, normals=NORMALS), paint(scene)
    base = scene.add_node("base", matrix=np.diag([2.0, 2, 2, 1]))
    arm = scene.add_node("arm", base, translation=(0, 0, 1))
    return base, arm, scene.add_node("hand", arm, scale=(0.5, 0.5, 0.5), parts=[square]), square


def test_nodes_move_their_children(device):
    scene = Scene()
    base, arm, hand, _ = limb(scene)
    assert (base, arm, hand) == ("/base", "/base/arm", "/base/arm/hand")
    assert [scene.instance(i).node for i in scene.instances(hand)] == [hand]
    scene.add_animation("lift", [AnimationChannel(node=arm, property="translation", times=[0, 1], values=[[0] * 3, [0, 0, 2]])])
    assert distance_at(scene, device, None) == pytest.approx(8)  # at rest
    assert distance_at(scene, device, 0.5) == pytest.approx(8)
    assert distance_at(scene, device, 1) == pytest.approx(6)
    with pytest.raises(latelight.UsageError, match="/base in the animation .* because its transform is a matrix"):
        scene.add_animation("no", [AnimationChannel(node=base, property="scale", times=[0], values=[[1, 1, 1]])])


def test_morph_targets_follow_weights(device):
    near, far = np.tile(np.float32([0, 0, 1]), (4, 1)), np.tile(np.float32([0, 0, -3]), (4, 1))
    targets = [{"positions": near}, {"positions": far}]
    weights = [[0, 0], [1, 0.5]]
    scene = moving_square(Scene(), "weights", [0, 1], weights, targets=targets)
    for time in (0, 0.25, 1):
        assert distance_at(scene, device, time) == pytest.approx(10 - time * 1 + time * 0.5 * 3, abs=1e-5)
    posed = Scene()
    mesh = posed.add_mesh(SQUARE, FACES, normals=NORMALS, targets=targets)
    posed.add_node(parts=[(mesh, paint(posed))], weights=[1, 0])
    assert distance_at(posed, device, None) == pytest.approx(9, abs=1e-5)
    assert posed.bounds[1][2] == 1


def bent_sheet(scene, look):
    """A sheet along X whose right half follows the second of two joints."""
    x = np.linspace(0, 2, 9)
    points = np.array([[a, y, 0] for a in x for y in (0, 1)], np.float32)
    faces = [[2 * i + a, 2 * i + b, 2 * i + c] for i in range(8) for a, b, c in ((0, 2, 3), (0, 3, 1))]
    root = scene.add_node("root")
    tip = scene.add_node("tip", root, translation=(1, 0, 0))
    inverse = np.tile(np.eye(4), (2, 1, 1))
    inverse[1, 0, 3] = -1
    skin = scene.add_skin([root, tip], inverse)
    share = np.clip(points[:, 0] - 0.5, 0, 1)  # in steps of 1/4, which floats add exactly
    mesh = scene.add_mesh(
        points,
        faces,
        normals=np.tile(np.float32([0, 0, 1]), (18, 1)),
        skin=skin,
        joints=np.tile([0, 1], (18, 1)),
        joint_weights=np.stack([1 - share, share], axis=1),
        name="sheet",
    )
    scene.add_node("sheet", parts=[(mesh, look)], translation=(50, 0, 0))  # joints move it, its node does not
    return root, tip


def test_joints_bend_meshes(device):
    scene = Scene()
    _, tip = bent_sheet(scene, paint(scene))
    assert scene.joints(scene.instances("/sheet")[0]) == ["/root", "/root/tip"]
    turn = AnimationChannel(node=tip, property="rotation", times=[0, 1], values=[[0, 0, 0, 1], [0, -HALF, 0, HALF]])
    scene.add_animation("bend", [turn])
    # Linear blend skinning of the point (x, y, 0): (1 - s)(x, y, 0) + s (1 + (x - 1) cos a, y, (x - 1) sin a).
    for time in (0.25, 0.5):
        angle = time * np.pi / 2
        for x in (0.25, 1.25, 1.75):  # columns of vertices
            s = np.clip(x - 0.5, 0, 1)
            at = (1 - s) * x + s * (1 + (x - 1) * np.cos(angle)), s * (x - 1) * np.sin(angle)
            assert distance_at(scene, device, time, (at[0], 0.5, 10)) == pytest.approx(10 - at[1], abs=1e-5)


def test_nodes_are_shown_in_steps(device):
    scene = moving_square(Scene(), "visible", [0, 1, 2], [[1], [0], [1]], "step")
    assert np.isfinite(distance_at(scene, device, 0.5))
    assert np.isinf(distance_at(scene, device, 1.5))
    assert np.isfinite(distance_at(scene, device, 2.5))


def test_cameras_and_lights_follow_nodes(device):
    scene = Scene()
    node = scene.add_node("rig", translation=(0, 0, 3))
    scene.add_camera(Camera(name="eye", vertical_fov=50), node=node)
    light = scene.add_light(Light(intensity=5), node=node)
    scene.add_animation("fly", [AnimationChannel(node=node, property="translation", times=[0, 1], values=[[0, 0, 3], [1, 0, 5]])])
    assert scene.cameras[0].name == "eye"
    np.testing.assert_allclose(scene.cameras[0].camera_to_world[:3, 3], (0, 0, 3))
    np.testing.assert_allclose(scene.cameras[0].camera_to_world[:3, 2], (0, 0, -1))
    np.testing.assert_allclose(scene.cameras_at(0.5)[0].camera_to_world[:3, 3], (0.5, 0, 4))
    np.testing.assert_allclose(scene.light(light).position, (0, 0, 3))
    made = scene.add_mesh(SQUARE, FACES, normals=NORMALS)
    scene.add_instance(made, paint(scene))
    renderer = latelight.Renderer(scene, device)
    lit = [
        renderer.render(Camera.look_at((0, 0, 9), (0, 0, 0)), (1, 1), "color", time=t, shadows="none")["color"][0, 0, 0]
        for t in (0, 1)
    ]
    # The diffuse part of the radiance under a point light goes with cos / r^2; the specular part is small here.
    assert lit[1] / lit[0] == pytest.approx(5 / 26**1.5 * 9, rel=0.1)


# --- moved nodes ------------------------------------------------------------------------------------------------------


def at(x, y, z):
    transform = np.eye(4)
    transform[:3, 3] = (x, y, z)
    return transform


def turned(axis, angle):
    """About X, Y or Z."""
    transform = np.eye(4)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    transform[a, a] = transform[b, b] = np.cos(angle)
    transform[a, b], transform[b, a] = -np.sin(angle), np.sin(angle)
    return transform


def test_moved_nodes_carry_what_is_below_them(device):
    scene = Scene()
    base, arm, hand, square = limb(scene)
    beside = scene.add_node("beside", base, translation=(5, 0, 0), parts=[square])
    scene.add_camera(Camera(name="eye"), node=hand)
    light = scene.add_light(Light(intensity=5), node=arm)
    renderer = latelight.Renderer(scene, device)
    distance = lambda x: pytest.approx(float(renderer.cast([(x, 0, 10)], [(0, 0, -1)])["distance"][0]), abs=1e-5)
    assert (distance(0), distance(10)) == (8, 10)
    scene.set_node_transform(arm, at(0, 0, 3))
    assert (distance(0), distance(10)) == (4, 10)  # twice 3 of 10
    assert {node.path: node.transform[2, 3] for node in scene.nodes} == {base: 0, arm: 6, hand: 6, beside: 0}
    np.testing.assert_allclose(scene.light(light).position, (0, 0, 6))
    np.testing.assert_allclose(scene.cameras[0].camera_to_world[:3, 3], (0, 0, 6))
    np.testing.assert_allclose(scene.bounds, ((-1, -2, 0), (12, 2, 6)))
    scene.set_transform(scene.instances(hand)[0], at(0, 0, 1))  # is placed, and follows its node no longer
    scene.set_node_transform(arm, at(0, 0, 4))
    assert distance(0) == 9
    scene.add_animation("lift", [AnimationChannel(node=arm, property="translation", times=[0], values=[[0, 0, 2]])])
    np.testing.assert_allclose(scene.cameras_at(0)[0].camera_to_world[:3, 3], (0, 0, 4))
    np.testing.assert_allclose(scene.cameras[0].camera_to_world[:3, 3], (0, 0, 8))


def test_moved_joints_bend_meshes(device):
    scene = Scene()
    _, tip = bent_sheet(scene, paint(scene))
    renderer = latelight.Renderer(scene, device)
    for angle in (0.3, 0.9):
        scene.set_node_transform(tip, at(1, 0, 0) @ turned(1, -angle))
        for x in (0.25, 1.25, 1.75):  # linear blend skinning, as in test_joints_bend_meshes
            s = np.clip(x - 0.5, 0, 1)
            point = (1 - s) * x + s * (1 + (x - 1) * np.cos(angle)), s * (x - 1) * np.sin(angle)
            distance = float(renderer.cast([(point[0], 0.5, 10)], [(0, 0, -1)])["distance"][0])
            assert distance == pytest.approx(10 - point[1], abs=1e-5)


def test_replaced_skinned_meshes_are_at_one_place(device):
    """The vertices of a skinned mesh far from the world's origin are relative to a point near its joints. A mesh without
    a skin has none, so that it is at the world's origin, at rest and in animations."""
    scene = Scene()
    joint = scene.add_node("joint", translation=(5000, 0, 0))
    skin = scene.add_skin([joint])
    values = {"skin": skin, "joints": [[0]] * 4, "joint_weights": [[1]] * 4}
    mesh = scene.add_mesh(SQUARE, FACES, normals=NORMALS, **values)
    instance = scene.instances(scene.add_node("skinned", parts=[(mesh, paint(scene))]))[0]
    scene.add_animation("stay", [AnimationChannel(node=joint, property="translation", times=[0], values=[[5000, 0, 0]])])
    renderer = latelight.Renderer(scene, device)

    def distances(time):
        hits = renderer.cast([(0, 0, 10), (5000, 0, 10)], [(0, 0, -1)] * 2, time=time)
        return pytest.approx(hits["distance"].tolist(), abs=1e-5)

    for _ in range(2):
        assert [distances(time) for time in (None, 0)] == [[np.inf, 10]] * 2
        scene.set_mesh(mesh, SQUARE, FACES, normals=NORMALS)
        assert [distances(time) for time in (None, 0)] == [[10, np.inf]] * 2
        assert scene.instance(instance).transform[0, 3] == 0
        scene.set_mesh(mesh, SQUARE, FACES, normals=NORMALS, **values)


def test_moved_nodes_are_shown_as_in_their_file(tmp_path, device):
    """A renderer that was created before the nodes moved, a new one, and one of the exported file."""
    scene = animated_scene()
    renderer = latelight.Renderer(scene, device)
    renderer.render(scene.default_camera(4 / 3), (64, 48), OUTPUTS)
    mirrored = at(1, 0, 0) @ np.diag([1.0, -1, 1, 1])
    moves = {"/root/tip": mirrored, "/face": at(-2, 1, 0) @ turned(0, 0.5), "/still": np.diag([1, 0.5, 1, 1]) @ turned(2, 1)}
    moves |= {"/sun": turned(0, -0.5), "/eye": at(0.5, 1, 8)}
    for node, transform in moves.items():
        scene.set_node_transform(node, transform)
    scene.export(tmp_path / "moved.glb")
    loaded = Scene(tmp_path / "moved.glb")
    for time in (None, 0.3125, 1.7):
        images = [
            shown.render(one.default_camera(4 / 3, time), (64, 48), OUTPUTS, time=time)
            for one, shown in ((scene, renderer), (scene, latelight.Renderer(scene, device)), (loaded, latelight.Renderer(loaded, device)))
        ]
        assert np.isfinite(images[0]["depth"]).sum() > 100
        for name in OUTPUTS:
            assert images[0][name].tobytes() == images[1][name].tobytes(), (time, name)
            if name in ("id", "part"):
                assert images[0][name].tobytes() == images[2][name].tobytes(), (time, name)
            else:
                np.testing.assert_allclose(images[0][name], images[2][name], rtol=1e-4, atol=1e-5, err_msg=f"{time} {name}")


def copies_file(path):
    """A file without animations: a square below two nodes, twice by EXT_mesh_gpu_instancing."""
    moves = np.float32([[0, 0, 0], [3, 0, 0]])
    data = SQUARE.tobytes() + np.uint32(FACES).tobytes() + moves.tobytes()
    views = [(0, 48), (48, 24), (72, 24)]
    accessors = [("VEC3", 5126, 4), ("SCALAR", 5125, 6), ("VEC3", 5126, 2)]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteOffset": begin, "byteLength": size} for begin, size in views],
        "accessors": [
            {"bufferView": i, "type": kind, "componentType": of, "count": count} for i, (kind, of, count) in enumerate(accessors)
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [
            {"name": "base", "children": [1], "translation": [0, 0, 1]},
            {"name": "arm", "children": [2, 3], "translation": [0, 0, 1]},
            {"name": "hand", "mesh": 0},
            {"name": "copies", "mesh": 0, "translation": [5, 0, 0],
             "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}},
        ],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    document["accessors"][0] |= {"min": [-1, -1, 0], "max": [1, 1, 0]}
    path.write_text(json.dumps(document))
    return Scene(path)


def test_nodes_of_files_move(tmp_path, device):
    scene = copies_file(tmp_path / "copies.gltf")
    renderer = latelight.Renderer(scene, device)

    def distances(*x):
        hits = renderer.cast([(a, 0, 10) for a in x], [(0, 0, -1)] * len(x))
        return pytest.approx(hits["distance"].tolist(), abs=1e-5)

    assert distances(0, 5, 8) == [8, 8, 8]
    scene.set_node_transform("/base/arm", at(0, 0, 4))
    assert distances(0, 5, 8) == [5, 5, 5]
    scene.set_node_transform("/base", at(0, 0, 0))
    assert distances(0, 5, 8) == [6, 6, 6]
    scene.set_node_transform("/base/arm/copies", at(4, 0, 1))
    assert distances(0, 4, 7) == [6, 5, 5]
    scene.export(tmp_path / "moved.glb")
    renderer = latelight.Renderer(Scene(tmp_path / "moved.glb"), device)
    assert distances(0, 4, 7) == [6, 5, 5]


def square_file(path, nodes, targets=(), weights=(), **members):
    """A file without animations and skins, whose mesh 0 is the square. `targets` move its vertices."""
    arrays = [SQUARE, np.uint32(FACES), *(np.float32(target) for target in targets)]
    data = b"".join(array.tobytes() for array in arrays)
    accessors = [{"bufferView": i, "type": "VEC3", "componentType": 5126, "count": 4} for i in range(len(arrays))]
    accessors[1] = {"bufferView": 1, "type": "SCALAR", "componentType": 5125, "count": 6}
    for accessor, array in zip(accessors, arrays):
        if accessor["type"] == "VEC3":
            accessor |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
    offsets = np.cumsum([0] + [array.nbytes for array in arrays]).tolist()
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    mesh = {"name": "square", "primitives": [primitive]}
    if targets:
        primitive["targets"] = [{"POSITION": 2 + i} for i in range(len(targets))]
    if weights:
        mesh["weights"] = list(weights)
    children = {child for node in nodes for child in node.get("children", ())}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": offset, "byteLength": array.nbytes} for offset, array in zip(offsets, arrays)
        ],
        "accessors": accessors,
        "meshes": [mesh],
        "nodes": nodes,
        "scenes": [{"nodes": [i for i in range(len(nodes)) if i not in children]}],
        "scene": 0,
        **members,
    }
    path.write_text(json.dumps(document))
    return Scene(path)


def test_nodes_of_files_without_animations_are_animated(tmp_path, device):
    """The animated property of a node replaces that of the file, and its other properties stay."""
    nodes = [
        {"name": "lift", "mesh": 0, "translation": [0, 0, 1], "rotation": [0, 0, HALF, HALF]},
        {"name": "mirror", "children": [2], "translation": [20, 0, 0], "scale": [1, -1, 1]},
        {"name": "child", "mesh": 0, "translation": [0, 3, 0]},
    ]
    scene = square_file(tmp_path / "still.gltf", nodes)
    lift = AnimationChannel(node="/lift", property="translation", times=[0, 1], values=[[0, 0, 1], [0, 0, 5]])
    turn = AnimationChannel(node="/mirror", property="rotation", times=[0], values=[[0, 0, HALF, HALF]])
    scene.add_animation("play", [lift, turn])
    scene.export(tmp_path / "animated.glb")
    for shown in (scene, Scene(tmp_path / "animated.glb")):
        assert distance_at(shown, device, 0.5) == pytest.approx(7, abs=1e-5)
        assert distance_at(shown, device, 0.5, (23, 0, 10)) == pytest.approx(10, abs=1e-5)  # (0, -3), turned by 90 degrees


def test_nodes_of_built_in_scenes_are_animated():
    scene = Scene("builtin:boxes")
    node = next(node for node in scene.nodes if scene.instances(node.path))
    move = AnimationChannel(node=node.path, property="translation", times=[0], values=[[0, 0, 2]])
    scene.add_animation("play", [move])
    assert [animation.name for animation in scene.animations] == ["play"]


@pytest.mark.parametrize("animated", [False, True])
def test_nodes_below_hidden_nodes_are_hidden(animated, tmp_path, device):
    """KHR_node_visibility: a node is visible if it and all nodes above it are."""
    hidden = {"KHR_node_visibility": {"visible": False}}
    nodes = [{"name": "group", "extensions": hidden}, {"name": "other", "mesh": 0, "translation": [50, 0, 0]}]
    scene = square_file(tmp_path / "hidden.gltf", nodes, extensionsUsed=["KHR_node_visibility"])
    if animated:
        move = AnimationChannel(node="/other", property="translation", times=[0], values=[[50, 0, 0]])
        scene.add_animation("move", [move])
    renderer = latelight.Renderer(scene, device, environment="none")
    camera = Camera.look_at((50, 0, 5), (50, 0, 0))
    picture = lambda time: renderer.render(camera, (8, 8), time=time)["rgba"].tobytes()
    before = picture(None)
    square = scene.add_mesh(SQUARE, FACES, normals=NORMALS)
    scene.add_node("child", "/group", parts=[(square, paint(scene))])
    scene.add_light(Light(type="directional", intensity=3), node="/group")
    assert [picture(time) for time in (None, 0)] == [before] * 2
    scene.export(tmp_path / "exported.glb")
    for shown in (scene, Scene(tmp_path / "exported.glb")):
        assert all(np.isinf(distance_at(shown, device, time)) for time in (None, 0))
    scene.add_light(Light(type="directional", intensity=3), node="/other")
    assert before not in (picture(None), picture(0))


def test_hidden_nodes_of_files_are_shown_with_what_is_below_them(tmp_path, device):
    nodes = [
        {"name": "group", "children": [1], "extensions": {"KHR_node_visibility": {"visible": False}}},
        {"name": "child", "mesh": 0},
    ]
    scene = square_file(tmp_path / "hidden.gltf", nodes, extensionsUsed=["KHR_node_visibility"])
    assert np.isinf(distance_at(scene, device, None))
    show = AnimationChannel(node="/group", property="visible", interpolation="step", times=[0], values=[[1]])
    scene.add_animation("show", [show])
    assert np.isinf(distance_at(scene, device, None))
    assert distance_at(scene, device, 0) == pytest.approx(10, abs=1e-5)


def test_weights_of_files_are_animated(tmp_path, device):
    """The weights of one of two nodes with the same mesh, in a file without animations and in one with others."""
    nodes = [{"name": "face", "mesh": 0}, {"name": "twin", "mesh": 0, "translation": [5, 0, 0]}]
    still = square_file(tmp_path / "still.gltf", nodes, targets=[[[0, 0, 1]] * 4], weights=[0.5])
    still.export(tmp_path / "exported.glb")
    moved = Scene(tmp_path / "still.gltf")
    stay = AnimationChannel(node="/twin", property="translation", times=[0], values=[[5, 0, 0]])
    moved.add_animation("stay", [stay])
    moved.export(tmp_path / "moved.glb")
    for scene in (still, moved, Scene(tmp_path / "exported.glb"), Scene(tmp_path / "moved.glb")):
        renderer = latelight.Renderer(scene, device)

        def distances(shown, **options):
            hits = shown.cast([(0.25, 0, 10), (5.25, 0, 10)], [(0, 0, -1)] * 2, **options)
            return pytest.approx(hits["distance"].tolist(), abs=1e-5)

        assert distances(renderer) == [9.5, 9.5]
        smile = AnimationChannel(node="/face", property="weights", times=[0, 1], values=[[0], [2]])
        scene.add_animation("smile", [smile])
        scene.export(tmp_path / "smile.glb")
        for shown in (renderer, latelight.Renderer(Scene(tmp_path / "smile.glb"), device)):
            assert distances(shown) == [9.5, 9.5]
            assert distances(shown, time=1, animation="smile") == [8, 9.5]


# --- the same scene from a file ---------------------------------------------------------------------------------------


def animated_scene():
    """All kinds of animation in one scene, with numbers that glTF keeps exactly."""
    scene = Scene()
    red, blue = (
        paint(scene, name, base_color=color)
        for name, color in (("red", (1, 0.25, 0.125, 1)), ("blue", (0.125, 0.25, 1, 1)))
    )
    root, tip = bent_sheet(scene, red)
    targets = [
        {"positions": np.float32([[0, 0, 1], [0, 0, 0], [0, 1, 0], [0, 0, 0]]), "normals": np.float32([[0, 1, 0]] * 4)},
        {"positions": np.float32([[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, -1]])},
    ]
    smooth = scene.add_mesh(SQUARE, FACES, normals=NORMALS, targets=targets, uv=SQUARE[:, :2], name="smooth")
    only = [{"positions": target["positions"]} for target in targets]
    flat = scene.add_mesh(SQUARE + [0, 2.5, 0], FACES, targets=only, name="flat")  # normals follow its triangles
    face = scene.add_node("face", translation=(-2, 0, 0), parts=[(smooth, blue), (flat, red)], weights=[0.25, 0])
    still = scene.add_node("still", matrix=np.array([[0, 0, 1, 3], [0, 1, 0, -1], [-1, 0, 0, 0], [0, 0, 0, 1.0]]))
    plain = scene.add_mesh(SQUARE, FACES, normals=NORMALS, name="plain")
    wheel = scene.add_node("wheel", still, parts=[(plain, blue)])
    eye = scene.add_node("eye", translation=(0, 1, 9))
    scene.add_camera(Camera(name="eye", vertical_fov=50), node=eye)
    scene.add_light(Light(type="directional", intensity=3), node=scene.add_node("sun", rotation=(-0.6, 0, 0, 0.8)))

    def channel(node, property, times, values, interpolation="linear"):
        return AnimationChannel(
            node=node, property=property, times=times, values=values, interpolation=interpolation
        )

    scene.add_animation(
        "all",
        [
            channel(tip, "rotation", [0, 0.5, 2], [[0, 0, 0, 1], [0, -HALF, 0, HALF], [0, 0, 0, 1]]),
            channel(root, "translation", [0, 2], [[0, 0, 0], [0, -1, 0.5]]),
            channel(face, "weights", [0, 1, 2], [[0, 0], [1, 0.5], [0.25, -1]]),
            channel(wheel, "rotation", [0, 1], [[0] * 4, [0, 0, 0, 1], [0, 0, 1, 0], [0] * 4, [0, 0, HALF, HALF], [0] * 4], "cubicspline"),
            channel(wheel, "scale", [0, 1], [[1, 1, 1], [1, 0.5, 2]], "step"),
            channel(wheel, "visible", [0, 1.5], [[1], [0]], "step"),
            channel(eye, "translation", [0, 2], [[0, 1, 9], [1, 2, 8]]),
        ],
    )
    scene.add_animation("lift", [channel(face, "translation", [0, 1], [[-2, 0, 0], [-2, 1, 0]])])
    return scene


@pytest.mark.parametrize("raster", ["compute", "hardware"])
def test_scenes_in_memory_equal_their_files(raster, tmp_path, device):
    scene = animated_scene()
    scene.export(tmp_path / "animated.glb")
    loaded = Scene(tmp_path / "animated.glb")
    assert [(a.name, a.duration) for a in loaded.animations] == [("all", 2), ("lift", 1)]
    assert [node.path for node in loaded.nodes] == [node.path for node in scene.nodes]
    assert scene.id_manifest() == loaded.id_manifest()
    renderers = [latelight.Renderer(one, device) for one in (scene, loaded)]
    shown = set()
    for animation in ("all", "lift", ""):
        for time in (None, 0, 0.3125, 1, 1.7, 3) if animation == "" else (0, 0.3125, 1, 1.7, 3):
            images = []
            for one, renderer in zip((scene, loaded), renderers):
                camera = one.default_camera(4 / 3, time, animation)
                options = {"time": time, "animation": animation, "raster": raster}
                images.append(renderer.render(camera, (64, 48), OUTPUTS, **options))
            for name in OUTPUTS:
                assert images[0][name].tobytes() == images[1][name].tobytes(), (animation, time, name)
            assert np.isfinite(images[0]["depth"]).any()
            shown.add(images[0]["rgba"].tobytes())
    assert len(shown) >= 8  # the animations do play


def test_renderers_follow_added_animations(device):
    """What is added after a renderer was created is seen as by a new renderer."""
    scene = Scene()
    look = paint(scene)
    scene.add_instance(scene.add_mesh(SQUARE, FACES, normals=NORMALS), look, np.diag([0.25, 0.25, 1, 1]), "still")
    renderer = latelight.Renderer(scene, device)
    camera = Camera.look_at((1, 0, 8), (1, 0, 0))
    renderer.render(camera, (32, 32), "depth")
    _, tip = bent_sheet(scene, look)
    targets = [{"positions": np.float32([[0, 0, 2]] * 4)}]
    mesh = scene.add_mesh(SQUARE * 0.5, FACES, normals=NORMALS, targets=targets)
    scene.add_instance(mesh, look, np.eye(4), "before")  # shows the mesh too, and follows its weights
    node = scene.add_node("face", translation=(0, -2, 0), parts=[(mesh, look)], weights=[0.5])
    turn = AnimationChannel(node=tip, property="rotation", times=[0, 1], values=[[0, 0, 0, 1], [0, -HALF, 0, HALF]])
    morph = AnimationChannel(node=node, property="weights", times=[0, 1], values=[[0], [1]])
    for time in (None, 0.5):
        if time is not None:
            scene.add_animation("bend", [turn, morph])
        options = {"time": time, "outputs": ("depth", "normal", "part")}
        ours = renderer.render(camera, (32, 32), **options)
        new = latelight.Renderer(scene, device).render(camera, (32, 32), **options)
        for name in options["outputs"]:
            assert ours[name].tobytes() == new[name].tobytes(), (time, name)
    assert scene.instance(scene.instances("/still")[0]).transform[0, 0] == 0.25


# --- refusals ---------------------------------------------------------------------------------------------------------


def test_invalid_animations_are_refused():
    scene = Scene()
    look = paint(scene)
    mesh = scene.add_mesh(SQUARE, FACES, targets=[{"positions": SQUARE}])
    node = scene.add_node("a", parts=[(mesh, look)])
    skin = scene.add_skin([node])
    plain = scene.add_node("b")

    def refused(words, call):
        with pytest.raises(latelight.UsageError, match=words) as caught:
            call()
        assert "\n" not in str(caught.value)

    def animate(**values):
        channel = {"node": node, "property": "translation", "times": [0, 1], "values": [[0] * 3] * 2, **values}
        return lambda: scene.add_animation("play", [AnimationChannel(**channel)])

    refused('no node "/c": give the path', lambda: scene.add_node("x", "/c"))
    refused("must not contain a slash", lambda: scene.add_node("x/y"))
    refused("quaternion of a length above 0", lambda: scene.add_node("x", rotation=(0, 0, 0, 0)))
    refused("last row 0 0 0 1", lambda: scene.add_node("x", matrix=np.ones((4, 4))))
    refused("has 2 weights, but its meshes have 0", lambda: scene.add_node("x", weights=[1, 2]))
    refused("already has the weights of another node", lambda: scene.add_node("x", parts=[(mesh, look)]))
    refused("must be pairs", lambda: scene.add_node("x", parts=[(mesh,)]))
    refused("a skin must have a joint", lambda: scene.add_skin([]))
    refused("inverse_bind must be an array of shape", lambda: scene.add_skin([node], np.eye(4)))
    refused("must have the last row 0 0 0 1", lambda: scene.add_skin([node], np.ones((1, 4, 4))))
    refused("values, but its 2 times require 6", animate(values=[[0, 0]] * 2))
    refused("values, but its 2 times require 18", animate(interpolation="cubicspline"))
    refused("times must be finite and at least 0", animate(times=[-1, 0]))
    refused("they must ascend", animate(times=[1, 0]))
    refused("has no times", animate(times=[], values=np.zeros((0, 3))))
    refused("rotation 0 0 0 0", animate(property="rotation", values=np.zeros((2, 4))))
    refused("no morph targets", animate(node=plain, property="weights", values=[[0], [1]]))
    refused("must have steps", animate(property="visible", values=[[0], [1]]))
    refused("property must be one of translation", animate(property="color"))
    refused("interpolation must be one of step", animate(interpolation="bezier"))
    refused("moves nothing", lambda: scene.add_animation("none", []))
    refused("row for each of the 4 positions", lambda: scene.add_mesh(SQUARE, targets=[{"positions": SQUARE[:3]}]))
    refused("changes normals, which the mesh", lambda: scene.add_mesh(SQUARE, FACES, targets=[{"normals": SQUARE}]))
    refused('no "uv"', lambda: scene.add_mesh(SQUARE, targets=[{"uv": SQUARE}]))

    def skinned(joints, weights, **values):
        return lambda: scene.add_mesh(SQUARE, FACES, joints=joints, joint_weights=weights, **{"skin": skin, **values})

    refused("has the joint 1, but its skin has 1", skinned([[1]] * 4, [[1]] * 4))
    refused("at least 0", skinned([[0]] * 4, [[-1]] * 4))
    refused("weights of vertex 0 .* are 0", skinned([[0]] * 4, [[0]] * 4))
    refused("must be given together", skinned([[0]] * 4, None))
    refused("has joints but no skin", skinned([[0]] * 4, [[1]] * 4, skin=None))
    refused("belongs to another scene", lambda: Scene().add_mesh(SQUARE, FACES, skin=skin, joints=[[0]] * 4, joint_weights=[[1]] * 4))
    refused("has 0 joints for 4 positions", lambda: scene.add_mesh(SQUARE, FACES, skin=skin))
    refused("has 2 morph targets, but the node that shows it has 1", lambda: scene.set_mesh(mesh, SQUARE, FACES, targets=[{}, {}]))
    boxes = Scene("builtin:boxes")
    assert boxes.add_node("x") == "/x"
    assert scene.animations == [] and len(scene.nodes) == 2


@pytest.mark.parametrize(
    "scale",
    [(1, 0, 2), (0, 1, -2), (2, 3, 0), (-1, 0, 1), (2, 0, 0), (0, -3, 0), (0, 0, 2), (0, 0, 0), (1, 1e-20, 2)],
)
@pytest.mark.parametrize("degrees", [0, 30, 90, 180])
@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 1, 1), (3, -2, 1)])
def test_flat_matrices_move_animated_nodes(scale, degrees, axis):
    """A scale of zero leaves axes without a direction, but shears nothing."""
    cross = np.cross(np.eye(3), np.array(axis) / np.linalg.norm(axis))  # Rodrigues' formula
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    moved = np.eye(4)
    moved[:3, :3] = (np.eye(3) - sine * cross + (1 - cosine) * cross @ cross) * scale
    moved[:3, 3] = (1, 2, 3)
    scene = Scene()
    node = scene.add_node("node")
    scene.add_animation("move", [AnimationChannel(node=node, property="translation", times=[0], values=[[4, 5, 6]])])
    scene.set_node_transform(node, moved)
    np.testing.assert_allclose(scene.nodes[0].transform, moved, atol=1e-12)


def test_invalid_moves_are_refused(tmp_path):
    scene = Scene()
    mesh, look = scene.add_mesh(SQUARE, FACES), paint(scene)
    parent = scene.add_node("parent", matrix=np.diag([1e30, 1, 1, 1]))
    node = scene.add_node("node", parent, translation=(1, 0, 0), parts=[(mesh, look)])
    scene.add_instance(mesh, look, name="added")
    sheared = np.eye(4)
    sheared[0, 1] = 0.5

    def refused(words, path, transform):
        before = {node.path: node.transform.tolist() for node in scene.nodes}
        with pytest.raises(latelight.UsageError, match=words) as caught:
            scene.set_node_transform(path, transform)
        assert "\n" not in str(caught.value)
        assert {node.path: node.transform.tolist() for node in scene.nodes} == before

    refused('no node "/nothing": give the path', "/nothing", np.eye(4))
    refused("last row 0 0 0 1", node, np.ones((4, 4)))
    refused("transform must hold finite numbers", node, np.diag([np.inf, 1, 1, 1]))
    refused("/parent/node has a transform that is not finite", node, np.diag([1e300, 1, 1, 1]))
    refused("/parent/node would get a transform that is not finite, or a node below", node, np.diag([1e30, 1, 1, 1]))
    refused("/added is that of an added instance: move the instance", "/added", np.eye(4))
    refused("transform must be an array of shape", node, np.eye(3))
    scene.set_node_transform(node, sheared)
    np.testing.assert_array_equal(scene.nodes[1].transform[:3, 1], (0.5e30, 1, 0))
    scene.set_node_transform(node, np.eye(4))
    scene.add_animation("turn", [AnimationChannel(node=node, property="rotation", times=[0], values=[[0, 0, 0, 1]])])
    refused("the matrix of the node /parent/node shears, but animations move the node", node, sheared)
    (tmp_path / "flat.stl").write_text("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n")
    with pytest.raises(latelight.UsageError, match="has Z up: only scenes in glTF's frame"):
        Scene(tmp_path / "flat.stl").set_node_transform("/flat", np.eye(4))
