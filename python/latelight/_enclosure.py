"""The files that a URDF or USD file may refer to: those in its folder and in folders that the caller allows, as for
glTF files (docs/conventions.md#files)."""

from __future__ import annotations

import os
import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .errors import InputError, UsageError

_KERNEL = ("/proc", "/sys", "/dev")


class Enclosure:
    """`root`: the folder of the owner; default: the one that it is in."""

    def __init__(self, owner: Any, allow_outside: Sequence[str | os.PathLike[str]], root: Path | None = None) -> None:
        self.owner = os.fspath(owner)
        file = Path(self.owner).absolute()
        self.folders = [root.resolve()] if root else [file.parent.resolve(), file.resolve().parent]
        for name in allow_outside:
            folder = Path(name).resolve()
            if not folder.is_dir():
                raise UsageError(
                    f"'{os.fspath(name)}' is not a folder: allow_outside requires a folder from which the scene may read"
                )
            self.folders.append(folder)

    def check(self, name: Any) -> str:
        """Returns the path of a file, with links followed, that the owner refers to. Raises InputError if the file must
        not be read. A file that does not exist is left to the caller."""
        real = Path(os.path.realpath(name))
        if not any(real.is_relative_to(folder) for folder in self.folders):
            raise InputError(
                f"{self.owner}: it refers to the file {os.fspath(name)}, which is outside the scene's folder, at {real}: "
                "move it there, or allow its folder with allow_outside"
            )
        if real.exists() and (not stat.S_ISREG(real.stat().st_mode) or any(real.is_relative_to(k) for k in _KERNEL)):
            raise InputError(
                f"{self.owner}: it refers to {os.fspath(name)}, which is not a regular file: a scene must not read "
                "devices, pipes, folders or kernel files"
            )
        return str(real)
