"""Scenes from URDF, by yourdfpy: their links, joints and files."""

import pathlib
import re

import numpy as np
import pytest

import latelight
from model_checks import (
    OCTAHEDRON,
    URDF,
    Z_UP,
    assert_bounds,
    assert_seen_as_exported,
    has_radial_normals,
    only_material,
)

trimesh = pytest.importorskip("trimesh")


def test_robots_have_the_normals_of_their_meshes(tmp_path):
    pytest.importorskip("yourdfpy")
    vertices, faces = OCTAHEDRON
    trimesh.Trimesh(vertices, faces, vertex_normals=vertices, process=False).export(tmp_path / "smooth.glb")
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "flat.glb")
    for name, expected in (("smooth", True), ("flat", False)):
        path = tmp_path / "robot.urdf"
        link = f'<link name="base"><visual><geometry><mesh filename="{name}.glb"/></geometry></visual></link>'
        path.write_text(f'<robot name="robot">{link}</robot>')
        assert has_radial_normals(latelight.from_urdf(path)) == expected
        assert has_radial_normals(latelight.Scene(path)) == expected
        for smooth in (True, False):
            assert has_radial_normals(latelight.from_urdf(path, smooth=smooth)) == smooth


def test_robots_have_the_materials_of_meshes_without_texture_coordinates(tmp_path):
    pytest.importorskip("yourdfpy")
    (tmp_path / "red.mtl").write_text("newmtl red\nKd 1 0 0\n")
    (tmp_path / "red.obj").write_text("mtllib red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
    path = tmp_path / "robot.urdf"
    link = '<link name="base"><visual><geometry><mesh filename="red.obj"/></geometry></visual></link>'
    path.write_text(f'<robot name="robot">{link}</robot>')
    _, made = only_material(latelight.from_urdf(path))
    assert (tuple(made.base_color), made.metallic) == ((1, 0, 0, 1), 0)


def test_robots_move_their_joints(tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    path = tmp_path / "crane.urdf"
    path.write_text(URDF)
    scene = latelight.from_urdf(path)
    arm = "/base/shoulder/arm"
    nodes = ["/base", "/base/visual", "/base/shoulder", arm, f"{arm}/visual 0", f"{arm}/visual 1"]
    assert [node.path for node in scene.nodes] == nodes
    assert_bounds(scene, (-0.5, -0.25, -1), (0.5, 2.75, 1))  # 2.5 m above the shoulder, which is at 0.25 m
    robot = yourdfpy.URDF.load(str(path))
    posed = latelight.from_urdf(robot, {"shoulder": np.pi / 2})
    assert_bounds(posed, (-0.5, -0.25, -1), (0.5, 0.5, 2.5))  # the arm points along -Y, which is +Z with Y up
    latelight.pose_urdf(posed, robot, [0])
    assert_bounds(posed, (-0.5, -0.25, -1), (0.5, 2.75, 1))
    with pytest.raises(latelight.UsageError, match='no joint "elbow": its joints are shoulder'):
        latelight.pose_urdf(posed, robot, {"elbow": 1})
    with pytest.raises(latelight.UsageError, match='has no node "/base/shoulder"'):
        latelight.pose_urdf(latelight.Scene("builtin:boxes"), robot, [0])
    with pytest.raises(latelight.UsageError, match="give a position for each of the 1 joints: shoulder"):
        latelight.pose_urdf(posed, robot, [0, 1])
    with pytest.raises(latelight.UsageError, match="positions of joints must be numbers, not 'up'"):
        latelight.pose_urdf(posed, robot, {"shoulder": "up"})
    with pytest.raises(latelight.UsageError, match="requires the yourdfpy.URDF that the scene was made from, not "):
        latelight.pose_urdf(posed, str(path), [0])
    for convert in (latelight.from_urdf, latelight.Scene):
        with pytest.raises(latelight.InputError, match="missing.urdf does not exist"):
            convert(tmp_path / "missing.urdf")


# A tree of joints of each type: a mimicking joint, a turned axis, a link without geometry, and names with slashes.
TREE = """<robot name="tree">
<link name="base"><visual><origin xyz="0.1 0 0.2" rpy="0.3 0 0"/><geometry><box size="1 0.5 0.25"/></geometry></visual></link>
<link name="turret"/><link name="left/finger"><visual><geometry><sphere radius="0.2"/></geometry></visual></link>
<link name="right/finger"><visual><geometry><cylinder radius="0.1" length="0.4"/></geometry></visual></link>
<link name="slider"><visual><origin rpy="0 0.5 0.1"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
<visual><origin xyz="0 0.4 0"/><geometry><box size="0.3 0.2 0.1"/></geometry></visual></link>
<link name="wheel"><visual><geometry><cylinder radius="0.3" length="0.1"/></geometry></visual></link>
<link name="drone"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
<link name="puck"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link>
<joint name="yaw" type="revolute"><parent link="base"/><child link="turret"/><origin xyz="0 0.2 0.5" rpy="0.1 0.2 0.3"/>
<axis xyz="0 0.6 0.8"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="grip/left" type="prismatic"><parent link="turret"/><child link="left/finger"/><origin xyz="0.5 0 0"/>
<axis xyz="0 1 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
<joint name="grip/right" type="prismatic"><parent link="turret"/><child link="right/finger"/><origin xyz="0.5 0 0"/>
<axis xyz="0 -1 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/><mimic joint="grip/left" multiplier="0.5" offset="0.1"/></joint>
<joint name="mount" type="fixed"><parent link="turret"/><child link="slider"/><origin xyz="0 0 0.7" rpy="0 0 1"/></joint>
<joint name="spin" type="continuous"><parent link="slider"/><child link="wheel"/><origin xyz="0.2 0 0" rpy="1.5 0 0"/>
<axis xyz="0 0 1"/></joint>
<joint name="fly" type="floating"><parent link="base"/><child link="drone"/><origin xyz="-1 0 1" rpy="0 0 0.4"/></joint>
<joint name="glide" type="planar"><parent link="base"/><child link="puck"/><origin xyz="0 -1 0"/><axis xyz="0 0 1"/></joint>
</robot>"""


def assert_links_are_where_yourdfpy_has_them(scene, robot):
    by_path = {node.path: np.asarray(node.transform) for node in scene.nodes}
    by_name = {path.rpartition("/")[2]: transform for path, transform in by_path.items()}
    for link in robot.link_map:
        expected = Z_UP @ robot.get_transform(link)
        np.testing.assert_allclose(by_name[link.replace("/", "_")], expected, atol=1e-6, err_msg=link)
    for joint in robot.joint_map.values():  # a joint's node is where its child link is
        expected = Z_UP @ robot.get_transform(joint.child)
        np.testing.assert_allclose(by_name[joint.name.replace("/", "_")], expected, atol=1e-6, err_msg=joint.name)
    assert_geometry_is_where_yourdfpy_has_it(scene, robot.scene)


def assert_geometry_is_where_yourdfpy_has_it(scene, shown):
    instances = sum(len(scene.instances(node.path)) for node in scene.nodes)
    assert instances == len(shown.graph.nodes_geometry)
    boxes = []
    for name in shown.graph.nodes_geometry:
        transform, geometry = shown.graph[name]
        points = shown.geometry[geometry].vertices @ transform[:3, :3].T + transform[:3, 3]
        boxes.append((points @ Z_UP[:3, :3].T).min(0).tolist() + (points @ Z_UP[:3, :3].T).max(0).tolist())
    found = []
    for instance in map(scene.instance, scene.instances()):
        transform = np.asarray(instance.transform)
        points = scene.mesh_arrays(instance.mesh)["positions"] @ transform[:3, :3].T + transform[:3, 3]
        found.append(points.min(0).tolist() + points.max(0).tolist())
    np.testing.assert_allclose(sorted(found), sorted(boxes), atol=1e-6)


def random_configuration(robot, random):
    joints = [robot.joint_map[name] for name in robot.actuated_joint_names]
    bounded = [joint for joint in joints if joint.type in ("revolute", "prismatic")]
    values = {joint.name: random.uniform(joint.limit.lower, joint.limit.upper) for joint in bounded}
    return values | {joint.name: random.uniform(-9, 9) for joint in joints if joint.type == "continuous"}


def test_joints_move_all_links_below_them(tmp_path):
    """The forward kinematics of yourdfpy, in random configurations."""
    yourdfpy = pytest.importorskip("yourdfpy")
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = yourdfpy.URDF.load(str(tmp_path / "tree.urdf"))
    scene = latelight.from_urdf(robot)
    assert_links_are_where_yourdfpy_has_them(scene, robot)
    random = np.random.default_rng(5)
    for _ in range(8):
        configuration = random_configuration(robot, random)
        latelight.pose_urdf(scene, robot, configuration)
        assert_links_are_where_yourdfpy_has_them(scene, robot)
        assert_links_are_where_yourdfpy_has_them(latelight.from_urdf(robot), robot)
    parents = {node.path: node.parent for node in scene.nodes}
    wheel = "/base/yaw/turret/mount/slider/spin/wheel"
    assert parents[wheel] == wheel[: -len("/wheel")] and parents["/base"] == ""


def test_names_of_joints_that_become_equal_are_numbered(tmp_path):
    pytest.importorskip("yourdfpy")
    names = ["a_b", "a_b 2", "a/b", "a/b 2"]
    links = [f'<link name="l{i}"/>' for i in range(len(names))]
    joints = [
        f'<joint name="{name}" type="fixed"><parent link="base"/><child link="l{i}"/></joint>'
        for i, name in enumerate(names)
    ]
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="base"/>{"".join(links + joints)}</robot>')
    paths = [node.path for node in latelight.from_urdf(tmp_path / "r.urdf").nodes if node.path.count("/") == 2]
    assert paths == ["/base/a_b", "/base/a_b 2", "/base/a_b 3", "/base/a_b 2 2"]


@pytest.mark.parametrize("kind", ["visual", "collision"])
@pytest.mark.parametrize("shapes", [1, 2])
def test_joints_named_as_geometry_are_posed(tmp_path, kind, shapes):
    """Joints that are called as the nodes of geometry keep their names, and move what is below them."""
    yourdfpy = pytest.importorskip("yourdfpy")
    shape = '<{0}><origin xyz="0 {1} 0"/><geometry><box size="1 0.5 0.25"/></geometry></{0}>'
    geometry = "".join(shape.format(name, i) for name in ("visual", "collision") for i in range(shapes))
    joint = (
        '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="0 0 2"/><axis xyz="0 1 0"/>'
        '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
    )
    names = [kind, f"{kind} 0", f"{kind} 1", f"{kind} 2"]
    links = [f'<link name="{name}">{geometry}</link>' for name in ("base", *"abcd", "hand", "thumb")]
    joints = [joint.format(name, "base", link) for name, link in zip(names, "abcd")]
    joints += [joint.format("wrist", "a", "hand"), joint.format("knuckle", "hand", "thumb")]
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{"".join(links + joints)}</robot>')
    collisions = dict(build_collision_scene_graph=True, load_collision_meshes=True, force_collision_mesh=False)
    robot = yourdfpy.URDF.load(str(tmp_path / "r.urdf"), **collisions)
    scene = latelight.from_urdf(robot, geometry=kind)
    random = np.random.default_rng(9)
    for _ in range(3):
        configuration = {name: random.uniform(-3, 3) for name in robot.actuated_joint_names}
        latelight.pose_urdf(scene, robot, configuration, geometry=kind)
        assert_geometry_is_where_yourdfpy_has_it(scene, robot.scene if kind == "visual" else robot.collision_scene)
    paths = [node.path for node in scene.nodes]
    assert {f"/base/{name}/{link}" for name, link in zip(names, "abcd")} <= set(paths)
    assert f"/base/{kind}/a/wrist/hand/knuckle/thumb" in paths and not any("#" in path for path in paths)


def test_one_joint_is_moved_by_its_node(tmp_path):
    """As robots' forward kinematics: a joint's node moves the links below it, and no others."""
    yourdfpy = pytest.importorskip("yourdfpy")
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = yourdfpy.URDF.load(str(tmp_path / "tree.urdf"))
    scene = latelight.from_urdf(robot)
    robot.update_cfg({"yaw": 0.8})
    scene.set_node_transform("/base/yaw", robot.get_transform("turret", "base"))
    assert_links_are_where_yourdfpy_has_them(scene, robot)
    scene.add_camera(latelight.Camera(), node="/base/fly/drone")
    half = np.array([0, 0, np.sin(0.35), np.cos(0.35)])  # 0.7 rad about Z, at the origin of the joint "fly"
    turn = latelight.AnimationChannel(node="/base/fly", property="rotation", times=[0, 1], values=[[0, 0, 0, 1], half])
    scene.add_animation("fly", [turn])
    drone = np.array([[np.cos(0.7), -np.sin(0.7), 0, -1], [np.sin(0.7), np.cos(0.7), 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]])
    expected = Z_UP @ drone @ np.diag([1, -1, -1, 1])  # from OpenCV's camera frame
    np.testing.assert_allclose(scene.cameras_at(1)[-1].camera_to_world, expected, atol=1e-6)


def test_exported_robots_keep_their_joints(tmp_path):
    """trimesh reads the nodes of the exported file, and moves the wheel by the node of a joint above it."""
    yourdfpy = pytest.importorskip("yourdfpy")
    (tmp_path / "tree.urdf").write_text(TREE)
    robot = yourdfpy.URDF.load(str(tmp_path / "tree.urdf"))
    scene = latelight.from_urdf(robot, {"yaw": -0.9, "grip/left": 0.2, "spin": 2})
    scene.export(tmp_path / "tree.glb")
    graph = trimesh.load(tmp_path / "tree.glb").graph
    for link in robot.link_map:
        expected = Z_UP @ robot.get_transform(link)
        np.testing.assert_allclose(graph.get(link.replace("/", "_"))[0], expected, atol=1e-6, err_msg=link)
    for node in scene.nodes:
        if node.parent:
            name, parent = (path.rpartition("/")[2] for path in (node.path, node.parent))
            assert graph.transforms.parents[name] == parent or name.startswith("visual")
    robot.update_cfg({"yaw": 1.1})
    graph.update("yaw", frame_from="base", matrix=robot.get_transform("turret", "base"))
    np.testing.assert_allclose(graph.get("wheel")[0], Z_UP @ robot.get_transform("wheel"), atol=1e-6)
    exported = latelight.Scene(tmp_path / "tree.glb")  # has the same paths and ids
    ids = {node.path: node.id for node in scene.nodes}
    assert {node.path: node.id for node in exported.nodes} == ids
    latelight.pose_urdf(exported, robot, {"yaw": 0.3, "grip/left": 0.1, "spin": -1})
    assert_links_are_where_yourdfpy_has_them(exported, robot)


def test_robots_of_too_many_nested_links_are_refused(tmp_path, monkeypatch):
    pytest.importorskip("yourdfpy")
    monkeypatch.setattr("latelight._from_urdf.MAX_PATH_BYTES", 5000)
    links = [f'<link name="l{i}"/>' for i in range(40)]
    joints = [
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>' for i in range(39)
    ]
    (tmp_path / "chain.urdf").write_text(f'<robot name="r">{"".join(links[:20] + joints[:19])}</robot>')
    assert len(latelight.from_urdf(tmp_path / "chain.urdf").nodes) == 39
    (tmp_path / "chain.urdf").write_text(f'<robot name="r">{"".join(links + joints)}</robot>')
    with pytest.raises(latelight.InputError, match="chain.urdf: its links are nested too deeply"):
        latelight.from_urdf(tmp_path / "chain.urdf")


def test_the_page_of_robots(tmp_path, monkeypatch):
    yourdfpy = pytest.importorskip("yourdfpy")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(URDF)
    page = (pathlib.Path(__file__).parents[2] / "docs" / "scene-files.md").read_text()
    (block,) = [text for text in re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE) if '"nod"' in text]
    names = {"latelight": latelight, "np": np, "yourdfpy": yourdfpy}
    exec(compile(block, "scene-files.md", "exec"), names)
    exported = latelight.Scene("robot.glb", id_nodes=["base", "arm"])
    assert [animation.name for animation in exported.animations] == ["nod"]
    assert len({node.id for node in exported.nodes}) == 2


def test_robots_show_collisions_if_required(tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    both, bare = tmp_path / "both.urdf", tmp_path / "bare.urdf"
    shape = '<{kind}><geometry><box size="{size}"/></geometry></{kind}>'
    links = [shape.format(kind="visual", size="1 2 3"), shape.format(kind="collision", size="4 4 4")]
    both.write_text(f'<robot name="r"><link name="base">{links[0]}{links[1]}</link></robot>')
    bare.write_text(f'<robot name="r"><link name="base">{links[1]}</link></robot>')
    assert_bounds(latelight.from_urdf(both), (-0.5, -1.5, -1), (0.5, 1.5, 1))
    assert_bounds(latelight.from_urdf(both, geometry="collision"), (-2, -2, -2), (2, 2, 2))
    with pytest.warns(UserWarning, match="no visual geometry: its collision geometry is shown"):
        scene = latelight.from_urdf(bare)
    assert_bounds(scene, (-2, -2, -2), (2, 2, 2))
    assert [node.path for node in scene.nodes] == ["/base", "/base/collision"]
    with pytest.raises(latelight.UsageError, match="load it with build_collision_scene_graph=True"):
        latelight.from_urdf(yourdfpy.URDF.load(str(bare)))
    with pytest.raises(latelight.UsageError, match='geometry must be "visual" or "collision", not "all"'):
        latelight.from_urdf(both, geometry="all")


def test_robots_are_seen_as_exported(tmp_path, device):
    pytest.importorskip("yourdfpy")
    (tmp_path / "crane.urdf").write_text(URDF)
    assert_seen_as_exported(latelight.from_urdf(tmp_path / "crane.urdf", {"shoulder": 0.7}), device, tmp_path)


@pytest.mark.parametrize("name", ["quadruped", "cartpole"])
def test_robots_of_newton_are_seen_as_exported(name, tmp_path, device):
    """Real robots, of boxes and cylinders. The geometry of the quadruped is that of its collisions."""
    pytest.importorskip("yourdfpy")
    newton = pytest.importorskip("newton")
    text = (pathlib.Path(newton.__file__).parent / "examples" / "assets" / f"{name}.urdf").read_text()
    if "<visual" not in text:
        text = text.replace("collision", "visual")
    (tmp_path / "robot.urdf").write_text(text)
    assert_seen_as_exported(latelight.from_urdf(tmp_path / "robot.urdf"), device, tmp_path)


def test_files_of_urdf_stay_in_its_folder(tmp_path):
    pytest.importorskip("yourdfpy")
    (tmp_path / "robot").mkdir()
    mesh = trimesh.creation.box((1, 1, 1)).export(file_type="stl")
    for folder in (tmp_path, tmp_path / "robot"):
        (folder / "box.stl").write_bytes(mesh)
    urdf = tmp_path / "robot" / "robot.urdf"

    def refer(name):
        urdf.write_text(
            f'<robot name="r"><link name="l"><visual><geometry><mesh filename="{name}"/></geometry></visual></link></robot>'
        )

    refer("box.stl")
    assert latelight.from_urdf(urdf).triangle_count == 12
    for name in ("../box.stl", str(tmp_path / "box.stl"), "file://" + str(tmp_path / "box.stl")):
        refer(name)
        with pytest.raises(latelight.InputError, match="box.stl, which is outside the scene's folder, at .*allow_outside"):
            latelight.from_urdf(urdf)
        assert latelight.from_urdf(urdf, allow_outside=[tmp_path]).triangle_count == 12
        assert latelight.Scene(urdf, allow_outside=[str(tmp_path)]).triangle_count == 12
    (tmp_path / "robot" / "link.stl").symlink_to(tmp_path / "box.stl")
    refer("link.stl")
    with pytest.raises(latelight.InputError, match="outside the scene's folder"):
        latelight.from_urdf(urdf)
    (tmp_path / "package.xml").write_text("<package/>")  # a ROS package, whose files belong together
    refer("package://robot/box.stl")
    assert latelight.from_urdf(urdf).triangle_count == 12
    refer("../box.stl")
    assert latelight.from_urdf(urdf).triangle_count == 12
    with pytest.raises(latelight.UsageError, match="is not a folder: allow_outside requires"):
        latelight.from_urdf(urdf, allow_outside=[tmp_path / "none"])


# yourdfpy logs a warning of such a file and leaves out its geometry.
@pytest.mark.parametrize("kind", ["visual", "collision"])
def test_meshes_of_urdf_that_do_not_exist_are_reported(tmp_path, monkeypatch, kind):
    pytest.importorskip("yourdfpy")
    monkeypatch.chdir(tmp_path)  # to which yourdfpy resolves names that it does not find
    shapes = [f'<{kind}><geometry>{shape}</geometry></{kind}>' for shape in ('<box size="1 1 1"/>', '<mesh filename="a/b.stl"/>')]
    (tmp_path / "robot.urdf").write_text(f'<robot name="r"><link name="l">{"".join(shapes)}</link></robot>')
    with pytest.raises(latelight.InputError, match="robot.urdf: its mesh a/b.stl does not exist"):
        latelight.from_urdf(tmp_path / "robot.urdf", geometry=kind)
