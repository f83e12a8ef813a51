"""Builds stages of USD for tests: in the fixture `stage`, in centimeters with Z up."""

import numpy as np
import pytest


def add_mesh(stage, path):
    """Two squares of 1 m, in a stage in centimeters."""
    UsdGeom = pytest.importorskip("pxr.UsdGeom")
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0), (200, 0, 0), (200, 100, 0)])
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 4, 5, 2])
    return mesh


def add_paint(stage, path, color):
    """A material of one color."""
    from pxr import Sdf, UsdShade

    material, shader = UsdShade.Material.Define(stage, path), UsdShade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def add_instancer(stage, path, prototypes, positions=((0, 0, 0), (30, 0, 0)), indices=None):
    from pxr import UsdGeom

    copies = UsdGeom.PointInstancer.Define(stage, path)
    copies.CreatePrototypesRel().SetTargets(prototypes)
    copies.CreateProtoIndicesAttr([0] * len(positions) if indices is None else indices)
    copies.CreatePositionsAttr(list(positions))
    return copies


def add_primvar(prim, name, kind, interpolation, values):
    from pxr import Sdf, UsdGeom

    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, getattr(Sdf.ValueTypeNames, kind), interpolation).Set(values)


def bind(stage, shader, context=None):
    from pxr import UsdShade

    material = UsdShade.Material.Define(stage, shader.GetPath().GetParentPath())
    output = material.CreateSurfaceOutput(context) if context else material.CreateSurfaceOutput()
    output.ConnectToSource(shader.ConnectableAPI(), "out")
    mesh = add_mesh(stage, "/squares")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    return mesh


def painted(stage, file):
    """A mesh whose color and roughness are images."""
    from pxr import Sdf, UsdShade

    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    texture = UsdShade.Shader.Define(stage, "/paint/image")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(file))
    for name, channel, kind in (("diffuseColor", "rgb", "Color3f"), ("roughness", "r", "Float")):
        output = texture.CreateOutput(channel, getattr(Sdf.ValueTypeNames, kind))
        shader.CreateInput(name, getattr(Sdf.ValueTypeNames, kind)).ConnectToSource(output)
    bind(stage, shader)


def painted_with(scene, folder):
    """A pixel of the color, and the roughness there."""
    trimesh = pytest.importorskip("trimesh")
    scene.export(folder / "painted.glb")
    (mesh,) = trimesh.load(folder / "painted.glb").geometry.values()
    paint = mesh.visual.material
    color, packed = np.asarray(paint.baseColorTexture), np.asarray(paint.metallicRoughnessTexture)
    return color[0, 0, :3].tolist(), int(packed[0, 0, 1])
