"""Damaged URDF and USD files are converted, or rejected by one sentence that names the file (exit code 3)."""

import os
import random
import re
import resource

import pytest
from model_checks import URDF

import latelight

USD = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 0.01
)
def Xform "a" {
    double3 xformOp:translate = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "m" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
        rel material:binding = </p>
    }
    def SphereLight "l" {
        float inputs:radius = 2
        float inputs:intensity = 100
    }
    def DistantLight "d" {
        float inputs:angle = 2
    }
    def RectLight "r" (prepend apiSchemas = ["ShadowAPI"]) {
        float inputs:width = 3
        bool inputs:normalize = 1
        bool inputs:shadow:enable = 0
    }
    def SphereLight "spot" (prepend apiSchemas = ["ShapingAPI"]) {
        float inputs:exposure = 2
        float inputs:shaping:cone:angle = 30
    }
    def DomeLight "sky" {
        float3 xformOp:scale = (1, -1, 2)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
    def Camera "c" {
        float focalLength = 20
        token projection = "perspective"
        float3 xformOp:scale.timeSamples = { 0: (1, 1, 0), 2: (1, -1, 1) }
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
}
def Mesh "w" {
    point3f[] points.timeSamples = {
        0: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        4: [(0, 0, 1), (1, 0, 0), (1, 1, 2), (0, 1, 0)],
    }
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
}
def PointInstancer "i" {
    int[] protoIndices = [0, 1]
    rel prototypes = [</i/k>, </i/s>]
    point3f[] positions.timeSamples = { 0: [(0, 0, 0), (9, 0, 0)], 3: [(0, 5, 0), (9, 0, 5)] }
    quath[] orientations = [(1, 0, 0, 0), (0, 1, 0, 0)]
    def Cube "k" {
        double size = 2
    }
    def Sphere "s" {
        double radius.timeSamples = { 0: 1, 2: 2 }
    }
}
class "far" {
    def PointInstancer "n" {
        int[] protoIndices = [0, 0]
        rel prototypes = [</i/k>]
        point3f[] positions = [(0, 0, 0), (9, 0, 0)]
    }
}
def PointInstancer "o" {
    int[] protoIndices = [0, 0]
    rel prototypes = [</far/n>]
    point3f[] positions = [(0, 9, 0), (0, 0, 9)]
}
def Material "p" {
    token outputs:surface.connect = </p/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0)
        float inputs:roughness = 0.5
        token outputs:surface
    }
}
"""
WORDS = ["1000000000", "-1", "nan", "inf", "1e999", "4294967295", "../../etc/passwd", "/dev/zero", "-9" * 10]
WORDS += ["", "[", "(", "<a/>", "&x;", "token", "float", "]"]


def damaged(text, choose):
    at = choose.randrange(len(text))
    kind = choose.randrange(5)
    if kind == 0:
        return text[:at]
    if kind == 1:
        return text[:at] + chr(choose.randrange(1, 127)) + text[at + 1 :]
    if kind == 2:  # a number or name becomes another one
        word = choose.choice(list(re.finditer(r"[A-Za-z0-9_.\-/]+", text)) or [re.match("", text)])
        return text[: word.start()] + choose.choice(WORDS) + text[word.end() :]
    if kind == 3:  # a range is repeated
        return text[:at] + text[at : at + choose.randrange(64)] + text[at:]
    return text[:at] + text[at + choose.randrange(32) :]


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # numbers that overflow
@pytest.mark.filterwarnings("ignore:from_usd reads the time samples")
@pytest.mark.parametrize("ending, text, package", [("urdf", URDF, "yourdfpy"), ("usda", USD, "pxr.Usd")])
def test_damaged_files_are_rejected(tmp_path, ending, text, package):
    pytest.importorskip(package)
    count = 10_000 if os.environ.get("LATELIGHT_TEST_ALL", "0") not in ("", "0") else 200
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    loaded = rejected = 0
    for i in range(count):
        choose, broken = random.Random(i), text
        for _ in range(choose.randrange(1, 4)):
            broken = damaged(broken, choose) or " "
        path = tmp_path / f"{i}.{ending}"  # usd-core remembers the files that it has opened
        path.write_text(broken)
        try:
            loaded += latelight.Scene(path).triangle_count > 0
        except latelight.InputError as error:
            rejected += 1
            assert str(path) in str(error) and "\n" not in str(error), f"{i}: {error}"
        path.unlink()
    assert loaded > count / 50 and rejected > count / 50
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 500_000  # kilobytes
