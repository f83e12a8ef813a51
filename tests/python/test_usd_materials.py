"""Materials from USD and MaterialX: surfaces and their images."""

import json
import re
import warnings

import numpy as np
import pytest

import latelight
from model_checks import only_material
from usd_stages import add_mesh, add_paint, bind, painted, painted_with


@pytest.mark.parametrize("full, preview, every, expected", [
    ("red", "", "", "red"),
    ("", "red", "", "red"),
    ("red", "blue", "", "red"),
    ("red", "", "blue", "red"),
    ("", "red", "blue", "blue"),  # the binding for all purposes is also one for full renderings
    ("other", "red", "", "red"),  # no shader of the material for full renderings is supported
    ("other", "", "", "default"),
])  # fmt: skip
def test_usd_bindings_may_have_purposes(stage, full, preview, every, expected):
    from pxr import UsdShade

    binding = UsdShade.MaterialBindingAPI.Apply(add_mesh(stage, "/squares").GetPrim())
    add_paint(stage, "/other", (0, 1, 0))
    UsdShade.Shader(stage.GetPrimAtPath("/other/surface")).CreateIdAttr("another")
    materials = {"red": add_paint(stage, "/red", (1, 0, 0)), "blue": add_paint(stage, "/blue", (0, 0, 1))}
    materials["other"] = UsdShade.Material(stage.GetPrimAtPath("/other"))
    for name, purpose in ((full, "full"), (preview, "preview"), (every, "")):
        if name:
            binding.Bind(materials[name], UsdShade.Tokens.weakerThanDescendants, purpose)
    scene = latelight.from_usd(stage)
    (handle,) = scene.instances()
    assert scene.material(scene.instance(handle).material).name == expected
    computed = binding.ComputeBoundMaterial("full")[0]
    if computed and full != "other":
        assert computed.GetPath().name == expected


def test_usd_standard_surfaces_of_materialx(stage):
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    shader.CreateInput("base", types.Float).Set(0.5)
    shader.CreateInput("metalness", types.Float).Set(0.25)
    shader.CreateInput("specular_roughness", types.Float).Set(0.75)
    shader.CreateInput("specular_IOR", types.Float).Set(2)
    shader.CreateInput("coat", types.Float).Set(0.3)
    shader.CreateInput("sheen", types.Float).Set(0.5)
    shader.CreateInput("sheen_color", types.Color3f).Set((1, 0.5, 0))
    shader.CreateInput("emission", types.Float).Set(4)
    shader.CreateInput("emission_color", types.Color3f).Set((1, 0, 0))
    shader.CreateInput("opacity", types.Color3f).Set((0.5, 0.5, 0.5))
    graph = UsdShade.NodeGraph.Define(stage, "/paint/graph")  # a constant through a node graph
    graph.CreateInput("tint", types.Color3f).Set((0.2, 0.4, 0.6))
    graph.CreateOutput("out", types.Color3f).ConnectToSource(graph.GetInput("tint"))
    shader.CreateInput("base_color", types.Color3f).ConnectToSource(graph.GetOutput("out"))
    bind(stage, shader, "mtlx")
    _, made = only_material(latelight.from_usd(stage))
    np.testing.assert_allclose(made.base_color, (0.1, 0.2, 0.3, 0.5), atol=1e-6)
    assert (made.metallic, made.roughness, made.alpha_mode) == (0.25, 0.75, "blend")
    np.testing.assert_allclose((made.f0, made.clearcoat, made.clearcoat_roughness), (1 / 9, 0.3, 0.1), atol=1e-6)
    np.testing.assert_allclose((*made.sheen_color, *made.emissive), (0.5, 0.25, 0, 4, 0, 0), atol=1e-6)


def test_usd_images_of_scalars_are_packed(stage, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    image.fromarray(np.full((2, 2, 3), (10, 20, 30), np.uint8)).save(tmp_path / "orm.png")
    image.fromarray(np.full((4, 4), 99, np.uint8)).save(tmp_path / "mask.png")
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    inputs = [("occlusion", "orm", "r"), ("roughness", "orm", "g"), ("metallic", "orm", "b"), ("opacity", "mask", "r")]
    for name, file, channel in inputs:
        texture = UsdShade.Shader.Define(stage, f"/paint/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(str(tmp_path / f"{file}.png"))
        output = texture.CreateOutput(channel, types.Float)
        shader.CreateInput(name, types.Float).ConnectToSource(output)
    bind(stage, shader)
    scene = latelight.from_usd(stage)
    _, made = only_material(scene)
    assert (made.metallic, made.roughness, made.alpha_mode) == (1, 1, "blend")
    scene.export(tmp_path / "paint.glb")
    (mesh,) = trimesh.load(tmp_path / "paint.glb").geometry.values()
    paint = mesh.visual.material
    assert np.asarray(paint.metallicRoughnessTexture)[0, 0, 1:3].tolist() == [20, 30]
    assert np.asarray(paint.occlusionTexture)[0, 0, 0] == 10
    assert np.asarray(paint.baseColorTexture)[0, 0].tolist() == [255, 255, 255, 99]


@pytest.mark.parametrize("given, mode", [("", "opaque"), ("opacity", "blend"), ("opacityThreshold", "mask")])
def test_usd_colors_exclude_the_alpha_of_their_image(stage, tmp_path, given, mode):
    """The output rgb of a UsdUVTexture has no alpha: the opacity is that of the input of this name, which is 1 by
    default."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 4), (200, 100, 50, 0), np.uint8)).save(tmp_path / "clear.png")
    painted(stage, tmp_path / "clear.png")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    if given:
        surface.CreateInput(given, Sdf.ValueTypeNames.Float).Set(0.5)
    scene = latelight.from_usd(stage)
    handle, made = only_material(scene)
    assert (made.alpha_mode, made.base_color[3]) == (mode, 0.5 if given == "opacity" else 1)
    assert scene.texture_pixels(scene.texture_of(handle, "base_color"))[0, 0].tolist() == [200, 100, 50, 255]


def painted_by_materialx(stage, file):
    """A translucent mesh whose color is an image. Returns the shader of the image."""
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    shader = UsdShade.Shader.Define(stage, "/paint/surface")
    shader.CreateIdAttr("ND_standard_surface_surfaceshader")
    texture = UsdShade.Shader.Define(stage, "/paint/image")
    texture.CreateIdAttr("ND_image_color3")
    texture.CreateInput("file", types.Asset).Set(str(file))
    shader.CreateInput("base_color", types.Color3f).ConnectToSource(texture.CreateOutput("out", types.Color3f))
    shader.CreateInput("opacity", types.Color3f).Set((0.5, 0.5, 0.5))
    bind(stage, shader, "mtlx")
    return texture


def test_materialx_colors_exclude_the_alpha_of_their_image(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.full((2, 2, 4), (200, 100, 50, 0), np.uint8)).save(tmp_path / "clear.png")
    painted_by_materialx(stage, tmp_path / "clear.png")
    scene = latelight.from_usd(stage)
    handle, made = only_material(scene)
    assert (made.alpha_mode, made.base_color[3]) == ("blend", 0.5)
    assert scene.texture_pixels(scene.texture_of(handle, "base_color"))[0, 0].tolist() == [200, 100, 50, 255]


def test_usd_surfaces_may_have_the_specular_workflow(stage, tmp_path):
    """specularColor is the reflectance at normal incidence, which is f0 times specular_color
    (KHR_materials_specular). metallic and ior do not apply to it."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    types = Sdf.ValueTypeNames
    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    surface.CreateInput("ior", types.Float).Set(2)
    surface.CreateInput("metallic", types.Float).ConnectToSource(texture.GetOutput("r"))
    color = surface.CreateInput("specularColor", types.Color3f)
    color.Set((1, 0.5, 0.02))
    workflow = surface.CreateInput("useSpecularWorkflow", types.Int)

    def converted():
        scene = latelight.from_usd(stage)
        handle, made = only_material(scene)
        reflectance = np.multiply(made.specular_color, made.f0)
        texels = scene.texture_pixels(scene.texture_of(handle, "metallic_roughness"))[0, 0, 1:3].tolist()
        return made.metallic, reflectance, texels, scene.texture_of(handle, "specular_color") is not None

    workflow.Set(0)
    metallic, reflectance, texels, has_texture = converted()
    assert (metallic, texels, has_texture) == (1, [200, 200], False)
    np.testing.assert_allclose(reflectance, 1 / 9, atol=1e-6)
    workflow.Set(1)
    metallic, reflectance, texels, has_texture = converted()
    assert (metallic, texels, has_texture) == (0, [200, 255], False)
    np.testing.assert_allclose(reflectance, (1, 0.5, 0.02), atol=1e-6)
    color.ConnectToSource(texture.GetOutput("rgb"))
    _, reflectance, _, has_texture = converted()
    assert has_texture
    np.testing.assert_allclose(reflectance, 1, atol=1e-6)


@pytest.mark.parametrize(
    "file, reason",
    [("gone.png", "does not exist"), ("gone.<UDIM>.png", "consists of UDIM tiles, which are not supported")],
)
def test_usd_images_that_do_not_exist_are_left_out(stage, file, reason):
    from pxr import UsdShade

    painted(stage, file)
    with pytest.warns(UserWarning) as raised:
        scene = latelight.from_usd(stage)
    assert [str(warning.message) for warning in raised] == [f"the image {file} of /paint/image {reason}, and is left out"]
    assert scene.textures() == []
    UsdShade.Shader(stage.GetPrimAtPath("/paint/image")).GetInput("file").Set("")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        latelight.from_usd(stage)


def test_usd_images_may_be_inputs_of_the_material(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 120, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, "")
    given = UsdShade.Material.Define(stage, "/paint").CreateInput("image", Sdf.ValueTypeNames.Asset)
    given.Set(str(tmp_path / "gray.png"))
    file = UsdShade.Shader(stage.GetPrimAtPath("/paint/image")).GetInput("file")
    file.GetAttr().Clear()
    file.ConnectToSource(given)
    assert painted_with(latelight.from_usd(stage), tmp_path) == ([120] * 3, 120)


def test_usd_images_may_have_16_bits(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    image.fromarray(np.full((2, 2), 120 * 257 - 100, np.uint16)).save(tmp_path / "deep.png")  # rounds to 120
    painted(stage, tmp_path / "deep.png")
    assert painted_with(latelight.from_usd(stage), tmp_path) == ([120, 120, 120], 120)


@pytest.mark.parametrize("packaged", [False, True])
def test_usd_images_may_have_linear_values(stage, tmp_path, packaged):
    """Radiance's RGBE: a mantissa m of 8 bits and an exponent e are m / 256 * 2^(e - 128). Colors become sRGB (IEC
    61966-2-1): 0.75, 0.25 and 0.125 are 225, 137 and 99 of 255. The roughness 0.75 is 191."""
    from pxr import Sdf

    texel = bytes((192, 64, 32, 128))
    (tmp_path / "paint.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + 4 * texel)
    file = tmp_path / "paint.hdr"
    if packaged:
        archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / "paint.usdz"))
        archive.AddFile(str(file), "paint.hdr")
        archive.Save()
        file = f"{tmp_path}/paint.usdz[paint.hdr]"
    painted(stage, file)
    assert painted_with(latelight.from_usd(stage), tmp_path) == ([225, 137, 99], 191)


@pytest.mark.parametrize("name", ["paint.png", "paint.jpg", "paint.exr"])
@pytest.mark.parametrize("damage", ["truncated", "garbage", "empty"])
def test_usd_images_that_cannot_be_decoded_are_named(stage, tmp_path, name, damage):
    image = pytest.importorskip("PIL.Image")

    file = tmp_path / name
    if name.endswith(".exr"):
        file.write_bytes(b"\x76\x2f\x31\x01")  # the magic number
    else:
        image.fromarray(np.random.default_rng(1).integers(0, 255, (16, 16, 3), np.uint8)).save(file)
    contents = {"truncated": file.read_bytes()[: file.stat().st_size // 2], "garbage": b"no image", "empty": b""}
    file.write_bytes(contents[damage])
    painted(stage, file)
    with pytest.raises(latelight.InputError, match=re.escape(str(file))):
        latelight.from_usd(stage)
    stage.GetRootLayer().Export(str(tmp_path / "stage.usda"))
    with pytest.raises(latelight.InputError, match=re.escape(str(file))) as raised:
        latelight.from_usd(tmp_path / "stage.usda")
    assert "usd-core" not in str(raised.value)


def test_usd_images_are_scaled(stage, tmp_path):
    """UsdUVTexture: values of an image are multiplied by a scale before they are used."""
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 255, np.uint8)).save(tmp_path / "white.png")
    painted(stage, tmp_path / "white.png")
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set((0.25, 0.5, 2, 1))
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    emissive = surface.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f)
    emissive.ConnectToSource(texture.GetOutput("rgb"))
    opacity = surface.CreateInput("opacity", Sdf.ValueTypeNames.Float)
    opacity.ConnectToSource(texture.CreateOutput("g", Sdf.ValueTypeNames.Float))
    _, made = only_material(latelight.from_usd(stage))
    np.testing.assert_allclose(made.base_color, (0.25, 0.5, 1, 0.5))  # glTF's colors are at most 1
    assert (made.roughness, tuple(made.emissive)) == (0.25, (0.25, 0.5, 2))
    texture.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set((0.1, 0, 0, 0))
    _, made = only_material(latelight.from_usd(stage))
    np.testing.assert_allclose((*made.base_color, made.roughness), 1)


def samplers(scene, folder):
    """The wrap modes of glTF's samplers: 10497 is REPEAT, 33071 CLAMP_TO_EDGE, 33648 MIRRORED_REPEAT (5.26)."""
    scene.export(folder / "wrapped.glb")
    data = (folder / "wrapped.glb").read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    modes = [(each.get("wrapS", 10497), each.get("wrapT", 10497)) for each in document["samplers"]]
    return {modes[texture["sampler"]] for texture in document["textures"]}


REPEAT, CLAMP, MIRROR = 10497, 33071, 33648


@pytest.mark.parametrize(
    "wraps, expected, warning",
    [
        (("repeat", "repeat"), REPEAT, ""),
        (("clamp", "clamp"), CLAMP, ""),
        (("mirror", "mirror"), MIRROR, ""),
        (("useMetadata", "useMetadata"), REPEAT, ""),
        (("black", "black"), CLAMP, '"clamp" instead of "black" for diffuseColor of /paint/surface'),
        (("mirror", "clamp"), MIRROR, '"mirror" for roughness of /paint/surface, because'),
    ],
)
def test_usd_images_have_wrap_modes(stage, tmp_path, wraps, expected, warning):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, UsdShade

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    painted(stage, tmp_path / "gray.png")
    texture = UsdShade.Shader(stage.GetPrimAtPath("/paint/image"))
    for name, wrap in zip(("wrapS", "wrapT"), wraps):
        texture.CreateInput(name, Sdf.ValueTypeNames.Token).Set(wrap)
    surface = UsdShade.Shader(stage.GetPrimAtPath("/paint/surface"))
    surface.CreateInput("normal", Sdf.ValueTypeNames.Normal3f).ConnectToSource(texture.GetOutput("rgb"))
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        scene = latelight.from_usd(stage)
    messages = [str(each.message) for each in given]
    assert len(messages) == (3 if warning else 0)  # one per texture
    assert any(warning in message for message in messages) or not warning
    assert samplers(scene, tmp_path) == {(expected, expected)}


def test_materialx_images_have_wrap_modes(stage, tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf

    image.fromarray(np.full((2, 2, 3), 200, np.uint8)).save(tmp_path / "gray.png")
    texture = painted_by_materialx(stage, tmp_path / "gray.png")
    for name in ("uaddressmode", "vaddressmode"):
        texture.CreateInput(name, Sdf.ValueTypeNames.String).Set("mirror")
    assert samplers(latelight.from_usd(stage), tmp_path) == {(MIRROR, MIRROR)}
