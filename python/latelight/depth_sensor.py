"""Depth cameras with measured noise: structured light and active stereo.

::

    from latelight import depth_sensor

    frame = depth_sensor.capture(renderer, camera, (640, 480), depth_sensor.kinect(), seed=7)
    frame.depth  # (480, 640) float32, meters; 0 where the sensor has no value
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Camera, Renderer
from ._options import numbers, reject_options, require
from .errors import UsageError

__all__ = ["DepthFrame", "DepthSensor", "capture", "kinect", "measure", "realsense_d435"]

Array = npt.NDArray[Any]


def _checked_seed(seed: int | None) -> int | None:
    return None if seed is None else _core.whole_number_of(seed, "seed", 0, 2**63 - 1)


@dataclass(frozen=True)
class DepthSensor:
    """A sensor that triangulates. dataclasses.replace() changes single properties.

    The standard deviation of a depth z on a surface at the angle of incidence a is, in meters,

        axial[0] + axial[1] (z - axial[2])^2 + axial[3] / sqrt(z) a^2 / (pi/2 - a)^2
        + disparity_noise z^2 / (f baseline)

    and that of a pixel's position lateral[0] + lateral[1] a / (pi/2 - a), in pixels. f is the focal length in pixels.
    """

    name: str
    baseline: float  # meters from the camera to the projector or second camera, along the camera's X axis (right)
    min_range: float  # meters of depth
    max_range: float
    axial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    lateral: tuple[float, float] = (0.0, 0.0)
    disparity_noise: float = 0.0  # pixels
    disparity_step: float = 0.0  # pixels: disparities are multiples of it
    max_incidence: float = 90.0  # degrees; steeper surfaces have no value

    def __post_init__(self) -> None:
        noise = [*numbers(self.axial, "axial", 4), *numbers(self.lateral, "lateral", 2)]
        noise += [_core.number_of(getattr(self, name), name) for name in ("disparity_noise", "disparity_step")]
        if not all(math.isfinite(value) and value >= 0 for value in noise):
            raise UsageError("the noise and the disparity step of a depth sensor must be at least 0")
        nearest, farthest = (_core.number_of(getattr(self, name), name) for name in ("min_range", "max_range"))
        baseline = _core.number_of(self.baseline, "baseline")
        if not 0 <= nearest < farthest or baseline == 0 or not math.isfinite(baseline):
            raise UsageError("a depth sensor needs a baseline other than 0 and a range from min_range to max_range")
        incidence = _core.number_of(self.max_incidence, "max_incidence")
        if not 0 <= incidence <= 90:
            raise UsageError(f"max_incidence must be from 0 to 90 degrees, not {incidence:g}")


def kinect() -> DepthSensor:
    """Microsoft Kinect, first generation: structured light, 640x480.

    Noise: Nguyen, Izadi and Lovell 2012, Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking.
    Baseline and disparities in eighths of a pixel: Khoshelham and Elberink 2012, Accuracy and Resolution of Kinect
    Depth Data for Indoor Mapping Applications.
    """
    return DepthSensor("Kinect", 0.075, 0.5, 5.0, (0.0012, 0.0019, 0.4, 0.0001), (0.8, 0.035), 0.0, 1 / 8, 82.0)


def realsense_d435() -> DepthSensor:
    """Intel RealSense D435: active stereo with a baseline of 50 mm and an error of 0.08 pixels of disparity.

    Grunnet-Jepsen, Sweetser and Woodfill, Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras. Disparities
    are multiples of 1/32 of a pixel.
    """
    return DepthSensor("RealSense D435", 0.05, 0.2, 10.0, disparity_noise=0.08, disparity_step=1 / 32, max_incidence=85.0)


@dataclass(frozen=True)
class DepthFrame:
    """The measurements of a depth sensor, and the truth."""

    depth: Array  # (H, W) float32, meters along the optical axis; 0: no value
    true_depth: Array  # (H, W) float32; infinite where there is no surface
    incidence: Array  # (H, W) float32, radians between the viewing ray and the surface's normal
    shadow: Array  # (H, W) bool: another surface hides the point from the projector or second camera


def measure(sensor: DepthSensor, depth: npt.ArrayLike, incidence: npt.ArrayLike, focal: float, seed: int | None = 0,
            shadow: npt.ArrayLike | None = None) -> Array:  # fmt: skip
    """Returns what the sensor measures of exact depths (H, W), in meters: float32, 0 where it has no value.

    incidence: (H, W) radians from 0 to pi/2, or NaN, where the sensor has no value; focal: focal length in pixels;
    seed: of the noise, or None for quantization only; shadow: (H, W) True where the point is hidden from the projector
    """
    require(sensor, DepthSensor, "sensor")
    seed = _checked_seed(seed)
    z, angle = _core.numbers_of(depth, "depth"), _core.numbers_of(incidence, "incidence")
    if z.ndim != 2 or angle.shape != z.shape:
        raise UsageError(f"depth and incidence must have the same shape (H, W), not {z.shape} and {angle.shape}")
    slack = 1e-6  # the rounding of pi/2 to float32
    wrong = np.isfinite(z) & (z > 0) & ((angle < -slack) | (angle > np.pi / 2 + slack))
    if wrong.any():
        raise UsageError(f"incidence must be from 0 to pi/2 radians, or NaN, not {angle[wrong][0]:g}")
    focal = _core.number_of(focal, "focal")
    if not (focal > 0 and math.isfinite(focal)):
        raise UsageError(f"focal must be a number of pixels above 0, not {focal}")
    hidden = np.zeros(z.shape, bool) if shadow is None else np.asarray(shadow, bool)
    if hidden.shape != z.shape:
        raise UsageError(f"shadow must have the shape of depth, {z.shape}, not {hidden.shape}")
    steep = np.where(np.isnan(angle), 0, np.clip(angle, 0, np.pi / 2 - 1e-3))
    if seed is not None:
        random = np.random.Generator(np.random.Philox(seed))
        moves, errors = random.standard_normal((2, *z.shape)), random.standard_normal(z.shape)
        spread = sensor.lateral[0] + sensor.lateral[1] * steep / (np.pi / 2 - steep)
        rows, columns = np.indices(z.shape)
        row = np.clip(np.rint(rows + moves[0] * spread), 0, z.shape[0] - 1).astype(np.int64)
        column = np.clip(np.rint(columns + moves[1] * spread), 0, z.shape[1] - 1).astype(np.int64)
        z, steep, angle, hidden = (values[row, column] for values in (z, steep, angle, hidden))
        valid = np.isfinite(z) & (z > 0)
        near = np.where(valid, z, 1)
        constant, square, center, grazing = sensor.axial
        sigma = constant + square * (near - center) ** 2
        sigma += grazing / np.sqrt(near) * steep**2 / (np.pi / 2 - steep) ** 2
        sigma += sensor.disparity_noise * near**2 / (focal * abs(sensor.baseline))
        z = np.where(valid, near + errors * sigma, z)
    valid = np.isfinite(z) & (z > 0) & ~hidden & (angle <= math.radians(sensor.max_incidence))
    near = np.where(valid, z, 1)
    if sensor.disparity_step > 0:
        scale = focal * abs(sensor.baseline) / sensor.disparity_step
        steps = np.rint(scale / near)
        valid &= steps > 0
        near = scale / np.maximum(steps, 1)
    valid &= (near >= sensor.min_range) & (near <= sensor.max_range)
    return np.where(valid, near, 0).astype(np.float32)


def _times_of_rows(renderer: Renderer, camera: Camera, height: int, options: dict[str, Any]) -> Array | None:
    """Returns the scene's time at each row of a rolling shutter, or None if all rows show it at the same time."""
    readout = camera.readout if camera.readout is not None else options.get("readout", 0.0)
    time = options.get("time")
    if not readout or time is None or not renderer.scene.animations:
        return None
    return time + ((np.arange(height) + 0.5) / height - 0.5) * readout


def _shadow(renderer: Renderer, camera: Camera, sensor: DepthSensor, points: Array, seen: Array,
            options: dict[str, Any]) -> Array:  # fmt: skip
    """Returns True for the points (H, W, 3) that are seen and that the projector does not reach.

    points: relative to the camera's eye, because their floats have no millimeters far from the origin
    """
    times = _times_of_rows(renderer, camera, len(points), options)
    if times is None:
        return _shadow_at_once(renderer, camera, sensor, points, seen, options)
    rows = [
        _shadow_at_once(renderer, camera, sensor, points[y : y + 1], seen[y : y + 1], {**options, "time": float(time)})
        for y, time in enumerate(times)
    ]
    return np.concatenate(rows)


def _shadow_at_once(renderer: Renderer, camera: Camera, sensor: DepthSensor, points: Array, seen: Array,
                    options: dict[str, Any]) -> Array:  # fmt: skip
    """_shadow() for points that are all seen at the time of the options."""
    pose = np.asarray(camera.camera_to_world, np.float64)
    offset = pose[:3, 0] * sensor.baseline
    projector = pose[:3, 3] + offset
    directions = points[seen].astype(np.float64) - offset
    lengths = np.linalg.norm(directions, axis=1)
    hits = renderer.cast(np.broadcast_to(projector, directions.shape), directions, **options)
    hidden = np.zeros(seen.shape, bool)
    hidden[seen] = hits["distance"] < lengths * (1 - 1e-3) - 1e-4
    return hidden


def _check_options(options: dict[str, Any]) -> None:
    frames = ("axes", "position_origin", "normal_frame")
    reject_options(options, frames, "a depth sensor measures in its camera's frame")
    arrays = ("outputs", "out", "on_device", "formats", "channels_first")
    reject_options(options, arrays, "a depth sensor returns a DepthFrame of NumPy arrays")
    cameras = ("previous_cameras", "next_cameras")
    reject_options(options, cameras, "a depth sensor does not move during a frame")


def capture(renderer: Renderer, camera: Camera, size: tuple[int, int], sensor: DepthSensor, *, seed: int | None = 0,
            **options: Any) -> DepthFrame:  # fmt: skip
    """Renders exact depth, and measures it as the sensor does.

    camera: a perspective camera, whose lens, if it has one, is a pinhole; size: width and height in pixels; seed: of
    the noise, or None for quantization and shadows only; options: those that both Renderer.render() and Renderer.cast()
    accept, such as time, except axes, position_origin and normal_frame, those that choose the arrays (outputs, out,
    on_device, formats and channels_first), previous_cameras and next_cameras

    The shadow of structured light is traced: pixels whose point the projector does not reach have no value. With a
    rolling shutter, each row has the shadow of its own time.
    """
    require(renderer, Renderer, "renderer")
    require(camera, Camera, "camera")
    require(sensor, DepthSensor, "sensor")
    if camera.orthographic or (camera.lens is not None and camera.lens.model != "pinhole"):
        raise UsageError("a depth sensor needs a perspective camera without a lens that bends rays")
    seed = _checked_seed(seed)  # before anything is rendered
    _check_options(options)
    if options.get("camera_fit") == "vertical":  # Camera.k() is the matrix of images that show the whole frame
        camera = copy.copy(camera)
        camera.aspect = None
    k = np.asarray(camera.k(size), np.float64)
    eye = ",".join(repr(float(value)) for value in camera.camera_to_world[:3, 3])
    frames = {"normal_frame": "opencv", "position_origin": eye}
    frame = renderer.render(camera, size, ("depth", "geonormal", "position"), **options, **frames)
    depth = frame["depth"]
    seen = np.isfinite(depth) & (depth > 0)
    x = (np.arange(size[0]) + 0.5 - k[0, 2]) / k[0, 0]
    y = (np.arange(size[1]) + 0.5 - k[1, 2]) / k[1, 1]
    rays = np.stack([*np.meshgrid(x, y), np.ones((size[1], size[0]))], axis=2)
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    cosine = np.clip(-np.einsum("ijk,ijk->ij", rays, frame["geonormal"].astype(np.float64)), 0, 1)
    incidence = np.where(seen, np.arccos(cosine), 0)
    shadow = _shadow(renderer, camera, sensor, frame["position"], seen, options)
    measured = measure(sensor, np.where(seen, depth, np.inf), incidence, float(k[0, 0]), seed, shadow)
    return DepthFrame(measured, np.where(seen, depth, np.inf).astype(np.float32), incidence.astype(np.float32), shadow)
