"""Materials from USD that read primvars: colors, opacities and texture coordinates."""

import warnings

import numpy as np
import pytest

import latelight
from model_checks import colors_by_node, only_material, surface_colors
from usd_stages import add_instancer, add_mesh, add_paint, add_primvar, bind, painted


def connect_primvar(stage, shader, name, kind, primvar, fallback=None):
    """Connects an input of a shader to a reader of a primvar. Kinds are float, float2 or float3."""
    from pxr import Sdf, UsdShade

    types, path = Sdf.ValueTypeNames, f"{shader.GetPath().GetParentPath()}/{shader.GetPrim().GetName()}_{name}"
    reader, value_type = UsdShade.Shader.Define(stage, path), getattr(types, kind.capitalize())
    reader.CreateIdAttr(f"UsdPrimvarReader_{kind}")
    reader.CreateInput("varname", types.String).Set(primvar)
    if fallback is not None:
        reader.CreateInput("fallback", value_type).Set(fallback)
    shader.CreateInput(name, value_type).ConnectToSource(reader.CreateOutput("result", value_type))
    return reader


def preview_surface(stage, path="/paint/surface"):
    from pxr import UsdShade

    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr("UsdPreviewSurface")
    return shader


def colors_at(scene, points):
    """The colors of the only instance at corners at these points, of which all corners there have one."""
    (handle,) = scene.instances()
    instance = scene.instance(handle)
    colors, positions = surface_colors(scene, instance), scene.mesh_arrays(instance.mesh)["positions"]
    found = [np.unique(colors[(positions == point).all(axis=1)].round(4), axis=0) for point in points]
    return [same.tolist() for same in found]


@pytest.mark.parametrize("interpolation, values, expected", [
    ("constant", [(0, 1, 0)], [[0, 1, 0]] * 6),
    ("constant", (0, 0.5, 1), [[0, 0.5, 1]] * 6),  # no array
    ("vertex", [(n / 8, 0, 1) for n in range(6)], [[n / 8, 0, 1] for n in range(6)]),
    ("faceVarying", [(n, n / 8, 0) for n in (0, 0, 0, 0, 1, 1, 1, 1)], None),
    ("uniform", [(1, 0, 0), (0, 0, 1)], None),
    ("vertex", [(1, 0, 0)] * 5, [[0.25, 0.5, 0.75]] * 6),  # fewer values than points
    (None, None, [[0.25, 0.5, 0.75]] * 6),
])  # fmt: skip
def test_usd_surfaces_read_colors_of_primvars(stage, interpolation, values, expected):
    shader = preview_surface(stage)
    mesh = bind(stage, shader)
    connect_primvar(stage, shader, "diffuseColor", "float3", "paint", (0.25, 0.5, 0.75))
    if interpolation:
        add_primvar(mesh, "paint", "Color3fArray" if isinstance(values, list) else "Color3f", interpolation, values)
    scene = latelight.from_usd(stage)
    if expected:
        made = colors_at(scene, mesh.GetPointsAttr().Get())
        assert made == [[pytest.approx([*color, 1], abs=1e-4)] for color in expected]
    else:  # points 0 and 3 belong to the first face only, and points 4 and 5 to the second one
        first, second = ([*color, 1] for color in (values[0], values[-1]))
        points = [mesh.GetPointsAttr().Get()[n] for n in (0, 3, 4, 5)]
        assert colors_at(scene, points) == [[first], [first], [second], [second]]
    assert only_material(scene)[1].alpha_mode == "opaque"


def test_usd_surfaces_read_opacities_of_primvars(stage):
    shader = preview_surface(stage)
    mesh = bind(stage, shader)
    connect_primvar(stage, shader, "opacity", "float", "displayOpacity")
    opacity = mesh.CreateDisplayOpacityPrimvar("vertex")
    opacity.Set([0, 0.25, 0.5, 0.75, 1, 1])
    scene = latelight.from_usd(stage)
    made = colors_at(scene, mesh.GetPointsAttr().Get())
    assert made == [[pytest.approx([0.18, 0.18, 0.18, alpha])] for alpha in (0, 0.25, 0.5, 0.75, 1, 1)]
    assert only_material(scene)[1].alpha_mode == "blend"


def test_usd_surfaces_read_constant_primvars(stage, tmp_path):
    """Meshes with a material differ in its constants, which are those of the mesh, inherited or the fallback, and share
    its textures."""
    image = pytest.importorskip("PIL.Image")
    from pxr import UsdGeom, UsdShade

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    shader = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    connect_primvar(stage, shader, "metallic", "float", "metal", 0.75)
    connect_primvar(stage, shader, "emissiveColor", "float3", "glow")
    material = UsdShade.Material(stage.GetPrimAtPath("/paint"))
    for name in ("/group/one", "/two"):
        UsdShade.MaterialBindingAPI.Apply(add_mesh(stage, name).GetPrim()).Bind(material)
    add_primvar(UsdGeom.Xform.Define(stage, "/group"), "metal", "FloatArray", "constant", [0.25])
    add_primvar(stage.GetPrimAtPath("/two"), "metal", "FloatArray", "constant", [0.5])
    add_primvar(stage.GetPrimAtPath("/two"), "glow", "Color3fArray", "constant", [(0, 1, 2)])
    scene = latelight.from_usd(stage)
    materials = {n.path: scene.material(scene.instance(i).material) for n, i in zip(scene.nodes, scene.instances())}
    made = {path: (material.metallic, material.emissive) for path, material in materials.items()}
    assert made == {"/group.one": (0.25, (0, 0, 0)), "/two": (0.5, (0, 1, 2)), "/squares": (0.75, (0, 0, 0))}
    assert len(scene.textures()) == 2  # of color and of roughness
    add_primvar(stage.GetPrimAtPath("/two"), "metal", "FloatArray", "vertex", [0.5] * 6)
    with pytest.warns(UserWarning, match='fallback of the primvar "metal" for metallic of /paint/surface, because only'):
        latelight.from_usd(stage)


def test_usd_copies_of_instancers_have_primvars_of_their_material(stage):
    """The material of a prototype reads a primvar with a value per copy, whose name is an input of the material."""
    from pxr import Sdf, UsdShade

    shader = preview_surface(stage)
    mesh = bind(stage, shader)
    reader = connect_primvar(stage, shader, "diffuseColor", "float3", "", (0.5, 0.5, 0.5))
    named = UsdShade.Material(stage.GetPrimAtPath("/paint")).CreateInput("name", Sdf.ValueTypeNames.String)
    named.Set("peanut")
    reader.GetInput("varname").ConnectToSource(named)
    copies = add_instancer(stage, "/copies", [mesh.GetPath()])
    stage.GetPrimAtPath("/squares").SetSpecifier(Sdf.SpecifierOver)
    add_primvar(copies, "peanut", "Color3fArray", "vertex", [(1, 0, 0), (0, 0, 1)])
    add_primvar(copies, "name", "StringArray", "vertex", ["a", "b"])
    scene = latelight.from_usd(stage)
    assert colors_by_node(scene) == {"/copies.0": [(1, 0, 0, 1)], "/copies.1": [(0, 0, 1, 1)]}
    assert len(scene.meshes()) == 1


def test_materialx_surfaces_read_primvars(stage):
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    reader = UsdShade.Shader.Define(stage, "/paint/graph/reader")
    UsdShade.NodeGraph.Define(stage, "/paint/graph")
    reader.CreateIdAttr("ND_geompropvalue_color3")
    reader.CreateInput("geomprop", types.String).Set("paint")
    reader.CreateInput("default", types.Color3f).Set((0, 0, 0.5))
    output = UsdShade.NodeGraph(stage.GetPrimAtPath("/paint/graph")).CreateOutput("color", types.Color3f)
    output.ConnectToSource(reader.CreateOutput("out", types.Color3f))
    shader.CreateInput("base_color", types.Color3f).ConnectToSource(output)
    mesh = bind(stage, shader, "mtlx")
    points = mesh.GetPointsAttr().Get()
    assert colors_at(latelight.from_usd(stage), points) == [[[0, 0, 0.5, 1]]] * 6
    add_primvar(mesh, "paint", "Color3fArray", "vertex", [(n / 8, 0, 1) for n in range(6)])
    assert colors_at(latelight.from_usd(stage), points) == [[[n / 8, 0, 1, 1]] for n in range(6)]


def texture_coordinates(scene):
    """The coordinates per corner, with v up as in USD; the last vertices are those of the second face."""
    (handle,) = scene.instances()
    uv = np.array(scene.mesh_arrays(scene.instance(handle).mesh)["uv"])
    return np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)


@pytest.mark.parametrize("through", ["", "transform"])
@pytest.mark.parametrize("primvar, scale", [("st", 1), ("uv2", 2), ("map1", 3), ("missing", None), ("", 1)])
def test_usd_images_have_their_own_texture_coordinates(stage, tmp_path, primvar, scale, through):
    """By the name that the reader states; without a name, by the usual ones. A mesh without the primvar has the reader's
    fallback."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    mesh = stage.GetPrimAtPath("/squares")
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)])
    for name, factor in (("st", 1), ("uv2", 2), ("map1", 3)):
        add_primvar(mesh, name, "TexCoord2fArray", "vertex", (corners * factor).tolist())
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    if through:
        turn = UsdShade.Shader.Define(stage, "/paint/turn")
        turn.CreateIdAttr("UsdTransform2d")
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
            turn.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        )
        connect_primvar(stage, turn, "in", "float2", primvar, (0.25, 0.5))
    else:
        connect_primvar(stage, texture, "st", "float2", primvar, (0.25, 0.5))
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        scene = latelight.from_usd(stage)
    messages = ['meshes without the primvar "missing", which their material states'] if scale is None else []
    assert [str(warning.message)[: len(messages[0])] for warning in warned] == messages
    (handle,) = scene.instances()
    points = scene.mesh_arrays(scene.instance(handle).mesh)["positions"][:, :2] / 100
    np.testing.assert_allclose(texture_coordinates(scene), np.tile((0.25, 0.5), (12, 1)) if scale is None else scale * points)


def test_usd_meshes_have_one_set_of_texture_coordinates(stage, tmp_path):
    """That of the base color, and a warning names it. Subsets have sets of their own."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdGeom, UsdShade

    types = Sdf.ValueTypeNames
    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    shader = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    connect_primvar(stage, UsdShade.Shader(stage.GetPrimAtPath("/paint/image")), "st", "float2", "second")
    other = UsdShade.Shader.Define(stage, "/paint/other")
    other.CreateIdAttr("UsdUVTexture")
    other.CreateInput("file", types.Asset).Set(str(tmp_path / "gray.png"))
    shader.CreateInput("emissiveColor", types.Color3f).ConnectToSource(other.CreateOutput("rgb", types.Float3))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/squares"))
    for name, value in (("st", 0.25), ("second", 0.5)):
        add_primvar(mesh, name, "TexCoord2fArray", "vertex", [(value, value)] * 6)
    with pytest.warns(UserWarning, match='coordinates "second" for all images of /paint/surface, because a mesh has one'):
        scene = latelight.from_usd(stage)
    assert np.unique(texture_coordinates(scene)) == [0.5]
    other.CreateInput("st", types.Float2).ConnectToSource(
        UsdShade.Shader(stage.GetPrimAtPath("/paint/image_st")).GetOutput("result")
    )
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "right", UsdGeom.Tokens.face, [1], "materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(add_paint(stage, "/red", (1, 0, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = latelight.from_usd(stage)
    sets = {}
    for instance in map(scene.instance, scene.instances()):
        sets[scene.material(instance.material).name] = np.unique(scene.mesh_arrays(instance.mesh)["uv"]).tolist()
    assert sets == {"red": [0.25, 0.75], "paint": [0.5]}
