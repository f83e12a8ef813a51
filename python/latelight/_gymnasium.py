"""Rendered observations for vector environments of Gymnasium."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ._core import (
    Camera,
    Renderer,
    _check_world_keywords,  # type: ignore[attr-defined]  # stubs list public names only
)
from ._from_mujoco import MujocoScene, from_mujoco
from ._model_builder import missing
from ._options import integers, reject_options, require
from .errors import ArgumentTypeError, UsageError


def _data_of(envs: Any) -> list[Any]:
    """The MjData of each environment of a SyncVectorEnv."""
    each = getattr(getattr(envs, "unwrapped", envs), "envs", None)
    if each is None or not all(hasattr(env.unwrapped, "data") for env in each):
        raise UsageError("the environments must be a SyncVectorEnv of MuJoCo environments, or `worlds` must be given")
    return [env.unwrapped.data for env in each]


def _check_combination(scene: Any, worlds: Any, renderer: Any, device: Any) -> None:
    if worlds is not None and not callable(worlds):
        raise ArgumentTypeError(f"worlds must be a function of the environments, not {type(worlds).__name__}")
    if worlds is not None and scene is not None:
        raise UsageError("`worlds` describes the worlds of the renderer's scene: omit `scene`")
    if renderer is not None and device != "auto":
        raise UsageError("`renderer` has a device: omit `device`")
    if renderer is not None and worlds is None and scene is None:
        raise UsageError("`renderer` requires `scene`, which it renders, or `worlds`")


def _list_of_cameras(cameras: Any) -> list[Camera]:
    each = [cameras] if isinstance(cameras, Camera) else cameras
    if not isinstance(each, Sequence) or not all(isinstance(camera, Camera) for camera in each):
        raise ArgumentTypeError(f"cameras must be a Camera or a list of these, not {cameras!r:.60}")
    if not each:
        raise UsageError("cameras must have at least one")
    return list(each)


def _size_of(size: Any) -> tuple[int, int]:
    pair = integers(size, "size")
    if len(pair) != 2 or min(pair) < 1:
        raise UsageError(f"size must be a width and a height above 0, not {size!r:.60}")
    return pair[0], pair[1]


def _indices(cameras: Sequence[Camera], of: Sequence[Camera]) -> list[int] | None:
    """The index of each camera, or nothing if not all of them are there. Equal cameras may differ in their body."""
    places = {id(camera): index for index, camera in enumerate(of)}
    found = [places[id(camera)] for camera in cameras if id(camera) in places]
    return found if len(found) == len(cameras) else None


def _reject_repeated(worlds: Mapping[str, Any], options: Mapping[str, Any], source: str) -> None:
    for name in options:
        if name in worlds:
            raise UsageError(f"{source} defines {name}: omit the option")


def add_pixels(
    envs: Any,
    *,
    scene: MujocoScene | None = None,
    cameras: Camera | Sequence[Camera] | None = None,
    size: tuple[int, int] = (64, 64),
    worlds: Callable[[Any], dict[str, Any]] | None = None,
    renderer: Renderer | None = None,
    device: str | int = "auto",
    **options: Any,
) -> Any:
    """Wraps a gymnasium.vector.VectorEnv: observations become {"state": the environment's, "pixels": images}.

    All environments are rendered in one call, as worlds. "pixels" is (N, H, W, 3), or (N, C, H, W, 3) with C > 1
    cameras: uint8, sRGB.

    scene: the model's scene; default: from_mujoco() of the first environment's model; not with `worlds`
    cameras: default: the first of the model's cameras; elements of `scene.cameras` follow their bodies, while other
    cameras, and a mixture of both, keep their poses
    size: width and height in pixels
    worlds: returns the arguments of render_worlds() that describe the worlds of the vector environment, for
    environments that are no SyncVectorEnv of MuJoCo environments; requires `renderer` and `cameras`
    renderer: default: one of the scene, on `device`; requires `scene` or `worlds`, and excludes `device`
    options: of render_worlds(), such as shadows="none", except outputs, out, on_device, channels_first, and what the
    environments' data or `worlds` defines

    All environments show the scene, so their models must be equal in what is shown: sizes, meshes, materials, lights.
    Gymnasium raises ValueError for environments with AutoresetMode.SAME_STEP, which its wrappers of observations do not
    support. Requires the package gymnasium (1.0 or newer)."""
    try:
        gymnasium = importlib.import_module("gymnasium")
    except ImportError:
        raise missing("gymnasium", "add_pixels") from None
    names = ("outputs", "out", "on_device", "channels_first")
    reject_options(options, names, 'a wrapped environment returns "pixels" as NumPy arrays of (..., H, W, 3)')
    _check_world_keywords(options)
    size = _size_of(size)
    if scene is not None:
        require(scene, MujocoScene, "scene")
    if renderer is not None:
        require(renderer, Renderer, "renderer")
    _check_combination(scene, worlds, renderer, device)
    if worlds is None:
        _data_of(envs)  # raises UsageError for other environments
        robot = scene or from_mujoco(envs.unwrapped.envs[0].unwrapped.model)
        if cameras is None and not robot.cameras:
            raise UsageError("the model has no camera: give `cameras`")
        cameras = _list_of_cameras(robot.cameras[0] if cameras is None else cameras)
        renderer = renderer or Renderer(robot.scene, device=device)
        camera_ids = _indices(cameras, robot.cameras)
        # Lights that the caller describes do not follow their bodies.
        light_ids: list[int] | None = [] if "lights" in options else None

        def worlds(envs: Any) -> dict[str, Any]:
            # Environments may replace their data, as in reset().
            arguments = robot.worlds(_data_of(envs), camera_ids=camera_ids, light_ids=light_ids)
            if camera_ids is None:
                arguments.pop("camera_to_world", None)
            return arguments

        _reject_repeated(worlds(envs), options, "the environments' data")

    elif renderer is None or cameras is None:
        raise UsageError("`worlds` requires `renderer` and `cameras`")
    return _class_of(gymnasium)(envs, renderer, _list_of_cameras(cameras), size, worlds, options)


def _class_of(gymnasium: Any) -> Any:
    class RenderedVectorEnv(gymnasium.vector.VectorObservationWrapper):  # type: ignore[misc]
        """See add_pixels()."""

        def __init__(
            self, envs: Any, renderer: Renderer, cameras: list[Camera], size: tuple[int, int], worlds: Any, options: dict[str, Any]
        ) -> None:
            super().__init__(envs)
            self.renderer, self.cameras, self.size = renderer, cameras, size
            self._worlds, self._options = worlds, options
            shape = (*((len(cameras),) if len(cameras) > 1 else ()), size[1], size[0], 3)
            spaces = gymnasium.spaces
            pixels = spaces.Box(0, 255, shape, np.uint8)
            self.single_observation_space = spaces.Dict(state=envs.single_observation_space, pixels=pixels)
            self.observation_space = spaces.Dict(
                state=envs.observation_space, pixels=gymnasium.vector.utils.batch_space(pixels, envs.num_envs)
            )

        def observations(self, observations: Any) -> dict[str, Any]:
            """The environment's observations and the images of their state."""
            worlds = self._worlds(self.env)
            if not isinstance(worlds, Mapping):
                raise ArgumentTypeError(
                    f"worlds must return a dict of arguments of render_worlds(), not {type(worlds).__name__}")
            _reject_repeated(worlds, self._options, "the result of `worlds`")
            frames = self.renderer.render_worlds(
                self.num_envs, self.cameras, self.size, "rgba", **worlds, **self._options
            )
            pixels = frames["rgba"][..., :3]
            if pixels.shape[1] == 1:
                pixels = pixels[:, 0]
            return {"state": observations, "pixels": np.ascontiguousarray(pixels)}

    return RenderedVectorEnv
