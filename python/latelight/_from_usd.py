"""Scenes from USD stages, by usd-core."""

from __future__ import annotations

import importlib
import math
import os
from typing import Any

import numpy as np

from ._core import Light, Material, MaterialHandle, MeshHandle, Scene
from ._model_builder import Builder, missing, v_down
from .errors import UsageError


class _Usd(Builder):
    """Walks a stage. `pxr` holds the modules UsdGeom, UsdShade, UsdLux and Gf."""

    def __init__(self, stage: Any, pxr: Any, time: float | None) -> None:
        geom = pxr.UsdGeom
        super().__init__("z" if geom.GetStageUpAxis(stage) == geom.Tokens.z else "y")
        self.stage, self.pxr = stage, pxr
        self.time = pxr.Usd.TimeCode.Default() if time is None else pxr.Usd.TimeCode(time)
        scale = float(geom.GetStageMetersPerUnit(stage))
        self.world = self.world @ np.diag([scale, scale, scale, 1])
        self.scale = scale
        self.cache = geom.XformCache(self.time)
        self.made: dict[Any, list[tuple[MeshHandle, MaterialHandle]]] = {}
        self.images: dict[str, Any] = {}

    def transform(self, prim: Any) -> np.ndarray:
        return np.array(self.cache.GetLocalToWorldTransform(prim), np.float64).T  # USD's vectors are rows

    def run(self) -> Scene:
        geom, lux = self.pxr.UsdGeom, self.pxr.UsdLux
        instancers: list[Any] = []
        walk = iter(
            self.pxr.Usd.PrimRange(
                self.stage.GetPseudoRoot(), self.pxr.Usd.TraverseInstanceProxies(self.pxr.Usd.PrimDefaultPredicate)
            )
        )
        for prim in walk:
            imageable = geom.Imageable(prim)
            if imageable and (
                imageable.ComputeVisibility(self.time) == geom.Tokens.invisible
                or imageable.ComputePurpose() in (geom.Tokens.guide, geom.Tokens.proxy)
            ):
                walk.PruneChildren()
            elif prim.IsA(geom.PointInstancer):
                instancers.append(geom.PointInstancer(prim))
                walk.PruneChildren()
            elif prim.IsA(geom.Mesh):
                self.show(prim, self.transform(prim), prim.GetPath())
            elif prim.IsA(geom.Camera):
                self.add_camera(geom.Camera(prim), prim)
            elif prim.HasAPI(lux.LightAPI):
                self.add_light(prim)
        for instancer in instancers:
            self.add_instancer(instancer)
        return self.scene

    # Names are paths with dots, because a path of the scene has slashes only between nodes.
    def show(self, prim: Any, transform: np.ndarray, path: Any) -> None:
        source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        key = source.GetPath()
        if key not in self.made:
            self.made[key] = self.meshes(self.pxr.UsdGeom.Mesh(prim), prim)
        for mesh, material in self.made[key]:
            self.add_instance(mesh, material, transform, str(path)[1:].replace("/", "."))

    def add_instancer(self, instancer: Any) -> None:
        geom = self.pxr.UsdGeom
        base = self.transform(instancer.GetPrim())
        indices = instancer.GetProtoIndicesAttr().Get(self.time) or []
        matrices = instancer.ComputeInstanceTransformsAtTime(self.time, self.time)
        prototypes = [self.stage.GetPrimAtPath(path) for path in instancer.GetPrototypesRel().GetTargets()]
        mask = instancer.ComputeMaskAtTime(self.time)
        kept = [i for i in range(len(indices)) if not mask or mask[i]]
        for number, matrix in zip(kept, matrices):
            prototype = prototypes[indices[number]]
            root = np.linalg.inv(self.transform(prototype.GetParent()))
            for prim in self.pxr.Usd.PrimRange(prototype):
                if prim.IsA(geom.Mesh):
                    local = root @ self.transform(prim)
                    # ComputeInstanceTransformsAtTime includes the prototype's own transform.
                    own = np.linalg.inv(
                        np.array(self.pxr.Gf.Matrix4d(geom.Xformable(prototype).GetLocalTransformation(self.time))).T
                    )
                    placed = base @ np.array(matrix, np.float64).T @ own @ local
                    self.show(prim, placed, f"{instancer.GetPath()}/{number}")

    # --- geometry ---

    def meshes(self, mesh: Any, prim: Any) -> list[tuple[MeshHandle, MaterialHandle]]:
        """One mesh per material. Corners share no vertices, because values may belong to faces and corners."""
        points = np.asarray(mesh.GetPointsAttr().Get(self.time), np.float32).reshape(-1, 3)
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get(self.time) or [], np.int64)
        indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(self.time) or [], np.int64)
        if len(points) == 0 or len(counts) == 0:
            return []
        if counts.sum() != len(indices) or (len(indices) and (indices.min() < 0 or indices.max() >= len(points))):
            raise UsageError(f"{prim.GetPath()} has faces that refer to points it does not have")
        first = np.concatenate([[0], np.cumsum(counts)[:-1]])
        corners, faces = _fans(first, counts)  # corners of triangles, and the face of each triangle
        if mesh.GetOrientationAttr().Get(self.time) == self.pxr.UsdGeom.Tokens.leftHanded:
            corners = corners[:, ::-1]
        flat = corners.ravel()
        normals = self.primvar(
            prim, "normals", mesh.GetNormalsAttr(), mesh.GetNormalsInterpolation(), flat, indices, faces, 3
        )
        uv = next(
            (
                v
                for v in (self.primvar(prim, n, None, "", flat, indices, faces, 2) for n in ("st", "UVMap", "st0"))
                if v is not None
            ),
            None,
        )
        colors = self.primvar(prim, "displayColor", None, "", flat, indices, faces, 3)
        made = []
        for material, triangles in self.subsets(prim, faces):
            chosen = np.repeat(triangles, 3)
            handle = self.material_of(material)
            rgba = None
            if handle is None and colors is not None:  # displayColor is linear, and the material of unbound meshes
                rgba = np.concatenate([np.clip(colors[chosen], 0, 1), np.ones((chosen.sum(), 1), np.float32)], axis=1)
                handle = self.white(False)
            made.append(
                (
                    self.scene.add_mesh(
                        points[indices[flat]][chosen],
                        normals=None if normals is None else normals[chosen],
                        uv=None if uv is None else v_down(uv[chosen]),
                        colors=rgba,
                        name=prim.GetName(),
                    ),
                    handle if handle is not None else self.default_material(),
                )
            )
        return made

    def primvar(
        self, prim: Any, name: str, attribute: Any, interpolation: str, flat: Any, indices: Any, faces: Any, width: int
    ) -> np.ndarray | None:
        """The values of a primvar, or of the attribute of the same meaning, per corner of the triangles."""
        source = self.pxr.UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        if source and source.HasValue():
            values, interpolation = source.ComputeFlattened(self.time), source.GetInterpolation()
        else:
            values = attribute.Get(self.time) if attribute else None
        if values is None or len(values) == 0:
            return None
        array = np.asarray(values, np.float32).reshape(len(values), -1)[:, :width]
        if interpolation == "constant":
            return np.repeat(array[:1], len(flat), axis=0)
        if interpolation == "uniform":
            return array[np.repeat(faces, 3)] if len(array) > faces.max() else None
        at = flat if interpolation == "faceVarying" else indices[flat]
        return array[at] if len(array) > at.max() else None

    def subsets(self, prim: Any, faces: np.ndarray) -> list[tuple[Any, np.ndarray]]:
        """The material of each subset of faces, and which triangles it has."""
        shade, geom = self.pxr.UsdShade, self.pxr.UsdGeom
        rest = np.ones(len(faces), bool)
        parts = []
        for subset in shade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
            chosen = (
                np.isin(faces, np.asarray(geom.Subset(subset).GetIndicesAttr().Get(self.time) or [], np.int64)) & rest
            )
            rest &= ~chosen
            if chosen.any():
                parts.append((shade.MaterialBindingAPI(subset).ComputeBoundMaterial()[0], chosen))
        if rest.any():
            parts.append((shade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0], rest))
        return parts

    # --- materials ---

    def material_of(self, material: Any) -> MaterialHandle | None:
        if not material:
            return None
        key = str(material.GetPath())
        if key not in self.materials:
            surface = material.ComputeSurfaceSource()[0]
            known = surface and surface.GetShaderId() == "UsdPreviewSurface"
            self.materials[key] = self.preview_surface(material, surface) if known else self.default_material()
        return self.materials[key]

    def preview_surface(self, material: Any, surface: Any) -> MaterialHandle:
        def value(name: str, otherwise: Any) -> Any:
            given = surface.GetInput(name)
            result = given.Get(self.time) if given and not given.HasConnectedSource() else None
            return otherwise if result is None else result

        images = {name: self.image(surface, name) for name in ("diffuseColor", "emissiveColor", "normal")}
        diffuse = (1, 1, 1) if images["diffuseColor"] is not None else value("diffuseColor", (0.18, 0.18, 0.18))
        emissive = (1, 1, 1) if images["emissiveColor"] is not None else value("emissiveColor", (0, 0, 0))
        opacity, threshold, ior = (
            float(value("opacity", 1)),
            float(value("opacityThreshold", 0)),
            float(value("ior", 1.5)),
        )
        handle = self.scene.add_material(
            Material(
                name=material.GetPrim().GetName(),
                base_color=(*(min(max(float(c), 0), 1) for c in diffuse), min(max(opacity, 0), 1)),
                metallic=min(max(float(value("metallic", 0)), 0), 1),
                roughness=min(max(float(value("roughness", 0.5)), 0), 1),
                emissive=tuple(max(float(c), 0) for c in emissive),
                clearcoat=min(max(float(value("clearcoat", 0)), 0), 1),
                clearcoat_roughness=min(max(float(value("clearcoatRoughness", 0.01)), 0), 1),
                f0=((ior - 1) / (ior + 1)) ** 2,
                alpha_mode="mask" if threshold > 0 else "blend" if opacity < 1 else "opaque",
                alpha_cutoff=threshold if threshold > 0 else 0.5,
            )
        )
        self.add_texture(handle, "base_color", images["diffuseColor"], True)
        self.add_texture(handle, "emissive", images["emissiveColor"], True)
        self.add_texture(handle, "normal", images["normal"], False)
        return handle

    def image(self, surface: Any, name: str) -> Any:
        """The image file that an input is connected to, as pixels."""
        given = surface.GetInput(name)
        if not given or not given.HasConnectedSource():
            return None
        texture = self.pxr.UsdShade.Shader(given.GetConnectedSource()[0].GetPrim())
        file = texture.GetInput("file").Get(self.time) if texture and texture.GetInput("file") else None
        path = file.resolvedPath if file else ""
        if not path or not os.path.isfile(path):
            return None
        if path not in self.images:
            try:
                pil = importlib.import_module("PIL.Image")
            except ImportError:
                raise missing("pillow", "from_usd") from None
            self.images[path] = pil.open(path)
        return self.images[path]

    # --- lights and cameras ---

    def add_light(self, prim: Any) -> None:
        lux = self.pxr.UsdLux
        api, transform = lux.LightAPI(prim), self.world @ self.transform(prim)
        color = tuple(float(c) for c in api.GetColorAttr().Get(self.time))
        power = float(api.GetIntensityAttr().Get(self.time)) * 2 ** float(api.GetExposureAttr().Get(self.time))
        position = tuple(transform[:3, 3].tolist())
        direction = tuple((-transform[:3, 2]).tolist())
        name = prim.GetName()
        if prim.IsA(lux.DistantLight):
            self.scene.add_light(
                Light(name=name, type="directional", direction=direction, color=color, intensity=power)
            )
        elif prim.IsA(lux.SphereLight):
            radius = float(lux.SphereLight(prim).GetRadiusAttr().Get(self.time)) * self.scale
            # Radiance times the projected area, as seen from afar.
            candela = power * (1 if api.GetNormalizeAttr().Get(self.time) else math.pi * radius**2)
            self.scene.add_light(Light(name=name, position=position, color=color, intensity=candela, size=radius))

    def add_camera(self, camera: Any, prim: Any) -> None:
        gf = camera.GetCamera(self.time)
        fov = float(gf.GetFieldOfView(self.pxr.Gf.Camera.FOVVertical))
        transform = self.world @ self.transform(prim)
        eye = transform[:3, 3]
        made = self.scene.look_at(eye, eye - transform[:3, 2] / np.linalg.norm(transform[:3, 2]), vertical_fov=fov)
        pose = np.eye(4)
        axes = transform[:3, :3] / np.linalg.norm(transform[:3, :3], axis=0)
        pose[:3, :3], pose[:3, 3] = axes @ np.diag([1, -1, -1]), eye  # OpenCV's camera: Y down, Z forward
        made.camera_to_world = pose
        made.name = prim.GetName()
        self.scene.add_camera(made)


def _fans(first: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the triangles of polygons, as fans, and the polygon of each triangle."""
    triangles = np.maximum(counts - 2, 0)
    faces = np.repeat(np.arange(len(counts)), triangles)
    step = np.arange(len(faces)) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    begin = first[faces]
    return np.stack([begin, begin + step + 1, begin + step + 2], axis=1), faces


def from_usd(stage: Any, *, time: float | None = None) -> Scene:
    """Converts a Usd.Stage, or the path of a .usd, .usda, .usdc or .usdz file, with usd-core.

    time: the time code at which values are read; default: their default values

    Converted are visible meshes with their subsets, normals, texture coordinates (st) and displayColor, instances and
    point instancers, UsdPreviewSurface with the images of diffuseColor, emissiveColor and normal, distant and sphere
    lights, cameras, and the stage's units, up axis and chosen variants. Subdivision surfaces are shown as their cages,
    and polygons as fans. Skeletons, curves, points, volumes and other shaders are left out."""
    try:
        pxr = importlib.import_module("pxr")
        for name in ("Gf", "Usd", "UsdGeom", "UsdLux", "UsdShade"):
            importlib.import_module(f"pxr.{name}")
    except ImportError:
        raise missing("usd-core", "from_usd") from None
    if isinstance(stage, (str, os.PathLike)):
        if not os.path.isfile(stage):
            raise UsageError(f"{os.fspath(stage)} does not exist: give a .usd, .usda, .usdc or .usdz file")
        stage = pxr.Usd.Stage.Open(os.fspath(stage))
    return _Usd(stage, pxr, time).run()
