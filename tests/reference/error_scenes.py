"""Scenes whose images `errors` compares with the reference: kinds of light that the built-in scenes do not have."""

import dataclasses

import numpy as np

from scenes import Material, Mesh, Scene, box, quad, sphere


def terrain(cells=192, side=60.0):
    """Hills with boulders below an open sky, 60 m wide."""
    rng = np.random.default_rng(4)
    waves = [(rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi), 0.11 * 1.7**octave) for octave in range(6)]

    def height(x, z):
        return sum(0.3 / k * np.sin(k * (x * np.cos(a) + z * np.sin(a)) + b) for a, b, k in waves)

    line = np.linspace(-side / 2, side / 2, cells + 1)
    z, x = np.meshgrid(line, line, indexing="ij")
    step = 1e-3
    slope_x = (height(x + step, z) - height(x - step, z)) / (2 * step)
    slope_z = (height(x, z + step) - height(x, z - step)) / (2 * step)
    normals = np.stack([-slope_x, np.ones_like(x), -slope_z], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    positions = np.stack([x, height(x, z), z], -1).reshape(-1, 3)
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (i.ravel() for i in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]))
    triangles = np.concatenate([np.stack([a, d, c], -1), np.stack([a, c, b], -1)])
    steep = normals.reshape(-1, 3)[triangles].mean(1)[:, 1] < 0.9
    meshes = [Mesh(name, positions, normals.reshape(-1, 3), triangles[chosen])
              for name, chosen in (("grass", ~steep), ("rock", steep))]
    for _ in range(60):
        at, radius = rng.uniform((-25, -25), (25, 18)), rng.uniform(0.2, 1.2)  # the eye is at z = 26
        meshes.append(sphere("rock", (at[0], height(*at) + 0.3 * radius, at[1]), radius, 16))
    materials = {"grass": Material((0.16, 0.22, 0.07), roughness=0.9, specular=1),
                 "rock": Material((0.32, 0.29, 0.26), roughness=0.7, specular=1)}
    eye = (0, height(0, 26) + 2.2, 26)
    return Scene(materials, meshes, eye, (0, 0, 0), 45)


def _table(low, high, thick=0.05):
    """A plate on four legs."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    parts = box("wood", (x0, y1 - thick, z0), high)
    for x in (x0, x1 - thick):
        for z in (z0, z1 - thick):
            parts += box("wood", (x, y0, z), (x + thick, y1 - thick, z + thick))
    return parts


def furnished():
    """A room with furniture, lit by a window and by a lamp."""
    materials = {
        "wall": Material((0.75, 0.72, 0.66)),
        "floor": Material((0.35, 0.2, 0.1), roughness=0.35, specular=1),
        "wood": Material((0.42, 0.25, 0.12), roughness=0.5, specular=1),
        "cloth": Material((0.15, 0.22, 0.4)),
        "rug": Material((0.5, 0.12, 0.1)),
        "metal": Material((0.9, 0.85, 0.75), 1, 0.25),
        "china": Material((0.8, 0.8, 0.82), roughness=0.1, specular=1),
        "lamp": Material((0, 0, 0), emission=(60, 48, 32)),
    }
    wide, deep, high = 2.5, 2.0, 2.6
    meshes = [
        quad("floor", (-wide, 0, deep), (2 * wide, 0, 0), (0, 0, -2 * deep)),
        quad("wall", (-wide, high, -deep), (2 * wide, 0, 0), (0, 0, 2 * deep)),
        quad("wall", (-wide, 0, -deep), (2 * wide, 0, 0), (0, high, 0)),
        quad("wall", (wide, 0, deep), (-2 * wide, 0, 0), (0, high, 0)),
        quad("wall", (wide, 0, -deep), (0, 0, 2 * deep), (0, high, 0)),
        # The left wall has a window from z = -1 to 0.6 m.
        quad("wall", (-wide, 0, deep), (0, 0, -2 * deep), (0, 0.9, 0)),
        quad("wall", (-wide, 2.2, deep), (0, 0, -2 * deep), (0, 0.4, 0)),
        quad("wall", (-wide, 0.9, deep), (0, 0, -1.4), (0, 1.3, 0)),
        quad("wall", (-wide, 0.9, -1), (0, 0, -1), (0, 1.3, 0)),
        quad("rug", (-1, 0.01, 0.9), (2.2, 0, 0), (0, 0, -1.6)),
        *_table((-0.5, 0, -0.6), (0.7, 0.72, 0.2)),
        *_table((-0.9, 0, -0.4), (-0.55, 0.45, 0)),
        *_table((0.75, 0, -0.4), (1.1, 0.45, 0)),
        *box("cloth", (-1.6, 0.15, -1.95), (0.4, 0.45, -1.2)),
        *box("cloth", (-1.6, 0.45, -1.95), (0.4, 0.9, -1.75)),
        *box("wood", (1.3, 0, -1.95), (2.3, 1.9, -1.6)),
        sphere("metal", (-0.1, 0.87, -0.25), 0.15),
        sphere("china", (0.35, 0.82, -0.1), 0.1),
        sphere("lamp", (1.5, 2.05, -1.4), 0.12),
    ]
    return Scene(materials, meshes, (1.9, 1.5, 1.8), (-0.3, 0.7, -0.6), 60)


def headgear():
    """Leather, metal, wood and glass on a stand: the materials of a pilot's helmet."""
    materials = {
        "leather": Material((0.16, 0.08, 0.04), roughness=0.55, specular=1),
        "strap": Material((0.05, 0.04, 0.035), roughness=0.7, specular=1),
        "brass": Material((0.88, 0.7, 0.38), 1, 0.3),
        "steel": Material((0.6, 0.6, 0.62), 1, 0.5),
        "wood": Material((0.3, 0.17, 0.08), roughness=0.4, specular=1),
        "lens": Material((0.9, 0.95, 0.9), roughness=0, specular=1, transmission=1),
        "rubber": Material((0.03, 0.03, 0.03), roughness=0.8, specular=1),
    }
    meshes = [
        *box("wood", (-0.5, -0.06, -0.4), (0.5, 0, 0.4)),
        *box("wood", (-0.06, 0, -0.06), (0.06, 0.5, 0.06)),
        sphere("leather", (0, 0.75, 0), 0.38),
        sphere("leather", (0, 0.55, 0.08), 0.26),
        *box("strap", (-0.39, 0.7, -0.03), (0.39, 0.76, 0.03)),
        sphere("rubber", (0, 0.5, 0.3), 0.12),
        sphere("steel", (0, 0.47, 0.42), 0.06),
    ]
    for side in (-1, 1):
        meshes += [
            sphere("brass", (side * 0.14, 0.8, 0.3), 0.12),
            sphere("rubber", (side * 0.14, 0.8, 0.36), 0.085),
            sphere("lens", (side * 0.14, 0.8, 0.36), 0.1),
            sphere("leather", (side * 0.37, 0.66, 0), 0.12),
            sphere("brass", (side * 0.47, 0.66, 0), 0.035),
        ]
    return Scene(materials, meshes, (0.7, 1.0, 1.7), (0, 0.55, 0.05), 38)


def glassware():
    """The furnished room with a ball of green glass instead of china."""
    scene = furnished()
    glass = Material((0.8, 0.8, 0.82), roughness=0.1, specular=1, transmission=1, solid=True, passed=(0.36, 0.81, 0.49))
    return dataclasses.replace(scene, materials={**scene.materials, "china": glass})


ERROR_SCENES = {"headgear": headgear, "terrain": terrain, "furnished": furnished, "glassware": glassware}
