"""Scenes from robots, which yourdfpy holds as scenes of trimesh."""

from __future__ import annotations

import functools
import importlib
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ._core import Scene
from ._enclosure import Enclosure
from ._from_trimesh import TrimeshBuilder, has_triangles
from ._model_builder import FROM_Z_UP, missing, node_name, reading
from .errors import InputError, UsageError


def _root_of(urdf: str | os.PathLike[str]) -> Path | None:
    """The folder of the ROS package that a URDF file is in, if it is in one."""
    folders = Path(urdf).absolute().parents
    return next((folder for folder in folders if (folder / "package.xml").is_file()), None)


def _load_urdf(robot: Any, allow_outside: Sequence[str | os.PathLike[str]], geometry: str) -> Any:
    if not isinstance(robot, (str, os.PathLike)):
        return robot
    try:
        yourdfpy = importlib.import_module("yourdfpy")
    except ImportError:
        raise missing("yourdfpy", "from_urdf") from None
    if not os.path.isfile(robot):
        raise InputError(f"{os.fspath(robot)} does not exist: give a .urdf file")
    enclosure = Enclosure(robot, allow_outside, _root_of(robot))
    folder = os.path.dirname(os.path.abspath(robot))

    def find_mesh(fname: str) -> str:  # yourdfpy leaves out meshes that do not exist
        found = yourdfpy.urdf.filename_handler_magic(fname, folder)
        if not os.path.exists(found):
            raise InputError(f"{os.fspath(robot)}: its mesh {fname} does not exist: add the file, or correct its name")
        return enclosure.check(found)

    load = functools.partial(yourdfpy.URDF.load, os.fspath(robot), filename_handler=find_mesh)
    with reading(robot, "yourdfpy"):
        urdf = load()
        if geometry == "visual" and not _has_only_collisions(urdf):
            return urdf
        return load(build_collision_scene_graph=True, load_collision_meshes=True, force_collision_mesh=False)


def _has_only_collisions(urdf: Any) -> bool:
    links = urdf.link_map.values()
    return not any(link.visuals for link in links) and any(link.collisions for link in links)


def _shown(urdf: Any, geometry: str) -> Any:
    """The trimesh.Scene of a robot with its visual or collision geometry."""
    if geometry not in ("visual", "collision"):
        raise UsageError(f'geometry must be "visual" or "collision", not "{geometry}"')
    if geometry == "visual" and not _has_only_collisions(urdf):
        return urdf.scene
    if urdf.collision_scene is None:
        raise UsageError(
            "the robot was loaded without its collision geometry: load it with build_collision_scene_graph=True and "
            "load_collision_meshes=True"
        )
    return urdf.collision_scene


def _numbers(positions: Any) -> np.ndarray:
    """An array, because yourdfpy accepts arrays, but not all numbers, such as int."""
    try:
        return np.asarray(positions, np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"positions of joints must be numbers, not {positions!r}") from None


def _configure(urdf: Any, configuration: Mapping[str, float] | Sequence[float] | None) -> None:
    if configuration is None:
        return
    names = urdf.actuated_joint_names
    if isinstance(configuration, Mapping):
        if unknown := set(configuration) - set(names):
            raise UsageError(f'the robot has no joint "{min(unknown)}": its joints are {", ".join(names)}')
        urdf.update_cfg({name: _numbers(value) for name, value in configuration.items()})
        return
    positions = _numbers(configuration)
    if positions.shape not in ((len(names),), (len(urdf.joint_names),)):
        raise UsageError(f"give a position for each of the {len(names)} joints: {', '.join(names)}")
    urdf.update_cfg(positions)


# The path of each node begins with those of all nodes above it, so paths may take far more memory than the file.
MAX_PATH_BYTES = 1 << 28


class _Link(NamedTuple):
    """A link of a robot, with the joint that moves it: none for the base and for links that no joint connects."""

    link: Any
    path: str  # of the link's node
    joint: Any  # a yourdfpy.Joint
    joint_path: str
    parent: str  # path of the parent link's node; empty for the base
    transform: np.ndarray  # from the link to the parent link
    shapes: list[tuple[str, Any]]  # names of the nodes of its geometry, and the nodes in the trimesh.Scene


def _unused(name: str, uses: dict[str, int]) -> str:
    """The name of a node that no other node below the same parent has. `uses`: how often each name was given out"""
    unused = name
    while unused in uses:
        uses[name] += 1
        unused = f"{name} {uses[name]}"
    uses[unused] = 1
    return unused


def _shapes_by_link(shown: Any) -> dict[Any, list[Any]]:
    """The nodes of geometry with triangles."""
    parents = shown.graph.transforms.parents
    by_link: dict[Any, list[Any]] = {}
    for node in shown.graph.nodes_geometry:
        if has_triangles(shown.geometry.get(shown.graph.transforms.node_data[node]["geometry"])):
            by_link.setdefault(parents.get(node, node), []).append(node)
    return by_link


def _links(urdf: Any, shown: Any) -> Iterator[_Link]:
    """All links, in the order of the tree. This decides the path of each node: a robot is posed by the paths that its
    conversion added. Joints come before geometry in the choice of names, because users move joints by their names."""
    kind = "visual" if shown is urdf.scene else "collision"
    joints = {(joint.parent, joint.child): joint for joint in urdf.joint_map.values()}
    children: dict[Any, list[Any]] = {}
    for child, parent in shown.graph.transforms.parents.items():
        if child in urdf.link_map:
            children.setdefault(parent, []).append(child)
    shapes_by_link = _shapes_by_link(shown)
    base = shown.graph.base_frame
    stack = [_Link(base, f"/{node_name(base)}", None, "", "", FROM_Z_UP, [])]
    while stack:
        above = stack.pop()
        uses: dict[str, int] = {}
        below = []
        for child in children.get(above.link, []):
            joint = joints.get((above.link, child))
            top = f"{above.path}/{_unused(node_name(joint.name if joint else child), uses)}"
            path, joint_path = (f"{top}/{node_name(child)}", top) if joint else (top, "")
            transform, _ = shown.graph.get(child, above.link)
            below.append(_Link(child, path, joint, joint_path, above.path, transform, []))
        stack.extend(reversed(below))
        shapes = shapes_by_link.get(above.link, [])
        names = [f"{kind} {number}" for number in range(len(shapes))] if len(shapes) > 1 else [kind] * len(shapes)
        yield above._replace(shapes=[(_unused(name, uses), shape) for name, shape in zip(names, shapes)])


def _rigid(transform: np.ndarray) -> dict[str, Any]:
    """The arguments of `add_node` for a rotation and a translation, which animations can change."""
    w, x, y, z = importlib.import_module("trimesh.transformations").quaternion_from_matrix(transform)
    return {"translation": transform[:3, 3], "rotation": (x, y, z, w)}


def _add_nodes(builder: TrimeshBuilder, urdf: Any, shown: Any) -> Scene:
    """Adds the nodes of joints and links, and their geometry."""
    scene = builder.scene
    made_by_name = {name: made for name, mesh in shown.geometry.items() if (made := builder.geometry(mesh, name))}
    path_bytes = 0
    for link in _links(urdf, shown):
        parent, own = link.parent, _rigid(link.transform)
        if link.joint:
            parent, own = scene.add_node(link.joint_path.rpartition("/")[2], parent, **own), {}
        path = scene.add_node(link.path.rpartition("/")[2], parent, **own)
        path_bytes += len(path) * (2 + len(link.shapes))
        if path_bytes > MAX_PATH_BYTES:
            raise UsageError("its links are nested too deeply: join those that fixed joints connect")
        for name, shape in link.shapes:
            transform, geometry = shown.graph.get(shape, link.link)
            scene.add_node(name, path, matrix=transform, parts=[made_by_name[geometry]])
    return scene


def from_urdf(
    robot: Any,
    configuration: Mapping[str, float] | Sequence[float] | None = None,
    *,
    geometry: str = "visual",
    smooth: bool | None = None,
    allow_outside: Sequence[str | os.PathLike[str]] = (),
) -> Scene:
    """Converts a robot: the path of a URDF file, which yourdfpy loads, or a yourdfpy.URDF.

    configuration: positions of its joints (radians, meters), by name or for all of them in order; default: as it is
    geometry: "visual" or "collision"; a robot without any visual geometry shows that of collisions, with a warning
    smooth: True: use vertex normals, which trimesh computes for meshes without any; False: triangles are flat; default:
    as the mesh files define it
    allow_outside: folders that the file may refer to, besides its own folder or ROS package

    The base link is a root node. Each joint is a node below its parent link, with its origin and motion, each other
    link a node below its joint, and the geometry nodes "visual" or "collision" below its link, as in
    "/base/shoulder/arm/visual". URDF has Z up, and this scene Y. `pose_urdf` and `Scene.set_node_transform` move the
    joints of the scene afterward."""
    urdf = _load_urdf(robot, allow_outside, geometry)
    if getattr(urdf, "scene", None) is None:
        raise UsageError("from_urdf requires a URDF file, or a yourdfpy.URDF that has built its scene graph")
    _configure(urdf, configuration)
    shown = _shown(urdf, geometry)
    if geometry == "visual" and shown is not urdf.scene:
        warnings.warn("the robot has no visual geometry: its collision geometry is shown", stacklevel=2)
    with reading(robot, "yourdfpy"):
        return _add_nodes(TrimeshBuilder("z", smooth), urdf, shown)


def pose_urdf(
    scene: Scene, robot: Any, configuration: Mapping[str, float] | Sequence[float], *, geometry: str = "visual"
) -> None:
    """Sets the nodes of the joints to another configuration of the robot, which is the yourdfpy.URDF that the scene was
    made from, with the same `geometry`. Joints that mimic others follow them. The scene may also come from a file that
    such a scene was exported to."""
    if getattr(robot, "scene", None) is None:
        raise UsageError(f"pose_urdf requires the yourdfpy.URDF that the scene was made from, not {robot!r}")
    _configure(robot, configuration)
    for link in _links(robot, _shown(robot, geometry)):
        if link.joint and link.joint.type != "fixed":
            scene.set_node_transform(link.joint_path, link.transform)
