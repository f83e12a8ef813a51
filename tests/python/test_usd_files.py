"""Files of USD: which a stage may read, and archives."""

import sys
import zipfile

import numpy as np
import pytest

import latelight
from model_checks import URDF, background
from usd_stages import add_mesh, bind, painted, painted_with


def test_files_of_other_packages_are_scenes(tmp_path, monkeypatch):
    pytest.importorskip("yourdfpy")
    UsdGeom, Usd = pytest.importorskip("pxr.UsdGeom"), pytest.importorskip("pxr.Usd")
    (tmp_path / "crane.urdf").write_text(URDF)
    assert "/base/shoulder/arm/visual 1" in [node.path for node in latelight.Scene(tmp_path / "crane.urdf").nodes]
    stage = Usd.Stage.CreateNew(str(tmp_path / "cube.usda"))
    mesh = UsdGeom.Mesh.Define(stage, "/square")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    stage.Save()
    scene = latelight.Scene(tmp_path / "cube.usda")
    assert scene.triangle_count == 1 and latelight.Renderer(scene, "cpu").render(scene.default_camera(), (8, 8))
    with pytest.raises(latelight.UsageError, match="Scene\\(\\) has no options for '.*cube.usda': call latelight.from_usd"):
        latelight.Scene(tmp_path / "cube.usda", up_axis="z")
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(latelight.UsageError, match="requires the package usd-core"):
        latelight.Scene(tmp_path / "cube.usda")


def save_mesh_stage(path):
    """Writes a stage that others can refer to: its default prim is a mesh."""
    Usd = pytest.importorskip("pxr.Usd")
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetDefaultPrim(add_mesh(stage, "/mesh").GetPrim())
    stage.Save()


@pytest.mark.parametrize("convert", [latelight.from_usd, latelight.usd_exposures, latelight.Scene])
def test_missing_usd_files_are_reported(tmp_path, convert):
    with pytest.raises(latelight.InputError, match="missing.usda does not exist"):
        convert(tmp_path / "missing.usda")


def test_files_of_usd_stay_in_its_folder(tmp_path):
    from pxr import Sdf, Usd, UsdShade

    image = pytest.importorskip("PIL.Image")
    (tmp_path / "stage").mkdir()
    save_mesh_stage(tmp_path / "other.usda")
    path = str(tmp_path / "stage" / "stage.usda")
    stage = Usd.Stage.CreateNew(path)
    stage.DefinePrim("/mesh").GetReferences().AddReference("../other.usda")
    stage.Save()
    with pytest.raises(latelight.InputError, match="other.usda, which is outside the scene's folder"):
        latelight.from_usd(path)
    assert latelight.from_usd(path, allow_outside=[tmp_path]).triangle_count == 4
    with pytest.raises(latelight.UsageError, match="is not a folder: allow_outside requires"):
        latelight.from_usd(path, allow_outside=[tmp_path / "none"])
    assert latelight.from_usd(stage).triangle_count == 4  # a stage that the caller composed
    image.fromarray(np.full((2, 2, 3), 9, np.uint8)).save(tmp_path / "paint.png")
    painted = Usd.Stage.CreateNew(str(tmp_path / "stage" / "painted.usda"))
    shader = UsdShade.Shader.Define(painted, "/paint/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    texture = UsdShade.Shader.Define(painted, "/paint/image")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("../paint.png")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(
        texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    )
    bind(painted, shader)
    painted.Save()
    with pytest.raises(latelight.InputError, match="paint.png, which is outside the scene's folder"):
        latelight.from_usd(tmp_path / "stage" / "painted.usda")
    assert len(latelight.from_usd(tmp_path / "stage" / "painted.usda", allow_outside=[tmp_path]).textures()) == 1


@pytest.mark.parametrize("key", ["assetPaths", "manifestAssetPath", "templateAssetPath"])
def test_clips_of_usd_stay_in_its_folder(tmp_path, key):
    """Value clips, which no reference names: a mesh whose points are in another file."""
    from pxr import Gf, Sdf, Usd, UsdGeom, Vt

    (tmp_path / "stage").mkdir()
    for folder, name in ((tmp_path, "clip.1.usda"), (tmp_path / "stage", "clip.1.usda")):
        clip = Usd.Stage.CreateNew(str(folder / name))
        points = UsdGeom.Mesh.Define(clip, "/mesh").CreatePointsAttr()
        for code in (0, 10):
            points.Set([(0, 0, code), (1, 0, code), (0, 1, code)], code)
        clip.Save()
    path = str(tmp_path / "stage" / "stage.usda")
    stage = Usd.Stage.CreateNew(path)
    mesh = UsdGeom.Mesh.Define(stage, "/mesh")
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    inside = Sdf.AssetPath("./clip.1.usda")
    clips = {"primPath": "/mesh", "assetPaths": Sdf.AssetPathArray([inside]), "manifestAssetPath": inside}
    clips |= {"active": Vt.Vec2dArray([Gf.Vec2d(0, 0)]), "times": Vt.Vec2dArray([Gf.Vec2d(0, 0), Gf.Vec2d(10, 10)])}
    mesh.GetPrim().SetMetadata("clips", {"default": clips})
    stage.Save()
    scene = latelight.from_usd(path)
    assert scene.triangle_count == 1 and len(scene.animations) == 1
    outside = {
        "assetPaths": Sdf.AssetPathArray([Sdf.AssetPath("../clip.1.usda")]),
        "manifestAssetPath": Sdf.AssetPath("../clip.1.usda"),
        "templateAssetPath": "../clip.#.usda",
    }
    mesh.GetPrim().SetMetadata("clips", {"default": {**clips, key: outside[key]}})
    stage.Save()
    with pytest.raises(latelight.InputError, match="clip.*usda, which is outside the scene's folder"):
        latelight.from_usd(path)


def test_expressions_of_usd_stay_in_its_folder(tmp_path, monkeypatch):
    """References whose names are computed from variables, also in the folder of the stage."""
    from pxr import Usd

    (tmp_path / "stage").mkdir()
    for folder in (tmp_path, tmp_path / "stage"):
        save_mesh_stage(folder / "other.usda")
    path = str(tmp_path / "stage" / "stage.usda")
    stage = Usd.Stage.CreateNew(path)
    stage.DefinePrim("/mesh").GetReferences().AddReference('`"${FOLDER}/other.usda"`')
    monkeypatch.chdir(tmp_path / "stage")
    stage.GetRootLayer().expressionVariables = {"FOLDER": "."}
    stage.Save()
    assert latelight.from_usd(path).triangle_count == 4
    stage.GetRootLayer().expressionVariables = {"FOLDER": ".."}
    stage.Save()
    with pytest.raises(latelight.InputError, match="other.usda, which is outside the scene's folder"):
        latelight.from_usd(path)
    assert latelight.from_usd(path, allow_outside=[tmp_path]).triangle_count == 4


def test_usd_archives_hold_their_images(tmp_path, device):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, Usd, UsdLux

    (tmp_path / "textures").mkdir()
    image.fromarray(np.full((2, 2, 3), (10, 20, 30), np.uint8)).save(tmp_path / "textures" / "paint.png")
    pixels = bytes((128, 64, 0, 129)) * 2  # RGBE: a value is its byte times 2^(exponent - 136)
    (tmp_path / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + pixels)
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    painted(stage, "textures/paint.png")
    UsdLux.DomeLight.Define(stage, "/sky").CreateTextureFileAttr("sky.hdr")
    stage.Save()

    def pack(name, *files):
        archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / name))
        for file in files:
            archive.AddFile(str(tmp_path / file), file)
        assert archive.Save()

    pack("inner.usdz", "stage.usda", "textures/paint.png", "sky.hdr")
    outer = Usd.Stage.CreateNew(str(tmp_path / "outer.usda"))
    outer.GetRootLayer().subLayerPaths.append("inner.usdz")
    outer.Save()
    pack("outer.usdz", "outer.usda", "inner.usdz")
    for file in ("textures/paint.png", "sky.hdr", "stage.usda"):
        (tmp_path / file).unlink()
    for name in ("inner.usdz", "outer.usdz", "outer.usda"):
        scene = latelight.from_usd(tmp_path / name)
        assert painted_with(scene, tmp_path) == ([10, 20, 30], 10), name
        np.testing.assert_allclose(background(scene, device, (0.3, 0.2, 1)), (1, 0.5, 0), rtol=1e-3)


def test_compressed_images_in_usd_archives_are_refused(tmp_path):
    """USD's archives are not compressed, so that their size bounds what is read from them."""
    import zipfile

    image = pytest.importorskip("PIL.Image")
    from pxr import Usd

    image.fromarray(np.full((99, 99, 3), 9, np.uint8)).save(tmp_path / "paint.bmp")
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    painted(stage, "paint.bmp")
    stage.Save()
    with zipfile.ZipFile(tmp_path / "stage.usdz", "w") as archive:
        archive.write(tmp_path / "stage.usda", "stage.usda")
        archive.write(tmp_path / "paint.bmp", "paint.bmp", zipfile.ZIP_DEFLATED)
    with pytest.raises(latelight.InputError, match="stage.usdz.paint.bmp. is compressed, which USD's archives do not"):
        latelight.from_usd(tmp_path / "stage.usdz")


def test_images_in_archives_outside_are_refused(tmp_path):
    image = pytest.importorskip("PIL.Image")
    from pxr import Sdf, Usd

    (tmp_path / "inside").mkdir()
    image.fromarray(np.full((2, 2, 3), 9, np.uint8)).save(tmp_path / "paint.png")
    archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / "images.usdz"))
    archive.AddFile(str(tmp_path / "paint.png"), "paint.png")
    assert archive.Save()
    stage = Usd.Stage.CreateNew(str(tmp_path / "inside" / "stage.usda"))
    painted(stage, "../images.usdz[paint.png]")
    stage.Save()
    with pytest.raises(latelight.InputError, match="images.usdz, which is outside the scene's folder"):
        latelight.from_usd(tmp_path / "inside" / "stage.usda")
    scene = latelight.from_usd(tmp_path / "inside" / "stage.usda", allow_outside=[tmp_path])
    assert painted_with(scene, tmp_path) == ([9, 9, 9], 9)
