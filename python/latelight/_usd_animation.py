"""Animations of USD stages: nodes, skins and keyframes for what has time samples.

Transforms are sampled where their attributes have samples, and keys are added between them until the interpolated
transforms follow the stage's, since USD interpolates the operations of a transform, such as angles, and glTF its
translation, rotation and scale. Joints and weights of blend shapes are interpolated in the same way by both. Points
are blended between a morph target per sample, and the copies of an instancer are nodes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ._core import AnimationChannel, MaterialHandle, MeshHandle, Scene, SkinHandle
from ._model_builder import node_name
from .errors import UsageError

Parts = Sequence[tuple[MeshHandle, MaterialHandle]]

# Attributes, by the type of their prim, that are read once, at the first time.
_READ_ONCE = {
    "Gprim": ("radius", "height", "size", "axis", "width", "length", "radiusTop", "radiusBottom", "orientation")
    + ("faceVertexCounts", "faceVertexIndices", "holeIndices", "primvars:displayColor")
    + ("primvars:st", "primvars:UVMap", "primvars:st0"),
    "Camera": ("focalLength", "horizontalAperture", "verticalAperture", "horizontalApertureOffset", "projection")
    + ("verticalApertureOffset",),
    "Subset": ("indices",),
}

_TOLERANCE = 1e-4  # of interpolated transforms: radians and relative scale, and of the path that translations cover
_FRACTIONS = (0.29, 0.5, 0.83)  # of intervals, where interpolated transforms are compared with the stage's
_FLAT = 1e-13  # relative length of an axis of a transform whose direction is rounding
_DEEPEST = 10  # halvings of an interval between samples


class Motion:
    """The animation of a stage under construction. `frame`: from the stage to the scene."""

    def __init__(self, stage: Any, pxr: Any, scene: Scene, frame: np.ndarray, prims: Sequence[Any]) -> None:
        self.stage, self.pxr, self.scene, self.frame = stage, pxr, scene, frame
        self.channels: list[AnimationChannel] = []
        self.nodes: dict[Any, str] = {}
        self.joints: dict[Any, list[str]] = {}
        self.animated: dict[Any, bool] = {}
        self.held = stage.GetInterpolationType() == pxr.Usd.InterpolationTypeHeld
        self.unplayed: list[str] = []  # paths of attributes with samples that are read once
        samples = sorted({time for prim in prims for time in self.samples_of(prim)})
        self.exists = len(samples) > 0
        samples = sorted({*samples, *(time for prim in prims for time in self.samples_read_once(prim))})
        if stage.HasAuthoredTimeCodeRange():
            samples = [stage.GetStartTimeCode(), stage.GetEndTimeCode()]
        self.start, self.end = (samples[0], samples[-1]) if samples else (0.0, 0.0)

    def finish(self) -> None:
        if self.channels:
            self.scene.add_animation("stage", self.channels)
        if unplayed := list(dict.fromkeys(self.unplayed)):
            named, others = ", ".join(unplayed[:3]), len(unplayed) - 3
            if others > 0:
                named += f" and {others} others"
            warnings.warn(
                f"from_usd reads the time samples of {named} only at the time code {self.start:g}: animations do not "
                "include them",
                stacklevel=2,
            )

    # --- time samples ---

    def samples_of(self, prim: Any) -> list[float]:
        """The times at which the prim's own transform, its visibility, its points as a mesh, its copies as an
        instancer, or its pose as an animation of a skeleton changes."""
        geom, skel = self.pxr.UsdGeom, self.pxr.UsdSkel
        times: list[float] = []
        if (form := geom.Xformable(prim)) and form.TransformMightBeTimeVarying():
            times += form.GetTimeSamples()
        if (seen := geom.Imageable(prim)) and seen.GetVisibilityAttr().ValueMightBeTimeVarying():
            times += seen.GetVisibilityAttr().GetTimeSamples()
        times += self.samples_of_points(prim) + self.samples_of_copies(prim)
        if pose := skel.Animation(prim):
            for attribute in (
                pose.GetTranslationsAttr(),
                pose.GetRotationsAttr(),
                pose.GetScalesAttr(),
                pose.GetBlendShapeWeightsAttr(),
            ):
                if attribute.ValueMightBeTimeVarying():
                    times += attribute.GetTimeSamples()
        return times

    def samples_of_points(self, prim: Any) -> list[float]:
        """The times at which the points of a mesh change, or their normals."""
        mesh = self.pxr.UsdGeom.Mesh(prim)
        return _samples((mesh.GetPointsAttr(), *normals_of(mesh, self.pxr))) if mesh else []

    def samples_of_copies(self, prim: Any, fewest: int = 2) -> list[float]:
        """The times at which the transforms of the copies of an instancer change: those of attributes with that many
        samples."""
        copies = self.pxr.UsdGeom.PointInstancer(prim)
        if not copies:
            return []
        names = ("positions", "orientations", "orientationsf", "scales", "velocities", "angularVelocities")
        return sorted(_samples([prim.GetAttribute(name) for name in names], fewest))

    def samples_read_once(self, prim: Any) -> list[float]:
        """The times of all other values that change. Their attributes are noted."""
        geom, shade = self.pxr.UsdGeom, self.pxr.UsdShade
        is_shading = prim.IsA(shade.Shader) or prim.IsA(shade.NodeGraph) or prim.HasAPI(self.pxr.UsdLux.LightAPI)
        names = [name for kind, read in _READ_ONCE.items() if prim.IsA(getattr(geom, kind)) for name in read]
        attributes = [
            attribute
            for attribute in prim.GetAuthoredAttributes()
            if (attribute.GetName() in names or (is_shading and attribute.GetName().startswith("inputs:")))
            and attribute.ValueMightBeTimeVarying()
        ]
        self.unplayed += [str(attribute.GetPath()) for attribute in attributes]
        return _samples(attributes)

    def clipped(self, times: Sequence[float]) -> list[float]:
        """The times within the stage's range, and its ends if there are any outside."""
        return sorted({min(max(float(time), self.start), self.end) for time in times})

    def seconds(self, times: Sequence[float]) -> np.ndarray:
        return (np.asarray(times) - self.start) / self.stage.GetTimeCodesPerSecond()

    def moves(self, prim: Any) -> bool:
        """True if the transform of the prim or of a parent changes over time, or its visibility."""
        if not self.exists or not prim or prim.IsPseudoRoot():
            return False
        path = prim.GetPath()
        if path not in self.animated:
            geom = self.pxr.UsdGeom
            form, seen = geom.Xformable(prim), geom.Imageable(prim)
            self.animated[path] = bool(
                (form and form.TransformMightBeTimeVarying())
                or (seen and seen.GetVisibilityAttr().ValueMightBeTimeVarying())
                or (not (form and form.GetResetXformStack()) and self.moves(prim.GetParent()))
            )
        return self.animated[path]

    def moves_below(self, prim: Any, above: Any) -> bool:
        """True if the transform of the prim changes over time relative to one of its parents."""
        while prim != above:
            form = self.pxr.UsdGeom.Xformable(prim)
            if form and form.TransformMightBeTimeVarying():
                return True
            prim = prim.GetParent()
        return False

    # --- nodes ---

    def add_channel(self, node: str, kind: str, times: Sequence[float], values: Any, steps: bool = False) -> None:
        self.channels.append(
            AnimationChannel(
                node=node,
                property=kind,
                interpolation="step" if steps or self.held else "linear",
                times=self.seconds(times),
                values=np.asarray(values, np.float32),
            )
        )

    def node_of(self, prim: Any, parts: Parts = (), weights: Sequence[float] = ()) -> str:
        """The node of a prim, below those of its parents. It is created once, with the parts that it then shows."""
        if prim.IsPseudoRoot():
            if prim.GetPath() not in self.nodes:
                self.nodes[prim.GetPath()] = self.scene.add_node("stage", matrix=self.frame)
            return self.nodes[prim.GetPath()]
        path = prim.GetPath()
        if path not in self.nodes:
            form = self.pxr.UsdGeom.Xformable(prim)
            above = self.stage.GetPseudoRoot() if form and form.GetResetXformStack() else prim.GetParent()
            parent, name = self.node_of(above), node_name(prim.GetName())
            common: Any = {"name": name, "parent": parent, "parts": parts, "weights": weights}
            if form and form.TransformMightBeTimeVarying():
                self.nodes[path] = self.moving_nodes(
                    [common], self.clipped(form.GetTimeSamples()), lambda time: _local(form, time)[None], path
                )[0]
            else:
                self.nodes[path] = self.scene.add_node(matrix=_local(form, self.start) if form else np.eye(4), **common)
            self.show(self.nodes[path], prim)
        return self.nodes[path]

    def visibility_times(self, prim: Any) -> list[float]:
        """The times at which the visibility of the prim or of a parent changes; none if it does not."""
        times: list[float] = []
        while self.exists and prim and not prim.IsPseudoRoot():
            seen = self.pxr.UsdGeom.Imageable(prim)
            if seen and seen.GetVisibilityAttr().ValueMightBeTimeVarying():
                times += seen.GetVisibilityAttr().GetTimeSamples()
            prim = prim.GetParent()
        return self.clipped([self.start, *times]) if times else []

    def is_visible(self, prim: Any, time: Any) -> bool:
        seen = self.pxr.UsdGeom.Imageable(prim)
        return bool(seen.ComputeVisibility(time) != self.pxr.UsdGeom.Tokens.invisible)

    def show(self, node: str, prim: Any) -> None:
        """Adds the visibility of a prim, including that of its parents, to the node that shows it."""
        if times := self.visibility_times(prim):
            self.add_channel(node, "visible", times, [[self.is_visible(prim, time)] for time in times], steps=True)

    def moving_nodes(
        self, nodes: Sequence[Any], times: Sequence[float], matrices: Callable[[float], np.ndarray], path: Any
    ) -> list[str]:
        """Adds nodes whose transforms are `matrices` of a time, (n, 4, 4). A node may name the number of an earlier one
        as its parent."""
        times, keys = self.keys(times, matrices, path)
        made: list[str] = []
        for i, node in enumerate(nodes):
            parent = made[node["parent"]] if isinstance(node["parent"], int) else node["parent"]
            first = {name: values[0, i] for name, values in keys.items()}
            made.append(self.scene.add_node(**{**node, "parent": parent}, **first))
            for kind, values in keys.items():
                if np.ptp(values[:, i], axis=0).max() > 0:
                    self.add_channel(made[-1], kind, times, values[:, i])
        return made

    def keys(
        self, times: Sequence[float], matrices: Callable[[float], np.ndarray], path: Any
    ) -> tuple[list[float], dict[str, np.ndarray]]:
        """Times, and the translations, rotations and scales at them, (times, n, 3 or 4)."""
        known = {time: _decomposed(matrices(time), path, time) for time in times}
        reach = max(float(np.ptp([t for t, _, _ in known.values()], axis=0).max()), 1e-30)
        pending = [] if self.held else [(a, b, 0) for a, b in zip(times, times[1:])]
        while pending:
            begin, end, depth = pending.pop()
            if depth < _DEEPEST and not self.follows(known, begin, end, matrices, reach):
                middle = (begin + end) / 2
                known[middle] = _decomposed(matrices(middle), path, middle)
                pending += [(begin, middle, depth + 1), (middle, end, depth + 1)]
        order = sorted(known)
        stacked = [np.stack([known[time][i] for time in order]) for i in range(3)]
        return order, dict(zip(("translation", "rotation", "scale"), stacked))

    def follows(
        self, known: Any, begin: float, end: float, matrices: Callable[[float], np.ndarray], reach: float
    ) -> bool:
        """True if the transforms interpolated between two keys are those of the stage."""
        for fraction in _FRACTIONS:
            exact = matrices(begin + fraction * (end - begin))
            error = np.abs(_composed(*_between(known[begin], known[end], fraction)) - exact)
            size = np.maximum(np.abs(exact[:, :3, :3]).max(axis=(1, 2)), 1e-30)
            turned = (error[:, :3, :3].max(axis=(1, 2)) > _TOLERANCE * size).any()
            if turned or error[:, :3, 3].max() > _TOLERANCE * reach:
                return False
        return True

    # --- skeletons ---

    def add_joints(self, query: Any) -> list[str]:
        """The nodes of the joints of a skeleton, below that of the skeleton."""
        prim = query.GetPrim()
        if prim.GetPath() not in self.joints:
            topology, names = query.GetTopology(), query.GetJointOrder()
            base = self.node_of(prim)
            nodes: list[Any] = []
            for i, name in enumerate(names):
                above = topology.GetParent(i)
                nodes.append({"name": node_name(str(name).rpartition("/")[2]), "parent": base if above < 0 else above})
            animation = query.GetAnimQuery()
            times = animation.GetJointTransformTimeSamples() if animation else []
            self.joints[prim.GetPath()] = self.moving_nodes(
                nodes,
                self.clipped([self.start, *times]),
                lambda time: np.array(query.ComputeJointLocalTransforms(time), np.float64).transpose(0, 2, 1),
                prim.GetPath(),
            )
        return self.joints[prim.GetPath()]

    def add_skin(self, skinning: Any, query: Any, path: Any) -> SkinHandle:
        """The joints of a mesh, in its order."""
        nodes, where = self.add_joints(query), joint_order(skinning, query, path)
        binds = query.GetSkeleton().GetBindTransformsAttr().Get() or []
        if len(binds) != len(nodes):
            raise UsageError(f"{query.GetPrim().GetPath()} has {len(nodes)} joints but {len(binds)} bind transforms")
        geometry = np.array(skinning.GetGeomBindTransform(self.start), np.float64).T
        inverse = np.linalg.inv(np.array(binds, np.float64).transpose(0, 2, 1)) @ geometry
        inverse[:, 3] = (0, 0, 0, 1)
        return self.scene.add_skin([nodes[i] for i in where], inverse[where])

    # --- blend shapes ---

    def weights_of(self, animation: Any, mapper: Any, shapes: Any) -> tuple[list[float], np.ndarray]:
        """Times, and the weights of all shapes and in-betweens at them. Between two samples a weight is linear, and
        that of an in-between is linear between the weights of its neighbors, so that keys are added where a weight
        passes one."""

        def own(time: float) -> Any:
            weights = animation.ComputeBlendShapeWeights(time)
            return mapper.Remap(weights) if mapper else weights

        times = self.clipped([self.start, *animation.GetBlendShapeWeightTimeSamples()])
        passed: set[float] = set()
        stops: dict[int, set[float]] = {}
        for part in range(shapes.GetNumSubShapes()):
            if between := shapes.GetInbetween(part):
                stops.setdefault(shapes.GetBlendShapeIndex(part), {0.0, 1.0}).add(float(between.GetWeight()))
        for begin, end in zip(times, times[1:]) if not self.held else ():
            first, last = own(begin), own(end)
            for shape, weights in stops.items():
                a, b = first[shape], last[shape]
                passed |= {begin + (end - begin) * (w - a) / (b - a) for w in weights if min(a, b) < w < max(a, b)}
        times = sorted({*times, *passed})
        table = np.zeros((len(times), shapes.GetNumSubShapes()), np.float32)
        for row, time in zip(table, times):
            for weight, _, part in zip(*shapes.ComputeSubShapeWeights(own(time))):
                row[part] += weight
        return times, table


def normals_of(mesh: Any, pxr: Any) -> list[Any]:
    """The attributes that may hold a mesh's normals; the primvar comes first."""
    return [pxr.UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals").GetAttr(), mesh.GetNormalsAttr()]


def _samples(attributes: Iterable[Any], fewest: int = 2) -> list[float]:
    return [time for a in attributes if a and a.GetNumTimeSamples() >= fewest for time in a.GetTimeSamples()]


def joint_order(skinning: Any, query: Any, path: Any) -> list[int]:
    """The joints of a mesh as indices into those of its skeleton."""
    names, order = [str(name) for name in query.GetJointOrder()], skinning.GetJointOrder()
    own = names if order is None else [str(name) for name in order]
    if not set(own) <= set(names):
        raise UsageError(f"{path} has joints that its skeleton does not have")
    return [names.index(name) for name in own]


def _local(form: Any, time: float) -> np.ndarray:
    return np.array(form.GetLocalTransformation(time), np.float64).T  # USD's vectors are rows


def _quaternions(rotations: np.ndarray) -> np.ndarray:
    """Quaternions x, y, z, w of rotation matrices (n, 3, 3). Each row of the matrix below is a multiple of the
    quaternion; the one with the largest diagonal element is the most precise."""
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(rotations, 0, -1)
    rows = np.array(
        [
            [1 + a - e - i, d + b, c + g, h - f],
            [d + b, 1 - a + e - i, h + f, c - g],
            [c + g, h + f, 1 - a - e + i, d - b],
            [h - f, c - g, d - b, 1 + a + e + i],
        ]
    )
    best = np.argmax(np.stack([rows[k, k] for k in range(4)]), axis=0)
    chosen: np.ndarray = rows[best, :, np.arange(len(rotations))]
    return chosen / np.linalg.norm(chosen, axis=1, keepdims=True)


def unsheared(matrices: np.ndarray) -> np.ndarray:
    """Transforms (n, 4, 4) by a translation, a rotation and a scale that are close to the given ones. Those of
    instancers are not exactly such, because their quaternions have half precision."""
    return _composed(*_parts(matrices))


def axes_of(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rotations (n, 3, 3) and scales (n, 3) whose product are the axes of transforms (n, 4, 4). The first scale is
    negative if a transform mirrors. The axes of a rotation are not perpendicular if a transform shears."""
    axes = matrices[:, :3, :3]
    scales = np.linalg.norm(axes, axis=1)
    flat = scales <= _FLAT * scales.max(axis=1, keepdims=True)
    scales[:, 0] *= np.where((np.linalg.det(axes) < 0) & ~flat.any(axis=1), -1, 1)
    return _completed(axes / np.where(flat, 1, scales)[:, None, :], flat), scales


def _parts(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The translations, rotations and scales of transforms (n, 4, 4) without shear."""
    rotations, scales = axes_of(matrices)
    return matrices[:, :3, 3], _quaternions(rotations), scales


def _completed(rotations: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3), of which a scale of zero left the axes that are flat (n, 3) without a direction. One follows
    from the other two, two are any that are perpendicular to the third, and three are those of the identity."""
    rotations, flat = rotations.copy(), flat.copy()
    rotations[flat.all(axis=1)] = np.eye(3)
    flat[flat.all(axis=1)] = False
    (line,) = np.nonzero(flat.sum(axis=1) == 2)
    known = np.argmin(flat[line], axis=1)
    axis, following = rotations[line, :, known], (known + 1) % 3
    steep = np.abs(axis[np.arange(len(line)), following]) < 0.9
    other = np.eye(3)[np.where(steep, following, (known + 2) % 3)]
    other -= np.sum(other * axis, axis=1, keepdims=True) * axis
    rotations[line, :, following] = other / np.linalg.norm(other, axis=1, keepdims=True)
    flat[line, following] = False
    (plane,) = np.nonzero(flat.any(axis=1))
    last = np.argmax(flat[plane], axis=1)
    first, second = (rotations[plane, :, (last + step) % 3] for step in (1, 2))
    rotations[plane, :, last] = np.cross(first, second)
    return rotations


def _decomposed(matrices: np.ndarray, path: Any, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Translations, rotations and scales of transforms (n, 4, 4). Shear is an error."""
    axes, parts = matrices[:, :3, :3], _parts(matrices)
    error = np.abs(_composed(*parts) - matrices)[:, :3, :3].max(axis=(1, 2))
    if (error > 1e-5 * np.maximum(np.abs(axes).max(axis=(1, 2)), 1e-30)).any():
        raise UsageError(
            f"{path} is sheared at the time code {time:g}, which animations of a translation, a rotation and a scale "
            "cannot be: give a time, at which the stage is then converted"
        )
    return parts


def _composed(translations: np.ndarray, rotations: np.ndarray, scales: np.ndarray) -> np.ndarray:
    x, y, z, w = np.moveaxis(rotations, -1, 0)
    matrices = np.zeros((len(scales), 4, 4))
    matrices[:, 3, 3] = 1
    matrices[:, :3, 3] = translations
    matrices[:, :3, :3] = np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        ),
        -1,
        0,
    ) * scales[:, None, :]
    return matrices


def _between(first: Any, last: Any, fraction: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Interpolates as glTF does: rotations along the shorter arc at constant speed."""
    (t0, q0, s0), (t1, q1, s1) = first, last
    cosine = np.sum(q0 * q1, axis=1, keepdims=True)
    q1, cosine = np.where(cosine < 0, -q1, q1), np.abs(cosine)
    angle = np.arccos(np.clip(cosine, 0, 1))
    sine = np.sin(angle)
    near = sine < 1e-6
    a = np.where(near, 1 - fraction, np.sin((1 - fraction) * angle) / np.where(near, 1, sine))
    b = np.where(near, fraction, np.sin(fraction * angle) / np.where(near, 1, sine))
    q = a * q0 + b * q1
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return t0 + fraction * (t1 - t0), q, s0 + fraction * (s1 - s0)
