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
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Renderer
from ._options import numbers, require
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
    "os1_128",
    "os1_64",
    "patterns",
    "scan",
    "sensor_pose",
    "spinning",
    "vlp16",
]

Array = npt.NDArray[Any]

RETURNS = ("strongest", "first", "last", "dual", "all")
POSITIVE = ("period", "rated_range", "max_range", "echo_separation")  # fields of Pattern that must be above 0
NOT_NEGATIVE = ("min_range", "range_noise", "range_resolution")


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
        # The only way to convert the fields of a frozen dataclass.
        object.__setattr__(self, "directions", _core.numbers_of(self.directions, "directions"))
        object.__setattr__(self, "times", _core.numbers_of(self.times, "times"))
        object.__setattr__(self, "rings", _core.rings_of(self.rings))
        count = self.times.size
        if self.directions.shape != (count, 3) or self.rings.shape != (count,) or self.times.shape != (count,):
            raise UsageError("a pattern needs directions (N, 3), and times and rings (N)")
        lengths = np.linalg.norm(self.directions, axis=1)
        if not np.allclose(lengths, 1, atol=1e-6):
            raise UsageError("the directions of a pattern must be unit vectors")
        positive = [_core.number_of(getattr(self, name), name) for name in POSITIVE]
        if not all(value > 0 for value in positive):
            raise UsageError("period, rated_range, max_range and echo_separation of a pattern must be above 0")
        others = [_core.number_of(getattr(self, name), name) for name in NOT_NEGATIVE]
        others += numbers(self.divergence, "divergence", 2)
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
    if not _core.number_of(cycle, "cycle") > 0 or not _core.number_of(rate, "rate") > 0:
        raise UsageError("a spinning sensor needs a cycle and a rate above 0")
    lasers = _core.numbers_of(elevations, "elevations").size
    offsets, azimuth = _core.numbers_of(firing, "firing"), _core.numbers_of(azimuths, "azimuths")
    if offsets.ndim == 0:
        offsets = np.arange(lasers) * offsets
    if azimuth.size == 1:
        azimuth = np.full(lasers, azimuth.item())
    fields = _core.spinning_pattern(name, elevations, azimuth, offsets, cycle, columns or 0, rate)
    return Pattern(**{**fields, **properties})


def _named(sensor: str, rate: float, columns: int = 0, start: float = 0.0) -> Pattern:
    if not _core.number_of(rate, "rate") > 0:
        raise UsageError("rate must be above 0")
    return Pattern(**_core.lidar_pattern(sensor, rate, columns, start))


def vlp16(rate: float = 10.0) -> Pattern:
    """Velodyne VLP-16 (VLP-16 User Manual, 63-9243 Rev. D: chapter 9 and appendix on timing); rate: 5 to 20 Hz."""
    return _named("vlp-16", rate)


def hdl32e(rate: float = 10.0) -> Pattern:
    """Velodyne HDL-32E (HDL-32E User Manual, 63-9113: appendix on the firing sequence); rate: 5 to 20 Hz."""
    return _named("hdl-32e", rate)


def hdl64e(rate: float = 10.0) -> Pattern:
    """Velodyne HDL-64E S2, the sensor of KITTI, with its nominal elevations (HDL-64E S2 User Manual); 5 to 15 Hz."""
    return _named("hdl-64e", rate)


def os1_64(rate: float = 10.0, columns: int = 1024) -> Pattern:
    """Ouster OS1-64, first generation (OS1 datasheet): 64 lasers from -16.6 to 16.6 degrees that fire at once.

    rate: 10 or 20 Hz; columns: 512, 1024 or 2048 per scan.
    """
    return _named("os1-64", rate, columns)


def os1_128(rate: float = 10.0, columns: int = 1024) -> Pattern:
    """Ouster OS1-128, first generation (OS1 datasheet): 128 lasers from -22.5 to 22.5 degrees that fire at once.

    rate: 10 or 20 Hz; columns: 512, 1024 or 2048 per scan.
    """
    return _named("os1-128", rate, columns)


def livox_mid40(period: float = 0.1, start: float = 0.0) -> Pattern:
    """Livox Mid-40: a rosette that never repeats, within a cone of 38.4 degrees, at 100,000 points per second.

    Two equal prisms that turn against each other deflect the beam, each by a quarter of the cone (Brazeal, Wilkinson
    and Hochmair 2021, A Rigorous Observation Model for the Risley Prism-Based Livox Mid-40 Lidar Sensor, Sensors 21:
    7294 and -4664 revolutions per minute; here with thin prisms). start: seconds; successive scans begin where the last
    one ended.
    """
    if not _core.number_of(period, "period") > 0:
        raise UsageError("period must be above 0")
    return _named("mid-40", 1 / period, 0, start)


def patterns() -> dict[str, Pattern]:
    """All sensors of this module, by name."""
    return {pattern.name: pattern for pattern in (vlp16(), hdl32e(), hdl64e(), os1_64(), os1_128(), livox_mid40())}


@dataclass(frozen=True)
class Scan:
    """The points of one scan, in the order of the firings, and of the range within a firing."""

    position: Array  # (P, 3) float32, meters: in the sensor's frame at the time of the firing, as sensors report them
    world_position: Array  # (P, 3) float64, meters: in the scene, in the frame of axes and relative to position_origin
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
        _core.write_points(path, dict(self.fields(frame)))


class _Poses(Protocol):
    def at(self, times: npt.ArrayLike) -> npt.NDArray[np.float64]: ...


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
    returns: "strongest", "first" or "last" echo of each firing, "all", or "dual": the strongest and the last, or the
    two strongest if these are the same
    seed: of the noise of ranges and signals; None: no noise, and echoes are detected if their signal reaches the
    threshold
    slices: number of equal parts of the pattern's period, each of which shows an animated scene at the time of its
    middle, where `time` is that of the scan's beginning. Firings outside the period are in further parts of the same
    length. 1: all firings show the scene at `time`. Without `time`, the scene is at rest
    options: those of Renderer.cast(), such as time, data_surfaces and axes. World positions are relative to
    position_origin; poses are not

    Returns the echoes that the receiver detects: those whose signal, which falls with the square of the range and the
    cosine of incidence, exceeds the threshold of a noisy receiver.
    """
    require(pattern, Pattern, "pattern")
    if returns not in RETURNS:
        raise UsageError(f"returns must be one of {', '.join(RETURNS)}, not {returns!r}")
    limit = _core.number_of(options.pop("max_distance", math.inf), "max_distance")
    if not limit > 0:
        raise UsageError(f"max_distance must be above 0 meters, not {limit:g}")
    if limit < pattern.max_range:
        pattern = replace(pattern, max_range=limit)
    # Arrays of JAX have a property "at", too.
    poses = pose if callable(getattr(pose, "at", None)) else Motion(checked_poses(pose))  # type: ignore[arg-type]
    begin = _core.number_of(start, "start")
    if not math.isfinite(begin):
        raise UsageError(f"start must be a finite number of seconds, not {begin:g}")
    frames = poses.at(begin + pattern.times)  # type: ignore[union-attr]
    return Scan(**_core.scan_lidar(renderer, pattern, frames, samples, returns, seed, slices, **options))
