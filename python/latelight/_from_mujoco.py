"""Scenes from MuJoCo models, and worlds from MuJoCo's data: one MjData per world, or arrays of all worlds."""

from __future__ import annotations

import functools
import hashlib
import importlib
import math
import os
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._core import Camera, InstanceHandle, Light, LightHandle, Material, MaterialHandle, MeshHandle, Scene
from ._model_builder import Builder, linear, missing, node_name
from ._options import integers
from ._shapes import box, capsule, cylinder, ellipsoid, height_field, mesh_arrays, plane
from .errors import ArgumentTypeError, InputError, UsageError

INFINITE_PLANE = 100.0  # half the side of a plane that is infinite in MuJoCo, in extents of the model

# The fields of a model that the conversion reads, except positions and the model's statistics, which depend on them:
# worlds have positions of their own.
GEOM_FIELDS = ("type", "size", "dataid", "matid", "rgba")
OTHER_FIELDS = (
    *(f"mesh_{name}" for name in (
        "vert", "vertadr", "vertnum", "normal", "normaladr", "normalnum", "texcoord", "texcoordadr", "texcoordnum", "face",
        "faceadr", "facenum", "facenormal", "facetexcoord")),
    *(f"hfield_{name}" for name in ("nrow", "ncol", "adr", "data", "size")),
    *(f"mat_{name}" for name in (
        "rgba", "texid", "texuniform", "texrepeat", "metallic", "roughness", "shininess", "specular", "emission")),
    *(f"tex_{name}" for name in ("type", "width", "height", "nchannel", "adr", "data")),
    *(f"cam_{name}" for name in ("fovy", "resolution", "sensorsize", "intrinsic", "projection", "orthographic")),
    *(f"light_{name}" for name in (
        "type", "active", "cutoff", "exponent", "diffuse", "attenuation", "castshadow", "mode", "bodyid")),
)


def _digest(values: Any) -> bytes:
    array = np.asarray(values)
    return hashlib.blake2b(str(array.shape).encode() + array.tobytes(), digest_size=16).digest()


def _digests(model: Any, groups: Sequence[int], moving_lights: Sequence[int]) -> dict[str, bytes]:
    """A digest of each field of a model that the conversion reads, by its name. Versions of MuJoCo differ in fields."""
    is_shown = np.isin(model.geom_group, list(groups))
    stays = np.isin(np.arange(model.nlight), list(moving_lights), invert=True)
    values = {"geom_group": is_shown}
    values |= {f"geom_{name}": getattr(model, f"geom_{name}")[is_shown] for name in GEOM_FIELDS}
    values |= {f"light_{name}": getattr(model, f"light_{name}")[stays] for name in ("pos", "dir")}
    values |= {name: getattr(model, name) for name in OTHER_FIELDS if hasattr(model, name)}
    return {name: _digest(value) for name, value in values.items()}


class MujocoScene:
    """A scene made of a MuJoCo model.

    `scene` is the Scene, `geoms` the ids of the geoms that it shows, and `instances` their instances, in the same
    order. `cameras` are the model's cameras, and `lights` the lights with the ids `light_ids`, at the positions of
    `qpos0`. The scene has Y up, and MuJoCo Z: `worlds()` converts.
    """

    def __init__(self, scene: Scene, geoms: Sequence[int], instances: Sequence[InstanceHandle],
                 cameras: Sequence[Camera], lights: Sequence[LightHandle], geom_count: int | None = None,
                 light_ids: Sequence[int] = (), moving_lights: Sequence[int] = (),
                 light_count: int | None = None, model: Any = None, groups: Sequence[int] = ()) -> None:
        self.scene = scene
        self._groups = list(groups)  # of geoms that are shown
        self._digests = None if model is None else _digests(model, groups, moving_lights)  # None: not known
        self._equal_models: weakref.WeakSet[Any] = weakref.WeakSet() if model is None else weakref.WeakSet([model])
        self._geom_count, self._light_count = geom_count, light_count  # of the model; None: not known
        self._moving_lights = list(moving_lights)  # ids
        self.light_ids = np.asarray(light_ids, np.int64)
        self.geoms = np.asarray(geoms, np.int64)
        self.instances = list(instances)
        self.cameras = list(cameras)
        self.lights = list(lights)

    def worlds(
        self, data: Any = None, *, geom_xpos: Any = None, geom_xmat: Any = None, cam_xpos: Any = None,
        cam_xmat: Any = None, light_xpos: Any = None, light_xdir: Any = None, camera_ids: Sequence[int] | None = None,
        light_ids: Sequence[int] | None = None,
    ) -> dict[str, Any]:
        """The arguments of render_worlds() that describe worlds: `instances`, `transforms`, `camera_to_world`, and if
        lights move, `lights`, `light_position` and `light_direction`.

        data: an MjData, or a list with one per world, of the scene's model or of equal ones, which are compared when
        their data is passed for the first time; or
        geom_xpos, geom_xmat, cam_xpos, cam_xmat: arrays (N, ngeom, 3), (N, ngeom, 9) or (N, ngeom, 3, 3), and the same
        of cameras: NumPy's, or those of torch, JAX or CuPy on a GPU, which stay there (MJX, mujoco_warp)
        light_xpos, light_xdir: likewise arrays (N, nlight, 3)
        camera_ids: the model's cameras that are rendered; default: all of them, if poses of cameras are given
        light_ids: the model's lights that move; default: those on moving bodies and those that track a body. With []
        the lights stay at `qpos0`, and the call may have a `lights` of its own

        For example: renderer.render_worlds(N, robot.cameras, (64, 64), **robot.worlds(all_data))"""
        if data is not None:
            each = _list_of_data(data)
            self._require_equal_models(each)
            geom_xpos, geom_xmat = (_stacked(each, name) for name in ("geom_xpos", "geom_xmat"))
            if len(self.cameras) > 0:
                cam_xpos, cam_xmat = (_stacked(each, name) for name in ("cam_xpos", "cam_xmat"))
        moving = self._lights_of(light_ids)
        if data is not None and moving:
            light_xpos, light_xdir = (_stacked(each, name) for name in ("light_xpos", "light_xdir"))
        if (geom_xpos is None) != (geom_xmat is None) or (cam_xpos is None) != (cam_xmat is None):
            raise UsageError("positions and matrices require each other: geom_xpos and geom_xmat, cam_xpos and cam_xmat")
        if (light_xpos is None) != (light_xdir is None):
            raise UsageError("light_xpos and light_xdir require each other")
        arguments: dict[str, Any] = {}
        if geom_xpos is not None:
            arguments["instances"] = self.instances
            arguments["transforms"] = _transforms(geom_xpos, geom_xmat, self.geoms, "geom", self._geom_count)
        ids = range(len(self.cameras)) if camera_ids is None else integers(camera_ids, "camera_ids")
        for camera in ids:
            if not 0 <= camera < len(self.cameras):
                raise UsageError(f"camera_ids must be indices of the model's cameras, of which there are "
                                 f"{len(self.cameras)}, and one is {camera}")
        if cam_xpos is not None:
            arguments["camera_to_world"] = _transforms(
                cam_xpos, cam_xmat, np.asarray(ids, np.int64), "cam", len(self.cameras), (1, -1, -1))
        if light_xpos is not None and moving:
            arguments["lights"] = list(moving.values())
            arguments["light_position"] = _vectors(light_xpos, "light_xpos", list(moving), self._light_count)
            arguments["light_direction"] = _vectors(light_xdir, "light_xdir", list(moving), self._light_count)
        return arguments

    def _require_equal_models(self, each: Sequence[Any]) -> None:
        """Raises UsageError if the scene does not show what the model of a world's data shows. Models may differ in
        physics, and in positions, which the data has."""
        for world, data in enumerate(each):
            model = getattr(data, "model", None)  # the data of other packages has none
            if model is None or self._digests is None or model in self._equal_models:
                continue
            if model.ngeom != self._geom_count or model.nlight != self._light_count:
                raise UsageError(f"data must be of one model, the scene's, and that of world {world} has other geoms or "
                                 "lights: convert each model, and render its worlds in a call of their own")
            digests = _digests(model, self._groups, self._moving_lights)
            different = [name for name, digest in self._digests.items() if digests[name] != digest]
            if different:
                raise UsageError(f"data must be of one model, the scene's, and that of world {world} differs in "
                                 f"{', '.join(different)}: convert each model, and render its worlds in a call of their own")
            self._equal_models.add(model)

    def _lights_of(self, ids: Sequence[int] | None) -> dict[int, LightHandle]:
        """The lights that move, by their ids."""
        handles = dict(zip(self.light_ids.tolist(), self.lights))
        chosen = self._moving_lights if ids is None else integers(ids, "light_ids")
        for light in chosen:
            if light not in handles:
                raise UsageError(f"light_ids must be among those of the scene, {list(handles)}, and one is {light}")
        return {light: handles[light] for light in chosen}


def _list_of_data(data: Any) -> list[Any]:
    """The MjData of each world."""
    each = [data]
    if not hasattr(data, "geom_xpos"):
        try:
            iterator = iter(data)
        except TypeError:
            raise ArgumentTypeError(
                f"data must be an MjData, or a list with one per world, not {type(data).__name__}") from None
        each = list(iterator)
    if not each:
        raise UsageError("data must be an MjData, or a list with one per world, and the list is empty")
    for one in each:
        if not hasattr(one, "geom_xpos"):
            raise ArgumentTypeError(f"data must be a list with one MjData per world, not {type(one).__name__}")
    return each


def _stacked(each: list[Any], name: str) -> np.ndarray:
    arrays = [np.asarray(getattr(data, name)) for data in each]
    for array in arrays:
        if array.ndim != 2:
            raise UsageError(f"{name} of each MjData must have two dimensions, and one has {array.ndim}: "
                             "batches of worlds are arguments of their own, such as geom_xpos and geom_xmat")
        if array.shape != arrays[0].shape:
            raise UsageError(f"data must be of one model, and {name} has {len(arrays[0])} and {len(array)} rows")
    return np.stack(arrays)


def _namespace(array: Any) -> Any:
    """The module whose functions compute with the array, where it is."""
    name = type(array).__module__.split(".")[0]
    if name == "torch" or name == "cupy":
        return importlib.import_module(name)
    return importlib.import_module("jax.numpy") if name in ("jax", "jaxlib") else np


def _array(values: Any, name: str) -> Any:
    """Arrays of any package stay as they are; lists become arrays of NumPy."""
    if hasattr(values, "shape"):
        return values
    try:
        return np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise ArgumentTypeError(f"{name} must be an array of numbers, not {type(values).__name__}") from None


def _transforms(positions: Any, matrices: Any, ids: np.ndarray, what: str, count: int | None,
                flip: tuple[int, ...] = (1, 1, 1)) -> Any:
    """3x4 matrices (N, I, 3, 4) in the scene's frame, of the chosen elements.

    count: number of the model's elements, if it is known
    flip: signs of columns"""
    positions, matrices = _array(positions, f"{what}_xpos"), _array(matrices, f"{what}_xmat")
    xp = _namespace(positions)
    if xp is not _namespace(matrices):
        raise ArgumentTypeError(f"{what}_xpos and {what}_xmat must be arrays of the same package")
    if len(positions.shape) != 3 or positions.shape[2] != 3:
        raise UsageError(f"{what}_xpos must have the shape (N, n{what}, 3), not {tuple(positions.shape)}")
    worlds, elements = positions.shape[:2]
    if tuple(matrices.shape) not in ((worlds, elements, 9), (worlds, elements, 3, 3)):
        raise UsageError(f"{what}_xmat must have the shape ({worlds}, {elements}, 9) or ({worlds}, {elements}, 3, 3), "
                         f"as {what}_xpos has {worlds} worlds, not {tuple(matrices.shape)}")
    rows = matrices.reshape((worlds, elements, 3, 3))
    if count is not None and elements != count or len(ids) and int(ids.max()) >= elements:
        expected = "all of the model's elements" if count is None else f"all of the model's elements, {count},"
        raise UsageError(f"{what}_xpos must have {expected} and has {elements}")

    chosen = _indices(tuple(ids.tolist()), positions)
    placed = xp.concatenate([rows[:, chosen] * _constant(flip, positions), positions[:, chosen][..., None]], -1)
    turned = placed[:, :, _indices((0, 2, 1), positions)]  # (x, y, z) becomes (x, z, -y)
    return turned * _constant(((1.0,), (1.0,), (-1.0,)), positions)


def _constant(values: tuple[Any, ...], like: Any) -> Any:
    """An array of the same package, device and type as another one."""
    xp = _namespace(like)
    if xp.__name__ == "torch":
        return _torch_constant(values, like.device, like.dtype)
    return xp.asarray(values, like.dtype)


def _indices(ids: tuple[int, ...], like: Any) -> Any:
    """Indices of elements along an axis of an array of this package and device."""
    xp = _namespace(like)
    return _torch_constant(ids, like.device, xp.int64) if xp.__name__ == "torch" else list(ids)


@functools.lru_cache(maxsize=64)
def _torch_constant(values: tuple[Any, ...], device: Any, dtype: Any) -> Any:
    """A tensor that stays in the device's memory, because each copy from the host waits for the device."""
    torch = importlib.import_module("torch")
    with torch.inference_mode(False):
        return torch.tensor(values, device=device, dtype=dtype)


def _vectors(vectors: Any, name: str, ids: list[int], count: int | None) -> Any:
    """Positions or directions (N, L, 3) in the scene's frame, of the chosen lights.

    count: number of the model's lights, if it is known"""
    vectors = _array(vectors, name)
    if len(vectors.shape) != 3 or vectors.shape[2] != 3:
        raise UsageError(f"{name} must have the shape (N, nlight, 3), not {tuple(vectors.shape)}")
    if count is not None and vectors.shape[1] != count or max(ids) >= vectors.shape[1]:
        raise UsageError(f"{name} must have all of the model's lights, {count}, and has {vectors.shape[1]}")
    turned = vectors[:, _indices(tuple(ids), vectors)][..., _indices((0, 2, 1), vectors)]  # to (x, z, -y)
    return turned * _constant((1.0, 1.0, -1.0), vectors)


def _sharp_normals(positions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """The normals of triangles' corners as MuJoCo's renderer shows them on meshes without texture coordinates
    (mjr_uploadMesh() in render_context.c): the vertex's normal, or the triangle's if the cosine of the angle between
    them is less than 0.8. Without normals in the file, MuJoCo averages those of all triangles around a vertex, also
    across sharp edges."""
    corners = positions.astype(np.float64).reshape(-1, 3, 3)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(faces, axis=1, keepdims=True)
    faces = np.repeat(np.divide(faces, length, out=np.zeros_like(faces), where=length > 0), 3, axis=0)
    is_sharp = ((normals * faces).sum(axis=1) < 0.8) & faces.any(axis=1)
    sharp: np.ndarray = np.where(is_sharp[:, None], faces, normals)
    return sharp


def _decoded(colors: Any) -> np.ndarray:
    """Decodes colors of MuJoCo, which are values on screen. Those above 1 follow the power 2.2, which the curve of sRGB
    approximates: MuJoCo multiplies colors on screen, and powers of factors multiply to the power of the product."""
    values = np.maximum(np.asarray(colors, np.float64), 0)
    decoded: np.ndarray = np.where(values > 1, values**2.2, linear(np.minimum(values, 1)))
    return decoded


def _cone(cutoff: float, exponent: float) -> dict[str, float]:
    """The cones, in degrees, of a spot light that fades with the cosine's power `exponent` and ends at `cutoff`.

    A light of the scene fades with the square of x, which is 1 at the inner cone and 0 at the outer one, and linear in
    the cosine. The color on screen, which is sRGB, halves at the same angle as in MuJoCo."""
    half = math.sqrt(float(linear(np.full(3, 0.5))[0]))  # x where the color is half
    cosine = 0.5 ** (1 / exponent) if exponent > 0 else 0.0  # there
    outer = math.cos(math.radians(cutoff))
    inner = outer + max(cosine - outer, 0) / half
    if inner > 1:  # The light fades to half in less than the cutoff allows: a narrower cone.
        inner, outer = 1.0, (cosine - half) / (1 - half)
    degrees = math.degrees(math.acos(outer))
    return {"outer_cone": degrees, "inner_cone": min(math.degrees(math.acos(inner)), 0.95 * degrees)}


class _Mujoco(Builder):
    def __init__(self, mujoco: Any, model: Any, groups: Sequence[int]) -> None:
        super().__init__("z")
        self.mujoco, self.model, self.groups = mujoco, model, set(groups)
        self.shapes: dict[Any, MeshHandle] = {}
        self.pictures: dict[int, np.ndarray] = {}
        self.since_3_12 = tuple(map(int, mujoco.__version__.split(".")[:2])) >= (3, 12)
        self.data = mujoco.MjData(model)
        mujoco.mj_forward(model, self.data)

    def run(self) -> MujocoScene:
        model = self.model
        geoms, instances = [], []
        for geom in range(model.ngeom):
            if int(model.geom_group[geom]) not in self.groups or self.color(geom)[3] == 0:
                continue
            mesh = self.shape(geom)
            if mesh is None:
                continue
            transform = np.eye(4)
            transform[:3, :3] = self.data.geom_xmat[geom].reshape(3, 3)
            transform[:3, 3] = self.data.geom_xpos[geom]
            name = node_name(model.geom(geom).name or f"geom {geom}")
            instances.append(
                self.scene.add_instance(mesh, self.material(geom), self.world @ transform, name)
            )
            geoms.append(geom)
        cameras = [self.camera(camera) for camera in range(model.ncam)]
        for camera in cameras:
            self.scene.add_camera(camera)
        lights = self.add_lights()
        moving = [light for light in lights if self.moves(light)]
        return MujocoScene(self.scene, geoms, instances, cameras, list(lights.values()), model.ngeom,
                           light_ids=list(lights), moving_lights=moving, light_count=model.nlight, model=model,
                           groups=sorted(self.groups))

    # --- geometry ---

    def shape(self, geom: int) -> MeshHandle | None:
        """Geoms with equal shapes share a mesh. Nothing for shapes that are left out."""
        model, kind = self.model, self.mujoco.mjtGeom
        shape = kind(int(model.geom_type[geom]))
        texture = self.texture_of(geom) if self.is_projected(geom) or self.since_3_12 else None
        repeat = None if texture is None else (int(model.geom_matid[geom]), texture)
        key = (shape, int(model.geom_dataid[geom]), tuple(model.geom_size[geom]), repeat)
        if key not in self.shapes:
            made = self.make_shape(geom, shape)
            if made is None:
                return None
            self.shapes[key] = self.scene.add_mesh(**made, name=node_name(model.geom(geom).name or shape.name[7:].lower()))
        return self.shapes[key]

    def is_mesh(self, geom: int) -> bool:
        """Geoms with a signed distance field have a mesh of its surface, which MuJoCo shows."""
        kind, shape = self.mujoco.mjtGeom, int(self.model.geom_type[geom])
        return shape in (kind.mjGEOM_MESH, kind.mjGEOM_SDF) and int(self.model.geom_dataid[geom]) >= 0

    def is_projected(self, geom: int) -> bool:
        """If a 2D texture of the geom has the coordinates of projected_uv()."""
        kind, shape = self.mujoco.mjtGeom, int(self.model.geom_type[geom])
        if self.is_mesh(geom):
            return int(self.model.mesh_texcoordadr[self.model.geom_dataid[geom]]) < 0
        return shape in (kind.mjGEOM_PLANE, kind.mjGEOM_HFIELD)

    def make_shape(self, geom: int, shape: Any) -> dict[str, Any] | None:
        model, kind = self.model, self.mujoco.mjtGeom
        size = np.asarray(model.geom_size[geom], np.float64)
        if self.is_mesh(geom):
            return self.mesh(geom)
        if shape == kind.mjGEOM_HFIELD:
            field = int(model.geom_dataid[geom])
            rows, columns, first = (int(getattr(model, f"hfield_{n}")[field]) for n in ("nrow", "ncol", "adr"))
            data = np.asarray(model.hfield_data[first : first + rows * columns]).reshape(rows, columns)
            points, triangles = height_field(data, np.asarray(model.hfield_size[field]))
            return {"positions": points.astype(np.float32), "indices": triangles,
                    "uv": self.projected_uv(geom, points)}
        if shape == kind.mjGEOM_PLANE:
            half = np.where(size[:2] > 0, size[:2], INFINITE_PLANE * max(float(model.stat.extent), 1.0))
            flat = plane(half)
            return {**mesh_arrays(flat), "uv": self.projected_uv(geom, flat[0])}
        round_shapes = {
            kind.mjGEOM_SPHERE: lambda: ellipsoid(np.full(3, size[0])),
            kind.mjGEOM_ELLIPSOID: lambda: ellipsoid(size),
            kind.mjGEOM_CAPSULE: lambda: capsule(size[0], size[1]),
            kind.mjGEOM_CYLINDER: lambda: cylinder(size[0], size[1]),
            kind.mjGEOM_BOX: lambda: box(size),
        }
        if shape not in round_shapes:
            return None
        return mesh_arrays(round_shapes[shape]())

    def mesh(self, geom: int) -> dict[str, Any]:
        """Corners share no vertices, because positions, normals and texture coordinates have indices of their own."""
        model, mesh = self.model, int(self.model.geom_dataid[geom])

        def rows(values: Any, first: Any, count: Any) -> np.ndarray:
            return np.asarray(values[int(first[mesh]) : int(first[mesh]) + int(count[mesh])])

        def corners(name: str) -> np.ndarray:
            return rows(getattr(model, name), model.mesh_faceadr, model.mesh_facenum).ravel()

        positions = rows(model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum)[corners("mesh_face")]
        normals = rows(model.mesh_normal, model.mesh_normaladr, model.mesh_normalnum)[corners("mesh_facenormal")]
        if self.is_projected(geom):
            normals = _sharp_normals(positions, normals)
        made: dict[str, Any] = {"positions": positions.astype(np.float32), "normals": normals.astype(np.float32)}
        if self.is_projected(geom):
            made["uv"] = self.projected_uv(geom, positions)
        else:
            uv = rows(model.mesh_texcoord, model.mesh_texcoordadr, model.mesh_texcoordnum)[corners("mesh_facetexcoord")]
            made["uv"] = (uv * self.texcoord_scale(geom)).astype(np.float32)
        return made

    def texcoord_scale(self, geom: int) -> np.ndarray:
        """The factors by which MuJoCo 3.12 and newer versions multiply texture coordinates of meshes: `texrepeat` and,
        if the material has `texuniform`, the half extents of the geom."""
        model, material = self.model, int(self.model.geom_matid[geom])
        if not self.since_3_12 or self.texture_of(geom) is None:
            return np.ones(2)
        half = np.asarray(model.geom_size[geom][:2], np.float64)
        uniform = (half > 0) & bool(model.mat_texuniform[material])
        scale: np.ndarray = np.asarray(model.mat_texrepeat[material], np.float64) * np.where(uniform, half, 1)
        return scale

    def projected_uv(self, geom: int, points: np.ndarray) -> np.ndarray | None:
        """Texture coordinates as MuJoCo's renderer generates them along the geom's Z axis (settexture() in
        render_gl3.c): `texrepeat` images over the geom, or per 2 m if the material has `texuniform` or the geom has no
        size. The center of the geom is at (-0.5, -0.5). MuJoCo 3.12 and newer versions place the upper left corner of
        planes at (0, 0) instead."""
        if self.texture_of(geom) is None:
            return None
        model, material = self.model, int(self.model.geom_matid[geom])
        half = np.maximum(np.asarray(model.geom_size[geom][:2], np.float64), 0)
        repeat = np.asarray(model.mat_texrepeat[material], np.float64)
        per_half = (half > 0) & (not model.mat_texuniform[material])
        scale = repeat / np.where(per_half, half, 1)
        center = np.full(2, -0.5)
        if model.geom_type[geom] == self.mujoco.mjtGeom.mjGEOM_PLANE and self.since_3_12:
            center = 0.5 * scale * half - (0 if (half > 0).all() else 0.5)
        uv: np.ndarray = points[:, :2] * scale * (0.5, -0.5) + center
        return uv.astype(np.float32)

    # --- materials ---

    def color(self, geom: int) -> np.ndarray:
        """The color that MuJoCo shows: the material's, unless the geom has another one than the default."""
        own, material = np.asarray(self.model.geom_rgba[geom], np.float64), int(self.model.geom_matid[geom])
        if material < 0 or (own != [0.5, 0.5, 0.5, 1]).any():
            return own
        return np.asarray(self.model.mat_rgba[material], np.float64)

    def texture_of(self, geom: int) -> int | None:
        """The image of the geom's material: a 2D texture. Cube maps are left out."""
        material = int(self.model.geom_matid[geom])
        if material < 0:
            return None
        ids = np.atleast_1d(self.model.mat_texid[material])
        roles = [self.mujoco.mjtTextureRole.mjTEXROLE_RGB, self.mujoco.mjtTextureRole.mjTEXROLE_RGBA,
                 self.mujoco.mjtTextureRole.mjTEXROLE_USER]
        for role in roles:
            texture = int(ids[int(role)]) if int(role) < len(ids) else -1
            if texture >= 0 and self.model.tex_type[texture] == self.mujoco.mjtTexture.mjTEXTURE_2D:
                return texture
        return None

    def picture(self, texture: int) -> np.ndarray:
        if texture not in self.pictures:
            model = self.model
            width, height, channels = (int(getattr(model, f"tex_{n}")[texture]) for n in ("width", "height", "nchannel"))
            first = int(model.tex_adr[texture])
            pixels = np.asarray(model.tex_data[first : first + width * height * channels], np.uint8)
            pixels = pixels.reshape(height, width, channels)
            self.pictures[texture] = np.ascontiguousarray(np.repeat(pixels, 3, 2) if channels == 1 else pixels)
        return self.pictures[texture]

    def material(self, geom: int) -> MaterialHandle:
        model, material, rgba = self.model, int(self.model.geom_matid[geom]), self.color(geom)
        texture = self.texture_of(geom)
        kind = self.mujoco.mjtGeom
        if not self.is_mesh(geom) and int(model.geom_type[geom]) not in (kind.mjGEOM_PLANE, kind.mjGEOM_HFIELD):
            texture = None
        key = (material, tuple(rgba), texture)
        if key in self.materials:
            return self.materials[key]
        shown = linear(np.clip(rgba, 0, 1))
        values: dict[str, Any] = {"metallic": 0.0, "roughness": 0.5, "emissive": (0, 0, 0)}
        if material >= 0:
            own_metallic, own_roughness = float(model.mat_metallic[material]), float(model.mat_roughness[material])
            values["metallic"] = min(own_metallic, 1.0) if own_metallic >= 0 else 0.0
            smooth = min(max(float(model.mat_shininess[material]), 0.0), 1.0)
            values["roughness"] = min(own_roughness, 1.0) if own_roughness >= 0 else 1 - 0.75 * smooth
            # The default of MuJoCo, 0.5, is the reflectance of other dielectrics (KHR_materials_specular).
            specular = 2 * min(max(float(model.mat_specular[material]), 0.0), 1.0)
            values["specular"], values["specular_color"] = min(specular, 1.0), (max(specular, 1.0),) * 3
            emission = max(float(model.mat_emission[material]), 0.0)
            values["emissive"] = tuple(_decoded(emission * rgba[:3]).tolist())
        name = model.mat(material).name if material >= 0 else ""
        handle = self.scene.add_material(
            Material(name=name or "material", base_color=tuple(shown.tolist()),
                     alpha_mode="blend" if rgba[3] < 1 else "opaque", **values)
        )
        if texture is not None:
            self.add_texture(handle, "base_color", self.picture(texture), True)
            if any(values["emissive"]):  # MuJoCo multiplies the sum of emitted and reflected light by the texture.
                self.add_texture(handle, "emissive", self.picture(texture), True)
        self.materials[key] = handle
        return handle

    # --- cameras and lights ---

    def pose(self, position: Any, matrix: Any) -> np.ndarray:
        """The pose of a camera that looks along -Z, in OpenCV's axes."""
        pose = np.eye(4)
        pose[:3, :3] = np.asarray(matrix).reshape(3, 3) @ np.diag([1, -1, -1])
        pose[:3, 3] = position
        return self.world @ pose

    def camera(self, camera: int) -> Camera:
        model, seen = self.model, self.frustum(camera)
        pose = self.pose(self.data.cam_xpos[camera], self.data.cam_xmat[camera])
        if seen.frustum_width > 0 and not seen.orthographic:  # intrinsics
            width, height = (max(int(pixels), 1) for pixels in model.cam_resolution[camera])
            made = Camera.from_k(self.intrinsics(seen, width, height), pose, (width, height))
        else:
            fov = float(model.cam_fovy[camera])
            made = self.scene.look_at((0, 0, 1), (0, 0, 0), vertical_fov=45 if seen.orthographic or fov <= 0 else fov)
            made.camera_to_world = pose
        if seen.orthographic:
            made.orthographic, made.half_height = True, (seen.frustum_top - seen.frustum_bottom) / 2
        if 0 < seen.frustum_near < seen.frustum_far:  # MuJoCo accepts other models, too.
            made.near_clip, made.far_clip = seen.frustum_near, seen.frustum_far
        made.name = model.cam(camera).name or f"camera {camera}"
        return made

    def frustum(self, camera: int) -> Any:
        """The frustum of MuJoCo's renderer, as an MjvGLCamera. Versions of MuJoCo differ in the name of the projection
        and in the sign of vertical offsets, and this follows the one that is installed."""
        fixed, scene = self.mujoco.MjvCamera(), self.mujoco.MjvScene(self.model, maxgeom=1)
        fixed.type, fixed.fixedcamid = self.mujoco.mjtCamera.mjCAMERA_FIXED, camera
        self.mujoco.mjv_updateCamera(self.model, self.data, fixed, scene)
        return scene.camera[0]

    @staticmethod
    def intrinsics(seen: Any, width: int, height: int) -> np.ndarray:
        """The matrix K of images that show a frustum, whose bounds lie in the near plane, with y up."""
        wide, high = 2 * seen.frustum_width, seen.frustum_top - seen.frustum_bottom
        focal_x, focal_y = seen.frustum_near * width / wide, seen.frustum_near * height / high
        if math.isclose(focal_x, focal_y, rel_tol=1e-6):  # The bounds are rounded to floats.
            focal_x = focal_y
        center_x = width / 2 - seen.frustum_center / wide * width
        center_y = seen.frustum_top / high * height
        return np.array([[focal_x, 0, center_x], [0, focal_y, center_y], [0, 0, 1]])

    def attenuation(self, light: int, distance: float) -> float:
        """The divisor of a light's color at a distance."""
        constant, by_distance, by_square = map(float, self.model.light_attenuation[light])
        divisor = constant + by_distance * distance + by_square * distance**2
        return divisor if divisor > 0 else 1.0

    def moves(self, light: int) -> bool:
        """If the light is on a body that moves, or tracks a body. Bodies of motion capture move without joints, and are
        children of the world."""
        model, body = self.model, int(self.model.light_bodyid[light])
        tracks = int(model.light_mode[light]) != int(self.mujoco.mjtCamLight.mjCAMLIGHT_FIXED)
        return bool(tracks or model.body_weldid[body] != 0 or model.body_mocapid[model.body_rootid[body]] >= 0)

    def add_lights(self) -> dict[int, LightHandle]:
        """Active lights by their ids, except image lights and spot lights without a cone. Spot lights with a cutoff of
        180 degrees are uniform, without an exponent, as in OpenGL. Lights of MuJoCo are no physical quantities, and
        fade with distance only by `attenuation`: each of these is as bright at the model's center as there, where a
        white surface that faces it has its diffuse color, divided by the attenuation."""
        model, types = self.model, self.mujoco.mjtLightType
        handles: dict[int, LightHandle] = {}
        for light in range(model.nlight):
            light_type = int(model.light_type[light])
            if not model.light_active[light] or light_type == types.mjLIGHT_IMAGE:
                continue
            position, direction = self.data.light_xpos[light], self.data.light_xdir[light]
            directional = light_type == types.mjLIGHT_DIRECTIONAL
            cone = float(model.light_cutoff[light])
            distance = max(float(np.linalg.norm(position - np.asarray(model.stat.center))), 0.1)
            kind = "directional" if directional else "spot" if light_type == types.mjLIGHT_SPOT and cone <= 90 else "point"
            if kind == "spot" and cone <= 0:
                continue
            arguments: dict[str, Any] = _cone(cone, float(model.light_exponent[light])) if kind == "spot" else {}
            diffuse = np.asarray(model.light_diffuse[light], np.float64)
            if not directional:
                diffuse = diffuse / self.attenuation(light, distance)
            color = _decoded(diffuse)
            excess = max(float(color.max()), 1.0)  # Colors of lights in glTF are at most 1.
            handles[light] = self.scene.add_light(
                Light(
                    name=model.light(light).name or f"light {light}", type=kind, color=tuple((color / excess).tolist()),
                    position=tuple((self.world[:3, :3] @ position).tolist()),
                    direction=tuple((self.world[:3, :3] @ direction).tolist()),
                    intensity=math.pi * excess * (1 if directional else distance**2),
                    cast_shadow=bool(model.light_castshadow[light]), **arguments,
                )
            )
        return handles


def from_mujoco(model: Any, *, groups: Sequence[int] = (0, 1, 2)) -> MujocoScene:
    """Converts a mujoco.MjModel, or the path of an MJCF (.xml) or .mjb file, with the package mujoco (3.3 or newer).

    groups: the groups of geoms to show; default: those that MuJoCo's viewer shows

    Converted are meshes with texture coordinates, meshes of signed distance fields, planes, height fields, spheres,
    capsules, ellipsoids, cylinders, boxes, colors, materials, 2D textures of meshes, planes and height fields, lights,
    and cameras with their projection, intrinsics, near and far planes. Planes that are infinite get a side of 200 times
    the model's extent. Cube maps, mirror images of `reflectance`, the headlight, image lights, sites, tendons, skins,
    and flexible bodies are left out. `MujocoScene.worlds()` converts the states of worlds."""
    try:
        mujoco = importlib.import_module("mujoco")
    except ImportError:
        raise missing("mujoco", "from_mujoco") from None
    if isinstance(model, (str, os.PathLike)):
        path = os.fspath(model)
        if os.path.isdir(path):
            raise InputError(f"{path} is a folder: give an .xml or .mjb file")
        if not os.path.isfile(path):
            raise InputError(f"{path} does not exist: give an .xml or .mjb file")
        try:
            load = mujoco.MjModel.from_binary_path if path.lower().endswith(".mjb") else mujoco.MjModel.from_xml_path
            model = load(path)
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{path}: MuJoCo cannot load it: {reason}") from None
    if not isinstance(model, mujoco.MjModel):
        raise UsageError(f"from_mujoco requires a mujoco.MjModel or a file, not {type(model).__name__}")
    return _Mujoco(mujoco, model, integers(groups, "groups")).run()
