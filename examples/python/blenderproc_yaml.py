"""Renders a BlenderProc configuration file with `latelight batch`, into the HDF5 files that BlenderProc writes.

usage: blenderproc_yaml.py CONFIG.yaml [ARGUMENT...]

The arguments replace <args:0>, <args:1>, ... in the file. These modules of BlenderProc 1.x are supported:

    main.Initializer      global: output_dir
    loader.ObjectLoader   path: one .obj, .ply, .stl, .glb or .gltf file
    lighting.LightLoader  lights: type POINT or SUN, location, rotation, energy, color
    camera.CameraLoader   cam_poses: location and rotation (euler, look_at or forward_vec), or cam2world_matrix;
                          intrinsics: cam_K, resolution_x, resolution_y, fov
    renderer.RgbRenderer, renderer.NormalRenderer, renderer.SegMapRenderer
                          render_depth, render_distance, render_normals, map_by: instance, class or category_id
    writer.Hdf5Writer

The object with the lights is written to OUTPUT.glb, next to the folder OUTPUT. Requires the packages latelight, numpy
and pyyaml, and the program latelight on the PATH or in LATELIGHT_PROGRAM.
"""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import latelight

FROM_BLENDER = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # from Z up to glTF's Y up
SEGMENTS = {
    "instance": "instance_segmaps",
    "class": "category_id_segmaps",
    "category_id": "category_id_segmaps",
    "cp_category_id": "category_id_segmaps",
}


RENDERED = {"render_depth", "render_distance", "render_normals"}
KEYS = {  # of the supported modules
    "main.Initializer": {"global"},
    "loader.ObjectLoader": {"path"},
    "lighting.LightLoader": {"lights"},
    "camera.CameraLoader": {"cam_poses", "intrinsics"},
    "renderer.RgbRenderer": RENDERED,
    "renderer.NormalRenderer": RENDERED,
    "renderer.SegMapRenderer": {"map_by"},
    "writer.Hdf5Writer": set(),
}


def fail(message, exit_code=2):
    print(f"blenderproc_yaml: {message}", file=sys.stderr)
    sys.exit(exit_code)


def check_keys(config, supported, where, required=()):
    if not isinstance(config, dict):
        fail(f"{where} must have keys and values")
    for key in config.keys() - supported:
        fail(f"{where}: the key {key} is not supported; {', '.join(sorted(supported)) or 'none'} would be")
    for key in required:
        if key not in config:
            fail(f"{where} lacks the key {key}")


def rotation_of(spec):
    """The matrix from Blender's camera or light, which looks along -Z, to Blender's world; angles in radians."""
    if spec["format"] == "euler":
        (sx, cx), (sy, cy), (sz, cz) = ((math.sin(angle), math.cos(angle)) for angle in spec["value"])
        return (
            np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
            @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
            @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        )
    back = -np.array(spec["value"], float)
    back /= np.linalg.norm(back)
    right = np.cross([0, 0, 1] if abs(back[2]) < 1 - 1e-9 else [0, 1, 0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=1)


def pose_of(camera):
    """The camera's pose, (4, 4), from Blender's (OpenGL's) camera frame to Blender's world."""
    check_keys(camera, {"location", "rotation", "cam2world_matrix"}, "a camera")
    if "cam2world_matrix" in camera:
        return np.reshape(np.array(camera["cam2world_matrix"], float), (4, 4))
    check_keys(camera, camera.keys(), "a camera", ("location", "rotation"))
    spec = (
        camera["rotation"] if isinstance(camera["rotation"], dict) else {"format": "euler", "value": camera["rotation"]}
    )
    spec = {"format": "euler", **spec}
    check_keys(spec, {"format", "value"}, "a rotation", ("value",))
    if spec["format"] == "look_at":
        spec = {"format": "forward_vec", "value": np.subtract(spec["value"], camera["location"])}
    if spec["format"] not in ("euler", "forward_vec"):
        fail(f"rotations are of the format euler, look_at or forward_vec, not {spec['format']}")
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_of(spec), camera["location"]
    return pose


def light_of(light, turn):
    """The intensity of a lamp of P watts is P / (4 pi) per steradian; a sun's energy is its irradiance."""
    check_keys(light, {"type", "location", "rotation", "energy", "color"}, "a light")
    kind, power = light.get("type", "POINT"), float(light.get("energy", 10))
    if kind not in ("POINT", "SUN"):
        fail(f"lights are of the type POINT or SUN, not {kind}")
    color = tuple(float(value) for value in light.get("color", [1, 1, 1])[:3])
    if kind == "POINT":
        check_keys(light, light.keys(), "a light", ("location",))
        position = tuple((turn @ light["location"]).tolist())
        return latelight.Light(type="point", position=position, color=color, intensity=power / (4 * math.pi))
    direction = turn @ -rotation_of({"format": "euler", "value": light.get("rotation", [0, 0, 0])})[:, 2]
    return latelight.Light(type="directional", direction=tuple(direction.tolist()), color=color, intensity=power)


def cameras_of(config, job):
    intrinsics = config.get("intrinsics", {})
    check_keys(intrinsics, {"cam_K", "resolution_x", "resolution_y", "fov"}, "intrinsics")
    width, height = intrinsics.get("resolution_x", 512), intrinsics.get("resolution_y", 512)
    job["options"]["size"] = f"{width}x{height}"
    source = {"type": "list", "cameras": []}
    if "cam_K" in intrinsics:  # pixel centers are whole numbers
        source |= {"K": np.reshape(intrinsics["cam_K"], (3, 3)).tolist(), "pixelCenter": 0}
    else:
        across = intrinsics.get("fov", 0.691111)  # radians, of the longer side
        source["fov"] = math.degrees(
            across if height >= width else 2 * math.atan(math.tan(across / 2) * height / width)
        )
    for number, camera in enumerate(config.get("cam_poses", [])):
        pose = pose_of(camera)
        pose[:3] = FROM_BLENDER @ pose[:3]
        source["cameras"].append({"name": str(number), "pose": pose.tolist(), "frame": "opengl"})
    if not source["cameras"]:
        fail("camera.CameraLoader lacks cam_poses; its key path is not supported")
    return source


def export_scene(source, lights, file):
    """Writes the object with the lights as glTF, next to the output."""
    scene = latelight.Scene(source)
    for light in scene.lights():
        scene.remove_light(light)
    # PLY and STL have Blender's axes, OBJ and glTF have Y up.
    turn = np.eye(3) if source.lower().endswith((".ply", ".stl")) else FROM_BLENDER
    for light in lights:
        scene.add_light(light_of(light, turn))
    file.parent.mkdir(parents=True, exist_ok=True)
    scene.export(file)


def job_of(config):
    listed = config.get("modules") if isinstance(config, dict) else None
    if not isinstance(listed, list) or not all(isinstance(module, dict) and "module" in module for module in listed):
        fail("the file must have a list of modules, each with the key module")
    modules = [(module["module"].removesuffix("Module"), module.get("config", {})) for module in listed]
    for name, settings in modules:
        if name not in KEYS:
            fail(f"the module {name} is not supported")
        check_keys(settings, KEYS[name], f"the module {name}", ("path",) if name == "loader.ObjectLoader" else ())
    common = next((settings.get("global", {}) for name, settings in modules if name == "main.Initializer"), {})
    check_keys(common, {"output_dir"}, "global")
    paths = [settings["path"] for name, settings in modules if name == "loader.ObjectLoader"]
    if len(paths) != 1:
        fail(f"the file must have one loader.ObjectLoader, not {len(paths)}")
    output = Path(common.get("output_dir", "output"))
    scene_file = output.with_name(output.name + ".glb")
    export_scene(
        paths[0],
        [light for name, settings in modules if name == "lighting.LightLoader" for light in settings.get("lights", [])],
        scene_file,
    )
    job = {"scenes": str(scene_file), "output": str(output), "hdri": "none", "options": {"axes": "z-up"}, "cameras": []}
    keys = []
    for name, settings in modules:
        if name == "camera.CameraLoader":
            job["cameras"].append(cameras_of(settings, job))
        elif name in ("renderer.RgbRenderer", "renderer.NormalRenderer"):
            keys += ["colors"] if name == "renderer.RgbRenderer" else ["normals"]
            keys += [key for key in ("depth", "distance", "normals") if settings.get(f"render_{key}")]
        elif name == "renderer.SegMapRenderer":
            map_by = settings.get("map_by", "class")
            for key in [map_by] if isinstance(map_by, str) else map_by:
                if key not in SEGMENTS:
                    fail(f"map_by is one of {', '.join(SEGMENTS)}, not {key}")
                keys.append(SEGMENTS[key])
    if not keys or not job["cameras"]:
        fail("the file must have a camera.CameraLoader and a renderer")
    job["formats"] = [{"format": "hdf5", "keys": list(dict.fromkeys(keys))}]
    return job


def main():
    if len(sys.argv) < 2:
        fail("usage: blenderproc_yaml.py CONFIG.yaml [ARGUMENT...]")
    try:
        import yaml
    except ImportError:
        fail("this script requires the package PyYAML: install it, for example with pip")
    try:
        text = Path(sys.argv[1]).read_text(encoding="utf-8")
    except OSError as error:
        fail(f"{sys.argv[1]} cannot be read: {error.strerror}")
    arguments = sys.argv[2:]
    for number in {int(index) for index in re.findall(r"<args:(\d+)>", text)}:
        if number >= len(arguments):
            fail(f"{sys.argv[1]} requires the argument {number}")
        text = text.replace(f"<args:{number}>", arguments[number])
    try:
        job = job_of(yaml.safe_load(text))
    except yaml.YAMLError as error:
        fail(f"{sys.argv[1]} is not valid YAML: {' '.join(str(error).split())}")
    except latelight.LatelightError as error:
        fail(error, error.exit_code)
    program = os.environ.get("LATELIGHT_PROGRAM") or shutil.which("latelight") or fail("latelight is not on the PATH")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "job.json"
        path.write_text(json.dumps(job))
        sys.exit(subprocess.run([program, "batch", str(path)]).returncode)


if __name__ == "__main__":
    main()
