"""Scenes from trimesh, and from robots by yourdfpy, which holds them as scenes of trimesh."""

from __future__ import annotations

import functools
import importlib
import os
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ._core import Material, MaterialHandle, MeshHandle, Scene
from ._enclosure import Enclosure
from ._model_builder import FROM_Z_UP, Builder, linear, missing, node_name, reading, v_down
from .errors import UsageError


def _factor(value: Any, size: int, otherwise: float = 1) -> tuple[float, ...]:
    """Factors of trimesh are floats, or bytes for colors."""
    if value is None:
        return (otherwise,) * size
    array = np.asarray(value)
    scale = 255 if array.dtype == np.uint8 else 1
    array = np.clip(array.astype(np.float64).ravel() / scale, 0, 1)
    return tuple(np.concatenate([array, np.ones(size)])[:size].tolist())


class _Trimesh(Builder):
    def __init__(self, up: str, smooth: bool) -> None:
        super().__init__(up)
        self.smooth = smooth

    def material(self, source: Any) -> MaterialHandle:
        if source is None:
            return self.default_material()
        if id(source) in self.materials:
            return self.materials[id(source)]
        self.kept.append(source)
        pbr = source if hasattr(source, "baseColorFactor") else source.to_pbr()
        mode = (pbr.alphaMode or "OPAQUE").lower()
        values = Material(
            name=str(getattr(source, "name", None) or "material"),
            base_color=_factor(pbr.baseColorFactor, 4),
            metallic=_factor(pbr.metallicFactor, 1, 1 if pbr.metallicRoughnessTexture is not None else 0)[0],
            roughness=_factor(pbr.roughnessFactor, 1)[0],
            emissive=_factor(pbr.emissiveFactor, 3, 1 if pbr.emissiveTexture is not None else 0),
            alpha_mode=mode if mode in ("opaque", "mask", "blend") else "opaque",
            alpha_cutoff=0.5 if pbr.alphaCutoff is None else float(pbr.alphaCutoff),
            double_sided=bool(pbr.doubleSided),
        )
        handle = self.materials[id(source)] = self.scene.add_material(values)
        self.add_texture(handle, "base_color", pbr.baseColorTexture, True)
        self.add_texture(handle, "metallic_roughness", pbr.metallicRoughnessTexture, False)
        self.add_texture(handle, "normal", pbr.normalTexture, False)
        self.add_texture(handle, "occlusion", pbr.occlusionTexture, False)
        self.add_texture(handle, "emissive", pbr.emissiveTexture, True)
        return handle

    def geometry(self, mesh: Any, name: Any) -> tuple[MeshHandle, MaterialHandle] | None:
        """Returns nothing for geometry without triangles, such as paths and point clouds."""
        if not hasattr(mesh, "faces") or len(mesh.faces) == 0:
            return None
        positions, indices = np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.int64)
        visual, colors, uv = mesh.visual, None, None
        normals = np.asarray(mesh.vertex_normals, np.float32) if self.smooth else None
        if getattr(visual, "uv", None) is not None and len(visual.uv) == len(positions):
            uv = v_down(visual.uv)
        if visual.kind == "vertex":
            colors = linear(np.asarray(visual.vertex_colors) / 255)
        elif visual.kind == "face":
            positions, colors = positions[indices.ravel()], linear(np.repeat(visual.face_colors, 3, axis=0) / 255)
            normals = normals[indices.ravel()] if normals is not None else None
            indices = np.arange(len(positions)).reshape(-1, 3)
        handle = self.scene.add_mesh(
            positions, indices=indices, normals=normals, uv=uv, colors=colors, name=node_name(name)
        )
        if colors is not None:
            return handle, self.white(bool((colors[:, 3] < 1).any()))
        return handle, self.material(getattr(visual, "material", None) if uv is not None else None)


def _from_trimesh_scene(model: Any, builder: _Trimesh, names: Mapping[Any, str]) -> Scene:
    """`names`: other names of nodes."""
    made_by_name = {name: builder.geometry(mesh, name) for name, mesh in model.geometry.items()}
    for node in model.graph.nodes_geometry:
        transform, geometry = model.graph[node]
        if made := made_by_name.get(geometry):
            builder.add_instance(*made, transform, names.get(node, node))
    return builder.scene


def from_trimesh(model: Any, *, up: str = "y", smooth: bool = False) -> Scene:
    """Converts a trimesh.Trimesh or trimesh.Scene.

    up: the axis that points up in the model, "y" or "z"
    smooth: use the vertex normals that trimesh computes; otherwise triangles are flat

    PBR and simple materials, textures, and vertex and face colors (sRGB) are converted. Paths, point clouds, lights and
    cameras are left out."""
    builder = _Trimesh(up, smooth)
    if hasattr(model, "faces"):
        if made := builder.geometry(model, "mesh"):
            builder.add_instance(*made, np.eye(4), "mesh")
        return builder.scene
    if not hasattr(model, "geometry") or not hasattr(model, "graph"):
        raise UsageError(f"from_trimesh requires a trimesh.Trimesh or trimesh.Scene, not {type(model).__name__}")
    return _from_trimesh_scene(model, builder, {})


# --- URDF -----------------------------------------------------------------------------------------------------------


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
        raise UsageError(f"{os.fspath(robot)} does not exist: give a .urdf file")
    enclosure = Enclosure(robot, allow_outside, _root_of(robot))
    find = functools.partial(yourdfpy.urdf.filename_handler_magic, dir=os.path.dirname(os.path.abspath(robot)))
    load = functools.partial(
        yourdfpy.URDF.load, os.fspath(robot), filename_handler=lambda fname: enclosure.check(find(fname))
    )
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


def _configure(urdf: Any, configuration: Mapping[str, float] | Sequence[float] | None) -> None:
    if configuration is None:
        return
    if isinstance(configuration, Mapping):
        unknown = set(configuration) - set(urdf.actuated_joint_names)
        if unknown:
            names = ", ".join(urdf.actuated_joint_names)
            raise UsageError(f'the robot has no joint "{min(unknown)}": its joints are {names}')
        urdf.update_cfg(dict(configuration))
    else:
        urdf.update_cfg(np.asarray(configuration, np.float64))


def _link_names(shown: Any) -> dict[Any, str]:
    """Names the nodes with geometry after their links: "arm", or "arm 0", "arm 1" and so on if a link has several."""
    parents = shown.graph.transforms.parents
    nodes: dict[Any, list[Any]] = {}
    for node in shown.graph.nodes_geometry:
        nodes.setdefault(parents.get(node, node), []).append(node)
    names = {}
    for link, parts in nodes.items():
        for number, node in enumerate(parts):
            names[node] = f"{link} {number}" if len(parts) > 1 else str(link)
    return names


def from_urdf(
    robot: Any,
    configuration: Mapping[str, float] | Sequence[float] | None = None,
    *,
    geometry: str = "visual",
    allow_outside: Sequence[str | os.PathLike[str]] = (),
) -> Scene:
    """Converts a robot: the path of a URDF file, which yourdfpy loads, or a yourdfpy.URDF.

    configuration: positions of its joints (radians, meters), by name or for all of them in order; default: as it is
    geometry: "visual" or "collision"; a robot without any visual geometry shows that of collisions, with a warning
    allow_outside: folders that the file may refer to, besides its own folder or ROS package

    Instances are named after their links. URDF has Z up, and this scene Y. `pose_urdf` moves the joints of the scene
    afterward."""
    urdf = _load_urdf(robot, allow_outside, geometry)
    if getattr(urdf, "scene", None) is None:
        raise UsageError("from_urdf requires a URDF file, or a yourdfpy.URDF that has built its scene graph")
    _configure(urdf, configuration)
    shown = _shown(urdf, geometry)
    if geometry == "visual" and shown is not urdf.scene:
        warnings.warn("the robot has no visual geometry: its collision geometry is shown", stacklevel=2)
    with reading(robot, "yourdfpy"):
        return _from_trimesh_scene(shown, _Trimesh("z", smooth=False), _link_names(shown))


def pose_urdf(
    scene: Scene, robot: Any, configuration: Mapping[str, float] | Sequence[float], *, geometry: str = "visual"
) -> None:
    """Moves the links of a scene from `from_urdf` to where they are in another configuration of the robot, which is the
    yourdfpy.URDF that the scene was made from, with the same `geometry`."""
    _configure(robot, configuration)
    shown = _shown(robot, geometry)
    for node, name in _link_names(shown).items():
        transform, _ = shown.graph[node]
        for instance in scene.instances("/" + node_name(name)):
            scene.set_transform(instance, FROM_Z_UP @ transform)
