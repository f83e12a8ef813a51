// The lobes of a path's surface with coats or transmission (shared/layers.h). Light from the eye's side of a material
// is evaluated by the functions of layers.h. They include the transmission lobe of thin walls, but not refraction: a
// volume's surface refracts at its visible facets (Walter, Marschner, Li and Torrance 2007, Microfacet Models for
// Refraction through Rough Surfaces), whose directions are distributed as facets are visible. That distributes exactly
// the light that the surface does not reflect, so no light is lost to masking.
//
// Seen from inside a volume, the surface has no coats. It is a mix of three parts, with metalness m and transmission t:
// - m: metal, whose facets reflect by Schlick's term, with the base color at normal incidence;
// - (1 - m) t: clear dielectric, whose facets reflect by Schlick's term F for the angle outside, or totally beyond the
//   critical angle, and refract the rest, 1 - F;
// - (1 - m) (1 - t): the diffuse part, which light from inside reaches without crossing the dielectric's interface.
// The fractions add up to 1, so white surfaces return all light toward each direction inside, as they do outside, where
// the interface lies over the diffuse part, too. Smooth facets refract the fraction (1 - m) t (1 - F) in both
// directions. The diffuse part scatters light also beyond the critical angle. It has to receive light from there as
// well, because otherwise nothing could scatter that light back, and it would never leave a smooth sphere.
#ifndef LATELIGHT_PATH_COATS_GLSL
#define LATELIGHT_PATH_COATS_GLSL
#include "render/glsl/ray_samples.glsl"
#include "render/glsl/rays.glsl"
#include "render/glsl/setup.glsl"
#include "render/layered/surface_layers.glsl"
#include "render/lighting/reference/path_samples.glsl"
#include "shared/layers.h"

// Environment light and light between surfaces include multiple reflections between facets, as prefiltered environments
// do.
uint pathShading() { return kShading == kShadingBlinnPhong ? kShadingBlinnPhong : kShadingGgxCompensated; }

// The table of splitSum(), extrapolated to its borders, half a texel beyond the centers of the first and last texels.
vec2 extrapolatedSplitSum(vec2 at) {
  float margin = 0.5 / float(textureSize(reflectanceTable, 0).x);
  vec2 within = clamp(at, margin, 1.0 - margin);
  return 2.0 * textureLod(reflectanceTable, within, 0.0).rg - textureLod(reflectanceTable, 2.0 * within - at, 0.0).rg;
}

// --- facets ----------------------------------------------------------------------------------------------------------

StretchedFrame roundFrame(vec3 normal, float alpha) {
  mat3 axes = rayAxes(normal);
  return StretchedFrame(axes[0], axes[1], normal, alpha, alpha);
}

vec3 mirroredBy(vec3 facet, vec3 toEye) { return facet * (2.0 * dot(facet, toEye)) - toEye; }

// Returns a visible normal, by a cap of the unit sphere (Dupuy and Benyoub 2023, Sampling Visible GGX Normals with
// Spherical Caps).
vec3 sampleFacet(StretchedFrame f, vec3 toEye, vec2 u) {
  vec3 eye = vec3(dot(f.tangent, toEye), dot(f.bitangent, toEye), max(dot(f.normal, toEye), kMinNv));
  vec3 stretched = normalize(vec3(eye.x * f.along, eye.y * f.across, eye.z));
  float height = 1.0 - u.y * (1.0 + stretched.z), turn = 2.0 * kPi * u.x;
  vec3 cap = vec3(sqrt(max(1.0 - height * height, 0.0)) * vec2(cos(turn), sin(turn)), height) + stretched;
  vec3 facet = normalize(vec3(cap.x * f.along, cap.y * f.across, max(cap.z, 1e-6)));
  return f.tangent * facet.x + f.bitangent * facet.y + f.normal * facet.z;
}

vec3 cosineSample(vec3 normal, vec2 u) {
  vec2 disk = diskSample(u);
  return rayAxes(normal) * vec3(disk, sqrt(max(1.0 - dot(disk, disk), 0.0)));
}

// 1/sr: the density of sampleFacet().
float facetDensity(StretchedFrame f, vec3 toEye, vec3 facet) {
  float nv = clamp(dot(f.normal, toEye), kMinNv, 1.0);
  return 2.0 * max(dot(toEye, facet), 0.0) * stretchedDistribution(f, facet) / (nv + stretchedRoot(f, toEye, nv));
}

// 1/sr: the density of directions in which visible facets mirror the eye.
float mirroredDensity(StretchedFrame f, vec3 toEye, vec3 toLight) {
  float nv = clamp(dot(f.normal, toEye), kMinNv, 1.0);
  return stretchedDistribution(f, halfVector(toLight, toEye)) / (2.0 * (nv + stretchedRoot(f, toEye, nv)));
}

// --- refraction ------------------------------------------------------------------------------------------------------

vec3 acrossPlane(vec3 normal, vec3 direction) { return direction - normal * (2.0 * dot(normal, direction)); }

// The facet that refracts the eye's ray into a direction, on the eye's side. `ior` is relative to the eye's side.
vec3 refractingFacet(vec3 normal, vec3 toEye, vec3 toLight, float ior) {
  vec3 facet = normalize(toEye + toLight * ior);
  return dot(facet, normal) < 0.0 ? -facet : facet;
}

// Returns the direction into which a facet refracts the eye's ray; 0 if it reflects totally.
vec3 refractedBy(vec3 facet, vec3 toEye, float ior) { return refract(-toEye, facet, 1.0 / ior); }

// 1/sr: the density of directions into which visible facets refract the eye's ray (Walter et al. 2007, equation 17),
// and the facet.
float refractedDensity(StretchedFrame f, vec3 toEye, vec3 toLight, float ior, out vec3 facet) {
  facet = refractingFacet(f.normal, toEye, toLight, ior);
  float vh = dot(toEye, facet), lh = dot(toLight, facet), across = vh + ior * lh;
  if (vh <= 0.0 || lh >= 0.0 || across == 0.0) return 0.0;
  return facetDensity(f, toEye, facet) * ior * ior * -lh / (across * across);
}

// --- a surface -------------------------------------------------------------------------------------------------------

struct CoatedVertex {
  LayeredBrdf b;
  StretchedFrame facets;  // of the base lobe
  float ior;              // of the other side relative to the eye's; 0: the surface does not refract
  bool inside;            // the eye is inside the volume
  vec3 straight;          // fraction of light that passes straight on, for which directions are not sampled
  float diffuse;          // inside: fraction of light for the diffuse part
  // Probabilities with which lobes are sampled; the remaining ones are the cosine's. Inside, `base` is that of facets.
  float base, coat, sheen, through, behind;
};

// Refraction below this relative index of refraction is less than the rounding of its facets.
const float kMinRefractingIor = 1.001;

// Smooth thin walls, and volumes that do not refract, let light pass straight on.
bool passesStraight(Surface s, SurfaceLayers l) {
  if (l.transmission <= 0.0) return false;
  if (l.thickness > 0.0) return l.ior < kMinRefractingIor;
  return ggxAlpha(transmittedRoughness(s.roughness, l.ior)) <= kGgxMinAlpha;
}

// Volumes absorb over the distance that a path travels in them, not over their thickness.
LayeredBrdf pathBrdf(Surface s, SurfaceLayers l, vec3 toEye) {
  l.thickness = 0.0;
  l.absorption = vec3(0.0);
  LayerTables t = layerTableCoordinates(s, l, toEye);
  t.base = extrapolatedSplitSum(t.base);
  t.coat = extrapolatedSplitSum(t.coat);
  t.behind = extrapolatedSplitSum(t.behind);
  return layeredBrdf(s, l, toEye, pathShading(), t);
}

// A facet that is seen from inside: the fractions of light that it reflects and refracts, and the probability with
// which it is sampled as a mirror.
struct InsideFacet {
  vec3 mirrors;
  vec3 refracts;
  float mirrorChance;
};

InsideFacet insideFacet(CoatedVertex c, Surface s, vec3 toEye, vec3 facet) {
  float cosine = saturate(dot(facet, toEye)), sine2 = (1.0 - cosine * cosine) / (c.ior * c.ior);
  float dielectric = (1.0 - s.metallic) * c.b.layers.transmission;
  vec3 fresnel = sine2 < 1.0 ? schlick(s.f0, s.f90, sqrt(1.0 - sine2)) : vec3(1.0);
  InsideFacet f;
  f.mirrors = dielectric * fresnel + s.metallic * schlick(s.baseColor, 1.0, cosine);
  f.refracts = dielectric * (vec3(1.0) - fresnel);
  // Exactly 1 beyond the critical angle, where there is no refracted direction.
  float mirrors = maxChannel(f.mirrors), refracts = maxChannel(f.refracts);
  f.mirrorChance = refracts > 0.0 ? mirrors / (mirrors + refracts) : 1.0;
  return f;
}

void chooseChances(inout CoatedVertex c) {
  LayeredBrdf b = c.b;
  float base = maxChannel(b.once) * b.under, coat = b.coatReflects * b.coatAlbedo;
  float sheen = maxChannel(b.layers.sheenColor) * b.sheenAlbedo, cosine = maxChannel(b.scattered) * b.under;
  bool refracts = c.ior > 0.0 || maxChannel(b.through) > 0.0;
  float through = refracts ? maxChannel(b.seen) * b.under : 0.0, behind = maxChannel(b.behind) * b.under;
  base = max(base, 0.1 * (cosine + through + behind));
  float all = max(base + coat + sheen + cosine + through + behind, 1e-6);
  c.base = base / all, c.coat = coat / all, c.sheen = sheen / all, c.through = through / all, c.behind = behind / all;
}

void chooseChancesInside(inout CoatedVertex c, Surface s) {
  SurfaceLayers l = c.b.layers;
  c.diffuse = (1.0 - s.metallic) * (1.0 - l.transmission);
  c.base = max(1.0 - c.diffuse, 0.1);
  c.behind = (1.0 - c.base) * l.diffuseTransmission;
}

// `front`: the eye is on the front side of the surface.
CoatedVertex coatedVertex(Surface s, SurfaceLayers l, vec3 toEye, bool front) {
  CoatedVertex c;
  bool straight = passesStraight(s, l), refracts = l.thickness > 0.0 && l.transmission > 0.0 && !straight;
  c.b = pathBrdf(s, l, toEye);
  c.ior = !refracts ? 0.0 : (front ? l.ior : 1.0 / l.ior);
  c.inside = refracts && !front;
  c.facets = roundFrame(s.normal, ggxAlpha(s.roughness));
  if (c.b.layers.anisotropy > 0.0) c.facets = c.b.stretched;
  c.straight = straight ? c.b.seen * c.b.under : vec3(0.0);
  if (straight || refracts) c.b.through = vec3(0.0);
  chooseChances(c);
  c.diffuse = 0.0;
  if (c.inside) chooseChancesInside(c, s);
  return c;
}

// --- inside a volume -------------------------------------------------------------------------------------------------

// Facets that reflect or refract to the wrong side of the surface do so to the other one, mirrored by its plane.
// Both functions return the density of a direction, and add the fraction of light from there.
float insideMirror(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight, inout vec3 light) {
  InsideFacet f = insideFacet(c, s, toEye, halfVector(toLight, toEye));
  float density = mirroredDensity(c.facets, toEye, toLight);
  light += density * f.mirrors;
  return density * f.mirrorChance;
}
float insideRefraction(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight, inout vec3 light) {
  vec3 facet;
  float density = refractedDensity(c.facets, toEye, toLight, c.ior, facet);
  InsideFacet f = insideFacet(c, s, toEye, facet);
  light += density * f.refracts * s.baseColor;
  return density * (1.0 - f.mirrorChance);
}

// Returns the density of a direction among facets, and the light from there in `light`.
float insideFacets(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight, out vec3 light) {
  vec3 other = acrossPlane(s.normal, toLight);
  light = vec3(0.0);
  if (dot(s.normal, toLight) > 0.0)
    return insideMirror(c, s, toEye, toLight, light) + insideMirror(c, s, toEye, other, light);
  return insideRefraction(c, s, toEye, toLight, light) + insideRefraction(c, s, toEye, other, light);
}

vec3 insideReflectance(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight) {
  vec3 light;
  insideFacets(c, s, toEye, toLight, light);
  float cosine = dot(s.normal, toLight);
  SurfaceLayers l = c.b.layers;
  vec3 scattered = cosine > 0.0 ? s.baseColor * (1.0 - l.diffuseTransmission)
                                : l.diffuseTransmissionColor * l.diffuseTransmission;
  return light + c.diffuse * scattered * (abs(cosine) * kInvPi);
}

float insideDensity(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight) {
  vec3 light;
  float cosine = dot(s.normal, toLight);
  float scattered = cosine > 0.0 ? 1.0 - c.base - c.behind : c.behind;
  return c.base * insideFacets(c, s, toEye, toLight, light) + max(scattered, 0.0) * abs(cosine) * kInvPi;
}

vec3 sampleInside(CoatedVertex c, Surface s, vec3 toEye, vec2 u, float choice) {
  if (choice >= c.base) return cosineSample(choice < c.base + c.behind ? -s.normal : s.normal, u);
  vec3 facet = sampleFacet(c.facets, toEye, u);
  bool mirrors = choice < c.base * insideFacet(c, s, toEye, facet).mirrorChance;
  vec3 toLight = mirrors ? mirroredBy(facet, toEye) : refractedBy(facet, toEye, c.ior);
  return (dot(s.normal, toLight) > 0.0) == mirrors ? toLight : acrossPlane(s.normal, toLight);
}

// --- all of them -----------------------------------------------------------------------------------------------------

// Directions on the other side of the surface, for a volume that is entered.
float entryDensity(CoatedVertex c, vec3 toEye, vec3 toLight) {
  if (c.ior == 0.0 || dot(c.facets.normal, toLight) >= 0.0) return 0.0;
  vec3 facet;
  return refractedDensity(c.facets, toEye, toLight, c.ior, facet) +
         refractedDensity(c.facets, toEye, acrossPlane(c.facets.normal, toLight), c.ior, facet);
}

// Returns, for lights, a surface as layeredBrdf() returns it without energy compensation. `base`: its surfaceBrdf()
// without. Light that passes straight on, or that facets refract, is in no lobe of the BRDF.
CoatedVertex withoutCompensation(CoatedVertex c, SurfaceBrdf base) {
  bool passes = maxChannel(c.b.through) > 0.0;
  c.b.compensated = 0.0;
  c.b.base = base;
  c.b.base.diffuse *= keptDiffuse(c.b.layers);
  addTransmission(c.b, vec2(1.0, 0.0));  // the table is for compensated surfaces only
  if (!passes) c.b.through = vec3(0.0);
  c.b.underCoat = 1.0 - c.b.coatReflects;
  c.b.under = c.b.underCoat * (1.0 - maxChannel(c.b.layers.sheenColor) * c.b.sheenAlbedo);
  return c;
}

// The radiance toward the eye from radiance 1 in a direction on either side of the surface, times the cosine.
vec3 coatedReflectance(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight) {
  if (dot(s.normal, toLight) * dot(s.geonormal, toLight) <= 0.0) return vec3(0.0);
  if (c.inside) return insideReflectance(c, s, toEye, toLight);
  vec3 light = shadeLayeredLight(c.b, LightSample(toLight, vec3(1.0), 1.0), pathShading());
  return light + c.b.seen * (c.b.under * entryDensity(c, toEye, toLight));
}

StretchedFrame thinFacets(CoatedVertex c) { return roundFrame(c.facets.normal, sqrt(c.b.throughA2)); }
StretchedFrame coatFacets(CoatedVertex c) { return roundFrame(c.b.layers.clearcoatNormal, sqrt(c.b.coatA2)); }

// 1/sr: the density of sampleCoats().
float coatedDensity(CoatedVertex c, Surface s, vec3 toEye, vec3 toLight) {
  if (c.inside) return insideDensity(c, s, toEye, toLight);
  float cosine = dot(s.normal, toLight);
  float density = c.base * mirroredDensity(c.facets, toEye, toLight);
  if (c.coat > 0.0) density += c.coat * mirroredDensity(coatFacets(c), toEye, toLight);
  if (c.through > 0.0 && c.ior > 0.0) density += c.through * entryDensity(c, toEye, toLight);
  if (c.through > 0.0 && c.ior == 0.0)
    density += c.through * mirroredDensity(thinFacets(c), toEye, acrossPlane(s.normal, toLight));
  float scattered = 1.0 - c.base - c.coat - c.sheen - c.through - c.behind;
  density += cosine > 0.0 ? max(scattered, 0.0) * cosine * kInvPi + c.sheen * (0.5 * kInvPi)
                          : c.behind * -cosine * kInvPi;
  return density;
}

vec3 sampleThrough(CoatedVertex c, Surface s, vec3 toEye, vec2 u) {
  if (c.ior == 0.0) return acrossPlane(s.normal, mirroredBy(sampleFacet(thinFacets(c), toEye, u), toEye));
  vec3 toLight = refractedBy(sampleFacet(c.facets, toEye, u), toEye, c.ior);
  return dot(s.normal, toLight) < 0.0 ? toLight : acrossPlane(s.normal, toLight);
}

// `u` and `choice` are in [0, 1).
vec3 sampleCoats(CoatedVertex c, Surface s, vec3 toEye, vec2 u, float choice) {
  if (c.inside) return sampleInside(c, s, toEye, u, choice);
  if ((choice -= c.base) < 0.0) return mirroredBy(sampleFacet(c.facets, toEye, u), toEye);
  if ((choice -= c.coat) < 0.0) return mirroredBy(sampleFacet(coatFacets(c), toEye, u), toEye);
  if ((choice -= c.through) < 0.0) return sampleThrough(c, s, toEye, u);
  if ((choice -= c.behind) < 0.0) return cosineSample(-s.normal, u);
  if ((choice -= c.sheen) >= 0.0) return cosineSample(s.normal, u);
  float height = 1.0 - u.y, turn = 2.0 * kPi * u.x;  // sheen: all directions alike
  return rayAxes(s.normal) * vec3(sqrt(max(1.0 - height * height, 0.0)) * vec2(cos(turn), sin(turn)), height);
}

#endif
