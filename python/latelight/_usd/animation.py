"""The animation of a scene: nodes, keyframes and the visibility of what changes over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._core import AnimationChannel
from .._model_builder import node_name
from .context import Context, Parts
from .keyframes import Matrices, keyframes
from .traversal import is_visible


class Animation:
    """Adds nodes to the scene, and one animation with all channels at the end."""

    def __init__(self, context: Context) -> None:
        self.context, self.samples, self.scene = context, context.samples, context.scene
        self.channels: list[AnimationChannel] = []
        self.nodes: dict[Any, str] = {}

    def finish(self) -> None:
        if self.channels:
            self.scene.add_animation("stage", self.channels)

    def add_channel(self, node: str, kind: str, times: Sequence[float], values: Any, steps: bool = False) -> None:
        self.channels.append(
            AnimationChannel(
                node=node,
                property=kind,
                interpolation="step" if steps or self.samples.held else "linear",
                times=self.samples.seconds(times),
                values=np.asarray(values, np.float32),
            )
        )

    def node_of(self, prim: Any, parts: Parts = (), weights: Sequence[float] = ()) -> str:
        """The node of a prim, below those of its parents. It is created once, with the parts that it then shows."""
        path = prim.GetPath()
        if path not in self.nodes and prim.IsPseudoRoot():
            self.nodes[path] = self.scene.add_node("stage", matrix=self.context.scene_from_stage)
        elif path not in self.nodes:
            form = self.context.pxr.UsdGeom.Xformable(prim)
            above = self.context.stage.GetPseudoRoot() if form and form.GetResetXformStack() else prim.GetParent()
            parent, name = self.node_of(above), node_name(prim.GetName())
            common: Any = {"name": name, "parent": parent, "parts": parts, "weights": weights}
            if form and form.TransformMightBeTimeVarying():
                times = self.samples.clipped(form.GetTimeSamples())
                (node,) = self.add_moving_nodes([common], times, lambda time: _local(form, time)[None], path)
            else:
                node = self.scene.add_node(matrix=_local(form, self.samples.start) if form else np.eye(4), **common)
            self.nodes[path] = node
            self.add_visibility(node, prim)
        return self.nodes[path]

    def add_visibility(self, node: str, prim: Any) -> None:
        """Adds the visibility of a prim, including that of its parents, to the node that shows it."""
        if times := self.samples.of_visibility(prim):
            values = [[is_visible(self.context, prim, time)] for time in times]
            self.add_channel(node, "visible", times, values, steps=True)

    def add_moving_nodes(
        self, nodes: Sequence[Any], times: Sequence[float], matrices: Matrices, path: Any
    ) -> list[str]:
        """Adds nodes whose transforms are `matrices` of a time. A node may name the number of an earlier one as its
        parent."""
        times, keys = keyframes(times, matrices, path, self.samples.held)
        made: list[str] = []
        for i, node in enumerate(nodes):
            parent = made[node["parent"]] if isinstance(node["parent"], int) else node["parent"]
            first = {name: values[0, i] for name, values in keys.items()}
            made.append(self.scene.add_node(**{**node, "parent": parent}, **first))
            for kind, values in keys.items():
                if np.ptp(values[:, i], axis=0).max() > 0:
                    self.add_channel(made[-1], kind, times, values[:, i])
        return made


def _local(form: Any, time: float) -> np.ndarray:
    return np.array(form.GetLocalTransformation(time), np.float64).T  # USD's vectors are rows
