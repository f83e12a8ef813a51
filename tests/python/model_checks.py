"""Checks and inputs that tests of models of other packages have in common."""

import numpy as np

import latelight

URDF = """<robot name="crane">
<link name="base"><visual><geometry><box size="1 2 0.5"/></geometry></visual></link>
<link name="arm">
  <visual><origin xyz="0 0 1"/><geometry><box size="0.25 0.25 2"/></geometry></visual>
  <visual><origin xyz="0 0 2.25"/><geometry><box size="0.5 0.5 0.5"/></geometry></visual>
</link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.25"/>
<axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""

OCTAHEDRON = (np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float),
              [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])

Z_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])  # from URDF's frame to glTF's


def assert_bounds(scene, low, high):
    np.testing.assert_allclose(scene.bounds, (low, high), atol=1e-6)


def has_radial_normals(scene):
    """Of an octahedron around the origin with smooth normals, in contrast to (1, 1, 1) / sqrt(3) of its faces."""
    arrays = scene.mesh_arrays(scene.meshes()[0])
    radial = arrays["positions"] / np.linalg.norm(arrays["positions"], axis=1, keepdims=True)
    cosines = (radial * arrays["normals"]).sum(axis=1)
    assert np.allclose(cosines, 1, atol=1e-5) or np.allclose(cosines, 3**-0.5, atol=1e-5)
    return bool(np.allclose(cosines, 1, atol=1e-5))


def only_material(scene):
    (handle,) = scene.materials()
    return handle, scene.material(handle)


def surface_colors(scene, instance):
    """The linear colors of an instance's vertices: those of its material and of its mesh, multiplied."""
    arrays = scene.mesh_arrays(instance.mesh)
    colors = arrays.get("colors", np.ones((len(arrays["positions"]), 4)))
    return colors * np.array(scene.material(instance.material).base_color)


def colors_by_node(scene):
    """The first color of each part, by the path of its node."""
    colors = {}
    for node, handle in zip(scene.nodes, scene.instances()):
        color = surface_colors(scene, scene.instance(handle))[0]
        colors.setdefault(node.path.partition("#")[0], []).append(tuple(color.round(4).tolist()))
    return colors


def background(scene, device, direction):
    """The radiance of the environment in a direction of the scene's frame."""
    up = (1, 0, 0) if abs(direction[1]) > 0.9 else (0, 1, 0)
    camera = latelight.Camera.look_at((0, 0, 0), direction, up, vertical_fov=1)
    renderer = latelight.Renderer(scene, device)
    return renderer.render(camera, (1, 1), ("color",), background="hdri")["color"][0, 0, :3]


SUBPIXEL = 1 / 256  # to which the raster rounds vertices; docs/compute.md states the same bound for edges


def near_edges(scene, camera, size):
    """Whether the center of each pixel is within one subpixel of a projected edge of any triangle."""
    width, height = size
    focal = height / 2 / np.tan(np.radians(camera.vertical_fov) / 2)
    camera_from_world = np.linalg.inv(camera.camera_to_world)
    near = np.zeros((height, width), bool)
    for instance in map(scene.instance, scene.instances()):
        arrays = scene.mesh_arrays(instance.mesh)
        matrix = camera_from_world @ np.asarray(instance.transform)
        points = arrays["positions"].astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
        assert points[:, 2].min() > 0
        pixels = points[:, :2] / points[:, 2:] * focal + (width / 2, height / 2)
        triangles = pixels[arrays["indices"].reshape(-1, 3)]
        for begin, end in zip(triangles.reshape(-1, 2), np.roll(triangles, -1, axis=1).reshape(-1, 2)):
            low = np.maximum(np.floor(np.minimum(begin, end)).astype(int) - 1, 0)
            high = np.minimum(np.ceil(np.maximum(begin, end)).astype(int) + 1, size)
            x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
            along = end - begin
            t = np.clip(((x - begin[0]) * along[0] + (y - begin[1]) * along[1]) / max(along @ along, 1e-30), 0, 1)
            distance = np.hypot(begin[0] + t * along[0] - x, begin[1] + t * along[1] - y)
            near[low[1] : high[1], low[0] : high[0]] |= distance <= SUBPIXEL
    return near


def assert_seen_as_exported(scene, device, tmp_path):
    """Distances and ids of all pixels are those of rays through the exported file, except where the center of a pixel
    is so close to an edge that rounding vertices to subpixels decides which side it shows."""
    scene.export(tmp_path / "exported.glb")
    exported = latelight.Scene(tmp_path / "exported.glb")
    low, high = np.array(scene.bounds)
    camera = scene.look_at(high + 0.7 * np.linalg.norm(high - low), (low + high) / 2)
    width, height = 480, 320
    frame = latelight.Renderer(scene, device).render(camera, (width, height), ("distance", "id"))
    focal = height / 2 / np.tan(np.radians(camera.vertical_fov) / 2)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    pose = np.asarray(camera.camera_to_world)
    rays = np.stack([x / focal, y / focal, np.ones_like(x)], axis=-1).reshape(-1, 3) @ pose[:3, :3].T
    hits = latelight.Renderer(exported, device).cast(np.broadcast_to(pose[:3, 3], rays.shape), rays)
    ids, distances = (hits[name].reshape(height, width) for name in ("id", "distance"))
    assert len(np.unique(ids)) > 3
    near = near_edges(scene, camera, (width, height))
    assert near.mean() < 0.003
    np.testing.assert_array_equal(frame["id"][~near], ids[~near])
    np.testing.assert_allclose(frame["distance"][~near], distances[~near], rtol=1e-5)
    assert (frame["id"] == ids).mean() > 0.9998
    nodes = [node.path for node in scene.nodes]
    assert [node.path for node in exported.nodes][: len(nodes)] == nodes  # nodes of lights follow
