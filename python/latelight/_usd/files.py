"""The files of a stage: which of them may be read, and their contents, also within .usdz archives."""

from __future__ import annotations

import io
import os
import zipfile
from typing import Any

from .._enclosure import Enclosure
from ..errors import UsageError


def open_stage(pxr: Any, path: str, enclosure: Enclosure) -> Any:
    """A stage all of whose layers may be read. Those found only by composition are checked after it."""
    _check_layers(pxr, path, enclosure)
    stage = pxr.Usd.Stage.Open(path)
    for layer in stage.GetUsedLayers():
        if layer.realPath:
            _check(pxr, layer.realPath, enclosure)
    return stage


def extension(path: str) -> str:
    """Also of a file in an archive, as in model.usdz[textures/sky.hdr]."""
    return os.path.splitext(path.rstrip("]"))[1].lower()


class Files:
    """The files that the prims of a stage refer to. Without an enclosure all may be read."""

    def __init__(self, pxr: Any, enclosure: Enclosure | None) -> None:
        self.pxr, self.enclosure = pxr, enclosure

    def resolved(self, asset: Any) -> str:
        """The path of a file that the stage refers to, if it may be read; empty if USD does not find it."""
        path = str(asset.resolvedPath) if asset else ""
        return _check(self.pxr, path, self.enclosure) if path and self.enclosure else path

    def is_packaged(self, path: str) -> bool:
        return bool(self.pxr.Ar.IsPackageRelativePath(path))

    def exists(self, path: str) -> bool:
        return self.is_packaged(path) or os.path.isfile(path)

    def packaged(self, path: str) -> bytes:
        """The contents of a file in a .usdz archive, or in one within it. Their files are not compressed."""
        source: Any
        source, rest = self.pxr.Ar.SplitPackageRelativePathOuter(path)
        while rest:
            name, rest = self.pxr.Ar.SplitPackageRelativePathOuter(rest)
            with zipfile.ZipFile(source) as archive:
                if archive.getinfo(name).compress_type != zipfile.ZIP_STORED:
                    raise UsageError(f"{path} is compressed, which USD's archives do not support")
                contents = archive.read(name)
            source = io.BytesIO(contents)
        return contents


def _check(pxr: Any, path: str, enclosure: Enclosure) -> str:
    """Checks a file; for one in an archive, the archive. Returns its path, with links followed unless it is in one."""
    if not pxr.Ar.IsPackageRelativePath(path):
        return enclosure.check(path)
    enclosure.check(pxr.Ar.SplitPackageRelativePathOuter(path)[0])
    return path


def _check_layers(pxr: Any, root: str, enclosure: Enclosure) -> None:
    """Checks the layers that a stage would read, before any of them is composed."""
    pending, known = [root], set()
    stronger: dict[str, Any] = {}  # the root's variables, which those of other layers do not replace
    while pending:
        layer = pxr.Sdf.Layer.FindOrOpen(pending.pop())
        if not layer:
            continue
        stronger = stronger or dict(layer.expressionVariables)
        variables = {**layer.expressionVariables, **stronger}
        for asset in (*layer.GetCompositionAssetDependencies(), *_clip_files(layer)):
            if pxr.Sdf.VariableExpression.IsExpression(asset):
                asset = pxr.Sdf.VariableExpression(asset).Evaluate(variables).value
            path = layer.ComputeAbsolutePath(asset) if asset else ""
            if not path or path in known:
                continue
            known.add(path)
            _check(pxr, path, enclosure)
            pending.append(path)


def _clip_files(layer: Any) -> list[str]:
    """The files of the value clips that the prims of a layer name; patterns of numbered files have the sign #."""
    files: list[str] = []

    def visit(path: Any) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if not prim or not prim.HasInfo("clips"):
            return
        for clips in prim.GetInfo("clips").values():
            assets = [*clips.get("assetPaths", ()), clips.get("manifestAssetPath"), clips.get("templateAssetPath")]
            files.extend(str(getattr(asset, "path", asset)) for asset in assets if asset)

    layer.Traverse("/", visit)
    return files
