"""Writes point clouds as PLY, PCD, KITTI .bin and NPZ files. Files appear whole or not at all."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import UsageError

Arrays = Mapping[str, npt.NDArray[Any]]

_PLY_TYPES = {"f4": "float", "f8": "double", "u1": "uchar", "u2": "ushort", "u4": "uint"}


def _rows(fields: Arrays) -> npt.NDArray[Any]:
    """One packed little-endian record per point."""
    types = [(name, values.dtype.newbyteorder("<")) for name, values in fields.items()]
    rows = np.empty(len(next(iter(fields.values()))), np.dtype(types))
    for name, values in fields.items():
        rows[name] = values
    return rows


def _code(values: npt.NDArray[Any]) -> str:
    return f"{values.dtype.kind}{values.dtype.itemsize}"


def _ply(fields: Arrays) -> bytes:
    """Binary PLY 1.0 (Turk 1994, The PLY Polygon File Format)."""
    rows = _rows(fields)
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    lines += [f"property {_PLY_TYPES[_code(values)]} {name}" for name, values in fields.items()]
    return "\n".join([*lines, "end_header", ""]).encode() + rows.tobytes()


def _pcd(fields: Arrays) -> bytes:
    """Binary PCD 0.7, the format of the Point Cloud Library."""
    rows = _rows(fields)
    columns = list(fields.values())
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "VERSION 0.7",
        "FIELDS " + " ".join(fields),
        "SIZE " + " ".join(str(values.dtype.itemsize) for values in columns),
        "TYPE " + " ".join(values.dtype.kind.upper() for values in columns),
        "COUNT " + " ".join("1" for _ in columns),
        f"WIDTH {len(rows)}",
        "HEIGHT 1",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {len(rows)}",
        "DATA binary",
        "",
    ]
    return "\n".join(lines).encode() + rows.tobytes()


def _kitti(fields: Arrays) -> bytes:
    """Four floats per point, x, y, z and reflectance (Geiger et al. 2013, Vision meets Robotics: The KITTI Dataset)."""
    return np.stack([fields[name] for name in ("x", "y", "z", "intensity")], axis=1).astype("<f4").tobytes()


def _npz(fields: Arrays) -> bytes:
    buffer = io.BytesIO()
    named: dict[str, Any] = dict(fields)
    np.savez(buffer, **named)
    return buffer.getvalue()


_WRITERS = {".ply": _ply, ".pcd": _pcd, ".bin": _kitti, ".npz": _npz}


def write_points(path: str | os.PathLike[str], fields: Arrays) -> None:
    """Writes fields of equal length in the format of the path's extension."""
    target = Path(path)
    writer = _WRITERS.get(target.suffix.lower())
    if writer is None:
        raise UsageError(f"{target}: points are written as {', '.join(_WRITERS)}, not \"{target.suffix}\"")
    data = writer(fields)
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(temporary, 0o666 & ~mask)
            os.replace(temporary, target)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise UsageError(f"{target}: {error.strerror}") from error
