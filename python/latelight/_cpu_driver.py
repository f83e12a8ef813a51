"""Finds the driver of the package latelight-cpu, which renders where the system has no Vulkan driver."""

import importlib.util
import os
from pathlib import Path

_VARIABLE = "LATELIGHT_CPU_DRIVER"


def _find() -> Path | None:
    spec = importlib.util.find_spec("latelight_cpu")
    for folder in (spec.submodule_search_locations or ()) if spec else ():
        manifest = Path(folder) / "lib" / "latelight_cpu_icd.json"
        if manifest.is_file():
            return manifest
    return None


if _VARIABLE not in os.environ and (_manifest := _find()):
    os.environ[_VARIABLE] = str(_manifest)
