"""Scenes that Latelight and Mitsuba 3 can both express exactly, in the axes of glTF: Y up, meters."""

import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True)
class Material:
    """A material of glTF 2.0, appendix B, with extensions of KHR_materials; colors are linear Rec.709."""

    color: tuple
    metallic: float = 0
    roughness: float = 1
    specular: float = 0  # 0: Lambertian, without a specular lobe
    ior: float = 1.5
    coat: float = 0  # strength of the clearcoat
    coat_roughness: float = 0
    transmission: float = 0  # 0 or 1
    solid: bool = False  # transmission: a volume that refracts, instead of a thin wall
    passed: tuple = (1, 1, 1)  # fraction of light that a volume passes per meter
    emission: tuple = (0, 0, 0)  # W/(sr m^2)
    plugin: bool = False  # Mitsuba's own `roughconductor` instead of the model of gltf_bsdf.py


@dataclasses.dataclass(frozen=True)
class Mesh:
    material: str
    positions: np.ndarray  # (n, 3)
    normals: np.ndarray  # (n, 3), unit
    triangles: np.ndarray  # (m, 3)


@dataclasses.dataclass(frozen=True)
class AreaLight:
    """A shape that emits `radiance`. A rect and a disk face -Z of `axes`, and a tube extends along X."""

    type: str  # rect, disk, sphere or tube
    position: tuple
    radiance: tuple  # W/(sr m^2)
    size: float  # height of a rect, radius of the others, meters
    length: float = 0  # width of a rect, length of a tube, meters
    axes: tuple = ((1, 0, 0), (0, 1, 0), (0, 0, 1))  # X, Y and Z


@dataclasses.dataclass
class Scene:
    materials: dict
    meshes: list
    eye: tuple
    target: tuple
    field_of_view: float  # vertical, degrees
    environment: object = None  # function from unit directions (..., 3) to radiance (..., 3)
    options: tuple = ()  # of Latelight
    lights: tuple = ()  # of AreaLight, outside of the picture: Latelight's cameras do not see them, but Mitsuba's do


def quad(material, corner, u, v):
    """A parallelogram whose normal is u x v."""
    corner, u, v = (np.asarray(a, float) for a in (corner, u, v))
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    positions = np.stack([corner, corner + u, corner + u + v, corner + v])
    return Mesh(material, positions, np.tile(normal, (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]))


def sphere(material, center, radius, rows=48):
    """A sphere of longitudes and latitudes with smooth normals."""
    latitude, longitude = np.meshgrid(
        np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, 2 * rows + 1), indexing="ij")
    normals = np.stack([np.sin(latitude) * np.cos(longitude), np.cos(latitude), np.sin(latitude) * np.sin(longitude)], -1)
    index = np.arange(normals[..., 0].size).reshape(latitude.shape)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    upper, lower = np.stack([a, b, c], -1)[1:], np.stack([a, c, d], -1)[:-1]  # without those that poles flatten
    normals = normals.reshape(-1, 3)
    triangles = np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])
    return Mesh(material, np.asarray(center) + radius * normals, normals, triangles)


def box(material, low, high):
    low, high = np.asarray(low, float), np.asarray(high, float)
    meshes = []
    for axis in range(3):
        for side in (0, 1):
            u, v = np.zeros(3), np.zeros(3)
            u[(axis + 1) % 3] = (high - low)[(axis + 1) % 3]
            v[(axis + 2) % 3] = (high - low)[(axis + 2) % 3]
            corner = low.copy()
            corner[axis] = (low, high)[side][axis]
            meshes.append(quad(material, corner, *((u, v) if side else (v, u))))
    return meshes


def room():
    """A closed Cornell box: diffuse walls, a metal, a dielectric, and an emissive plate below the ceiling."""
    materials = {
        "white": Material((0.73, 0.71, 0.68)),
        "red": Material((0.63, 0.06, 0.05)),
        "green": Material((0.14, 0.45, 0.09)),
        "lamp": Material((0, 0, 0), emission=(12, 10, 7)),
        "box": Material((0.3, 0.4, 0.8)),
        "metal": Material((0.95, 0.8, 0.5), metallic=1, roughness=0.4),
        "plastic": Material((0.6, 0.3, 0.1), roughness=0.3, specular=1),
    }
    meshes = [
        quad("white", (-1, 0, 3), (2, 0, 0), (0, 0, -4)),  # floor
        quad("white", (-1, 2, -1), (2, 0, 0), (0, 0, 4)),  # ceiling
        quad("white", (-1, 0, -1), (2, 0, 0), (0, 2, 0)),  # back
        quad("white", (1, 0, 3), (-2, 0, 0), (0, 2, 0)),  # behind the camera
        quad("red", (-1, 0, 3), (0, 0, -4), (0, 2, 0)),
        quad("green", (1, 0, -1), (0, 0, 4), (0, 2, 0)),
        *box("lamp", (-0.4, 1.95, -0.4), (0.4, 1.98, 0.4)),  # closed: Latelight emits from both sides of surfaces
        *box("box", (-0.75, 0, -0.7), (-0.15, 1.1, -0.2)),
        sphere("metal", (0.45, 0.4, -0.4), 0.4),
        sphere("plastic", (0, 0.25, 0.4), 0.25),
    ]
    return Scene(materials, meshes, (0, 1, 2.9), (0, 0.9, 0), 45)


def sky(direction):
    """A smooth environment: a bright patch over a gradient."""
    patch = np.exp(12 * (direction @ (np.array([0.5, 0.7, 0.5]) / np.sqrt(0.99)) - 1))
    height = 0.5 + 0.5 * direction[..., 1]
    return (np.stack([0.3 + 0.2 * height, 0.3 + 0.4 * height, 0.3 + 0.7 * height], -1)
            + patch[..., None] * np.array([8, 7, 5]))


def spheres(materials, environment, rows=48):
    """A row of spheres on a diffuse floor."""
    meshes = [quad("floor", (-6, 0, 6), (12, 0, 0), (0, 0, -12))]
    for i, name in enumerate(materials):
        meshes.append(sphere(name, (1.1 * (i - (len(materials) - 1) / 2), 0.5, 0), 0.5, rows))
    return Scene({"floor": Material((0.5, 0.5, 0.5)), **materials}, meshes, (0, 1.6, 6), (0, 0.45, 0), 34, environment)


def metals():
    return spheres({
        "mirror 0.1": Material((1, 1, 1), 1, 0.1, plugin=True),
        "gold 0.2": Material((1, 0.77, 0.34), 1, 0.2),
        "copper 0.4": Material((0.95, 0.64, 0.54), 1, 0.4),
        "gold 0.7": Material((1, 0.77, 0.34), 1, 0.7),
        "white 1": Material((1, 1, 1), 1, 1),
    }, sky)


def dielectrics():
    return spheres({
        "white 0.1": Material((0.8, 0.8, 0.8), 0, 0.1, 1),
        "red 0.3": Material((0.7, 0.1, 0.1), 0, 0.3, 1),
        "black 0.5": Material((0.02, 0.02, 0.02), 0, 0.5, 1),
        "blue 1": Material((0.1, 0.2, 0.7), 0, 1, 1),
        "half metal 0.5": Material((0.8, 0.6, 0.4), 0.5, 0.5, 1),
    }, sky)


def coats():
    return spheres({
        "red, coat 0.1": Material((0.7, 0.1, 0.1), 0, 0.6, 1, coat=1, coat_roughness=0.1),
        "metal, coat 0.2": Material((1, 0.77, 0.34), 1, 0.4, coat=1, coat_roughness=0.2),
        "blue, coat 0.5": Material((0.1, 0.2, 0.7), 0, 0.3, 1, coat=0.7, coat_roughness=0.5),
        "white, coat 1": Material((0.9, 0.9, 0.9), 0, 1, 1, coat=1, coat_roughness=1),
    }, sky)


def glass():
    """Volumes, whose curved surfaces need small triangles (docs/light.md), and thin walls."""
    scene = spheres({
        "solid 0.1": Material((1, 1, 1), 0, 0.1, 1, transmission=1, solid=True),
        "solid 0.3": Material((0.9, 0.95, 1), 0, 0.3, 1, transmission=1, solid=True, passed=(0.9, 0.5, 0.3)),
        "solid 0.6, ior 1.33": Material((1, 1, 1), 0, 0.6, 1, 1.33, transmission=1, solid=True),
        "thin 0.3": Material((0.6, 0.9, 0.7), 0, 0.3, 1, transmission=1),
        "thin 0.6": Material((1, 1, 1), 0, 0.6, 1, transmission=1),
    }, sky, 192)
    scene.options = ("--data-surfaces", "any")  # materials of transmissive surfaces, too
    return scene


def overcast():
    """Diffuse spheres and boxes under a constant environment."""
    scene = spheres({"white": Material((0.9, 0.9, 0.9)), "red": Material((0.8, 0.1, 0.1)),
                     "dark": Material((0.05, 0.05, 0.05))}, lambda direction: np.ones_like(direction))
    scene.materials["wall"] = Material((0.7, 0.8, 0.6))
    scene.meshes += box("wall", (-2.2, 0, -1.5), (2.2, 1.6, -1))
    return scene


def panels():
    """One area light of each shape above a row of spheres."""
    scene = spheres({
        "white": Material((0.9, 0.9, 0.9)),
        "metal 0.2": Material((1, 0.77, 0.34), 1, 0.2),
        "metal 0.5": Material((0.95, 0.64, 0.54), 1, 0.5),
        "plastic 0.3": Material((0.7, 0.1, 0.1), 0, 0.3, 1),
    }, None)
    scene.options = ("--shading", "ggx-compensated")  # lights follow --shading, and Mitsuba's lobes lose no light
    down = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
    tilted = ((0.8, 0.6, 0), (0, 0, -1), (-0.6, 0.8, 0))
    scene.lights = (AreaLight("rect", (-1.6, 2.9, 0.3), (24, 18, 12), 0.5, 1.2, tilted),
                    AreaLight("disk", (0.1, 3.2, 0.9), (18, 24, 30), 0.35, axes=down),
                    AreaLight("sphere", (1.7, 2.9, -0.2), (30, 12, 12), 0.25),
                    AreaLight("tube", (0.5, 2.8, -1), (12, 36, 18), 0.08, 1.4))
    return scene


SCENES = {"room": room, "metals": metals, "dielectrics": dielectrics, "overcast": overcast,
          "panels": panels, "coats": coats, "glass": glass}
