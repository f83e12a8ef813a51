"""Instances and instancers from USD."""

import numpy as np
import pytest

import latelight
from model_checks import Z_UP, assert_bounds, colors_by_node, surface_colors
from usd_stages import add_instancer, add_mesh, add_paint, add_primvar


def test_usd_instances_share_meshes(stage):
    from pxr import Sdf, UsdGeom

    stage.DefinePrim("/proto", "Xform").SetSpecifier(Sdf.SpecifierClass)
    add_mesh(stage, "/proto/leaf")
    for number in range(2):
        tree = UsdGeom.Xform.Define(stage, f"/tree{number}")
        tree.GetPrim().GetReferences().AddInternalReference("/proto")
        tree.GetPrim().SetInstanceable(True)
        UsdGeom.XformCommonAPI(tree).SetTranslate((0, 300 * number, 0))
    grass = UsdGeom.PointInstancer.Define(stage, "/grass")
    blade = add_mesh(stage, "/grass/protos/blade")
    UsdGeom.XformCommonAPI(blade).SetScale((2, 2, 2))
    grass.CreatePrototypesRel().SetTargets(["/grass/protos/blade"])
    grass.CreateProtoIndicesAttr([0, 0, 0])
    grass.CreatePositionsAttr([(0, 0, 100), (0, 0, 200), (0, 0, 300)])
    UsdGeom.Imageable(add_mesh(stage, "/hidden")).MakeInvisible()
    scene = latelight.from_usd(stage)
    assert [node.path for node in scene.nodes] == ["/tree0.leaf", "/tree1.leaf", "/grass.0", "/grass.1", "/grass.2"]
    assert len(scene.meshes()) == 2
    assert_bounds(scene, (0, 0, -4), (4, 3, 0))


def add_native_instances(stage, count):
    """Instances of a prototype with a mesh, one of whose two faces is a subset, and a shape."""
    from pxr import UsdGeom, UsdShade

    stage.CreateClassPrim("/kind")
    mesh = add_mesh(stage, "/kind/squares")
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, "right", UsdGeom.Tokens.face, [1], "materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(add_paint(stage, "/kind/paint", (0, 0.25, 0)))
    UsdGeom.Cube.Define(stage, "/kind/cube")
    instances = []
    for number in range(count):
        instances.append(UsdGeom.Xform.Define(stage, f"/copy{number}").GetPrim())
        instances[-1].GetInherits().AddInherit("/kind")
        instances[-1].SetInstanceable(True)
    return instances


@pytest.mark.parametrize("strength", ["weakerThanDescendants", "strongerThanDescendants"])
def test_usd_instances_have_their_own_materials(stage, strength):
    """USD's bindings, of instances in the same prototype, whose meshes are shared."""
    from pxr import UsdShade

    paints = {"/red": (0.5, 0, 0), "/blue": (0, 0, 0.75), "/kind/paint": (0, 0.25, 0)}
    instances = add_native_instances(stage, 3)
    for prim, path in zip(instances, ("/red", "/blue")):
        material = add_paint(stage, path, paints[path])
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, strength)
    assert len({prim.GetPrototype() for prim in instances}) == 1
    scene = latelight.from_usd(stage)
    assert len(scene.meshes()) == 3  # two of the faces, and the cube
    expected = {}
    for number in range(3):
        for name, parts in (("squares", ["squares/right", "squares"]), ("cube", ["cube"])):
            prims = [stage.GetPrimAtPath(f"/copy{number}/{part}") for part in parts]
            bound = [str(UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath()) for prim in prims]
            colors = [paints.get(path.replace(f"/copy{number}", "/kind"), (0.8, 0.8, 0.8)) for path in bound]
            expected[f"/copy{number}.{name}"] = [(*color, 1) for color in colors]
    assert colors_by_node(scene) == expected


def test_usd_instances_have_their_own_display_colors(stage):
    """Primvars that an instance states are inherited by what it shows, which shares the meshes nevertheless."""
    from pxr import Sdf, UsdGeom

    instances = add_native_instances(stage, 4)
    for number, color in ((0, (1, 0, 0)), (1, (0, 0, 1)), (3, (1, 0, 0))):
        UsdGeom.PrimvarsAPI(instances[number]).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray).Set([color])
    UsdGeom.PrimvarsAPI(instances[1]).CreatePrimvar("displayOpacity", Sdf.ValueTypeNames.FloatArray).Set([0.5])
    scene = latelight.from_usd(stage)
    own = [(1, 0, 0, 1), (0, 0, 1, 0.5), (0.8, 0.8, 0.8, 1), (1, 0, 0, 1)]
    squares = {f"/copy{n}.squares": [(0, 0.25, 0, 1), color] for n, color in enumerate(own)}
    assert colors_by_node(scene) == {**squares, **{f"/copy{n}.cube": [color] for n, color in enumerate(own)}}
    modes = [scene.material(scene.instance(i).material).alpha_mode for i in scene.instances("/copy1.cube")]
    assert modes == ["blend"]
    assert len(scene.meshes()) == 3 and len(scene.materials()) == 4  # paint, red, blue and the default


def add_kind(stage, path):
    """A shown cube, a hidden one, a guide with a cube that is meant for rendering, a proxy, and an instance."""
    from pxr import Sdf, UsdGeom

    for name in ("shown", "hidden", "guide/guide", "guide/rendered", "proxy/coarse"):
        UsdGeom.Cube.Define(stage, f"{path}/{name}")
    UsdGeom.Imageable(stage.GetPrimAtPath(f"{path}/hidden")).MakeInvisible()
    for name, purpose in (("guide", "guide"), ("guide/rendered", "render"), ("proxy", "proxy")):
        prim = stage.GetPrimAtPath(f"{path}/{name}")
        prim.SetTypeName("Cube" if "/" in name else "Xform")
        UsdGeom.Imageable(prim).CreatePurposeAttr(purpose)
    UsdGeom.Sphere.Define(stage, "/library/ball").CreateRadiusAttr(3)
    stage.GetPrimAtPath("/library").SetSpecifier(Sdf.SpecifierOver)
    instance = stage.DefinePrim(f"{path}/instance", "Xform")
    instance.GetReferences().AddInternalReference("/library")
    instance.SetInstanceable(True)


def shown_by(stage):
    """The sizes of the instances of a stage, and where they are, in units of the stage."""
    scene = latelight.from_usd(stage)
    found = []
    for instance in map(scene.instance, scene.instances()):
        matrix = 100 * np.linalg.inv(Z_UP) @ np.asarray(instance.transform)  # from meters and Y up
        size = np.ptp(scene.mesh_arrays(instance.mesh)["positions"] @ matrix[:3, :3].T, axis=0).max()
        found.append((round(float(size), 3), tuple((np.round(matrix[:3, 3], 3) + 0.0).tolist())))
    return sorted(found)


def test_usd_instancers_show_what_is_visible_in_their_prototypes(stage, capfd):
    add_kind(stage, "/kind")
    direct = [(2, (0, 0, 0)), (2, (0, 0, 0)), (6, (0, 0, 0))]  # the shown cube, the rendered one and the instance
    assert shown_by(stage) == direct
    stage.RemovePrim("/kind")
    add_instancer(stage, "/copies", ["/copies/kind"])
    add_kind(stage, "/copies/kind")
    assert shown_by(stage) == sorted(direct + [(size, (30, 0, 0)) for size, _ in direct])
    output = capfd.readouterr()
    assert (output.out, output.err) == ("", "")


def test_usd_copies_of_instancers_have_colors(stage):
    """Values per copy apply by the number of the copy, also after a masked one, and share the meshes. They replace what a
    prototype inherits, and a prototype's own color replaces them."""
    from pxr import UsdGeom

    positions = [(10 * n, 0, 0) for n in range(4)]
    copies = add_instancer(stage, "/group/copies", ["/group/copies/plain", "/group/copies/own"], positions, [0, 0, 1, 0])
    copies.InvisId(1, 0)
    UsdGeom.Cube.Define(stage, "/group/copies/plain")
    UsdGeom.Cube.Define(stage, "/group/copies/own/cube")
    for path, color in (("/group", (0.5, 0.5, 0.5)), ("/group/copies/own", (1, 1, 0))):
        add_primvar(stage.GetPrimAtPath(path), "displayColor", "Color3fArray", "constant", [color])
    colors = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0.25, 0)]
    add_primvar(copies, "displayColor", "Color3fArray", "vertex", colors)
    add_primvar(copies, "displayOpacity", "FloatArray", "varying", [0.5, 1, 0.25, 1])
    scene = latelight.from_usd(stage)
    expected = {"0": [(1, 0, 0, 0.5)], "2": [(1, 1, 0, 0.25)], "3": [(0, 0.25, 0, 1)]}
    assert colors_by_node(scene) == {f"/group.copies.{n}": color for n, color in expected.items()}
    modes = [scene.material(scene.instance(handle).material).alpha_mode for handle in scene.instances()]
    assert modes == ["blend", "blend", "opaque"] and len(scene.meshes()) == 2
    add_primvar(copies, "displayColor", "Color3fArray", "vertex", colors[:3])  # too few, but they end the inheritance
    cube = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/group/copies/plain"))
    assert not cube.FindPrimvarWithInheritance("displayColor")
    first, _, last = colors_by_node(latelight.from_usd(stage)).values()
    assert first == [(0.8, 0.8, 0.8, 0.5)] and last == [(0.8, 0.8, 0.8, 1)]


def test_usd_copies_of_nested_instancers_have_colors(stage):
    """The innermost instancer with values per copy counts."""
    from pxr import UsdGeom

    forest = add_instancer(stage, "/forest", ["/forest/tree"])
    tree = add_instancer(stage, "/forest/tree", ["/forest/tree/leaf"], [(1, 0, 0), (2, 0, 0)])
    UsdGeom.Cube.Define(stage, "/forest/tree/leaf")
    add_primvar(forest, "displayColor", "Color3fArray", "vertex", [(1, 0, 0), (0, 0, 1)])
    add_primvar(forest, "displayOpacity", "FloatArray", "vertex", [0.5, 1])
    by_forest = [(1, 0, 0, 0.5)] * 2 + [(0, 0, 1, 1)] * 2
    assert sum(colors_by_node(latelight.from_usd(stage)).values(), []) == by_forest
    add_primvar(tree, "displayColor", "Color3fArray", "vertex", [(0, 1, 0), (0.5, 0, 0)])
    by_both = [(0, 1, 0, 0.5), (0.5, 0, 0, 0.5), (0, 1, 0, 1), (0.5, 0, 0, 1)]
    assert sum(colors_by_node(latelight.from_usd(stage)).values(), []) == by_both


@pytest.mark.parametrize("moving", ["copies", "parent"])
def test_usd_copies_that_move_have_colors(stage, moving):
    from pxr import UsdGeom

    copies = add_instancer(stage, "/group/copies", ["/group/copies/cube"])
    UsdGeom.Cube.Define(stage, "/group/copies/cube")
    add_primvar(copies, "displayColor", "Color3fArray", "vertex", [(1, 0, 0), (0, 0, 1)])
    if moving == "copies":
        copies.GetPositionsAttr().Set([(0, 0, 0), (9, 0, 0)], 0)
        copies.GetPositionsAttr().Set([(0, 0, 0), (9, 9, 0)], 24)
    else:
        shift = UsdGeom.Xformable(stage.DefinePrim("/group", "Xform")).AddTranslateOp()
        shift.Set((0, 0, 0), 0)
        shift.Set((5, 0, 0), 24)
    scene = latelight.from_usd(stage)
    colors = [surface_colors(scene, scene.instance(handle))[0].tolist() for handle in scene.instances()]
    assert scene.animations and colors == [[1, 0, 0, 1], [0, 0, 1, 1]]


@pytest.mark.parametrize("hidden_by", ["over", "class", "visibility", "purpose"])
@pytest.mark.parametrize("folder", ["/copies/kinds", "/kinds"])
def test_usd_prototypes_may_be_hidden_outside_of_instancers(stage, hidden_by, folder):
    """As in UsdImaging: neither the visibility nor the purpose above a prototype counts, and it may be undefined."""
    from pxr import Sdf, UsdGeom

    kinds = UsdGeom.Scope.Define(stage, folder)
    add_instancer(stage, "/copies", [f"{folder}/kind"])
    cube = UsdGeom.Cube.Define(stage, f"{folder}/kind")
    if hidden_by in ("over", "class"):
        kinds.GetPrim().SetSpecifier(Sdf.SpecifierOver if hidden_by == "over" else Sdf.SpecifierClass)
    elif hidden_by == "visibility":
        kinds.MakeInvisible()
    else:
        kinds.CreatePurposeAttr("guide")
    assert shown_by(stage) == [(2, (0, 0, 0)), (2, (30, 0, 0))]
    cube.CreateVisibilityAttr("invisible")  # that of the prototype itself counts
    assert shown_by(stage) == []


def test_usd_instancers_may_be_nested(stage):
    from pxr import UsdGeom

    add_instancer(stage, "/forest", ["/forest/tree"])
    tree = add_instancer(stage, "/forest/tree", ["/forest/tree/leaf"], [(1, 0, 0), (2, 0, 0)])
    UsdGeom.XformCommonAPI(tree).SetTranslate((0, 10, 0))
    UsdGeom.XformCommonAPI(UsdGeom.Cube.Define(stage, "/forest/tree/leaf")).SetTranslate((0, 0, 5))
    expected = [(2, (x, 10, 5)) for x in (1, 2, 31, 32)]
    assert shown_by(stage) == expected
    positions = [(0, 0, 0), (9, 9, 9), (30, 0, 0)]
    add_instancer(stage, "/forest", ["/forest/tree", "/missing"], positions, [0, 1, 0])
    assert shown_by(stage) == expected


def test_usd_instancers_that_cannot_be_shown_are_refused(stage):
    from pxr import UsdGeom

    UsdGeom.Cube.Define(stage, "/copies/kind")
    for indices in ([0, 1], [-1, 0]):
        add_instancer(stage, "/copies", ["/copies/kind"], indices=indices)
        with pytest.raises(latelight.UsageError, match="/copies has copies of prototypes that it does not have: it has 1"):
            latelight.from_usd(stage)
    add_instancer(stage, "/copies", ["/copies"])
    with pytest.raises(latelight.UsageError, match="/copies is an instancer within its own prototypes"):
        latelight.from_usd(stage)


def test_small_usd_files_of_nested_instancers_end(stage, monkeypatch):
    """Each of 40 instancers shows a copy of each of the next two: 2.7e8 paths lead from the first to the last one."""
    from pxr import Sdf, UsdGeom

    monkeypatch.setattr("latelight._usd.instancers._MAX_PARTS", 1000)
    for level in range(40):
        below = [f"/levels/n{level + 1}", f"/levels/n{level + 2}"]
        add_instancer(stage, f"/levels/n{level}", below, indices=[0, 1])
    stage.GetPrimAtPath("/levels").SetSpecifier(Sdf.SpecifierClass)
    add_instancer(stage, "/copies", ["/levels/n0"])
    assert shown_by(stage) == []
    UsdGeom.Cube.Define(stage, "/levels/n40")
    stage.GetPrimAtPath("/levels").SetSpecifier(Sdf.SpecifierClass)
    with pytest.raises(latelight.UsageError, match="the instancers in /levels/n.* show more than 1000 prims"):
        latelight.from_usd(stage)
