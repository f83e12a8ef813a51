"""Renders the scenes of scenes.py with Latelight and with Mitsuba 3."""

import base64
import json
import pathlib
import struct
import subprocess

import numpy as np


def _accessor(document, blob, values, kind, component):
    values = np.ascontiguousarray(values, {5126: "<f4", 5125: "<u4"}[component])
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(blob), "byteLength": values.nbytes})
    accessor = {"bufferView": len(document["bufferViews"]) - 1, "componentType": component, "type": kind,
                "count": len(values)}
    if kind == "VEC3":
        accessor |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
    document["accessors"].append(accessor)
    blob += values.tobytes()
    return len(document["accessors"]) - 1


def _material(name, m):
    extensions = {"KHR_materials_specular": {"specularFactor": m.specular}}
    if m.ior != 1.5:
        extensions["KHR_materials_ior"] = {"ior": m.ior}
    if m.coat:
        extensions["KHR_materials_clearcoat"] = {"clearcoatFactor": m.coat, "clearcoatRoughnessFactor": m.coat_roughness}
    if m.transmission:
        extensions["KHR_materials_transmission"] = {"transmissionFactor": m.transmission}
    if m.solid:
        extensions["KHR_materials_volume"] = {"thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": m.passed}
    if any(m.emission):
        extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": max(m.emission)}
    return {"name": name, "extensions": extensions,
            "emissiveFactor": [e / max(max(m.emission), 1e-9) for e in m.emission],
            "pbrMetallicRoughness": {"baseColorFactor": [*m.color, 1], "metallicFactor": m.metallic,
                                     "roughnessFactor": m.roughness}}


def _light_node(light):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.array(light.axes).T, light.position
    intensity = max(light.radiance)
    area = {"type": light.type, "intensity": intensity, "color": [r / intensity for r in light.radiance],
            "size": light.size if light.type == "rect" else 2 * light.size}
    if light.type == "rect":
        area["rect"] = {"aspect": light.length / light.size}
    if light.type == "tube":
        area["tube"] = {"length": light.length}
    return {"matrix": matrix.T.reshape(-1).tolist(), "extras": {"areaLight": area}}


def write_gltf(scene, path):
    """Writes the scene without its environment, with one material index per name in their order."""
    names, blob = list(scene.materials), bytearray()
    materials = [_material(n, scene.materials[n]) for n in names]
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                "bufferViews": [], "accessors": [], "materials": materials,
                "extensionsUsed": sorted({e for m in materials for e in m["extensions"]})}
    for mesh in scene.meshes:
        document["meshes"].append({"primitives": [{
            "attributes": {"POSITION": _accessor(document, blob, mesh.positions, "VEC3", 5126),
                           "NORMAL": _accessor(document, blob, mesh.normals, "VEC3", 5126)},
            "indices": _accessor(document, blob, mesh.triangles.reshape(-1), "SCALAR", 5125),
            "material": names.index(mesh.material)}]})
        document["nodes"].append({"mesh": len(document["meshes"]) - 1})
    document["nodes"] += [_light_node(light) for light in scene.lights]
    axes = camera_axes(scene)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = axes[0], axes[1], -axes[2], scene.eye
    document["nodes"].append({"camera": 0, "matrix": matrix.T.reshape(-1).tolist()})
    document["cameras"] = [{"type": "perspective", "perspective": {
        "yfov": np.radians(scene.field_of_view), "znear": 0.01, "zfar": 100}}]
    document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    document["buffers"] = [{"byteLength": len(blob), "uri": uri}]
    path.write_text(json.dumps(document))


def camera_axes(scene):
    """Returns right, up and forward, (3, 3)."""
    forward = np.subtract(scene.target, scene.eye).astype(float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def pixel_directions(scene, width, height):
    """Returns the unit directions through the centers of pixels, (height, width, 3)."""
    half = np.tan(np.radians(scene.field_of_view) / 2)
    y, x = np.mgrid[0:height, 0:width] + 0.5
    plane = np.stack([(2 * x / width - 1) * half * width / height, (1 - 2 * y / height) * half, np.ones_like(x)], -1)
    directions = plane @ camera_axes(scene)
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


# Rows of Latelight's images are strips of latitude, and their center column is +X.
def _latelight_environment(environment, width=256, height=128):
    latitude, turn = np.meshgrid((np.arange(height) + 0.5) / height * np.pi,
                                 ((np.arange(width) + 0.5) / width - 0.5) * 2 * np.pi, indexing="ij")
    return environment(np.stack([np.sin(latitude) * np.cos(turn), np.cos(latitude), np.sin(latitude) * np.sin(turn)], -1))


# The first and last rows of Mitsuba's images are the poles, and their center column is +Z.
def _mitsuba_environment(environment, width=256, height=129):
    latitude, turn = np.meshgrid(np.arange(height) / (height - 1) * np.pi,
                                 (np.arange(width) + 0.5) / width * 2 * np.pi, indexing="ij")
    return environment(np.stack([np.sin(latitude) * np.sin(turn), np.cos(latitude), -np.sin(latitude) * np.cos(turn)], -1))


def write_exr(path, image):
    """Writes an OpenEXR file of 32-bit floats without compression."""
    height, width, _ = image.shape
    attribute = lambda name, kind, value: name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(c + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    header = struct.pack("<ii", 20000630, 2) + attribute(b"channels", b"chlist", channels) + b"".join(
        attribute(*a) for a in ((b"compression", b"compression", b"\0"), (b"dataWindow", b"box2i", box),
                                (b"displayWindow", b"box2i", box), (b"lineOrder", b"lineOrder", b"\0"),
                                (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
                                (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
                                (b"screenWindowWidth", b"float", struct.pack("<f", 1)))) + b"\0"
    row = 8 + 12 * width
    first = len(header) + 8 * height
    rows = image[..., ::-1].transpose(0, 2, 1).astype("<f4")
    path.write_bytes(header + struct.pack(f"<{height}q", *(first + row * y for y in range(height))) + b"".join(
        struct.pack("<ii", y, 12 * width) + rows[y].tobytes() for y in range(height)))


def by_latelight(program, scene, folder, width, height, samples, options=()):
    """Returns the linear image, (height, width, 3), and the name of each pixel's material, (height, width)."""
    folder = pathlib.Path(folder)
    write_gltf(scene, folder / "scene.gltf")
    command = [program, "render", folder / "scene.gltf", "-o", folder / "{aov}.npy", "--aov", "color,material",
               "--size", f"{width}x{height}", "--lighting", "reference", "--samples", str(samples), "--layout", "exact",
               *scene.options, *options]
    if scene.environment:
        write_exr(folder / "sky.exr", _latelight_environment(scene.environment))
        command += ["--hdri", folder / "sky.exr"]
    subprocess.run([str(c) for c in command], check=True)
    color = np.load(folder / "color.npy")[..., :3]
    ids = json.loads((folder / "meta.json").read_text())["materials"]
    names = np.full((height, width), "", dtype=object)
    for id, name in ids.items():
        names[np.load(folder / "material.npy") == int(id)] = name if isinstance(name, str) else name["name"]
    return color, names


def _plugin(mi, name, material):
    from gltf_bsdf import GlassBsdf, GltfBsdf

    if material.transmission:
        GlassBsdf.materials[name] = material
        return {"type": "gltf_glass", "material": name}
    if material.plugin:
        return {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": material.roughness ** 2,
                "specular_reflectance": {"type": "rgb", "value": list(material.color)}}
    if material.specular == 0 and material.metallic == 0:
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(material.color)}}
    GltfBsdf.materials[name] = material
    return {"type": "gltf", "material": name}


def _mesh(mi, mesh, bsdf, emission):
    emitter = {"emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(emission)}}} if any(emission) else {}
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    for key, value in emitter.items():
        props[key] = mi.load_dict(value)
    result = mi.Mesh(mesh.material, len(mesh.positions), len(mesh.triangles), has_vertex_normals=True, props=props)
    parameters = mi.traverse(result)
    parameters["vertex_positions"] = mesh.positions.astype(np.float32).ravel()
    parameters["vertex_normals"] = mesh.normals.astype(np.float32).ravel()
    parameters["faces"] = mesh.triangles.astype(np.uint32).ravel()
    parameters.update()
    return result


def _light_shapes(mi, light):
    """Returns Mitsuba's shapes of a light. Its rectangle and disk face +Z, and its cylinder has no ends."""
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = np.array(light.axes).T, light.position
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": list(light.radiance)}}
    dark = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0}}
    make = lambda kind, *local: {"type": kind, "emitter": emitter, "bsdf": dark,
                                 "to_world": mi.ScalarTransform4f(frame @ np.array(local, float))}
    size, half = light.size, light.length / 2
    if light.type == "rect":
        return [make("rectangle", (half, 0, 0, 0), (0, -size / 2, 0, 0), (0, 0, -1, 0), (0, 0, 0, 1))]
    if light.type == "disk":
        return [make("disk", (size, 0, 0, 0), (0, -size, 0, 0), (0, 0, -1, 0), (0, 0, 0, 1))]
    if light.type == "sphere":
        return [make("sphere", (size, 0, 0, 0), (0, size, 0, 0), (0, 0, size, 0), (0, 0, 0, 1))]
    # The cylinder is along Z from 0 to 1.
    return [make("cylinder", (0, 0, 2 * half, -half), (size, 0, 0, 0), (0, size, 0, 0), (0, 0, 0, 1)),
            make("disk", (0, 0, 1, half), (size, 0, 0, 0), (0, size, 0, 0), (0, 0, 0, 1)),
            make("disk", (0, 0, -1, -half), (-size, 0, 0, 0), (0, size, 0, 0), (0, 0, 0, 1))]


def by_mitsuba(mi, scene, width, height, samples, at_once=64):
    """Returns the linear image and the standard error of each value, (height, width, 3), through the pixels' centers."""
    parts = {"type": "scene"}
    for i, mesh in enumerate(scene.meshes):
        material = scene.materials[mesh.material]
        parts[f"mesh{i}"] = _mesh(mi, mesh, _plugin(mi, mesh.material, material), material.emission)
    for i, light in enumerate(scene.lights):
        parts |= {f"light{i}_{k}": shape for k, shape in enumerate(_light_shapes(mi, light))}
    if scene.environment:
        bitmap = mi.Bitmap(_mitsuba_environment(scene.environment).astype(np.float32))
        parts["sky"] = {"type": "envmap", "bitmap": bitmap}
    loaded = mi.load_dict(parts)
    # As Latelight: light over 16 surfaces after the visible one. It does not count those inside of volumes.
    depth = 64 if any(m.solid for m in scene.materials.values()) else 18
    integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 99})
    directions = np.repeat(pixel_directions(scene, width, height).reshape(-1, 3), at_once, 0)
    origin = mi.Point3f(*[mi.Float(float(e)) for e in scene.eye])
    means = []
    for batch in range(samples // at_once):
        sampler = mi.load_dict({"type": "independent", "sample_count": at_once})
        sampler.seed(batch, len(directions))
        ray = mi.RayDifferential3f(mi.Ray3f(origin, mi.Vector3f(directions.T.astype(np.float32))))
        color = integrator.sample(loaded, sampler, ray)[0]
        means.append(np.array(color).reshape(3, height, width, at_once).mean(-1).transpose(1, 2, 0))
    means = np.asarray(means, np.float64)
    return means.mean(0), means.std(0, ddof=1) / np.sqrt(len(means))
