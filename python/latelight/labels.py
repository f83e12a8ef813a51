"""Labels of pictures as arrays: objects, keypoints and correspondence (docs/labels.md)."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


@dataclasses.dataclass(frozen=True, eq=False)
class Labels:
    """The N objects of a picture (H, W), as Renderer.labels() returns them, sorted by id.

    An object is everything with one value of the output ``id``. Objects that would cover no pixel of the picture, even
    with nothing else in the scene, are left out. Boxes of pixels are x, y, width and height with y down, as in COCO,
    and zeros if they are empty.
    """

    ids: npt.NDArray[np.uint32]
    """(N,): values of the output ``id``."""
    nodes: list[str]
    """N paths of nodes."""
    id_image: npt.NDArray[np.uint32]
    """(H, W): the output ``id``."""
    visible_masks: npt.NDArray[np.bool_]
    """(N, H, W): the pixels that show the object."""
    amodal_masks: npt.NDArray[np.bool_]
    """(N, H, W): the pixels that the object would cover with nothing else in the scene."""
    visible_pixels: npt.NDArray[np.int64]
    """(N,): numbers of pixels of ``visible_masks``."""
    amodal_pixels: npt.NDArray[np.int64]
    """(N,): numbers of pixels of ``amodal_masks``."""
    full_pixels: npt.NDArray[np.int64]
    """(N,): the same including up to one picture width and height beyond each edge."""
    visible_share: npt.NDArray[np.float64]
    """(N,): ``visible_pixels / full_pixels``, from 0 to 1."""
    visible_boxes: npt.NDArray[np.int64]
    """(N, 4): bounding boxes of ``visible_masks``."""
    amodal_boxes: npt.NDArray[np.int64]
    """(N, 4): bounding boxes of ``amodal_masks``."""
    full_boxes: npt.NDArray[np.int64]
    """(N, 4): bounding boxes of ``full_pixels``; they may extend beyond the picture."""
    object_to_world: npt.NDArray[np.float64]
    """(N, 4, 4): from the object's own frame, which is rigid, to the frame of the option ``axes``."""
    object_to_camera: npt.NDArray[np.float64]
    """(N, 4, 4): from the object's own frame to OpenCV's camera frame."""
    box_min: npt.NDArray[np.float64]
    """(N, 3): the lower corner of the box in the object's own frame, meters."""
    box_max: npt.NDArray[np.float64]
    """(N, 3): the upper corner."""
    box_corners: npt.NDArray[np.float64]
    """(N, 8, 3): pixel coordinates and depth of the corners; x changes fastest, z slowest. NaN if not projected."""
    occlusions: npt.NDArray[np.int64]
    """(N, N): the number of pixels at which object i is in front of object j, even if others are in front of both."""


@dataclasses.dataclass(frozen=True)
class Keypoint:
    """A point that follows a node of the scene, which may be a joint of a skin."""

    node: str
    """Path of the node."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """In the node's frame, before the node's scale."""
    name: str = ""
    thickness: float = 0.0
    """Meters that the point's own object may be in front of it, as flesh is in front of a joint."""


@dataclasses.dataclass(frozen=True, eq=False)
class Keypoints:
    """K keypoints in a picture, as Renderer.keypoints() returns them."""

    names: list[str]
    positions: npt.NDArray[np.float64]
    """(K, 3): in the frame of the option ``axes``, meters."""
    pixels: npt.NDArray[np.float64]
    """(K, 2): pixel coordinates, possibly outside the picture. NaN if the camera does not project the point."""
    depth: npt.NDArray[np.float64]
    """(K,): as the output ``depth``. NaN if the camera does not project the point."""
    visibility: npt.NDArray[np.uint32]
    """(K,): COCO's values: 0 outside the picture or the camera's planes, 1 occluded, 2 visible."""


@dataclasses.dataclass(frozen=True, eq=False)
class Correspondence:
    """Where the surfaces of one picture (H, W) are in another, as Renderer.correspond() returns it."""

    pixels: npt.NDArray[np.float32]
    """(H, W, 2): pixel coordinates in the second picture, possibly outside of it. NaN for the background and for
    points that the second camera does not project."""
    depth: npt.NDArray[np.float32]
    """(H, W): as the output ``depth`` of the second picture. NaN where ``pixels`` is."""
    visible: npt.NDArray[np.bool_]
    """(H, W): the second picture shows the same point."""
    flow: npt.NDArray[np.float32]
    """(H, W, 3): scene flow, the displacement of the surface in the frame of the option ``axes``, meters. 0 for the
    background."""


@dataclasses.dataclass(frozen=True, eq=False)
class WorldLabels:
    """The O objects of N worlds with C cameras each, as Renderer.labels_of_worlds() returns them, sorted by id.

    The O objects are those that cover a pixel of any image by themselves. ``present`` tells in which images they do. In
    the other images their masks, pixels, boxes of pixels and shares are 0, and everything else about them is NaN.
    Arrays are those of ``Labels`` with two axes before, worlds and cameras.
    """

    ids: npt.NDArray[np.uint32]
    """(O,): values of the output ``id``."""
    nodes: list[str]
    """O paths of nodes."""
    present: npt.NDArray[np.bool_]
    """(N, C, O): the object would cover a pixel of the image with nothing else in the scene."""
    id_image: npt.NDArray[np.uint32]
    """(N, C, H, W): the output ``id``."""
    visible_masks: npt.NDArray[np.bool_]
    """(N, C, O, H, W)"""
    amodal_masks: npt.NDArray[np.bool_]
    """(N, C, O, H, W)"""
    visible_pixels: npt.NDArray[np.int64]
    """(N, C, O)"""
    amodal_pixels: npt.NDArray[np.int64]
    """(N, C, O)"""
    full_pixels: npt.NDArray[np.int64]
    """(N, C, O)"""
    visible_share: npt.NDArray[np.float64]
    """(N, C, O)"""
    visible_boxes: npt.NDArray[np.int64]
    """(N, C, O, 4)"""
    amodal_boxes: npt.NDArray[np.int64]
    """(N, C, O, 4)"""
    full_boxes: npt.NDArray[np.int64]
    """(N, C, O, 4)"""
    object_to_world: npt.NDArray[np.float64]
    """(N, C, O, 4, 4)"""
    object_to_camera: npt.NDArray[np.float64]
    """(N, C, O, 4, 4)"""
    box_min: npt.NDArray[np.float64]
    """(N, C, O, 3)"""
    box_max: npt.NDArray[np.float64]
    """(N, C, O, 3)"""
    box_corners: npt.NDArray[np.float64]
    """(N, C, O, 8, 3)"""
    occlusions: npt.NDArray[np.int64]
    """(N, C, O, O)"""


@dataclasses.dataclass(frozen=True, eq=False)
class WorldKeypoints:
    """K keypoints in N worlds with C cameras each, as Renderer.keypoints_of_worlds() returns them. In a world with
    values that are not finite, the visibility is 0, and all other values are NaN."""

    names: list[str]
    positions: npt.NDArray[np.float64]
    """(N, C, K, 3)"""
    pixels: npt.NDArray[np.float64]
    """(N, C, K, 2)"""
    depth: npt.NDArray[np.float64]
    """(N, C, K)"""
    visibility: npt.NDArray[np.uint32]
    """(N, C, K)"""


@dataclasses.dataclass(frozen=True, eq=False)
class WorldCorrespondence:
    """Where the surfaces of the images of N worlds with C cameras each are in the next frame's images, as
    Renderer.correspond_worlds() returns it. Arrays are those of ``Correspondence`` with two axes before, worlds and
    cameras."""

    pixels: npt.NDArray[np.float32]
    """(N, C, H, W, 2)"""
    depth: npt.NDArray[np.float32]
    """(N, C, H, W)"""
    visible: npt.NDArray[np.bool_]
    """(N, C, H, W)"""
    flow: npt.NDArray[np.float32]
    """(N, C, H, W, 3)"""


def _world_labels(views: Sequence[Labels], cameras: int) -> WorldLabels:
    """The labels of all views, world by world, as arrays with the same objects in every view."""
    paths = {int(number): node for view in views for number, node in zip(view.ids, view.nodes, strict=True)}
    ids = np.array(sorted(paths), np.uint32)
    axes = (len(views) // cameras, cameras)
    present = np.zeros((len(views), len(ids)), bool)
    places = [np.searchsorted(ids, view.ids) for view in views]
    for index, place in enumerate(places):
        present[index, place] = True
    arrays: dict[str, npt.NDArray[np.generic]] = {"id_image": np.stack([view.id_image for view in views])}
    for field in dataclasses.fields(WorldLabels):
        if field.name in ("ids", "nodes", "present", "id_image"):
            continue
        values = [getattr(view, field.name) for view in views]
        dtype = values[0].dtype
        pairs = field.name == "occlusions"
        shape = (len(ids), len(ids)) if pairs else (len(ids), *values[0].shape[1:])
        unknown = np.nan if dtype.kind == "f" and field.name != "visible_share" else 0
        array = np.full((len(views), *shape), unknown, dtype)
        for index, place in enumerate(places):
            array[index][np.ix_(place, place) if pairs else place] = values[index]
        arrays[field.name] = array
    shaped = {name: array.reshape(axes + array.shape[1:]) for name, array in arrays.items()}
    return WorldLabels(
        ids=ids, nodes=[paths[int(number)] for number in ids], present=present.reshape(*axes, -1), **shaped
    )  # type: ignore[arg-type]


def _stacked(views: Sequence[object], cameras: int, name: str) -> npt.NDArray[np.generic]:
    array = np.stack([getattr(view, name) for view in views])
    return array.reshape(len(views) // cameras, cameras, *array.shape[1:])


def _world_keypoints(views: Sequence[Keypoints], cameras: int) -> WorldKeypoints:
    arrays = {name: _stacked(views, cameras, name) for name in ("positions", "pixels", "depth", "visibility")}
    return WorldKeypoints(names=views[0].names, **arrays)  # type: ignore[arg-type]


def _world_correspondence(views: Sequence[Correspondence], cameras: int) -> WorldCorrespondence:
    arrays = {name: _stacked(views, cameras, name) for name in ("pixels", "depth", "visible", "flow")}
    return WorldCorrespondence(**arrays)  # type: ignore[arg-type]
