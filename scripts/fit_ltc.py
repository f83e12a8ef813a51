#!/usr/bin/env python3
"""Fits the table of linearly transformed cosines by which area lights are shaded.

    python3 scripts/fit_ltc.py > src/render/gpu_scene/ltc_table.inc

Heitz, Dupuy, Hill and Neubelt 2016, Real-Time Polygonal-Light Shading with Linearly Transformed Cosines. The fitted
lobe is that of src/shared/brdf/ggx.h with a Fresnel term of 1: Trowbridge-Reitz with Smith's height-correlated masking
and shadowing, times the cosine. For each direction to the eye and each roughness, a matrix M transforms the clamped
cosine distribution to the lobe's shape. The part below the surface's horizon is cut off and the rest normalized to 1,
which makes the errors less than half as large. The shaders scale it by the split-sum table.

In the frame whose z axis is the mirrored direction to the eye, and whose x axis is in the plane of that and the normal,
the inverse of M, divided by its middle element, is

    | a 0 b |
    | 0 1 0 |    and a line of the table is {a, b, c, d}.
    | c 0 d |

Rows run over the perceptual roughness from 0 to 1, and columns over sqrt(1 - n.v) from 0 to 1. All elements change
slowly between neighbors, so the shaders interpolate them linearly. The script is deterministic and needs numpy and
scipy; it runs for minutes.
"""

import sys

import numpy as np
from scipy.optimize import minimize

SIZE = 32  # rows and columns; kLtcSize in src/shared/area_light.h
MIN_ALPHA = 1 / 1024  # kGgxMinAlpha
MIN_COSINE = 0.005  # of the last column: at 0, the lobe has no width
SAMPLES = 28  # per axis of the square of sample points


def grid(count):
    u = (np.arange(count) + 0.5) / count
    return [axis.ravel() for axis in np.meshgrid(u, u, indexing="ij")]


def ggx(light, view, alpha):
    """The lobe times the cosine, and the density of ggx_samples(), at unit directions in the rows of `light`."""
    half = light + view
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    nl, nv, nh = light[:, 2], view[2], half[:, 2]
    d = (alpha / (nh * nh * alpha * alpha + half[:, 0] ** 2 + half[:, 1] ** 2)) ** 2 / np.pi

    def root(cosine):
        return np.sqrt(alpha * alpha + (1 - alpha * alpha) * cosine * cosine)

    with np.errstate(divide="ignore", invalid="ignore"):
        value = d * nl * 0.5 / (nv * root(nl) + nl * root(nv))
        density = d / (2 * (nv + root(nv)))
    above = nl > 0
    return np.where(above, value, 0), np.where(above, density, 0)


def ggx_samples(view, alpha, u, v):
    """Directions mirrored by visible normals (Dupuy and Benyoub 2023, Sampling Visible GGX Normals)."""
    stretched = np.array([view[0] * alpha, 0, view[2]])
    stretched /= np.linalg.norm(stretched)
    z = 1 - v * (1 + stretched[2])
    radius = np.sqrt(np.maximum(1 - z * z, 0))
    turn = 2 * np.pi * u
    cap = np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1) + stretched
    half = np.stack([cap[:, 0] * alpha, cap[:, 1] * alpha, np.maximum(cap[:, 2], 1e-9)], axis=1)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    return 2 * (half @ view)[:, None] * half - view


class Transformed:
    """The clamped cosine, transformed by the inverse of the table's matrix, above the surface's horizon only.

    The part of the hemisphere about z of the cosine that is above the horizon has the form factor (1 + cos g) / 2, where
    g is the angle between their normals. Dividing by it makes the integral 1.
    """

    def __init__(self, a, b, c, d):
        self.inverse = np.array([[a, 0, b], [0, 1, 0], [c, 0, d]])
        self.matrix = np.linalg.inv(self.inverse)
        self.determinant = abs(np.linalg.det(self.matrix))
        self.scale = 2 / (1 + a / np.hypot(a, c))

    def density(self, light):
        original = light @ self.inverse.T
        return np.maximum(original[:, 2], 0) / (np.pi * np.sum(original**2, axis=1) ** 2 * self.determinant)

    def samples(self, u, v):
        radius, turn = np.sqrt(u), 2 * np.pi * v
        cosine = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - u)], axis=1)
        light = cosine @ self.matrix.T
        return light / np.linalg.norm(light, axis=1, keepdims=True)


def fit(view, alpha, starts):
    """The table's elements that minimize the absolute difference, from the best of several starts."""
    u, v = grid(4 * SAMPLES)
    value, density = ggx(ggx_samples(view, alpha, u, v), view, alpha)
    total = np.where(density > 0, value / np.maximum(density, 1e-300), 0).mean()
    u, v = grid(SAMPLES)
    own = ggx_samples(view, alpha, u, v)
    own_value, own_density = ggx(own, view, alpha)

    def elements(p):  # of parameters that change slowly with alpha
        if len(p) == 1:
            return 1, 0, 0, alpha * np.exp(p[0])
        return np.exp(p[0]), p[1], alpha * p[2], alpha * np.exp(p[3])

    def error(p):
        fitted = Transformed(*elements(p))
        there = fitted.samples(u, v)
        there_value, there_density = ggx(there, view, alpha)
        cosine = np.concatenate([fitted.density(own), fitted.density(there)])
        sampled = np.concatenate([own_density, there_density]) + cosine
        lobe = np.concatenate([own_value, there_value]) / total
        above = np.concatenate([own, there])[:, 2] > 0
        return np.sum(above * np.abs(lobe - cosine * fitted.scale) / np.maximum(sampled, 1e-300)) / len(u)

    best = None
    for start in starts:
        simplex = np.array([start] + [start + 0.15 * axis for axis in np.eye(len(start))])
        options = {"initial_simplex": simplex, "xatol": 1e-4, "fatol": 1e-7, "maxiter": 500}
        found = minimize(error, start, method="Nelder-Mead", options=options)
        if best is None or found.fun < best.fun:
            best = found
    return best.x, elements(best.x)


def main():
    table = np.zeros((SIZE, SIZE, 4))
    last_column = {}
    for column in range(SIZE):
        x = column / (SIZE - 1)
        cosine = max(1 - x * x, MIN_COSINE)
        view = np.array([np.sqrt(1 - cosine * cosine), 0, cosine])
        rougher = np.zeros(1 if column == 0 else 4)
        for row in reversed(range(SIZE)):
            alpha = max((row / (SIZE - 1)) ** 2, MIN_ALPHA)
            starts = [rougher]
            if column > 1:
                starts.append(last_column[row])
            rougher, (a, b, c, d) = fit(view, alpha, starts)
            turned = np.array([[a, b], [c, d]]) @ np.array([[view[2], -view[0]], [view[0], view[2]]])
            table[row, column] = turned.ravel()
            last_column[row] = rougher
        print(f"column {column}", file=sys.stderr)
    print("// Written by scripts/fit_ltc.py: per line {a, b, c, d} of a row (roughness) and a column (sqrt(1 - n.v)).")
    for line in table.reshape(-1, 4):
        numbers = [f"{value:.6g}" for value in line]
        print("{" + ", ".join((n if "." in n or "e" in n else n + ".0") + "f" for n in numbers) + "},")


if __name__ == "__main__":
    main()
