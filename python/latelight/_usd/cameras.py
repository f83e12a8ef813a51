"""Cameras, with a perspective or an orthographic projection, and their exposures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from .._core import Camera
from ..errors import UsageError
from .animation import Animation
from .context import Context
from .transforms import axes_of
from .traversal import visible_prims


def exposures_of(context: Context) -> Iterator[float]:
    """The exposures of all cameras in stops, in the order in which cameras are added to a scene."""
    for prim in visible_prims(context):
        if prim.IsA(context.pxr.UsdGeom.Camera):
            scale = float(context.pxr.UsdGeom.Camera(prim).ComputeLinearExposureScale(context.time))
            yield math.log2(scale) if scale > 0 else -math.inf


def add_camera(context: Context, animation: Animation, prim: Any) -> None:
    gf = context.pxr.UsdGeom.Camera(prim).GetCamera(context.time)
    is_orthographic = gf.projection == context.pxr.Gf.Camera.Orthographic
    if gf.verticalAperture <= 0 or (gf.focalLength <= 0 and not is_orthographic):
        name = "verticalAperture" if gf.verticalAperture <= 0 else "focalLength"
        raise UsageError(f"{prim.GetPath()} has the {name} {getattr(gf, name):g}, but it must be positive")
    pose = _camera_pose(context.scene_from(prim))
    camera = context.scene.look_at(pose[:3, 3], pose[:3, 3] + pose[:3, 2])
    camera.camera_to_world, camera.name = pose, prim.GetName()
    if is_orthographic:
        camera.orthographic = True
        camera.half_height = gf.verticalAperture * context.pxr.Gf.Camera.APERTURE_UNIT / 2 * context.meters
    else:
        camera.vertical_fov = float(gf.GetFieldOfView(context.pxr.Gf.Camera.FOVVertical))
    _set_planes(context, camera, prim)
    # An offset moves what the camera sees, and the center of the projection moves the other way in the image.
    if gf.horizontalAperture > 0:
        camera.aspect = gf.horizontalAperture / gf.verticalAperture
        camera.principal_x = -2 * gf.horizontalApertureOffset / gf.horizontalAperture
    camera.principal_y = -2 * gf.verticalApertureOffset / gf.verticalAperture
    context.scene.add_camera(camera, animation.node_of(prim) if context.samples.moves(prim) else None)


def _set_planes(context: Context, camera: Camera, prim: Any) -> None:
    """USD's range without an authored one begins at 1 unit, which would clip what is near the camera in stages in
    meters. Ranges that are not possible are repaired like those of glTF files."""
    attribute = context.pxr.UsdGeom.Camera(prim).GetClippingRangeAttr()
    near, far = (float(distance) * context.meters for distance in attribute.Get(context.time))
    if camera.orthographic:
        camera.near_clip, camera.far_clip = sorted((near if attribute.HasAuthoredValue() else 0, far))
    elif attribute.HasAuthoredValue():
        camera.near_clip = near if near > 0 else camera.near_clip
        camera.far_clip = far if far > camera.near_clip else math.inf


def _camera_pose(transform: np.ndarray) -> np.ndarray:
    """The pose of OpenCV's camera, which has Y down and Z forward, by USD's, which has Y up and -Z forward. Scale,
    mirroring and shear do not change the image, as in GfFrustum; a sheared camera keeps its direction."""
    rotation = axes_of(transform[None])[0][0]
    back = rotation[:, 2]
    right = np.cross(rotation[:, 1], back)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.stack([right, -np.cross(back, right), -back], axis=1), transform[:3, 3]
    return pose
