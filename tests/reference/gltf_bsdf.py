"""The model of docs/light.md for Mitsuba 3: glTF 2.0, appendix B, with multiple scattering between microfacets.

Trowbridge-Reitz, Smith's height-correlated masking and shadowing (Heitz 2014, Understanding the Masking-Shadowing
Function, equation 99), Schlick's Fresnel term, and a Lambertian part that sends back what the facets lose.
Mitsuba's own `roughconductor` and `principled` multiply masking and shadowing instead of correlating them.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

TABLE = 256  # cosines of the table of reflected fractions


def smith_lambda(cosine, alpha):
    tangent2 = 1 / np.maximum(cosine, 1e-6) ** 2 - 1
    return (np.sqrt(1 + alpha * alpha * tangent2) - 1) / 2


def reflected_fractions(alpha, side=96):
    """Returns the fractions of uniform light that facets of f0 = 1 and of f90 = 1 reflect once, (TABLE, 2)."""
    u, v = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    fractions = np.empty((TABLE, 2))
    for i in range(TABLE):
        nv = max(i / (TABLE - 1), 1e-3)
        view = np.array([np.sqrt(1 - nv * nv), 0, nv])
        # Visible normals by projection of a hemisphere (Heitz 2018, JCGT 7(4)).
        stretched = view * (alpha, alpha, 1)
        stretched /= np.linalg.norm(stretched)
        across = np.array([0, 1.0, 0])
        up = np.cross(stretched, across)
        radius, turn = np.sqrt(u), 2 * np.pi * v
        x, y = radius * np.cos(turn), radius * np.sin(turn)
        blend = (1 + stretched[2]) / 2
        y = (1 - blend) * np.sqrt(np.maximum(1 - x * x, 0)) + blend * y
        z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
        facet = x[..., None] * across + y[..., None] * up + z[..., None] * stretched
        facet = facet * (alpha, alpha, 1)
        facet /= np.linalg.norm(facet, axis=-1, keepdims=True)
        vh = facet @ view
        nl = 2 * vh * facet[..., 2] - view[2]
        own, other = smith_lambda(nv, alpha), smith_lambda(nl, alpha)
        weight = np.where(nl > 0, (1 + own) / (1 + own + other), 0)
        grazing = np.clip(1 - vh, 0, 1) ** 5
        fractions[i] = np.mean(weight * (1 - grazing)), np.mean(weight * grazing)
    return fractions


def scattered_table(material):
    """Returns the Lambertian albedo per cosine toward the eye, (TABLE, 3)."""
    scale, bias = reflected_fractions(max(material.roughness ** 2, 1 / 1024)).T[..., None]
    color = np.asarray(material.color, float)

    def parts(f0, f90):
        lost = 1 - scale - bias
        mean = f0 + (f90 - f0) / 21
        again = 0.75 * lost
        return f0 * scale + f90 * bias, mean * mean * lost * (1 - again) / (1 - mean * again)

    once, more = parts(np.full(3, 0.04 * material.specular), material.specular)
    _, metal_more = parts(color, 1)
    diffuse = color * (1 - material.metallic) * (1 - (once + more).max(-1, keepdims=True))
    return more + (metal_more - more) * material.metallic + diffuse


class GltfBsdf(mi.BSDF):
    materials = {}  # by name; plugins accept only numbers and text

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        m = self.materials[props["material"]]
        self.alpha = max(m.roughness ** 2, 1 / 1024)
        dielectric = 0.04 * m.specular
        self.f0 = mi.Color3f(*[dielectric + (c - dielectric) * m.metallic for c in m.color])
        self.f90 = m.specular + (1 - m.specular) * m.metallic
        self.scattered = [mi.Float(column) for column in scattered_table(m).T.astype(np.float32)]
        self.share = 0.5 if m.metallic < 1 else 0.8  # of the samples of the specular lobe
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags

    def lambertian(self, cosine):
        at = dr.clip(cosine, 0, 1) * (TABLE - 1)
        low = dr.minimum(mi.UInt32(at), TABLE - 2)
        between = at - mi.Float(low)
        return mi.Color3f(*[dr.lerp(dr.gather(mi.Float, c, low), dr.gather(mi.Float, c, low + 1), between)
                            for c in self.scattered])

    def eval_pdf(self, ctx, si, wo, active=True):
        nv, nl = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (nv > 0) & (nl > 0)
        half = dr.normalize(si.wi + wo)
        vh = dr.dot(half, wo)
        facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, self.alpha, True)
        d = facets.eval(half)
        a2 = self.alpha * self.alpha
        root = lambda c: dr.sqrt(a2 + (1 - a2) * c * c)
        visibility = 0.5 / (nv * root(nl) + nl * root(nv))
        fresnel = self.f0 + (self.f90 - self.f0) * dr.clip(1 - vh, 0, 1) ** 5
        value = (fresnel * (d * visibility) + self.lambertian(nv) / dr.pi) * nl
        pdf = self.share * facets.pdf(si.wi, half) / (4 * vh) + (1 - self.share) * nl / dr.pi
        return dr.select(active, value, 0), dr.select(active, pdf, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, self.alpha, True)
        mirrored = mi.reflect(si.wi, facets.sample(si.wi, sample2)[0])
        bs = mi.BSDFSample3f()
        bs.wo = dr.select(sample1 < self.share, mirrored, mi.warp.square_to_cosine_hemisphere(sample2))
        bs.eta = 1
        bs.sampled_type = mi.UInt32(int(mi.BSDFFlags.GlossyReflection))
        bs.sampled_component = mi.UInt32(0)
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        active &= bs.pdf > 0
        return bs, dr.select(active, value / bs.pdf, 0)


mi.register_bsdf("gltf", GltfBsdf)
