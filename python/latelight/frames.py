"""The results of render(): arrays by the names of outputs."""

from __future__ import annotations

from collections.abc import Iterator, KeysView, Mapping, Sequence
from typing import Any, TypeVar, overload

import numpy as np

from . import _core
from ._core import DeviceArray


Array = TypeVar("Array")
Item = TypeVar("Item")


class Outputs(Mapping[str, Array]):
    """Arrays by the names of outputs."""

    def __init__(self, arrays: dict[str, Array]) -> None:
        self._arrays = arrays

    def __getitem__(self, name: str) -> Array:
        try:
            return self._arrays[name]
        except KeyError:
            raise KeyError(f"there is no {name!r}; there are the outputs {', '.join(self._arrays)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        arrays = ", ".join(f"{name}: {array.dtype}{array.shape}" for name, array in self.items())
        return f"{type(self).__name__}({arrays})"


class Frame(Outputs[np.ndarray]):
    """The outputs of one camera, by name: frame["depth"].

    Arrays are (H, W), or (H, W, C) with more than one channel, (C, H, W) with channels_first; rows from the top. They
    are the renderer's own memory, not a copy, and stay valid as long as they are used. `exposure` is the factor that
    the picture's radiance was multiplied by, metered with exposure="auto".
    """

    def __init__(self, arrays: dict[str, np.ndarray], exposure: float = 1.0, channels_first: bool = False) -> None:
        super().__init__(arrays)
        self.exposure = exposure
        self._channels_first = channels_first

    def png(self) -> bytes:
        """The picture, the output rgba, as a PNG file."""
        picture = self["rgba"]
        if self._channels_first:
            picture = np.moveaxis(picture, 0, 2)
        if picture.shape[2] == 3:
            picture = np.concatenate([picture, np.full_like(picture[..., :1], 255)], axis=2)
        return _core.encode_png(np.ascontiguousarray(picture))

    def _repr_png_(self) -> bytes | None:
        return self.png() if "rgba" in self else None


class DeviceFrames(Outputs[DeviceArray]):
    """The outputs of all cameras in the memory of the renderer's device, by name: frames["depth"].

    torch.from_dlpack(frames["depth"]) shares that memory without a copy and keeps it as long as the tensor lives.
    Arrays are (V, H, W), or (V, H, W, C) with more than one channel; of a single camera without V. `exposures` are the
    factors that the radiance of each picture was multiplied by, in the order of the pictures.
    """

    def __init__(self, arrays: dict[str, DeviceArray], exposures: Sequence[float] = ()) -> None:
        super().__init__(arrays)
        self.exposures = tuple(exposures)


class _Stacked(Sequence[Item]):
    """A sequence whose outputs are also found by their names, as those of a Frame are."""

    def keys(self) -> KeysView[str]:
        """The names of the outputs."""
        return self[0].keys() if len(self) else {}.keys()

    def __contains__(self, key: object) -> bool:
        return key in self.keys() if isinstance(key, str) else super().__contains__(key)


class Frames(_Stacked[Frame]):
    """The outputs of several cameras: frames[3] is a Frame, frames["depth"] all depths, (V, H, W) or (V, H, W, C).

    `"depth" in frames` and `frames.keys()` are about the outputs, so dict(frames) has an array per output.
    An array of all views is put together when it is asked for the first time, which copies it.
    """

    def __init__(self, frames: list[Frame]) -> None:
        self._frames = frames
        self._stacked: dict[str, np.ndarray] = {}

    @overload
    def __getitem__(self, key: int) -> Frame: ...
    @overload
    def __getitem__(self, key: slice) -> Frames: ...
    @overload
    def __getitem__(self, key: str) -> np.ndarray: ...
    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, slice):
            return Frames(self._frames[key])
        if not isinstance(key, str):
            return self._frames[key]
        if key not in self._stacked:
            self._stacked[key] = np.stack([frame[key] for frame in self._frames])
        return self._stacked[key]

    def __len__(self) -> int:
        return len(self._frames)

    def __repr__(self) -> str:
        return f"Frames({len(self)} x {self._frames[0]!r})" if self._frames else "Frames()"


class WorldFrames(_Stacked[Frames]):
    """The outputs of worlds: frames[3] are the Frames of world 3, frames["depth"] all depths, (N, C, H, W).

    Outputs with more than one channel are (N, C, H, W, channels), and found by name as those of Frames.
    `invalid_worlds` are the worlds with values that are not finite; their images show only the background.
    """

    def __init__(self, frames: list[Frame], cameras: int, invalid_worlds: Sequence[int]) -> None:
        self._worlds = [Frames(frames[first : first + cameras]) for first in range(0, len(frames), cameras)]
        self._stacked: dict[str, np.ndarray] = {}
        self.invalid_worlds = tuple(invalid_worlds)

    @overload
    def __getitem__(self, key: int) -> Frames: ...
    @overload
    def __getitem__(self, key: slice) -> Sequence[Frames]: ...
    @overload
    def __getitem__(self, key: str) -> np.ndarray: ...
    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return self._worlds[key]
        if key not in self._stacked:
            self._stacked[key] = np.stack([np.stack([frame[key] for frame in world]) for world in self._worlds])
        return self._stacked[key]

    def __len__(self) -> int:
        return len(self._worlds)

    def __repr__(self) -> str:
        return f"WorldFrames({len(self)} x {self._worlds[0]!r})"


def frames_of_arrays(
    arrays: dict[str, np.ndarray],
    axes: int,
    exposures: Sequence[float],
    invalid_worlds: Sequence[int],
    channels_first: bool,
) -> Any:
    """The frames of arrays of all views, without a copy. `axes`: the number of their view axes."""
    if axes == 0:
        return Frame(arrays, exposures[0], channels_first)
    first = next(iter(arrays.values())).shape
    flat = {name: array.reshape((-1, *array.shape[axes:])) for name, array in arrays.items()}
    count = int(np.prod(first[:axes]))
    frames = [Frame({name: a[i] for name, a in flat.items()}, exposures[i], channels_first) for i in range(count)]
    all_frames = Frames(frames) if axes == 1 else WorldFrames(frames, first[1], invalid_worlds)
    all_frames._stacked = dict(arrays)
    return all_frames


class DeviceWorldFrames(DeviceFrames):
    """The outputs of worlds in the memory of the renderer's device: (N, C, H, W), or (N, C, H, W, channels).

    `invalid_worlds` are the worlds with values that are not finite; their images show only the background.
    """

    def __init__(
        self, arrays: dict[str, DeviceArray], invalid_worlds: Sequence[int], exposures: Sequence[float] = ()
    ) -> None:
        super().__init__(arrays, exposures)
        self.invalid_worlds = tuple(invalid_worlds)
