"""Rigid poses over time, for sensors that move while they measure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import UsageError

Array = npt.NDArray[np.float64]


def checked_poses(poses: npt.ArrayLike, name: str = "pose") -> Array:
    """Returns poses (..., 4, 4) as float64. Raises UsageError unless all are rigid: rotations and translations."""
    array = _core.numbers_of(poses, name)
    if array.shape[-2:] != (4, 4):
        raise UsageError(f"{name} must be a matrix of 4x4 values, not of shape {array.shape}")
    turns = array[..., :3, :3]
    rigid = (
        np.isfinite(array).all()
        and np.allclose(turns @ np.swapaxes(turns, -1, -2), np.eye(3), atol=1e-4)
        and np.all(np.linalg.det(turns) > 0)
        and np.allclose(array[..., 3, :], [0, 0, 0, 1])
    )
    if not rigid:
        raise UsageError(f"{name} must be rigid: a rotation and a translation, without scale or reflection")
    return array


def rotations(vectors: Array) -> Array:
    """Returns the matrices (N, 3, 3) of rotation vectors (N, 3): axis times angle in radians (Rodrigues' formula)."""
    angles = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    # sin(a) / a and (1 - cos(a)) / a^2, which are 1 and 1/2 at 0.
    first = np.sinc(angles / np.pi)
    second = 0.5 * np.sinc(angles / (2 * np.pi)) ** 2
    return np.eye(3) + first * cross + second * (cross @ cross)


def rotation_vectors(matrices: Array) -> Array:
    """Returns the rotation vectors (N, 3) of matrices (N, 3, 3), with angles from 0 to pi."""
    # As quaternions, from the largest of the four components, so that no angle loses precision (Shepperd 1978).
    m = matrices
    trace = np.trace(m, axis1=-2, axis2=-1)
    diagonal = np.diagonal(m, axis1=-2, axis2=-1)
    squares = 1 + np.concatenate([trace[..., None], 2 * diagonal - trace[..., None]], axis=-1)
    largest = np.argmax(squares, axis=-1)
    w = [
        np.stack([squares[..., 0], m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], -1),
        np.stack([m[..., 2, 1] - m[..., 1, 2], squares[..., 1], m[..., 1, 0] + m[..., 0, 1], m[..., 0, 2] + m[..., 2, 0]], -1),
        np.stack([m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] + m[..., 0, 1], squares[..., 2], m[..., 2, 1] + m[..., 1, 2]], -1),
        np.stack([m[..., 1, 0] - m[..., 0, 1], m[..., 0, 2] + m[..., 2, 0], m[..., 2, 1] + m[..., 1, 2], squares[..., 3]], -1),
    ]
    quaternions = np.take_along_axis(np.stack(w, axis=-2), largest[..., None, None], axis=-2)[..., 0, :]
    quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
    quaternions = np.where(quaternions[..., :1] < 0, -quaternions, quaternions)
    sines = np.linalg.norm(quaternions[..., 1:], axis=-1, keepdims=True)
    angles = 2 * np.arctan2(sines, quaternions[..., :1])
    return quaternions[..., 1:] * np.where(sines > 1e-12, angles / np.maximum(sines, 1e-12), 2.0)


class Trajectory:
    """Poses of a sensor over time: worldFromSensor, in the frame of the scene file.

    Between the given poses, positions are linear, and rotations turn about a fixed axis at a constant rate (slerp).
    """

    def __init__(self, times: npt.ArrayLike, poses: npt.ArrayLike) -> None:
        """times: (K,) seconds, increasing, at least two; poses: (K, 4, 4), rigid."""
        self.times = _core.numbers_of(times, "times")
        self.poses = checked_poses(poses, "poses")
        if self.times.ndim != 1 or len(self.times) < 2 or self.poses.shape != (len(self.times), 4, 4):
            raise UsageError("a trajectory has at least two times (K) and as many poses (K, 4, 4)")
        if not np.all(np.isfinite(self.times)) or np.any(np.diff(self.times) <= 0):
            raise UsageError("the times of a trajectory must increase")

    def at(self, times: npt.ArrayLike) -> Array:
        """Returns the poses (N, 4, 4) at times (N,) in seconds, which must lie within the trajectory."""
        when = _core.numbers_of(times, "times").ravel()
        slack = 1e-9 * max(1.0, float(np.abs(self.times).max()))
        if when.size and (when.min() < self.times[0] - slack or when.max() > self.times[-1] + slack):
            raise UsageError(
                f"the trajectory is known from {self.times[0]:g} to {self.times[-1]:g} s, and the scan lasts from "
                f"{when.min():g} to {when.max():g} s"
            )
        before = np.clip(np.searchsorted(self.times, when, side="right") - 1, 0, len(self.times) - 2)
        share = (when - self.times[before]) / (self.times[before + 1] - self.times[before])
        first, second = self.poses[:-1], self.poses[1:]
        turns = rotation_vectors(np.swapaxes(first[:, :3, :3], 1, 2) @ second[:, :3, :3])
        result = np.tile(np.eye(4), (len(when), 1, 1))
        result[:, :3, :3] = first[before, :3, :3] @ rotations(turns[before] * share[:, None])
        offsets = second[:, :3, 3] - first[:, :3, 3]
        result[:, :3, 3] = first[before, :3, 3] + offsets[before] * share[:, None]
        return result


class Motion:
    """A sensor that moves at a constant velocity: at time 0 it is at `pose` (4, 4).

    velocity: meters per second along the axes of the scene file; angular_velocity: a rotation vector in radians per
    second, about the sensor's own origin and along the axes of the scene file.
    """

    def __init__(
        self, pose: npt.ArrayLike, velocity: Sequence[float] = (0, 0, 0), angular_velocity: Sequence[float] = (0, 0, 0)
    ) -> None:
        self.pose = checked_poses(pose)
        self.velocity = _core.numbers_of(velocity, "velocity")
        self.angular_velocity = _core.numbers_of(angular_velocity, "angular_velocity")
        if self.pose.shape != (4, 4):
            raise UsageError(f"pose must be one matrix of 4x4 values, not of shape {self.pose.shape}")
        for name in ("velocity", "angular_velocity"):
            vector = getattr(self, name)
            if vector.shape != (3,) or not np.isfinite(vector).all():
                raise UsageError(f"{name} must be three numbers")

    def at(self, times: npt.ArrayLike) -> Array:
        """Returns the poses (N, 4, 4) at times (N,) in seconds."""
        when = _core.numbers_of(times, "times").ravel()
        result = np.tile(self.pose, (len(when), 1, 1))
        result[:, :3, :3] = rotations(when[:, None] * self.angular_velocity) @ self.pose[:3, :3]
        result[:, :3, 3] += when[:, None] * self.velocity
        return result


def sensor_pose(position: Sequence[float], forward: Sequence[float], up: Sequence[float] = (0, 1, 0)) -> Array:
    """Returns the pose (4, 4) of a sensor whose X axis points forward, Y left and Z up (REP 103 of ROS).

    All vectors are in the frame of the scene file. `forward` and `up` may have any length and need not be orthogonal;
    the sensor looks exactly forward.
    """
    x, z, origin = _core.numbers_of(forward, "forward"), _core.numbers_of(up, "up"), _core.numbers_of(position, "position")
    if x.shape != (3,) or z.shape != (3,) or origin.shape != (3,):
        raise UsageError("position, forward and up must be three numbers each")
    for name, vector in (("position", origin), ("forward", x), ("up", z)):
        if not np.isfinite(vector).all():
            raise UsageError(f"{name} must be three finite numbers, not {vector.tolist()}")
    y = np.cross(z, x)
    if not np.isfinite(y).all() or np.linalg.norm(y) < 1e-9 * np.linalg.norm(x) * np.linalg.norm(z) or not x.any():
        raise UsageError("forward and up must be different directions")
    x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, y, np.cross(x, y)], axis=1)
    pose[:3, 3] = origin
    return pose
