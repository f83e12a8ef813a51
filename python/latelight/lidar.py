"""Lidar sensors that scan a scene: spinning and solid-state patterns, motion, beams with a width, echoes and dropouts.

::

    from latelight import lidar

    pose = lidar.sensor_pose((0, 1.5, 0), forward=(0, 0, -1))
    scan = lidar.scan(renderer, lidar.vlp16(), lidar.Motion(pose, velocity=(0, 0, -10)))
    scan.write("scan.pcd")

A sensor's frame has X forward, Y left and Z up (REP 103 of ROS).
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ._core import Renderer
from ._point_files import write_points
from .errors import UsageError
from .trajectory import Motion, Trajectory, checked_poses, sensor_pose

__all__ = [
    "Motion",
    "Pattern",
    "Scan",
    "Trajectory",
    "hdl32e",
    "hdl64e",
    "livox_mid40",
    "os1_64",
    "patterns",
    "scan",
    "sensor_pose",
    "spinning",
    "vlp16",
]

Array = npt.NDArray[Any]

RETURNS = ("strongest", "first", "last", "dual", "all")

# Signals are relative to that of a surface of this reflectance that faces the sensor at the rated range, which the
# receiver detects with this probability, as makers state ranges.
RATED_REFLECTANCE = 0.8
RATED_DETECTION = 0.9
# The threshold of the receiver in standard deviations of its noise. A Gaussian exceeds 4.5 of them with 3.4e-6.
THRESHOLD_TO_NOISE = 4.5
_NORMAL_QUANTILE = 1.2815515655446004  # of RATED_DETECTION
SIGNAL_NOISE = 1 / (THRESHOLD_TO_NOISE + _NORMAL_QUANTILE)
SIGNAL_THRESHOLD = THRESHOLD_TO_NOISE * SIGNAL_NOISE


@dataclass(frozen=True)
class Pattern:
    """The firings of one scan, and the sensor's properties. dataclasses.replace() changes single ones."""

    name: str
    directions: Array  # (N, 3) unit vectors in the sensor's frame
    times: Array  # (N,) seconds since the scan began
    rings: Array  # (N,) uint16: index of the laser, from the lowest elevation up
    period: float  # seconds from one scan to the next
    min_range: float = 0.0  # meters; nearer surfaces are not seen, and still block the beam
    max_range: float = math.inf  # meters; farther returns are discarded
    rated_range: float = math.inf  # meters, at 80 % reflectance and 90 % probability; inf: the signal does not matter
    range_noise: float = 0.0  # meters, standard deviation
    range_resolution: float = 0.0  # meters; ranges are multiples of it
    divergence: tuple[float, float] = (0.0, 0.0)  # horizontal, vertical: full angles in radians at 1/e^2 of the center
    echo_separation: float = 1.0  # meters; nearer surfaces along a beam are one echo

    def __post_init__(self) -> None:
        count = len(self.times)
        if self.directions.shape != (count, 3) or np.shape(self.rings) != (count,) or np.shape(self.times) != (count,):
            raise UsageError("a pattern needs directions (N, 3), and times and rings (N)")
        lengths = np.linalg.norm(self.directions, axis=1)
        if not np.allclose(lengths, 1, atol=1e-6):
            raise UsageError("the directions of a pattern must be unit vectors")
        positive = (self.period, self.rated_range, self.max_range, self.echo_separation)
        if not all(value > 0 for value in positive):
            raise UsageError("period, rated_range, max_range and echo_separation of a pattern must be above 0")
        others = (self.min_range, self.range_noise, self.range_resolution, *self.divergence)
        if not all(value >= 0 and math.isfinite(value) for value in others):
            raise UsageError("min_range, range_noise, range_resolution and divergence of a pattern must be at least 0")

    def __len__(self) -> int:
        return len(self.times)


def spinning(
    name: str,
    elevations: Sequence[float],
    cycle: float,
    rate: float,
    firing: Sequence[float] | float = 0.0,
    azimuths: Sequence[float] | float = 0.0,
    columns: int | None = None,
    **properties: Any,
) -> Pattern:
    """A sensor that turns clockwise, seen from above, and begins a scan forward.

    elevations: degrees, laser by laser; cycle: seconds from one firing of a laser to its next one; rate: scans per
    second; firing: seconds from the beginning of a cycle to each laser's firing, or between two lasers' firings;
    azimuths: degrees that each laser looks to the right of the rotor; columns: cycles per scan (default: as many as
    fit); properties: those of Pattern.
    """
    if not elevations or not cycle > 0 or not rate > 0:
        raise UsageError("a spinning sensor needs lasers, and a cycle and a rate above 0")
    lasers = np.asarray(elevations, np.float64)
    offsets = np.arange(len(lasers)) * firing if isinstance(firing, (int, float)) else np.asarray(firing, np.float64)
    period = 1 / rate
    count = columns or int(period / cycle)
    if count < 1 or offsets.shape != lasers.shape:
        raise UsageError("a spinning sensor needs at least one cycle per scan, and one firing offset per laser")
    times = (np.arange(count)[:, None] * cycle + offsets).ravel()
    azimuth = 2 * np.pi * rate * times + np.radians(np.tile(np.broadcast_to(azimuths, lasers.shape), count))
    elevation = np.radians(np.tile(lasers, count))
    across = np.cos(elevation)
    directions = np.stack([across * np.cos(azimuth), -across * np.sin(azimuth), np.sin(elevation)], axis=1)
    rings = np.tile(np.argsort(np.argsort(lasers)).astype(np.uint16), count)
    return Pattern(name, directions, times, rings, period, **properties)


def vlp16(rate: float = 10.0) -> Pattern:
    """Velodyne VLP-16 (VLP-16 User Manual, 63-9243 Rev. D: chapter 9 and appendix on timing); rate: 5 to 20 Hz."""
    low = np.arange(-15, 0, 2)
    elevations = np.stack([low, low + 16], axis=1).ravel().tolist()  # -15, 1, -13, 3, ...
    return spinning(
        "VLP-16", elevations, 55.296e-6, rate, 2.304e-6,
        min_range=0.9, max_range=131.07, rated_range=100.0, range_noise=0.015, range_resolution=0.002,
        divergence=(math.radians(0.18), math.radians(0.07)),
    )  # fmt: skip


def hdl32e(rate: float = 10.0) -> Pattern:
    """Velodyne HDL-32E (HDL-32E User Manual, 63-9113: appendix on the firing sequence); rate: 5 to 20 Hz."""
    low = -92 / 3 + np.arange(16) * 4 / 3  # -30.67, -29.33, ...; the others follow 21.33 degrees above
    elevations = np.stack([low, low + 64 / 3], axis=1).ravel().tolist()
    return spinning(
        "HDL-32E", elevations, 46.08e-6, rate, 1.152e-6,
        min_range=0.9, max_range=131.07, rated_range=100.0, range_noise=0.02, range_resolution=0.002,
        divergence=(math.radians(0.16), math.radians(0.08)),
    )  # fmt: skip


def hdl64e(rate: float = 10.0) -> Pattern:
    """Velodyne HDL-64E S2, the sensor of KITTI, with its nominal elevations (HDL-64E S2 User Manual); 5 to 15 Hz."""
    upper = 2 - np.arange(32) / 3  # 2 to -8.33 degrees
    lower = -8.83 - np.arange(32) * 0.5  # -8.83 to -24.33 degrees
    elevations = np.concatenate([upper, lower]).tolist()
    return spinning(
        "HDL-64E S2", elevations, 48e-6, rate, 0.75e-6,
        min_range=0.9, max_range=131.07, rated_range=120.0, range_noise=0.02, range_resolution=0.002,
        divergence=(2e-3, 2e-3),
    )  # fmt: skip


def os1_64(rate: float = 10.0, columns: int = 1024) -> Pattern:
    """Ouster OS1-64, first generation (OS1 datasheet): 64 lasers from -16.6 to 16.6 degrees that fire at once.

    rate: 10 or 20 Hz; columns: 512, 1024 or 2048 per scan.
    """
    elevations = np.linspace(16.6, -16.6, 64)
    azimuths = np.tile([-3.164, -1.055, 1.055, 3.164], 16)
    return spinning(
        "OS1-64", elevations.tolist(), 1 / (rate * columns), rate, 0.0, azimuths.tolist(), columns,
        min_range=0.8, rated_range=120.0, range_noise=0.015, range_resolution=0.003,
        # The datasheet's 0.18 degrees are the full width at half maximum.
        divergence=(math.radians(0.18) * math.sqrt(2 / math.log(2)),) * 2,
    )  # fmt: skip


def livox_mid40(period: float = 0.1, start: float = 0.0) -> Pattern:
    """Livox Mid-40: a rosette that never repeats, within a cone of 38.4 degrees, at 100,000 points per second.

    Two equal prisms that turn against each other deflect the beam, each by a quarter of the cone (Brazeal, Wilkinson and
    Hochmair 2021, A Rigorous Observation Model for the Risley Prism-Based Livox Mid-40 Lidar Sensor, Sensors 21: 7294 and
    -4664 revolutions per minute; here with thin prisms). start: seconds; successive scans begin where the last one ended.
    """
    if not period > 0:
        raise UsageError("period must be above 0")
    times = np.arange(max(1, round(period * 1e5))) / 1e5
    deflection = math.radians(38.4 / 4)
    angles = [2 * np.pi * speed / 60 * (start + times) for speed in (7294.0, -4664.0)]
    left = deflection * sum(np.cos(angle) for angle in angles)
    up = deflection * sum(np.sin(angle) for angle in angles)
    angle = np.hypot(left, up)
    scale = np.sinc(angle / np.pi)  # sin(angle) / angle
    directions = np.stack([np.cos(angle), left * scale, up * scale], axis=1)
    return Pattern(
        "Livox Mid-40", directions, times, np.zeros(len(times), np.uint16), period,
        min_range=1.0, rated_range=260.0, range_noise=0.02, range_resolution=0.001,
        divergence=(math.radians(0.03), math.radians(0.28)),
    )  # fmt: skip


def patterns() -> dict[str, Pattern]:
    """All sensors of this module, by name."""
    return {pattern.name: pattern for pattern in (vlp16(), hdl32e(), hdl64e(), os1_64(), livox_mid40())}


@dataclass(frozen=True)
class Scan:
    """The points of one scan, in the order of the firings, and of the range within a firing."""

    position: Array  # (P, 3) float32, meters: in the sensor's frame at the time of the firing, as sensors report them
    world_position: Array  # (P, 3) float64, meters: in the scene, in the frame of the option axes
    time: Array  # (P,) float64, seconds since the scan began
    range: Array  # (P,) float32, meters
    intensity: Array  # (P,) float32 in 0..1: the part of the beam that a surface returns, corrected for the range
    ring: Array  # (P,) uint16: index of the laser, from the lowest elevation up
    echo: Array  # (P,) uint8: 0 for the nearest echo of the firing that was detected, and so on
    firing: Array  # (P,) uint32: index in the pattern
    id: Array  # (P,) uint32, and so are the others: as the outputs of these names
    part: Array
    material: Array

    def __len__(self) -> int:
        return len(self.time)

    def fields(self, frame: str = "sensor") -> Mapping[str, Array]:
        """One array per value of a point: x, y, z, intensity, time, ring and so on. frame: "sensor" or "world"."""
        if frame not in ("sensor", "world"):
            raise UsageError(f'frame must be "sensor" or "world", not "{frame}"')
        points = self.position if frame == "sensor" else self.world_position.astype(np.float32)
        named = {name: points[:, axis] for axis, name in enumerate("xyz")}
        for name in ("intensity", "time", "ring", "range", "echo", "firing", "id", "part", "material"):
            named[name] = getattr(self, name)
        return named

    def write(self, path: str | os.PathLike[str], frame: str = "sensor") -> None:
        """Writes a .ply, .pcd (binary), .bin (KITTI: x, y, z, intensity) or .npz file with the values of fields()."""
        write_points(path, self.fields(frame))


class _Poses(Protocol):
    def at(self, times: npt.ArrayLike) -> npt.NDArray[np.float64]: ...


def _beam(pattern: Pattern, samples: int) -> Array:
    """Offsets (samples, 2) of the rays of a beam, horizontal and vertical, in radians.

    Each stands for an equal share of the energy of a Gaussian beam (Vogel's spiral over the quantiles of its radius).
    """
    if samples == 1:
        return np.zeros((1, 2))
    index = np.arange(samples)
    radius = np.sqrt(-0.5 * np.log(1 - (index + 0.5) / samples))  # in radii at 1/e^2
    angle = index * np.pi * (3 - math.sqrt(5))
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1) * (np.asarray(pattern.divergence) / 2)


def _rays(directions: Array, offsets: Array) -> Array:
    """Unit vectors (N, samples, 3) around the directions (N, 3)."""
    right = np.stack([directions[:, 1], -directions[:, 0], np.zeros(len(directions))], axis=1)
    lengths = np.linalg.norm(right, axis=1, keepdims=True)
    right = np.where(lengths > 1e-9, right / np.maximum(lengths, 1e-9), [0.0, -1.0, 0.0])
    up = np.cross(right, directions)
    rays = directions[:, None] + offsets[:, :1] * right[:, None] + offsets[:, 1:] * up[:, None]
    return rays / np.linalg.norm(rays, axis=2, keepdims=True)


@dataclass
class _Echoes:
    """Of each firing (N) up to as many echoes (E) as rays, from the nearest on. Unused ones have a signal of 0."""

    range: Array
    intensity: Array
    signal: Array  # relative to that of RATED_REFLECTANCE at the rated range
    ray: Array  # index of the ray that returns most


def _echoes(pattern: Pattern, distance: Array, intensity: Array) -> _Echoes:
    """Merges what the rays of a beam hit (N, samples) into echoes."""
    count, samples = distance.shape
    order = np.argsort(distance, axis=1, kind="stable")
    distance = np.take_along_axis(distance, order, axis=1)
    share = np.take_along_axis(intensity, order, axis=1) / samples
    hit = np.isfinite(distance)
    near = np.where(hit, distance, 0)
    # A Lambertian surface that fills the beam returns its intensity over the square of the distance.
    power = np.where(hit, share / np.maximum(near, 1e-3) ** 2, 0)
    with np.errstate(invalid="ignore"):
        gaps = np.diff(distance, axis=1) > pattern.echo_separation
    echo = np.concatenate([np.zeros((count, 1), np.int64), np.cumsum(gaps, axis=1)], axis=1)
    flat = (np.arange(count)[:, None] * samples + echo).ravel()

    def total(values: Array) -> Array:
        return np.bincount(flat, values.ravel(), count * samples).reshape(count, samples)

    signal = total(power)
    mean = total(power * near) / np.where(signal > 0, signal, 1)
    if math.isfinite(pattern.rated_range):
        relative = signal * (pattern.rated_range**2 / RATED_REFLECTANCE)
    else:
        relative = np.where(signal > 0, np.inf, 0)
    # The first of each echo in the order of falling power.
    strongest = np.zeros(count * samples, np.int64)
    by_power = np.lexsort((-power.ravel(), flat))
    firsts = np.flatnonzero(np.diff(flat[by_power], prepend=-1))
    strongest[flat[by_power[firsts]]] = order.ravel()[by_power[firsts]]
    return _Echoes(mean, total(np.where(hit, share, 0)), relative, strongest.reshape(count, samples))


def _chosen(detected: Array, signal: Array, returns: str) -> Array:
    """Selects among detected echoes (N, E)."""
    if returns == "all":
        return detected
    number = np.arange(detected.shape[1])
    some = detected.any(axis=1, keepdims=True)
    first = some & (number == np.argmax(detected, axis=1)[:, None])
    last = some & (number == detected.shape[1] - 1 - np.argmax(detected[:, ::-1], axis=1)[:, None])
    ranked = np.where(detected, signal, -1)
    strongest = some & (number == np.argmax(ranked, axis=1)[:, None])
    if returns != "dual":
        return {"first": first, "last": last, "strongest": strongest}[returns]
    # As Velodyne's sensors: the strongest and the last, or the two strongest if these are the same.
    others = np.where(strongest, -1, ranked)
    second = (others.max(axis=1, keepdims=True) >= 0) & (number == np.argmax(others, axis=1)[:, None])
    same = (strongest & last).any(axis=1, keepdims=True)
    return strongest | np.where(same, second, last)


def _cast(renderer: Renderer, origins: Array, directions: Array, slices: Array, times: Sequence[float | None],
          options: Mapping[str, Any]) -> dict[str, Array]:  # fmt: skip
    """Casts the rays of all firings (N, samples, 3), slice by slice of the time."""
    parts: list[dict[str, Array]] = []
    for first, end, time in zip(slices[:-1], slices[1:], times):
        some = directions[first:end]
        starts = np.broadcast_to(origins[first:end, None], some.shape).reshape(-1, 3)
        moment = options if time is None else {**options, "time": time}
        hits = renderer.cast(starts, some.reshape(-1, 3), **moment)
        parts.append({name: hits[name] for name in ("distance", "intensity", "id", "part", "material")})
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def scan(
    renderer: Renderer,
    pattern: Pattern,
    pose: npt.ArrayLike | _Poses,
    *,
    start: float = 0.0,
    samples: int = 1,
    returns: str = "strongest",
    seed: int | None = 0,
    slices: int = 1,
    **options: Any,
) -> Scan:
    """Scans the scene once and returns the points.

    pose: worldFromSensor in the frame of the option axes: a rigid matrix (4, 4), or a Trajectory or Motion, from which
    each firing has a pose of its own
    start: seconds on the trajectory at which the scan begins
    samples: rays per beam. With more than one, beams have the pattern's divergence, and edges may return two echoes
    returns: "strongest", "first" or "last" echo of each firing, "dual" (the strongest and the last) or "all"
    seed: of the noise of ranges and signals; None: no noise, and echoes are detected if their signal reaches the
    threshold
    slices: number of times at which an animated scene is posed during the scan; `time` is the pose at its beginning
    options: those of Renderer.cast(), such as time, data_surfaces and axes

    Returns the echoes that the receiver detects: those whose signal, which falls with the square of the range and the
    cosine of incidence, exceeds the threshold of a noisy receiver.
    """
    if returns not in RETURNS:
        raise UsageError(f"returns must be one of {', '.join(RETURNS)}, not {returns!r}")
    if not 1 <= samples <= 1024 or samples != int(samples):
        raise UsageError(f"samples must be a whole number from 1 to 1024, not {samples}")
    if slices < 1 or slices != int(slices):
        raise UsageError(f"slices must be a whole number of at least 1, not {slices}")
    poses = pose if hasattr(pose, "at") else Motion(checked_poses(pose))  # type: ignore[arg-type]
    frames = poses.at(start + pattern.times)  # type: ignore[union-attr]
    turns, origins = frames[:, :3, :3], frames[:, :3, 3]
    rays = _rays(pattern.directions, _beam(pattern, samples))
    directions = np.einsum("nij,nsj->nsi", turns, rays)
    edges = np.searchsorted(pattern.times, np.linspace(0, pattern.period, slices + 1)[1:-1])
    bounds = np.concatenate([[0], edges, [len(pattern)]]).astype(np.int64)
    if math.isfinite(pattern.max_range):
        options.setdefault("max_distance", pattern.max_range + 10 * pattern.range_noise)
    begin = options.get("time")
    moments = [None] if slices == 1 else [(begin or 0.0) + (i + 0.5) * pattern.period / slices for i in range(slices)]
    hits = _cast(renderer, origins, directions, bounds, moments, options)

    count = len(pattern)
    shape = (count, samples)
    echoes = _echoes(pattern, hits["distance"].reshape(shape).astype(np.float64), hits["intensity"].reshape(shape))
    range_noise = signal_noise = np.zeros(shape)
    if seed is not None:
        random = np.random.Generator(np.random.Philox(seed))
        range_noise = random.standard_normal(shape) * pattern.range_noise
        signal_noise = random.standard_normal(shape) * SIGNAL_NOISE
    ranges = echoes.range + range_noise
    if pattern.range_resolution > 0:
        ranges = np.round(ranges / pattern.range_resolution) * pattern.range_resolution
    detected = (echoes.signal > 0) & (echoes.signal + signal_noise >= SIGNAL_THRESHOLD)
    detected &= (ranges >= pattern.min_range) & (ranges <= pattern.max_range) & (ranges > 0)
    chosen = _chosen(detected, echoes.signal, returns)

    firing, echo = np.nonzero(chosen)
    at = ranges[firing, echo]
    position = pattern.directions[firing] * at[:, None]
    ray = firing * samples + echoes.ray[firing, echo]
    number = np.cumsum(detected, axis=1)[firing, echo] - 1
    return Scan(
        position=position.astype(np.float32),
        world_position=np.einsum("nij,nj->ni", turns[firing], position) + origins[firing],
        time=pattern.times[firing],
        range=at.astype(np.float32),
        intensity=np.clip(echoes.intensity[firing, echo], 0, 1).astype(np.float32),
        ring=np.asarray(pattern.rings, np.uint16)[firing],
        echo=number.astype(np.uint8),
        firing=firing.astype(np.uint32),
        id=hits["id"][ray],
        part=hits["part"][ray],
        material=hits["material"][ray],
    )
