"""Labels from Python: arrays of objects, keypoints and correspondence, and coordinates of worlds."""

import base64
import json
import math
import os
import subprocess

import numpy as np
import pytest

import latelight


@pytest.fixture(scope="module")
def cards():
    """A card of 4 x 4 m behind one of 2 x 1 m, which cover 32 x 32 and 16 x 8 pixels of 64 x 64."""
    scene = latelight.Scene()
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    mesh = scene.add_mesh(corners, indices=[[0, 1, 2], [0, 2, 3]])
    plain = scene.add_material(latelight.Material())
    for name, z, half in (("back", 0, (2, 2)), ("front", 1, (1, 0.5))):
        transform = np.diag((*half, 1, 1)).astype(float)
        transform[2, 3] = z
        scene.add_instance(mesh, plain, transform, name=name)
    return scene, latelight.Renderer(scene, os.environ.get("LATELIGHT_TEST_DEVICE", "cpu"))


def front():
    pose = np.diag((1.0, -1, -1, 1))
    pose[2, 3] = 10
    return latelight.Camera(camera_to_world=pose, orthographic=True, half_height=4, far_clip=100)


def test_labels_are_arrays(cards):
    _, renderer = cards
    labels = renderer.labels(front(), (64, 64))
    order = [labels.nodes.index("/back"), labels.nodes.index("/front")]
    assert labels.ids.dtype == np.uint32 and labels.visible_masks.dtype == bool
    assert labels.visible_masks.shape == labels.amodal_masks.shape == (2, 64, 64)
    assert labels.amodal_masks.sum((1, 2))[order].tolist() == [1024, 128]
    assert labels.visible_masks.sum((1, 2))[order].tolist() == [896, 128]
    assert labels.visible_share[order].tolist() == [896 / 1024, 1]
    assert labels.amodal_boxes[order].tolist() == [[16, 16, 32, 32], [24, 28, 16, 8]]
    assert labels.occlusions[np.ix_(order, order)].tolist() == [[0, 0], [128, 0]]
    assert (labels.id_image == (labels.visible_masks * labels.ids[:, None, None]).sum(0)).all()
    assert labels.box_max[order[0]].tolist() == [2, 2, 0]
    assert np.allclose(labels.box_corners[order[1], 0], (24, 36, 9))


def test_keypoints(cards):
    _, renderer = cards
    points = [latelight.Keypoint("/back", (0, 0, 0), name="middle"), latelight.Keypoint("/back", (0.9, 0, 0)), "/front"]
    found = renderer.keypoints(front(), points, (64, 64))
    assert found.names == ["middle", "/back", "/front"]
    assert found.visibility.tolist() == [1, 2, 2]
    assert np.allclose(found.pixels, [(32, 32), (46.4, 32), (32, 32)])
    assert np.allclose(found.depth, (10, 10, 9))
    with pytest.raises(latelight.UsageError, match="no node with this path"):
        renderer.keypoints(front(), ["/side"])
    with pytest.raises(latelight.ArgumentTypeError, match="a list of Keypoint"):
        renderer.keypoints(front(), [3])


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """The path of a scene: the node R, without a mesh, with two cards of 2 x 2 m below it and two empty nodes."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([0, 1, 2, 0, 2, 3], np.uint16)
    data = base64.b64encode(corners.tobytes() + triangles.tobytes()).decode()
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "R", "translation": [0.5, 0, 0], "rotation": [0, 0.6, 0, 0.8], "children": [1, 2, 3]},
            {"name": "Front", "mesh": 0, "translation": [0, 0, 1], "scale": [2, 0.5, 1], "children": [4]},
            {"name": "Back", "mesh": 0, "translation": [0.25, 0, -2]},
            {"name": "Mark", "translation": [0, 1, 0]},
            {"name": "Tip", "translation": [0, 1, 0.5]},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"doubleSided": True}],
        "buffers": [{"byteLength": 60, "uri": f"data:application/octet-stream;base64,{data}"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
    }
    path = tmp_path_factory.mktemp("pair") / "pair.gltf"
    path.write_text(json.dumps(document))
    return path


# A turn of 90 degrees about the z axis, and a translation.
TURN = np.array([[0, -1, 0, 0.5], [1, 0, 0, -0.25], [0, 0, 1, 0.125], [0, 0, 0, 1]], np.float64)
REST = np.array([[0.28, 0, 0.96, 0.5], [0, 1, 0, 0], [-0.96, 0, 0.28, 0], [0, 0, 0, 1]])  # of R


def placed(scene, node, displacement):
    """A node's instance, and its transform displaced in the world."""
    (instance,) = scene.instances(node)
    return instance, displacement @ scene.instance(instance).transform


def test_a_group_has_the_pose_by_which_edits_and_worlds_move_it(pair):
    scene = latelight.Scene(pair, id_nodes=["/R"])
    renderer = latelight.Renderer(scene, "cpu")
    front_moved, back_moved = placed(scene, "/R/Front", TURN), placed(scene, "/R/Back", TURN)
    rest = renderer.labels(front(), (64, 64))
    assert rest.nodes == ["/R"] and np.allclose(rest.object_to_world[0][:3], REST[:3], atol=1e-6)
    expected = TURN @ REST
    transforms = np.array([[front_moved[1], back_moved[1]], [front_moved[1], placed(scene, "/R/Back", np.eye(4))[1]]])
    worlds = renderer.labels_of_worlds(
        2, [front()], (64, 64), instances=[front_moved[0], back_moved[0]], transforms=transforms)
    assert np.allclose(worlds.object_to_world[0, 0, 0][:3], expected[:3], atol=1e-5)
    assert np.allclose(worlds.box_min[0, 0], rest.box_min, atol=1e-5)
    assert np.allclose(worlds.box_max[0, 0], rest.box_max, atol=1e-5)
    assert np.allclose(worlds.object_to_world[1, 0, 0][:3], REST[:3], atol=1e-6), "one part moves, but not the group"
    for instance, transform in (front_moved, back_moved):
        scene.set_transform(instance, transform)
    moved = renderer.labels(front(), (64, 64))
    assert np.allclose(moved.object_to_world[0][:3], expected[:3], atol=1e-6)
    assert np.allclose([moved.box_min, moved.box_max], [rest.box_min, rest.box_max], atol=1e-6)


def test_a_group_is_one_model_in_all_variations(pair, tmp_path):
    """BOP's object keeps its number, and its rotations are those that the manifest records."""
    program = os.environ.get("LATELIGHT_PROGRAM")
    if not program:
        pytest.skip("LATELIGHT_PROGRAM names no program")
    job = {
        "scenes": str(pair), "output": "set", "id-nodes": ["/R"], "repeat": 3, "formats": ["bop"],
        "options": {"size": "64x64"},
        "cameras": {"type": "list", "cameras": [{"eye": [0, 0, 9], "target": [0, 0, 0]}]},
        "variations": [{"type": "transforms", "nodes": ["R"], "rotation": [0, 360], "axis": [0, 0, 1]}],
    }
    (tmp_path / "job.json").write_text(json.dumps(job))
    subprocess.run([program, "batch", "job.json", "--devices=cpu"], cwd=tmp_path, check=True, capture_output=True)
    truth = json.loads((tmp_path / "set/train/000000/scene_gt.json").read_text())
    frames = json.loads((tmp_path / "set/manifest.json").read_text())["frames"]
    assert len(truth) == 3 and {each["obj_id"] for (each,) in truth.values()} == {1}
    for frame, (each,) in zip(frames, truth.values()):
        (values,) = frame["drawn"]
        angle = math.radians(values["nodes"][0]["rotation"])
        turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
        expected = np.diag([1, -1, -1]) @ turn @ REST[:3, :3]
        assert np.allclose(np.reshape(each["cam_R_m2c"], (3, 3)), expected, atol=1e-5)


def test_keypoints_follow_what_their_nodes_move_with(pair):
    """Nodes without a mesh follow their parent's, and a group follows its parts once all of them have moved alike."""
    scene = latelight.Scene(pair)
    renderer = latelight.Renderer(scene, "cpu")
    nodes = ["/R", "/R/Mark", "/R/Front", "/R/Front/Tip", "/R/Back"]
    local = [[0, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [0, 0.5, 1.5, 1], [0.25, 0, -2, 1]]
    rest = REST @ np.array(local, np.float64).T
    turned = (TURN @ rest).T[:, :3]
    rest = rest.T[:, :3]
    both = [placed(scene, "/R/Front", TURN), placed(scene, "/R/Back", TURN)]
    transforms = np.array([[both[0][1], placed(scene, "/R/Back", np.eye(4))[1]], [both[0][1], both[1][1]]])

    def expect(positions, moved):
        expected = np.where(np.array(moved, bool)[:, None], turned, rest)
        np.testing.assert_allclose(positions, expected, atol=1e-5)

    expect(renderer.keypoints(front(), nodes, (64, 64)).positions, [0, 0, 0, 0, 0])
    worlds = renderer.keypoints_of_worlds(
        2, [front()], nodes, (64, 64), instances=[instance for instance, _ in both], transforms=transforms)
    expect(worlds.positions[0, 0], [0, 0, 1, 1, 0])
    expect(worlds.positions[1, 0], [1, 1, 1, 1, 1])
    scene.set_transform(*both[0])
    expect(renderer.keypoints(front(), nodes, (64, 64)).positions, [0, 0, 1, 1, 0])
    scene.set_transform(*both[1])
    expect(renderer.keypoints(front(), nodes, (64, 64)).positions, [1, 1, 1, 1, 1])


def decoded(segmentation):
    """A mask from COCO's compressed run lengths."""
    runs, value, shift = [], 0, 0
    for character in segmentation["counts"]:
        group = ord(character) - 48
        value |= (group & 31) << shift
        shift += 5
        if group & 32:
            continue
        if group & 16:
            value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
        value = shift = 0
    flags = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return flags.reshape(segmentation["size"][::-1]).T


def test_labels_of_the_command(tmp_path):
    """`latelight render --labels` writes the labels of Python for the same camera."""
    program = os.environ.get("LATELIGHT_PROGRAM")
    if not program:
        pytest.skip("LATELIGHT_PROGRAM names no program to compare with")
    options = ["--labels", tmp_path / "labels.json", "--keypoints", '[{"name": "origin"}]', "--size=96x54"]
    camera = ["--eye=4,2.5,8", "--target=0,1,0", "--fov=45"]
    subprocess.run([program, "render", "builtin:boxes", *options, *camera, "--device=cpu"], check=True)
    objects = json.loads((tmp_path / "labels.json").read_text())["objects"]
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, "cpu")
    camera = scene.look_at(eye=(4, 2.5, 8), target=(0, 1, 0), vertical_fov=45)
    labels = renderer.labels(camera, (96, 54))
    keypoints = renderer.keypoints(camera, labels.nodes, (96, 54))
    by_node = {each["node"]: each for each in objects}
    assert len(labels.nodes) > 5
    assert sorted(labels.nodes) == sorted(node for node, each in by_node.items() if each["whole"]["pixelsInPicture"])
    for i, node in enumerate(labels.nodes):
        each = by_node[node]
        assert each["id"] == labels.ids[i]
        assert (decoded(each["visible"]["segmentation"]) == labels.visible_masks[i]).all()
        assert (decoded(each["whole"]["segmentation"]) == labels.amodal_masks[i]).all()
        assert each["visible"]["box"] == labels.visible_boxes[i].tolist()
        assert each["whole"]["box"] == labels.full_boxes[i].tolist()
        assert each["visibleShare"] == labels.visible_share[i]
        assert np.allclose(each["box"]["size"], labels.box_max[i] - labels.box_min[i])
        others = {labels.ids[j]: labels.occlusions[i, j] for j in range(len(labels.ids)) if labels.occlusions[i, j]}
        assert {int(key): value for key, value in each["occludes"].items()} == others
        np.testing.assert_allclose(
            each["box"]["center"], (labels.box_min[i] + labels.box_max[i]) / 2, atol=1e-6)
        for corner, expected in zip(each["box"]["corners"], labels.box_corners[i], strict=True):
            assert np.isnan(expected).all() if corner is None else np.allclose(corner, expected)
        (origin,) = each["keypoints"]
        assert origin["visibility"] == keypoints.visibility[i]
        assert np.allclose(origin["pixel"], keypoints.pixels[i]) and np.allclose(origin["depth"], keypoints.depth[i])


def test_correspondence(cards):
    _, renderer = cards
    beside = front()
    pose = beside.camera_to_world.copy()
    pose[0, 3] = 0.25  # two pixels
    beside.camera_to_world = pose
    match = renderer.correspond(front(), beside, (64, 64))
    y, x = np.indices((64, 64)) + 0.5
    drawn = ~np.isnan(match.depth)
    assert drawn.sum() == 1024 and match.visible.dtype == bool
    assert np.allclose(match.pixels[drawn], np.stack([x - 2, y], -1)[drawn], atol=1e-3)
    assert (match.visible == drawn).all() and (match.flow == 0).all()


def test_correspondence_of_the_command(tmp_path):
    """`latelight render --correspond` writes the arrays of Python for the same two pictures."""
    program = os.environ.get("LATELIGHT_PROGRAM")
    if not program:
        pytest.skip("LATELIGHT_PROGRAM names no program to compare with")
    scene = latelight.Scene("builtin:boxes")
    renderer = latelight.Renderer(scene, "cpu")
    eyes = ["--eye=4,2.5,8", "--target=0,1,0", "--to-eye=-1,3,7", "--to-target=0.5,1,0"]
    places = [{"eye": (4, 2.5, 8), "target": (0, 1, 0)}, {"eye": (-1, 3, 7), "target": (0.5, 1, 0)}]
    fisheye = latelight.Lens(model="fisheye", fx=40, fy=40, cx=48, cy=27, distortion=[0.01], width=96, height=54)
    for lens, options in ((None, ["--fov=45"]), (fisheye, ["--lens=fisheye:40,40,48,27,0.01"])):
        command = [program, "render", "builtin:boxes", *eyes, *options, "--size=96x54", "--device=cpu"]
        subprocess.run([*command, "--correspond", tmp_path / "match.npz"], check=True)
        cameras = [scene.look_at(**place, **({} if lens else {"vertical_fov": 45})) for place in places]
        for camera in cameras:
            camera.lens = lens
        expected = renderer.correspond(*cameras, (96, 54))
        assert 500 < expected.visible.sum() < 96 * 54
        with np.load(tmp_path / "match.npz") as match:
            assert sorted(match) == ["depth", "flow", "pixels", "visible"]
            for name, array in match.items():
                assert array.dtype == getattr(expected, name).dtype
                np.testing.assert_array_equal(array, getattr(expected, name))


def test_coordinates_stay_with_the_object_in_worlds(cards):
    """A world moves, turns and scales both cards and the camera alike."""
    scene, renderer = cards
    angle = 0.4
    cosine, sine = math.cos(angle), math.sin(angle)
    move = np.array([[cosine, -sine, 0, 3], [sine, cosine, 0, -2], [0, 0, 1, 5], [0, 0, 0, 1]])
    scale = np.diag((2.0, 2, 2, 1))
    handles = scene.instances()
    rest = np.stack([scene.instance(handle).transform for handle in handles])
    camera = front()
    outputs = ("nocs", "object-position", "triangle")
    expected = renderer.render(camera, (64, 64), outputs)
    pose = camera.camera_to_world.copy()
    pose[:3, 3] *= 2
    wide = latelight.Camera(camera_to_world=move @ pose, orthographic=True, half_height=8, far_clip=200)
    world = {"instances": handles, "transforms": (move @ scale @ rest)[None]}
    worlds = renderer.render_worlds(1, wide, (64, 64), outputs, **world)
    arrays = renderer.render_worlds(1, wide, (64, 64), outputs, on_device=True, **world)
    for name in outputs:
        assert np.abs(worlds[name][0, 0].astype(float) - expected[name]).max() < 1e-5, name
        assert (np.from_dlpack(arrays[name]) == worlds[name]).all(), name
    assert worlds["triangle"].dtype == np.uint32


def test_labels_of_worlds(cards):
    """Two worlds and two cameras: the labels of each view are those of the edited scene."""
    scene, renderer = cards
    handles = scene.instances()
    rest = np.stack([scene.instance(handle).transform for handle in handles])
    names = [scene.instance(handle).node for handle in handles]
    moved = np.stack([rest, rest])
    moved[1, names.index("/front"), 0, 3] = 1.5
    beside = front()
    pose = beside.camera_to_world.copy()
    pose[0, 3] = 1
    beside.camera_to_world = pose
    world = {"instances": handles, "transforms": moved}
    labels = renderer.labels_of_worlds(2, [front(), beside], (64, 64), **world)
    assert isinstance(labels, latelight.WorldLabels) and sorted(labels.nodes) == ["/back", "/front"]
    assert labels.amodal_masks.shape == (2, 2, 2, 64, 64) and labels.present.all()
    assert labels.occlusions.shape == (2, 2, 2, 2) and labels.object_to_world.shape == (2, 2, 2, 4, 4)
    points = [latelight.Keypoint("/back", (0, 0, 0)), "/front"]
    keypoints = renderer.keypoints_of_worlds(2, [front(), beside], points, (64, 64), **world)
    assert keypoints.pixels.shape == (2, 2, 2, 2) and keypoints.names == ["/back", "/front"]
    assert keypoints.visibility.tolist() == [[[1, 2], [1, 2]], [[2, 2], [2, 2]]]
    for n in range(2):
        edited = latelight.Scene()
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
        mesh = edited.add_mesh(corners, indices=[[0, 1, 2], [0, 2, 3]])
        plain = edited.add_material(latelight.Material())
        for i, name in enumerate(names):
            edited.add_instance(mesh, plain, moved[n, i], name=name[1:])
        alone = latelight.Renderer(edited, os.environ.get("LATELIGHT_TEST_DEVICE", "cpu"))
        for c, camera in enumerate((front(), beside)):
            expected = alone.labels(camera, (64, 64))
            order = [expected.nodes.index(node) for node in labels.nodes]
            for name in ("visible_masks", "amodal_masks", "full_boxes", "visible_share", "box_max", "box_corners"):
                assert np.allclose(getattr(labels, name)[n, c], getattr(expected, name)[order]), name
            assert (labels.occlusions[n, c] == expected.occlusions[np.ix_(order, order)]).all()
            one = alone.keypoints(camera, points, (64, 64))
            assert np.allclose(keypoints.pixels[n, c], one.pixels)
            assert (keypoints.visibility[n, c] == one.visibility).all()
    exists = [[name == "/back" for name in names]]
    gone = renderer.labels_of_worlds(1, front(), (64, 64), instances=handles, exists=exists)
    assert gone.nodes == ["/back"] and gone.visible_share.tolist() == [[[1.0]]]


@pytest.mark.parametrize("argument", ["transforms", "metallic", "camera_to_world", "k", "environment_rotation"])
def test_worlds_that_are_not_finite_have_no_keypoints(cards, argument):
    scene, renderer = cards
    handles, camera = scene.instances(), front()
    values = {
        "transforms": np.stack([[scene.instance(handle).transform for handle in handles]] * 3),
        "metallic": np.zeros((3, len(handles))),
        "camera_to_world": np.stack([[camera.camera_to_world]] * 3),
        "k": np.tile([[20.0, 0, 32], [0, 20, 32], [0, 0, 1]], (3, 1, 1, 1)),
        "environment_rotation": np.zeros(3),
    }[argument]
    given = {argument: values, **({"instances": handles} if argument in ("transforms", "metallic") else {})}
    lens = latelight.Camera(camera_to_world=camera.camera_to_world) if argument == "k" else camera
    points = ["/front", "/back"]
    expected = renderer.keypoints_of_worlds(3, lens, points, (64, 64), **given)
    assert (expected.visibility > 0).all()
    values.reshape(3, -1)[1, 0] = np.nan
    keypoints = renderer.keypoints_of_worlds(3, lens, points, (64, 64), **given)
    assert not keypoints.visibility[1].any()
    for name in ("positions", "pixels", "depth", "visibility"):
        here = getattr(keypoints, name)
        np.testing.assert_array_equal(here[::2], getattr(expected, name)[::2])
        assert name == "visibility" or np.isnan(here[1]).all(), name


def test_worlds_correspond_as_animations_do(device):
    """Against correspond() of a scene whose animation moves in the same way."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    scene = latelight.Scene()
    mesh = scene.add_mesh(corners, indices=[[0, 1, 2], [0, 2, 3]])
    plain = scene.add_material(latelight.Material(double_sided=True))
    scene.add_instance(mesh, plain, np.diag((3.0, 2, 1, 1)), name="back")
    node = scene.add_node("front", translation=(-1.5, 0, 1), scale=(0.5, 0.5, 1), parts=[(mesh, plain)])
    move = latelight.AnimationChannel(node=node, property="translation", times=[0, 1], values=[[-1.5, 0, 1], [0.5, 0.25, 2]])
    scene.add_animation("move", [move])
    renderer = latelight.Renderer(scene, device)
    camera = latelight.Camera.look_at((0.3, 0.2, 9), (0, 0, 0))
    expected = renderer.correspond(camera, camera, (48, 48), time=0, second_time=1)

    front = scene.instances(node)
    now, later = np.eye(4), np.eye(4)
    now[:3, 3], later[:3, 3] = (-1.5, 0, 1), (0.5, 0.25, 2)
    now, later = ((m @ np.diag((0.5, 0.5, 1, 1)))[None, None] for m in (now, later))
    match = renderer.correspond_worlds(1, camera, (48, 48), instances=front, transforms=now, next_transforms=later)
    shown = ~np.isnan(expected.depth)
    assert 0.02 < (shown & ~expected.visible).mean() < 0.3
    np.testing.assert_array_equal(match.visible[0, 0], expected.visible)
    np.testing.assert_allclose(match.pixels[0, 0], expected.pixels, atol=1e-3)
    np.testing.assert_allclose(match.depth[0, 0], expected.depth, atol=1e-5)
    np.testing.assert_allclose(match.flow[0, 0], expected.flow, atol=1e-5)

    # Three worlds, in the second of which nothing moves, with two cameras, of which the second moves to the first.
    aside = latelight.Camera.look_at((2, 0.2, 9), (0, 0, 0))
    still = np.concatenate([now, now, now])
    moved = np.concatenate([later, now, later])
    poses = np.tile(np.stack([camera.camera_to_world, aside.camera_to_world]), (3, 1, 1, 1))
    after = np.tile(camera.camera_to_world, (3, 2, 1, 1))
    match = renderer.correspond_worlds(
        3,
        [camera, aside],
        (48, 48),
        instances=front,
        transforms=still,
        next_transforms=moved,
        camera_to_world=poses,
        next_camera_to_world=after,
    )
    assert match.pixels.shape == (3, 2, 48, 48, 2)
    np.testing.assert_array_equal(match.visible[0], match.visible[2])
    np.testing.assert_array_equal(match.visible[0, 0], expected.visible)
    assert (match.visible[1, 0] == shown).all() and (match.flow[1] == 0).all()
    still_scene = renderer.correspond(aside, camera, (48, 48))
    np.testing.assert_array_equal(match.visible[1, 1], still_scene.visible)
    np.testing.assert_allclose(match.pixels[1, 1], still_scene.pixels, atol=1e-3)
    turning = renderer.correspond(aside, camera, (48, 48), time=0, second_time=1)
    np.testing.assert_array_equal(match.visible[2, 1], turning.visible)
    np.testing.assert_allclose(match.pixels[2, 1], turning.pixels, atol=1e-3)


def test_correspondences_in_worlds_are_exact_far_from_the_origin(device):
    """The plane's points project to the same pixels as at the origin; floats there are half a meter apart."""
    plane, far = np.float32([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array((5e5, 0, 4e6))
    matches = []
    for at in (np.zeros(3), far):
        scene = latelight.Scene()
        material = scene.add_material(latelight.Material(double_sided=True))
        place = np.eye(4)
        place[:3, 3] = at
        scene.add_instance(scene.add_mesh(plane, [[0, 1, 2], [0, 2, 3]]), material, place)
        first, second = (latelight.Camera.look_at(at + (x, 0, 2), at) for x in (0, 0.3))
        after = second.camera_to_world[None, None]
        renderer = latelight.Renderer(scene, device)
        matches.append(renderer.correspond_worlds(1, first, (64, 48), next_camera_to_world=after))
    near, distant = matches
    assert near.visible.mean() > 0.9
    np.testing.assert_array_equal(distant.visible, near.visible)
    np.testing.assert_allclose(distant.pixels, near.pixels, atol=1e-3)


ROLLING_SIZE, ROLLING_READOUT = (160, 120), 0.1


@pytest.fixture(scope="module")
def rolling(tmp_path_factory):
    """A data set of a floor at y = 0 and a card at z = 0: three cameras at 10 m/s, each image read out in 0.1 s."""
    program = os.environ.get("LATELIGHT_PROGRAM")
    if not program:
        pytest.skip("LATELIGHT_PROGRAM names no program")
    folder = tmp_path_factory.mktemp("rolling")
    floor = "o floor\nv -30 0 -30\nv -30 0 30\nv 30 0 30\nv 30 0 -30\nf 1 2 3 4\n"
    card = "o card\nv -1 0 0\nv 1 0 0\nv 1 1.5 0\nv -1 1.5 0\nf 5 6 7 8\n"
    (folder / "scene.obj").write_text(floor + card)
    places = [{"time": t, "eye": [x, 2, 5], "target": [x, 0, -1], "fov": 50} for t, x in ((0, -1), (0.2, 1))]
    corners = [{"name": f"{x} {y}", "position": [x, y, 0]} for x in (-1, 0, 1) for y in (0.2, 1, 1.5)]
    job = {
        "scenes": "scene.obj", "output": "set", "cameras": {"type": "path", "fps": 10, "keys": places},
        "options": {"size": "{}x{}".format(*ROLLING_SIZE), "readout": ROLLING_READOUT},
        "formats": [
            {"format": "colmap", "as": "text", "points": 8},
            {"format": "coco", "keypoints": corners, "picture": "coco/{name}.png"},
        ],
    }
    (folder / "job.json").write_text(json.dumps(job))
    subprocess.run([program, "batch", "job.json", "--devices=cpu"], cwd=folder, check=True, capture_output=True)
    return folder / "set"


def rolling_pixel(point, image):
    """The pixel at which image 0, 1 or 2 shows a point: rows follow from times, and times from rows."""
    width, height = ROLLING_SIZE
    forward = np.array([0, -2, -6]) / math.sqrt(40)
    axes = np.stack([[1, 0, 0], np.cross(forward, [1, 0, 0]), forward])  # right, down, forward
    focal = height / 2 / math.tan(math.radians(25))
    row = height / 2
    for _ in range(60):
        seconds = (row / height - 0.5) * ROLLING_READOUT
        eye = np.array([image - 1 + 10 * seconds, 2, 5])
        x, y, depth = axes @ (point - eye)
        row = height / 2 + focal * y / depth
    return np.array([width / 2 + focal * x / depth, row])


def test_keypoints_of_data_sets_follow_a_rolling_shutter(rolling):
    data = json.loads((rolling / "annotations/instances.json").read_text())
    cards = [each for each in data["annotations"] if each["node"].endswith("card")]
    assert len(cards) == 3
    for card in cards:
        keypoints = np.reshape(card["keypoints"], (-1, 3))
        points = [(x, y, 0) for x in (-1, 0, 1) for y in (0.2, 1, 1.5)]
        for keypoint, point in zip(keypoints, points, strict=True):
            expected = rolling_pixel(np.array(point, float), card["image_id"])
            inside = ((expected >= 0) & (expected < ROLLING_SIZE)).all()
            assert keypoint[2] == (2 if inside else 0)
            if inside:
                np.testing.assert_allclose(keypoint[:2], expected, atol=1e-3)
        assert keypoints[:, 2].max() == 2


def test_sparse_points_lie_on_surfaces_with_a_rolling_shutter(rolling):
    lines = (rolling / "sparse/0/images.txt").read_text().splitlines()
    lines = [line for line in lines if not line.startswith("#")]
    pixels = {int(head.split()[0]): np.reshape(points.split(), (-1, 3)).astype(float)[:, :2]
              for head, points in zip(lines[::2], lines[1::2], strict=True)}
    order = {number: i for i, number in enumerate(sorted(pixels))}
    count = 0
    for line in (rolling / "sparse/0/points3D.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        values = line.split()
        point = np.array(values[1:4], float)
        assert min(abs(point[1]), abs(point[2])) < 1e-4, point
        for image, place in np.reshape(values[8:], (-1, 2)).astype(int):
            expected = rolling_pixel(point, order[image])
            # Pixels are those of the row's center: the image moves by 0.2 pixels per row.
            np.testing.assert_allclose(pixels[image][place], expected, atol=0.3)
        count += 1
    assert count > 100
