"""The model of docs/light.md for Mitsuba 3: glTF 2.0, appendix B, with multiple scattering between microfacets, and
clearcoats, thin walls and volumes as in "Coats and transmission along paths".

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


def f0_of(material):
    return ((material.ior - 1) / (material.ior + 1)) ** 2 * material.specular


def albedo_tables(material):
    """Returns the Lambertian albedo and the transmitted fraction per cosine toward the eye, (TABLE, 3) each."""
    scale, bias = reflected_fractions(max(material.roughness ** 2, 1 / 1024)).T[..., None]
    color = np.asarray(material.color, float)

    def parts(f0, f90):
        lost = 1 - scale - bias
        mean = f0 + (f90 - f0) / 21
        again = 0.75 * lost
        return f0 * scale + f90 * bias, mean * mean * lost * (1 - again) / (1 - mean * again)

    once, more = parts(np.full(3, f0_of(material)), material.specular)
    _, metal_more = parts(color, 1)
    left = color * (1 - material.metallic) * (1 - (once + more).max(-1, keepdims=True))
    scattered = more + (metal_more - more) * material.metallic + left * (1 - material.transmission)
    return scattered, left * material.transmission


def columns(table):
    return [mi.Float(column) for column in table.T.astype(np.float32)]


def lookup(table, cosine):
    at = dr.clip(cosine, 0, 1) * (TABLE - 1)
    low = dr.minimum(mi.UInt32(at), TABLE - 2)
    between = at - mi.Float(low)
    return [dr.lerp(dr.gather(mi.Float, c, low), dr.gather(mi.Float, c, low + 1), between) for c in table]


def schlick(f0, f90, cosine):
    return f0 + (f90 - f0) * dr.clip(1 - cosine, 0, 1) ** 5


def facets_of(alpha):
    return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha, alpha, True)


def smith_root(alpha, cosine):
    return dr.sqrt(alpha * alpha + (1 - alpha * alpha) * cosine * cosine)


def lobe(alpha, half, nv, nl):
    """The lobe without its Fresnel term and without the cosine."""
    return facets_of(alpha).eval(half) * 0.5 / (nv * smith_root(alpha, nl) + nl * smith_root(alpha, nv))


def alpha_of(roughness):
    return max(roughness ** 2, 1 / 1024)


class GltfBsdf(mi.BSDF):
    materials = {}  # by name; plugins accept only numbers and text

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        m = self.materials[props["material"]]
        self.alpha = alpha_of(m.roughness)
        dielectric = f0_of(m)
        self.f0 = mi.Color3f(*[dielectric + (c - dielectric) * m.metallic for c in m.color])
        self.f90 = m.specular + (1 - m.specular) * m.metallic
        self.scattered = columns(albedo_tables(m)[0])
        self.share = 0.5 if m.metallic < 1 else 0.8  # of the samples of the specular lobe
        self.coat, self.coat_alpha = m.coat, alpha_of(m.coat_roughness)
        self.coat_share = 0.2 if m.coat else 0
        self.coat_albedo = columns(reflected_fractions(self.coat_alpha).sum(1, keepdims=True))
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags

    def eval_pdf(self, ctx, si, wo, active=True):
        nv, nl = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (nv > 0) & (nl > 0)
        half = dr.normalize(si.wi + wo)
        vh = dr.dot(half, wo)
        mirrored = schlick(self.f0, self.f90, vh) * lobe(self.alpha, half, nv, nl)
        value = mirrored + mi.Color3f(*lookup(self.scattered, nv)) / dr.pi
        coat = self.coat * schlick(0.04, 1, nv)
        value = value * (1 - coat * lookup(self.coat_albedo, nv)[0]) + coat * lobe(self.coat_alpha, half, nv, nl)
        pdf = self.share * facets_of(self.alpha).pdf(si.wi, half) / (4 * vh) + (1 - self.share) * nl / dr.pi
        pdf = dr.lerp(pdf, facets_of(self.coat_alpha).pdf(si.wi, half) / (4 * vh), self.coat_share)
        return dr.select(active, value * nl, 0), dr.select(active, pdf, 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        coated = sample1 < self.coat_share
        sample1 = (sample1 - self.coat_share) / (1 - self.coat_share)
        mirrored = mi.reflect(si.wi, facets_of(self.alpha).sample(si.wi, sample2)[0])
        by_coat = mi.reflect(si.wi, facets_of(self.coat_alpha).sample(si.wi, sample2)[0])
        bs = mi.BSDFSample3f()
        bs.wo = dr.select(sample1 < self.share, mirrored, mi.warp.square_to_cosine_hemisphere(sample2))
        bs.wo = dr.select(coated, by_coat, bs.wo)
        bs.eta = 1
        bs.sampled_type = mi.UInt32(int(mi.BSDFFlags.GlossyReflection))
        bs.sampled_component = mi.UInt32(0)
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        active &= bs.pdf > 0
        return bs, dr.select(active, value / bs.pdf, 0)


class GlassBsdf(mi.BSDF):
    """Thin walls and volumes. Their lobes are only sampled, as if they were mirrors: Mitsuba then neither evaluates them
    toward lights, nor weights the light that their directions find. The light that is lost over the distance inside of
    a volume is part of the reflectance where the path arrives.
    """

    materials = {}

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        m = self.materials[props["material"]]
        self.m = m
        self.alpha = alpha_of(m.roughness)
        self.through_alpha = alpha_of(m.roughness * min(max(2 * m.ior - 2, 0), 1))
        self.f0, self.f90 = f0_of(m), m.specular
        self.scattered, self.seen = (columns(table) for table in albedo_tables(m))
        self.through_albedo = columns(reflected_fractions(self.through_alpha).sum(1, keepdims=True))
        self.absorption = mi.Color3f(*[-float(np.log(p)) for p in m.passed])
        flags = mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.DeltaTransmission
        self.m_components = [flags | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide]
        self.m_flags = self.m_components[0]

    def eval(self, ctx, si, wo, active=True):
        return mi.Color3f(0)

    def pdf(self, ctx, si, wo, active=True):
        return mi.Float(0)

    def eval_pdf(self, ctx, si, wo, active=True):
        return mi.Color3f(0), mi.Float(0)

    def mirrored(self, eye, sample, alpha):
        """Returns a direction, its facet's cosine, and the ratio of lobe and density."""
        facet = facets_of(alpha).sample(eye, sample)[0]
        wo = mi.reflect(eye, facet)
        nv, nl = eye.z, dr.maximum(wo.z, 1e-6)
        # The density of visible facets contains the masking toward the eye only.
        ratio = nl * (nv + smith_root(alpha, nv)) / (nv * smith_root(alpha, nl) + nl * smith_root(alpha, nv))
        return wo, dr.dot(eye, facet), dr.select(wo.z > 0, ratio, 0)

    def refracted(self, eye, facet, ior):
        """Returns the direction into a medium of this relative index, and true if there is one."""
        cosine = dr.dot(eye, facet)
        sine2 = (1 - cosine * cosine) / (ior * ior)
        inside = dr.sqrt(dr.maximum(1 - sine2, 0))
        return facet * (cosine / ior - inside) - eye / ior, sine2 < 1

    def from_outside(self, eye, sample1, sample2):
        mirror, vh, ratio = self.mirrored(eye, sample2, self.alpha)
        scattered = mi.warp.square_to_cosine_hemisphere(sample2)
        seen = mi.Color3f(*lookup(self.seen, eye.z))
        if self.m.solid:
            through = self.refracted(eye, facets_of(self.alpha).sample(eye, sample2)[0], self.m.ior)[0]
            through.z = -dr.abs(through.z)
        else:
            through, _, passes = self.mirrored(eye, sample2, self.through_alpha)
            through.z = -through.z
            seen *= passes / dr.maximum(lookup(self.through_albedo, eye.z)[0], 0.1)
        mirrors, scatters = sample1 < 0.3, sample1 >= 0.9
        weight = dr.select(mirrors, mi.Color3f(schlick(self.f0, self.f90, vh) * ratio / 0.3), seen / 0.6)
        weight = dr.select(scatters, mi.Color3f(*lookup(self.scattered, eye.z)) / 0.1, weight)
        return dr.select(mirrors, mirror, dr.select(scatters, scattered, through)), weight

    def from_inside(self, eye, sample1, sample2, distance):
        facet = facets_of(self.alpha).sample(eye, sample2)[0]
        cosine = dr.dot(eye, facet)
        through, passes = self.refracted(eye, facet, 1 / self.m.ior)
        outside = dr.sqrt(dr.maximum(1 - (1 - cosine * cosine) * self.m.ior ** 2, 0))
        fresnel = dr.select(passes, schlick(self.f0, self.f90, outside), 1)
        mirrors = sample1 < fresnel
        mirror = mi.reflect(eye, facet)
        mirror.z, through.z = dr.abs(mirror.z), -dr.abs(through.z)
        weight = dr.select(mirrors, mi.Color3f(1), mi.Color3f(*self.m.color) * self.m.transmission)
        return dr.select(mirrors, mirror, through), weight * dr.exp(-self.absorption * distance)

    def sample(self, ctx, si, sample1, sample2, active=True):
        # A thin wall is the same from both sides.
        front = dr.dot(si.n, si.to_world(si.wi)) > 0
        eye = mi.Vector3f(si.wi)
        eye.z = dr.maximum(dr.select(front, eye.z, -eye.z), 1e-4)
        eye = dr.normalize(eye)
        wo, weight = self.from_outside(eye, sample1, sample2)
        if self.m.solid:
            inner, inner_weight = self.from_inside(eye, sample1, sample2, si.t)
            wo, weight = dr.select(front, wo, inner), dr.select(front, weight, inner_weight)
        wo.z = dr.select(front, wo.z, -wo.z)
        # As Latelight: the interpolated normal and that of the triangle have to agree about the side.
        active &= wo.z * dr.dot(si.n, si.to_world(wo)) > 0
        bs = mi.BSDFSample3f()
        bs.wo = wo
        bs.pdf = 1
        bs.eta = 1
        bs.sampled_type = mi.UInt32(int(mi.BSDFFlags.DeltaTransmission))
        bs.sampled_component = mi.UInt32(0)
        return bs, dr.select(active, weight, 0)


mi.register_bsdf("gltf", GltfBsdf)
mi.register_bsdf("gltf_glass", GlassBsdf)
