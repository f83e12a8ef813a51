"""The camera sensor of Newton, rendered by Latelight (packages newton 1.8 or newer and warp-lang)::

    from latelight.newton import SensorCamera

    camera = SensorCamera(model)  # instead of newton.sensors.SensorCamera
    camera.create_default_light()
    rays = SensorCamera.compute_camera_rays_pinhole(64, 64, camera_fov=1.0, device=model.device)
    color = camera.allocate_image_color(model.world_count, 64, 64)
    camera.update(state, camera_transforms, rays, color_image=color)

Poses of bodies and cameras and the colors of shapes are read where the simulation leaves them, and images are written
to the caller's arrays of Warp. On a GPU nothing passes through the host.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import newton
import numpy as np
import warp as wp

from ._core import Camera, InstanceHandle, Light, Material, MaterialHandle, MeshHandle, Renderer, Scene
from ._model_builder import FROM_Z_UP, v_down
from ._options import reject_options
from ._shapes import box, capsule, cone, cylinder, ellipsoid, height_field, mesh_arrays, plane
from .errors import UsageError

__all__ = ["SensorCamera"]

# From the frame of Newton's world to that of the scene, which has Y up.
_FROM_UP = {
    newton.Axis.X: np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], np.float64),
    newton.Axis.Y: np.eye(3),
    newton.Axis.Z: FROM_Z_UP[:3, :3],
}

# The output of the renderer for each of update()'s images.
_OUTPUTS = {
    "color_image": "rgba",
    "depth_image": "distance",
    "forward_depth_image": "depth",
    "shape_index_image": "id",
    "normal_image": "geonormal",
    "albedo_image": "albedo",
    "hdr_color_image": "color",
}
_TYPES = {
    "color_image": wp.uint32,
    "depth_image": wp.float32,
    "forward_depth_image": wp.float32,
    "shape_index_image": wp.uint32,
    "normal_image": wp.vec3f,
    "albedo_image": wp.uint32,
    "hdr_color_image": wp.vec3f,
}


# --- kernels ----------------------------------------------------------------------------------------------------------


@wp.func
def _world_of(worlds: wp.array(dtype=wp.int32), view: int):
    if worlds.shape[0] > 0:
        return worlds[view]
    return view


@wp.func
def _rows(pose: wp.transformf, file_from_world: wp.mat33f, flip: wp.vec3f, out: wp.array2d(dtype=wp.float32)):
    turn = file_from_world * wp.quat_to_matrix(wp.transform_get_rotation(pose))
    at = file_from_world * wp.transform_get_translation(pose)
    for row in range(3):
        for column in range(3):
            out[row, column] = turn[row, column] * flip[column]
        out[row, 3] = at[row]


@wp.func
def _linear(srgb: wp.float32):
    c = wp.clamp(srgb, 0.0, 1.0)
    if c <= 0.04045:
        return c / 12.92
    return wp.pow((c + 0.055) / 1.055, 2.4)


@wp.kernel
def _place_shapes(
    worlds: wp.array(dtype=wp.int32),
    shape_of: wp.array2d(dtype=wp.int32),
    shape_body: wp.array(dtype=wp.int32),
    shape_transform: wp.array(dtype=wp.transformf),
    shape_color: wp.array(dtype=wp.vec3f),
    body_q: wp.array(dtype=wp.transformf),
    file_from_world: wp.mat33f,
    transforms: wp.array4d(dtype=wp.float32),
    exists: wp.array2d(dtype=wp.bool),
    base_color: wp.array3d(dtype=wp.float32),
):
    view, instance = wp.tid()
    world = _world_of(worlds, view)
    shape = int(-1)
    if world >= 0 and world < shape_of.shape[0]:
        shape = shape_of[world, instance]
    exists[view, instance] = shape >= 0
    pose = wp.transform_identity(dtype=wp.float32)
    color = wp.vec3f(1.0, 1.0, 1.0)
    if shape >= 0:
        color = shape_color[shape]
        pose = shape_transform[shape]
        if shape_body[shape] >= 0:
            pose = wp.transform_multiply(body_q[shape_body[shape]], pose)
    _rows(pose, file_from_world, wp.vec3f(1.0, 1.0, 1.0), transforms[view, instance])
    for channel in range(3):
        base_color[view, instance, channel] = _linear(color[channel])
    base_color[view, instance, 3] = 1.0


@wp.kernel
def _place_cameras(
    camera_transforms: wp.array(dtype=wp.transformf),
    file_from_world: wp.mat33f,
    poses: wp.array4d(dtype=wp.float32),
):
    view = wp.tid()
    # Newton's cameras look along -Z with Y up, those of Latelight along Z with Y down.
    _rows(camera_transforms[view], file_from_world, wp.vec3f(1.0, -1.0, -1.0), poses[view, 0])


_PRESERVE = wp.constant(int(newton.sensors.SensorCamera.WorldRenderFlag.DISABLE_PRESERVE))


@wp.func
def _keeps(worlds: wp.array(dtype=wp.int32), view: int):
    return _world_of(worlds, view) == _PRESERVE


@wp.kernel
def _write_bytes(
    worlds: wp.array(dtype=wp.int32),
    ids: wp.array3d(dtype=wp.uint32),
    pixels: wp.array4d(dtype=wp.uint8),
    clear: wp.uint32,
    image: wp.array3d(dtype=wp.uint32),
):
    view, row, column = wp.tid()
    if _keeps(worlds, view):
        return
    packed = clear
    if ids[view, row, column] != wp.uint32(0):
        packed = wp.uint32(0)
        for channel in range(4):
            packed = packed | (wp.uint32(pixels[view, row, column, channel]) << wp.uint32(8 * channel))
    image[view, row, column] = packed


@wp.func
def _srgb_byte(value: wp.float32):
    c = wp.clamp(value, 0.0, 1.0)
    if c <= 0.0031308:
        c = 12.92 * c
    else:
        c = 1.055 * wp.pow(c, 1.0 / 2.4) - 0.055
    return wp.uint32(c * 255.0 + 0.5)


@wp.kernel
def _write_albedo(
    worlds: wp.array(dtype=wp.int32),
    ids: wp.array3d(dtype=wp.uint32),
    values: wp.array4d(dtype=wp.float32),
    clear: wp.uint32,
    image: wp.array3d(dtype=wp.uint32),
):
    view, row, column = wp.tid()
    if _keeps(worlds, view):
        return
    packed = clear
    if ids[view, row, column] != wp.uint32(0):
        packed = wp.uint32(0xFF000000)
        for channel in range(3):
            packed = packed | (_srgb_byte(values[view, row, column, channel]) << wp.uint32(8 * channel))
    image[view, row, column] = packed


@wp.kernel
def _write_floats(
    worlds: wp.array(dtype=wp.int32),
    ids: wp.array3d(dtype=wp.uint32),
    values: wp.array3d(dtype=wp.float32),
    clear: wp.float32,
    image: wp.array3d(dtype=wp.float32),
):
    view, row, column = wp.tid()
    if _keeps(worlds, view):
        return
    value = clear
    if ids[view, row, column] != wp.uint32(0):
        value = values[view, row, column]
    image[view, row, column] = value


@wp.kernel
def _write_vectors(
    worlds: wp.array(dtype=wp.int32),
    ids: wp.array3d(dtype=wp.uint32),
    values: wp.array4d(dtype=wp.float32),
    turn: wp.mat33f,
    clear: wp.vec3f,
    image: wp.array3d(dtype=wp.vec3f),
):
    view, row, column = wp.tid()
    if _keeps(worlds, view):
        return
    value = clear
    if ids[view, row, column] != wp.uint32(0):
        value = turn * wp.vec3f(
            values[view, row, column, 0], values[view, row, column, 1], values[view, row, column, 2]
        )
    image[view, row, column] = value


@wp.kernel
def _write_shapes(
    worlds: wp.array(dtype=wp.int32),
    ids: wp.array3d(dtype=wp.uint32),
    sorted_ids: wp.array(dtype=wp.uint32),
    instances: wp.array(dtype=wp.int32),
    shape_of: wp.array2d(dtype=wp.int32),
    clear: wp.uint32,
    image: wp.array3d(dtype=wp.uint32),
):
    view, row, column = wp.tid()
    if _keeps(worlds, view):
        return
    value = clear
    id = ids[view, row, column]
    if id != wp.uint32(0):
        place = wp.lower_bound(sorted_ids, id)
        value = wp.uint32(shape_of[_world_of(worlds, view), instances[place]])
    image[view, row, column] = value


# --- the scene --------------------------------------------------------------------------------------------------------


def _scaled(source: Any, scale: np.ndarray) -> dict[str, Any]:
    """The arrays of a newton.Mesh."""
    points = np.asarray(source.vertices, np.float64).reshape(-1, 3) * scale
    triangles = np.asarray(source.indices, np.int64).reshape(-1, 3)
    if np.prod(scale) < 0:
        triangles = triangles[:, ::-1]
    made: dict[str, Any] = {"positions": points.astype(np.float32), "indices": triangles}
    if source.normals is not None:
        normals = np.asarray(source.normals, np.float64).reshape(-1, 3) / scale
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        made["normals"] = (normals / np.maximum(lengths, 1e-30)).astype(np.float32)
    if source.uvs is not None:
        made["uv"] = v_down(np.asarray(source.uvs).reshape(-1, 2))
    return made


def _height_field_mesh(source: Any, scale: np.ndarray) -> dict[str, Any]:
    span = source.max_z - source.min_z
    points, triangles = height_field(
        np.asarray(source.data), np.array([source.hx, source.hy, span, 0.0]), falling=True
    )
    points = (points + [0, 0, source.min_z]) * scale
    return {"positions": points.astype(np.float32), "indices": triangles}


def _mesh_of(kind: Any, scale: np.ndarray, source: Any, plane_side: float) -> dict[str, Any] | None:
    """The arrays of add_mesh(), or None for kinds that are left out."""
    geo = newton.GeoType
    if kind in (geo.MESH, geo.CONVEX_MESH):
        return _scaled(source, scale)
    if kind == geo.PLANE:
        return mesh_arrays(plane(np.where(scale[:2] > 0, scale[:2], plane_side) / 2))
    if kind == geo.HFIELD:
        return _height_field_mesh(source, scale)
    shapes = {
        geo.SPHERE: lambda: ellipsoid(np.full(3, scale[0])),
        geo.ELLIPSOID: lambda: ellipsoid(scale),
        geo.CAPSULE: lambda: capsule(scale[0], scale[1]),
        geo.CYLINDER: lambda: cylinder(scale[0], scale[1]),
        geo.CONE: lambda: cone(scale[0], scale[1]),
        geo.BOX: lambda: box(scale),
    }
    if kind not in shapes:
        return None
    return mesh_arrays(shapes[kind]())


class _ModelScene:
    """A scene with an instance for each shape that any world has. Worlds with equal shapes share instances, whatever
    the colors of their shapes, which change between updates."""

    def __init__(self, model: Any, textures: bool, plane_side: float) -> None:
        self.textures = textures
        self.scene = Scene()
        self.meshes: dict[Any, MeshHandle | None] = {}
        self.materials: dict[Any, MaterialHandle] = {}
        self.instances: list[InstanceHandle] = []
        enabled = model.bvh_shape_enabled
        shown = set() if enabled is None else set(enabled.numpy()[: model.bvh_shape_count_enabled].tolist())
        kinds, scales = model.shape_type.numpy(), model.shape_scale.numpy().astype(np.float64)
        worlds = model.shape_world.numpy()
        count = max(int(model.world_count), 1)
        number: dict[Any, int] = {}  # of the instance, by shape and by how many such shapes its world had before
        rows: list[dict[int, int]] = [{} for _ in range(count)]
        for shape in range(model.shape_count):
            if shape not in shown:
                continue
            kind, source = newton.GeoType(int(kinds[shape])), model.shape_source[shape]
            key = (kind, tuple(scales[shape]), id(source))
            if key not in self.meshes:
                made = _mesh_of(kind, scales[shape], source, plane_side)
                self.meshes[key] = None if made is None else self.scene.add_mesh(**made, name=kind.name.lower())
            mesh = self.meshes[key]
            if mesh is None:
                continue
            world = int(worlds[shape])
            repeat = 0
            while (key, world < 0, repeat) in number and self._taken(rows, world, number[(key, world < 0, repeat)]):
                repeat += 1
            instance = number.setdefault((key, world < 0, repeat), len(self.instances))
            if instance == len(self.instances):
                material = self.material(source)
                self.instances.append(self.scene.add_instance(mesh, material, np.eye(4), f"shape {shape}"))
            for row in rows if world < 0 else (rows[world],):
                row[instance] = shape
        self.shape_of = np.full((count, len(self.instances)), -1, np.int32)
        for world, row in enumerate(rows):
            for instance, shape in row.items():
                self.shape_of[world, instance] = shape

    @staticmethod
    def _taken(rows: list[dict[int, int]], world: int, instance: int) -> bool:
        return instance in rows[max(world, 0)]

    def material(self, source: Any) -> MaterialHandle:
        """A white material, because each update sets the base color."""
        texture = getattr(source, "texture", None) if self.textures else None
        surface = {
            name: float(value)
            for name in ("roughness", "metallic")
            if (value := getattr(source, name, None)) is not None
        }
        key = (tuple(surface.items()), None if texture is None else id(source))
        if key not in self.materials:
            values = {"roughness": 1.0, "metallic": 0.0, **surface}
            made = self.scene.add_material(Material(name="shape", base_color=(1, 1, 1, 1), **values))
            if texture is not None:
                self._add_texture(made, texture)
            self.materials[key] = made
        return self.materials[key]

    def _add_texture(self, material: MaterialHandle, texture: Any) -> None:
        pixels = newton.utils.load_texture(texture) if isinstance(texture, str) else np.asarray(texture)
        if pixels is None:
            raise UsageError(f"can't load the texture {texture}: load_textures=False renders without")
        if pixels.dtype != np.uint8:
            pixels = np.rint(np.clip(pixels, 0, 1) * 255).astype(np.uint8)
        added = self.scene.add_texture(np.ascontiguousarray(pixels), srgb=True, name="texture")
        self.scene.set_texture(material, "base_color", added)


# Settings of a RenderConfig that change no image of Latelight: those of Newton's kernels, those of elements that are
# not rendered, and the use of textures, which load_textures decides.
_FREE_SETTINGS = {
    "enable_fast_math", "render_order", "tile_width", "tile_height", "block_dim", "enable_particles", "enable_textures",
    "gaussians_mode", "gaussians_min_transmittance", "gaussians_max_num_hits",
}  # fmt: skip


def _check_config(config: Any) -> None:
    """Raises UsageError for settings that Latelight would ignore."""
    if config is None:
        return
    default = SensorCamera.RenderConfig()
    names = [field.name for field in dataclasses.fields(default) if field.name not in _FREE_SETTINGS]
    if ignored := [name for name in names if getattr(config, name) != getattr(default, name)]:
        raise UsageError(
            f"the RenderConfig must have the default {', '.join(ignored)}: options of SensorCamera() set what Latelight "
            'renders, such as shadows="d32" or aa="ss2"'
        )


# --- the sensor -------------------------------------------------------------------------------------------------------


class SensorCamera:
    """Renders worlds of a Newton model, with the interface of newton.sensors.SensorCamera.

    Cameras look along their -Z axis, with +Y up. Rigid shapes are rendered: primitives, meshes, convex meshes, and
    height fields, in the colors, roughness and metalness that the model states, with their textures. Particles,
    deformable surfaces and Gaussians are not.

    Images differ from Newton's in that surfaces have a specular lobe (GGX, F0 = 0.04), and round primitives are meshes
    of 32 sides. Rays are those of a pinhole camera with one sample per pixel; for several samples
    per pixel, pass aa="ss2", for example.
    """

    AntiAliasing = newton.sensors.SensorCamera.AntiAliasing
    ClearData = newton.sensors.SensorCamera.ClearData
    DeformableSurfaceMode = newton.sensors.SensorCamera.DeformableSurfaceMode
    GaussianRenderMode = newton.sensors.SensorCamera.GaussianRenderMode
    RenderConfig = newton.sensors.SensorCamera.RenderConfig
    RenderOrder = newton.sensors.SensorCamera.RenderOrder
    TextureProjectionMode = newton.sensors.SensorCamera.TextureProjectionMode
    WorldRenderFlag = newton.sensors.SensorCamera.WorldRenderFlag
    compute_camera_rays_pinhole = staticmethod(newton.sensors.SensorCamera.compute_camera_rays_pinhole)
    compute_camera_rays_pinhole_opencv = staticmethod(newton.sensors.SensorCamera.compute_camera_rays_pinhole_opencv)
    compute_camera_rays_pinhole_usd = staticmethod(newton.sensors.SensorCamera.compute_camera_rays_pinhole_usd)

    def __init__(
        self, model: Any, *, default_clear_data: Any = None, default_render_config: Any = None,
        load_textures: bool = True, deformable_surface_mode: Any = 0, infinite_plane: float = 100.0,
        device: str | None = None, **options: Any,
    ) -> None:  # fmt: skip
        """model: a newton.Model, whose shapes are read once, but their transforms and colors at every update();
        default_clear_data: values of pixels without a surface; default_render_config: a RenderConfig, as for update();
        load_textures: textures of meshes; deformable_surface_mode: without effect, because deformable surfaces are not
        rendered; infinite_plane: side in meters of planes that are infinite in the model (shadow maps are coarser with
        larger ones); device: as for Renderer (default: the model's); options: of Renderer.render_worlds(), such as
        shadows="d32" or exposure=1 (default: shadows="none", tonemap="none"), except outputs, out, on_device, formats,
        channels_first, axes and normal_frame"""
        names = ("outputs", "out", "on_device", "formats", "channels_first", "axes", "normal_frame")
        reject_options(options, names, "a SensorCamera writes the arrays of update() as Newton defines them")
        self.model = model
        _check_config(default_render_config)
        self.default_render_config = default_render_config if default_render_config is not None else self.RenderConfig()
        self.default_clear_data = default_clear_data if default_clear_data is not None else self.ClearData()
        made = _ModelScene(model, load_textures, infinite_plane)
        self.scene, self._instances = made.scene, made.instances
        self._options = {"shadows": "none", "tonemap": "none", **options}
        self._device_name = device or (f"cuda:{model.device.ordinal}" if model.device.is_cuda else "cpu")
        self._turn = _FROM_UP[newton.Axis(model.up_axis)]
        self._file_from_world = wp.mat33f(*self._turn.ravel().tolist())
        self._world_from_file = wp.mat33f(*self._turn.T.ravel().tolist())
        self._shape_of = wp.array(made.shape_of, dtype=wp.int32, device=model.device)
        ids = np.array([self.scene.instance(handle).id for handle in made.instances], np.uint32)
        order = np.argsort(ids)
        self._sorted_ids = wp.array(ids[order], dtype=wp.uint32, device=model.device)
        self._instance_of = wp.array(order.astype(np.int32), dtype=wp.int32, device=model.device)
        self._light: Any = None
        self._renderer: Renderer | None = None
        self._results: dict[Any, Any] = {}
        self._rays: tuple[Any, np.ndarray] | None = None
        self.set_ambient_light((0.2, 0.2, 0.225), (0.05, 0.05, 0.06))

    @property
    def device(self) -> Any:
        """The device of the model."""
        return self.model.device

    # --- images ---

    def allocate_image(self, view_count: int, width: int, height: int, dtype: Any) -> Any:
        """A Warp array (view_count, height, width) of zeros on the model's device."""
        return wp.zeros((int(view_count), int(height), int(width)), dtype=dtype, device=self.device)

    def allocate_image_color(self, view_count: int, width: int, height: int) -> Any:
        """uint32: sRGB and alpha, red in the lowest byte."""
        return self.allocate_image(view_count, width, height, wp.uint32)

    def allocate_image_depth(self, view_count: int, width: int, height: int) -> Any:
        """float32: meters along the ray, or along the camera's axis."""
        return self.allocate_image(view_count, width, height, wp.float32)

    allocate_image_depth_forward = allocate_image_depth

    def allocate_image_shape_index(self, view_count: int, width: int, height: int) -> Any:
        """uint32: index of the shape in the model."""
        return self.allocate_image(view_count, width, height, wp.uint32)

    def allocate_image_normal(self, view_count: int, width: int, height: int) -> Any:
        """vec3f: unit normals in the frame of the world."""
        return self.allocate_image(view_count, width, height, wp.vec3f)

    def allocate_image_albedo(self, view_count: int, width: int, height: int) -> Any:
        """uint32: base color in sRGB, red in the lowest byte."""
        return self.allocate_image(view_count, width, height, wp.uint32)

    def allocate_image_color_hdr(self, view_count: int, width: int, height: int) -> Any:
        """vec3f: linear color."""
        return self.allocate_image(view_count, width, height, wp.vec3f)

    # --- light ---

    def create_default_light(
        self, *, enable_shadows: bool = True, direction: Sequence[float] | None = None,
        color: Sequence[float] | None = None,
    ) -> None:  # fmt: skip
        """A directional light, in place of one created before. A white Lambertian surface that faces it has the
        radiance `color` (linear, default: white). It casts shadows with the option shadows."""
        if direction is None:
            # Newton's default, as seen from its Z axis.
            direction = _FROM_UP[newton.Axis(self.model.up_axis)].T @ FROM_Z_UP[:3, :3] @ np.array([-1.0, 1.0, -1.0])
        turned = self._turn @ np.asarray([float(value) for value in direction])
        light = Light(
            name="light", type="directional", direction=tuple(turned.tolist()), intensity=math.pi,
            color=tuple(float(value) for value in (color if color is not None else (1, 1, 1))),
            cast_shadow=bool(enable_shadows),
        )  # fmt: skip
        if self._light is not None:
            self.scene.remove_light(self._light)
        self._light = self.scene.add_light(light)

    def set_ambient_light(self, sky_color: Sequence[float], ground_color: Sequence[float] | None = None) -> None:
        """Light from the upper and the lower half of the surroundings: linear radiance, by default that of Newton."""
        ground = sky_color if ground_color is None else ground_color
        halves = [[float(value) for value in color] for color in (sky_color, ground)]
        self._environment = np.repeat(np.array(halves, np.float32), 16, 0)[:, None].repeat(64, 1)
        self._renderer = None

    # --- rendering ---

    def compute_camera_transforms_usd(self, cameras: Any, *, time: Any = None, xform: Any = None) -> Any:
        """The `camera_transforms` of USD cameras, as newton.sensors.SensorCamera computes them for this model."""
        sensor = newton.sensors.SensorCamera(self.model, load_textures=False)
        return sensor.compute_camera_transforms_usd(cameras, time=time, xform=xform)

    def sync_deformable_meshes(self, state: Any, *, deformable_visuals: Any = None) -> None:
        """Without effect, because deformable surfaces are not rendered. Raises UsageError for deformable_visuals."""
        if deformable_visuals is not None:
            raise UsageError("deformable_visuals must be None, because deformable surfaces are not rendered")

    def _camera_matrix(self, rays: Any) -> np.ndarray:
        """The camera matrix of a bundle of rays (H, W, 1, 2), which is read once as long as it is the same array."""
        if self._rays is not None and self._rays[0] is rays:
            return self._rays[1]
        height, width = rays.shape[:2]
        values = rays.numpy()[:, :, 0].astype(np.float64)
        directions = values[:, :, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = directions[..., :2] / -directions[..., 2:]
        matrix = np.eye(3)
        for axis, (count, sign) in enumerate(((width, 1), (height, -1))):
            pixels = np.arange(count) + 0.5
            line = slopes[0, :, 0] if axis == 0 else sign * slopes[:, 0, 1]
            step = (line[-1] - line[0]) / max(count - 1, 1)
            if count == 1 or not math.isfinite(step) or step <= 0:
                raise UsageError("camera_rays must be those of a pinhole camera, with at least 2x2 pixels")
            matrix[axis, axis] = 1 / step
            matrix[axis, 2] = pixels[0] - line[0] / step
        x = (np.arange(width) + 0.5 - matrix[0, 2]) / matrix[0, 0]
        y = -(np.arange(height) + 0.5 - matrix[1, 2]) / matrix[1, 1]
        expected = np.stack(np.meshgrid(x, y), 2)
        if np.abs(values[:, :, 0]).max() > 0 or not np.abs(slopes - expected).max() < 1e-4:
            raise UsageError(
                "camera_rays must be those of a pinhole camera, without distortion and offsets of origins"
            )
        self._rays = (rays, matrix)
        return matrix

    def _check(self, name: str, array: Any, shape: tuple[int, ...]) -> None:
        if not isinstance(array, wp.array) or array.dtype != _TYPES[name]:
            raise UsageError(f"{name} must be a Warp array of {_TYPES[name].__name__}")
        if array.shape != shape or array.device != self.device:
            raise UsageError(
                f"{name} must have the shape {shape} on {self.device}, not {array.shape} on {array.device}"
            )

    def update(
        self, state: Any, camera_transforms: Any, camera_rays: Any, *, color_image: Any = None, depth_image: Any = None,
        forward_depth_image: Any = None, shape_index_image: Any = None, normal_image: Any = None,
        albedo_image: Any = None, hdr_color_image: Any = None, world_indices: Any = None, clear_data: Any = None,
        render_config: Any = None, sync_deformables: bool = True, deformable_visuals: Any = None,
    ) -> None:  # fmt: skip
        """Renders one view per camera transform into the given images.

        state: a newton.State, for its body_q; camera_transforms: (views,) transformf in the frame of the world;
        camera_rays: (height, width, 1, 2) vec3f of compute_camera_rays_pinhole(), read once as long as it is the same
        array; images: Warp arrays (views, height, width) on the model's device, as allocate_image_color() and others
        return; world_indices: (views,) int32, the world of each view or a WorldRenderFlag (default: view i shows world
        i); clear_data: values of pixels without a surface; render_config: a RenderConfig whose settings that change
        images have their defaults (textures are rendered unless load_textures=False); sync_deformables: without effect;
        deformable_visuals: None

        Raises UsageError for arrays of another shape, type or device, and for other settings."""
        _check_config(render_config if render_config is not None else self.default_render_config)
        self.sync_deformable_meshes(state, deformable_visuals=deformable_visuals)
        if not isinstance(camera_transforms, wp.array) or camera_transforms.dtype != wp.transformf:
            raise UsageError("camera_transforms must be a Warp array (views,) of transformf")
        views = camera_transforms.shape[0]
        if camera_rays.ndim != 4 or camera_rays.shape[2:] != (1, 2):
            raise UsageError(
                f"camera_rays must have the shape (height, width, 1, 2), not {tuple(camera_rays.shape)}; "
                'for several samples per pixel, pass aa="ss2" to SensorCamera()'
            )
        if world_indices is not None and (world_indices.dtype != wp.int32 or world_indices.shape != (views,)):
            raise UsageError(f"world_indices must be a Warp array ({views},) of int32")
        if world_indices is None and views > self._shape_of.shape[0]:
            raise UsageError(
                f"{views} views require world_indices, because the model has {self._shape_of.shape[0]} worlds"
            )
        height, width = camera_rays.shape[:2]
        images = {
            name: image
            for name, image in (
                ("color_image", color_image), ("depth_image", depth_image),
                ("forward_depth_image", forward_depth_image), ("shape_index_image", shape_index_image),
                ("normal_image", normal_image), ("albedo_image", albedo_image), ("hdr_color_image", hdr_color_image),
            )
            if image is not None
        }  # fmt: skip
        for name, image in images.items():
            self._check(name, image, (views, height, width))
        if images:
            worlds = wp.empty(0, dtype=wp.int32, device=self.device) if world_indices is None else world_indices
            frames = self._render(state, camera_transforms, camera_rays, tuple(images), worlds)
            self._write(images, frames, worlds, clear_data or self.default_clear_data)

    def _render(self, state: Any, camera_transforms: Any, rays: Any, names: tuple[str, ...], worlds: Any) -> Any:
        views, (height, width) = camera_transforms.shape[0], rays.shape[:2]
        transforms = wp.empty((views, len(self._instances), 3, 4), dtype=wp.float32, device=self.device)
        exists = wp.empty((views, len(self._instances)), dtype=wp.bool, device=self.device)
        colors = wp.empty((views, len(self._instances), 4), dtype=wp.float32, device=self.device)
        poses = wp.empty((views, 1, 3, 4), dtype=wp.float32, device=self.device)
        model = self.model
        wp.launch(
            _place_shapes, (views, len(self._instances)), device=self.device,
            inputs=[
                worlds, self._shape_of, model.shape_body, model.shape_transform, model.shape_color, state.body_q,
                self._file_from_world,
            ],
            outputs=[transforms, exists, colors],
        )  # fmt: skip
        wp.launch(
            _place_cameras,
            views,
            inputs=[camera_transforms, self._file_from_world],
            outputs=[poses],
            device=self.device,
        )
        camera = Camera.from_k(self._camera_matrix(rays), np.eye(4), (width, height))
        outputs = tuple(dict.fromkeys(["id", *(_OUTPUTS[name] for name in names)]))
        key = (views, width, height, outputs)
        if self._renderer is None:
            self._renderer, self._results = Renderer(self.scene, self._device_name, self._environment), {}
        placed = {
            "instances": self._instances, "transforms": transforms, "exists": exists, "base_color": colors,
        } if self._instances else {}  # fmt: skip
        # The copies of the arrays follow the kernels above, and those that read the last results, on this stream.
        stream = {"stream": wp.get_stream(self.device)} if self.device.is_cuda else {}
        self._results[key] = self._renderer.render_worlds(
            views, camera, (width, height), outputs, camera_to_world=poses, on_device=True, out=self._results.get(key),
            **placed, **stream, **self._options,
        )  # fmt: skip
        return self._results[key]

    def _array(self, rendered: Any) -> Any:
        """The same memory as an array of Warp. Views have one camera: (N, 1, H, W, ...) becomes (N, H, W, ...), because
        Warp has four dimensions."""
        shape = (rendered.shape[0], *rendered.shape[2:])
        if not self.device.is_cuda:
            return wp.array(np.from_dlpack(rendered).reshape(shape), copy=False, device=self.device)
        interface = rendered.__cuda_array_interface__
        dtype = wp.dtype_from_numpy(np.dtype(interface["typestr"]))
        return wp.array(ptr=interface["data"][0], shape=shape, dtype=dtype, device=self.device)

    def _write(self, images: dict[str, Any], frames: Any, worlds: Any, clear: Any) -> None:
        rendered = {name: self._array(frames[name]) for name in {"id", *(_OUTPUTS[name] for name in images)}}
        ids = rendered["id"]
        for name, image in images.items():
            values = rendered[_OUTPUTS[name]]
            if name == "color_image":
                kernel, inputs = _write_bytes, [values, clear.clear_color]
            elif name == "albedo_image":
                kernel, inputs = _write_albedo, [values, clear.clear_albedo]
            elif name == "shape_index_image":
                kernel, inputs = (
                    _write_shapes,
                    [self._sorted_ids, self._instance_of, self._shape_of, clear.clear_shape_index],
                )
            elif name == "normal_image":
                kernel, inputs = _write_vectors, [values, self._world_from_file, wp.vec3f(*clear.clear_normal)]
            elif name == "hdr_color_image":
                kernel, inputs = _write_vectors, [values, wp.mat33f(*np.eye(3).ravel()), wp.vec3f(0.0, 0.0, 0.0)]
            else:
                kernel, inputs = _write_floats, [values, clear.clear_depth]
            wp.launch(kernel, image.shape, inputs=[worlds, ids, *inputs], outputs=[image], device=self.device)
