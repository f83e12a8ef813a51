// Every shared function, called with random arguments: this one list is compiled for the device
// (gpu_math/functions.comp) and for the host (gpu_math/functions_test.cpp), which compares. GLSL and C++ like the
// headers it tests.
//
// C(name, relative, absolute, (vec4)): the two may differ by relative * |host| + absolute in each component. The bounds
// follow from Vulkan's precision rules (division 2.5 ULP, inversesqrt 2, sqrt of both; exp2 3 + 2 |x|; log2 2^-21
// absolute in [0.5, 2]; pow of those two; atan 4096; acos that of atan; 1 ULP is 1.2e-7) times what the function's own
// condition makes of them.
#ifndef LATELIGHT_TESTS_FUNCTION_CASES_H
#define LATELIGHT_TESTS_FUNCTION_CASES_H

#include "shared/environment.h"
#include "shared/gbuffer.h"
#include "shared/layers.h"
#include "shared/light.h"
#include "shared/samples.h"
#include "shared/shade.h"
#include "shared/tonemap.h"

SH_BEGIN

struct Arguments {
  vec3 n, l, v;  // unit
  vec3 c, d;     // in [0, 1]
  vec4 u;        // in [0, 1]
  vec4 w;        // from 1e-3 to 1e3
  uint k;        // 32 bits
};

SH_FUNC vec4 pad(float x) {
  return vec4(x, 0.0f, 0.0f, 0.0f);
}
SH_FUNC vec4 pad(vec2 v) {
  return vec4(v.x, v.y, 0.0f, 0.0f);
}
SH_FUNC vec4 pad(vec3 v) {
  return vec4(v.x, v.y, v.z, 0.0f);
}
SH_FUNC vec4 bytes(uint x) {
  return vec4(float(x & 255u), float((x >> 8u) & 255u), float((x >> 16u) & 255u), float(x >> 24u));
}

// A function of one channel and one of three. All of them are in portable_cases.h.
SH_FUNC uint someEncoding(Arguments a) {
  return a.k % 2u == 0u ? kNormal_octahedral : kNormal_xyz;
}

// The inputs of a pixel.
SH_FUNC uint someSamples(Arguments a) {
  return 1u << (a.k % 5u);
}

SH_FUNC Surface someSurface(Arguments a) {
  Surface s = emptySurface();
  s.normal = a.n;
  s.baseColor = a.c;
  s.metallic = a.u.x;
  s.roughness = a.u.y;
  s.f90 = a.u.z;
  s.f0 = a.d * a.u.z;
  s.scattered = a.d;
  s.ao = a.u.w;
  return s;
}

SH_FUNC Light someLight(Arguments a, uint type) {
  Light light;
  light.position = a.n * a.w.x;
  light.inverseRadius2 = inverseRadius2(a.w.y);
  light.direction = a.l;
  light.type = type;
  light.intensity = a.c;
  light.spotScale = 2.5f;
  light.spotOffset = -0.5f;
  return light;
}

SH_FUNC LightSample someSample(Arguments a) {
  LightSample s;
  s.toLight = a.l;
  s.intensity = a.d;
  s.attenuation = 1.0f;
  return s;
}

SH_FUNC vec4 coneOf(Arguments a) {
  float scale;
  float offset;
  spotCone(a.u.x * 0.7f, 0.8f + a.u.y * 0.7f, scale, offset);
  return vec4(scale, offset, 0.0f, 0.0f);
}

// A perspective or orthographic projection, off-center.
SH_FUNC Projection someProjection(Arguments a) {
  Projection p;
  p.H = 0.5f + a.u.x;
  p.V = 0.5f + a.u.y;
  p.A = -0.001f;
  p.B = 0.1f;
  p.X = 0.3f;
  p.Z = -0.2f;
  p.kind = a.k & 1u;
  return p;
}

SH_FUNC GbufferContext someContext(Arguments a) {
  GbufferContext context;
  vec3 x = normalize(cross(a.n, a.l));
  vec3 z = cross(x, a.n);
  vec3 eye = a.c;
  context.view.viewToWorld = mat4x3(x, a.n, z, eye);
  context.view.worldToView = mat4x3(vec3(x.x, a.n.x, z.x), vec3(x.y, a.n.y, z.y), vec3(x.z, a.n.z, z.z),
                                    vec3(-dot(x, eye), -dot(a.n, eye), -dot(z, eye)));
  context.view.projection = someProjection(a);
  context.view.projection.kind = kPerspective;
  context.view.eye = eye;
  context.view.size = vec2(640.0f, 480.0f);
  context.pixel = vec2(640.0f * a.u.z, 480.0f * a.u.w);
  context.depth = 0.01f + 0.9f * a.d.x;
  context.ao = 1.0f;
  context.normalEncoding = someEncoding(a);
  context.normalSpace = (a.k >> 8u) % 3u;
  context.positionMethod = (a.k >> 16u) % 3u;
  return context;
}

// Continuous where the angle wraps: the sign of y separates the halves left and right of the center column.
SH_FUNC vec4 panorama(vec3 d) {
  vec2 uv = equirectangular(d);
  return vec4(abs(uv.x - 0.5f), (uv.x - 0.5f) * d.y, uv.y, 0.0f);
}

SH_FUNC vec4 reflectanceOf(Arguments a) {
  Reflectance r = reflectance(a.c, a.u.x, vec2(0.9f * a.u.y, 0.1f * a.u.z));
  return vec4(r.once.x, r.once.y, r.more.x, r.more.y);
}

SH_FUNC vec4 surfaceReflectanceOf(Arguments a) {
  SurfaceReflectance r = surfaceReflectance(someSurface(a), vec2(0.9f * a.u.y, 0.1f * a.u.z));
  return vec4(r.once.x, r.once.y, r.scattered.x, r.scattered.y);
}

// All layers at once; the film and the volume depend on `k`.
SH_FUNC SurfaceLayers someLayers(Arguments a) {
  SurfaceLayers l = emptyLayers();
  vec3 other = abs(a.n.z) < 0.9f ? vec3(0.0f, 0.0f, 1.0f) : vec3(1.0f, 0.0f, 0.0f);
  l.clearcoat = a.u.x;
  l.clearcoatRoughness = 0.1f + 0.9f * a.u.z;
  l.clearcoatNormal = a.n;
  l.sheenColor = a.d * 0.9f;
  l.sheenRoughness = a.u.w;
  l.anisotropy = a.u.z;
  l.anisotropyDirection = normalize(cross(a.n, other));
  l.iridescence = (a.k & 1u) == 0u ? 0.0f : a.u.w;
  l.iridescenceIor = 1.1f + a.u.x;
  l.iridescenceThickness = 1000.0f * a.u.y;
  l.ior = 1.2f + a.u.z;
  l.transmission = a.u.w;
  l.thickness = (a.k & 2u) == 0u ? 0.0f : a.u.x;
  l.absorption = absorptionOf(a.c, a.w.x);
  l.dispersion = (a.k & 4u) == 0u ? 0.0f : a.u.y;
  l.diffuseTransmission = a.u.z;
  l.diffuseTransmissionColor = a.c;
  return l;
}

SH_FUNC LayeredBrdf someLayered(Arguments a, uint shading) {
  LayerTables t = layerTableCoordinates(someSurface(a), someLayers(a), a.v);
  t.base = vec2(0.5f + 0.4f * t.base.x, 0.1f * t.base.y);
  t.coat = vec2(0.5f + 0.4f * t.coat.x, 0.1f * t.coat.y);
  t.behind = vec2(0.5f + 0.4f * t.behind.x, 0.1f * t.behind.y);
  return layeredBrdf(someSurface(a), someLayers(a), a.v, shading, t);
}

SH_FUNC StretchedFrame someFrame(Arguments a) {
  return stretchedFrame(a.n, someLayers(a).anisotropyDirection, 0.1f + 0.9f * a.u.x, a.u.y);
}

SH_FUNC vec4 stretchedLobeOf(Arguments a) {
  float nl = clamp(dot(a.n, a.l), 0.01f, 1.0f);
  float nv = clamp(dot(a.n, a.v), 0.01f, 1.0f);
  return pad(stretchedLobe(someFrame(a), a.l, a.v, halfVector(a.l, a.v), nl, nv));
}

SH_FUNC vec4 stretchedSampleOf(Arguments a) {
  LobeSample r = stretchedSample(someFrame(a), a.v, clamp(dot(a.n, a.v), 0.01f, 1.0f), a.k % 80u, 80u);
  return vec4(r.toLight.x, r.toLight.y, r.weight, r.solidAngle);
}

SH_FUNC vec4 sheenSampleOf(Arguments a) {
  float nv = clamp(dot(a.n, a.v), 0.01f, 1.0f);
  SheenSample r = sheenSample(a.n, alongEye(a.n, a.v), a.v, nv, a.u.x, a.k % kSheenSamples);
  return vec4(r.toLight.x, r.toLight.y, r.toLight.z, r.weight);
}

// The lobe under radiance of two colors.
SH_FUNC vec4 stretchedSumOf(Arguments a) {
  LayeredBrdf b = someLayered(a, kShadingGgx);
  FilmCurve film = filmCurve(b);
  StretchedSum sum = emptySum();
  for (uint i = 0u; i < 4u; ++i) addSample(sum, b, film, baseSample(b, 20u * i), a.c);
  return pad(meanOfSum(b, sum) + b.once);
}

SH_FUNC vec4 layeredLightOf(Arguments a, uint shading) {
  return pad(shadeLayeredLight(someLayered(a, shading), someSample(a), shading));
}

SH_FUNC vec4 layeredEnvironmentOf(Arguments a) {
  LayerLight light;
  light.front = a.c;
  light.back = a.d;
  light.sheen = a.c;
  light.base = a.d;
  light.coat = a.c;
  return pad(shadeLayeredEnvironment(someLayered(a, kShadingGgx), light));
}

SH_FUNC vec4 transmittedRayOf(Arguments a) {
  TransmittedRay ray = transmittedRay(someLayered(a, kShadingGgx), a.k % 3u);
  return vec4(ray.direction.x, ray.direction.y, ray.direction.z, ray.roughness);
}

#define FUNCTION_CASES(C)                                                                                              \
  C(srgbFromLinear, 2e-6f, 1e-7f, (pad(srgbFromLinear(a.u.x))))                                                        \
  C(linearFromSrgb, 4e-6f, 1e-7f, (pad(linearFromSrgb(a.u.x))))                                                        \
  C(linearFromByte, 2e-6f, 1e-7f, (pad(linearFromByte(floor(a.u.x * 255.0f) * (1.0f / 255.0f)))))                      \
  C(luminance, 5e-7f, 0.0f, (pad(luminance(a.c))))                                                                     \
  C(maxChannel, 0.0f, 0.0f, (pad(maxChannel(a.c))))                                                                    \
  C(lightWindow, 1e-6f, 3e-6f, (pad(lightWindow(a.w.x, a.w.y))))                                                       \
  C(spotCone, 2e-5f, 0.0f, (coneOf(a)))                                                                                \
  C(directionalLight, 0.0f, 0.0f, (pad(sampleLight(someLight(a, kLightDirectional), a.v).toLight)))                    \
  C(pointDirection, 1e-6f, 5e-7f, (pad(sampleLight(someLight(a, kLightPoint), a.v).toLight)))                          \
  C(pointIrradiance, 1e-4f, 1e-5f, (pad(irradianceOf(sampleLight(someLight(a, kLightPoint), a.v * 0.5f)))))            \
  C(spotIrradiance, 1e-4f, 1e-5f, (pad(irradianceOf(sampleLight(someLight(a, kLightSpot), a.v * 0.5f)))))              \
  C(ggxAlpha, 2e-7f, 0.0f, (pad(ggxAlpha(a.u.x))))                                                                     \
  C(ggxDistribution, 5e-6f, 0.0f, (pad(ggxDistribution(a.u.x, 1.0f - a.u.x * a.u.x, ggxAlpha(a.u.y)))))                \
  C(ggxVisibility, 3e-6f, 0.0f, (pad(ggxVisibility(a.u.x + 1e-4f, a.u.z + 1e-4f, ggxAlpha(a.u.y)))))                   \
  C(schlickWeight, 1e-6f, 0.0f, (pad(schlickWeight(a.u.x))))                                                           \
  C(schlick, 5e-7f, 5e-7f, (pad(schlick(a.c, a.u.y, a.u.x))))                                                          \
  C(exponentFromRoughness, 2e-6f, 1e-6f, (pad(exponentFromRoughness(a.u.x))))                                          \
  C(roughnessFromExponent, 1e-6f, 0.0f, (pad(roughnessFromExponent(a.w.x))))                                           \
  C(log2Cosine, 3e-6f, 5e-7f, (pad(log2Cosine(a.u.x + 1e-4f, 1.0f - a.u.x * a.u.x))))                                  \
  C(blinnPhong, 5e-4f, 1e-6f, (pad(blinnPhong(a.u.x, 1.0f - a.u.x * a.u.x, a.w.x, blinnPhongScale(a.w.x)))))           \
  C(diffuseColor, 2e-7f, 1e-7f, (pad(diffuseColor(someSurface(a)))))                                                   \
  C(specularF0, 2e-7f, 2e-7f, (pad(specularF0(someSurface(a)))))                                                       \
  C(specularF90, 2e-7f, 2e-7f, (pad(specularF90(someSurface(a)))))                                                     \
  C(withoutReflection, 0.0f, 0.0f, (pad(specularF0(withoutReflection(someSurface(a))))))                               \
  C(shadeLightGgx, 2e-3f, 1e-6f,                                                                                       \
    (pad(shadeLight(surfaceBrdf(someSurface(a), a.v, kShadingGgx), someSample(a), kShadingGgx))))                      \
  C(shadeLightBlinnPhong, 2e-3f, 1e-6f,                                                                                \
    (pad(shadeLight(surfaceBrdf(someSurface(a), a.v, kShadingBlinnPhong), someSample(a), kShadingBlinnPhong))))        \
  C(shadeLightGgxCompensated, 2e-3f, 1e-6f,                                                                            \
    (pad(                                                                                                              \
        shadeLight(surfaceBrdf(someSurface(a), a.v, kShadingGgxCompensated), someSample(a), kShadingGgxCompensated)))) \
  C(charlieDistribution, 1e-4f, 1e-7f, (pad(charlieDistribution(a.u.x, charlieAlpha(a.u.y)))))                         \
  C(charlieLambda, 2e-5f, 1e-7f, (pad(charlieLambda(a.u.x + 1e-3f, charlieAlpha(a.u.y)))))                             \
  C(charlieAlbedo, 2e-4f, 1e-7f, (pad(charlieAlbedo(a.u.x, a.u.y))))                                                   \
  C(charlieLobe, 1e-4f, 1e-7f, (pad(charlieLobe(a.u.x, a.u.z + 0.01f, a.u.w + 0.01f, charlieAlpha(a.u.y), 1.0f))))     \
  C(stretchedLobe, 1e-4f, 1e-6f, (stretchedLobeOf(a)))                                                                 \
  C(stretchedSample, 1e-4f, 1e-5f, (stretchedSampleOf(a)))                                                             \
  C(stretchedSum, 1e-3f, 1e-4f, (stretchedSumOf(a)))                                                                   \
  C(sheenSample, 1e-4f, 1e-5f, (sheenSampleOf(a)))                                                                     \
  C(levelOfShare, 0.0f, 0.0f, (pad(levelOfShare(a.u.x))))                                                              \
  C(thinFilm, 1e-5f, 2e-5f, (pad(thinFilm(a.c, 1.0f + a.u.x, 1500.0f * a.u.y, a.u.z))))                                \
  C(absorptionOf, 1e-5f, 1e-6f, (pad(absorptionOf(a.c, 1.0f + a.w.x))))                                                \
  C(beersLaw, 1e-5f, 0.0f, (pad(beersLaw(a.c, a.u.x))))                                                                \
  C(dispersedIor, 5e-7f, 0.0f, (pad(dispersedIor(1.0f + a.u.x, a.u.y, a.k % 3u))))                                     \
  C(refractedRay, 1e-6f, 2e-6f, (pad(refractedRay(a.n, a.v, clamp(dot(a.n, a.v), 0.01f, 1.0f), 1.0f + a.u.x))))        \
  C(layeredLightGgx, 2e-3f, 1e-5f, (layeredLightOf(a, kShadingGgx)))                                                   \
  C(layeredLightBlinnPhong, 2e-3f, 1e-5f, (layeredLightOf(a, kShadingBlinnPhong)))                                     \
  C(layeredLightGgxCompensated, 2e-3f, 1e-5f, (layeredLightOf(a, kShadingGgxCompensated)))                             \
  C(layeredEnvironment, 2e-5f, 1e-5f, (layeredEnvironmentOf(a)))                                                       \
  C(transmittedRadiance, 2e-5f, 1e-5f, (pad(transmittedRadiance(someLayered(a, kShadingGgx), a.c))))                   \
  C(transmittedRay, 1e-6f, 2e-6f, (transmittedRayOf(a)))                                                               \
  C(reflectance, 2e-6f, 2e-7f, (reflectanceOf(a)))                                                                     \
  C(surfaceReflectance, 2e-6f, 1e-6f, (surfaceReflectanceOf(a)))                                                       \
  C(specularOcclusion, 2e-6f, 1e-6f, (pad(specularOcclusion(a.u.x + 1e-4f, a.u.y, a.u.z))))                            \
  C(shadeEnvironment, 5e-6f, 2e-6f,                                                                                    \
    (pad(shadeEnvironment(someSurface(a), a.v, a.c, a.d, vec2(0.9f * a.u.x, 0.1f * a.u.w)))))                          \
  C(tonemapKhronosNeutral, 5e-6f, 1e-6f, (pad(tonemap(kTonemapKhronosNeutral, a.c * a.w.x))))                          \
  C(tonemapAces, 1e-5f, 1e-6f, (pad(tonemap(kTonemapAces, a.c * a.w.x))))                                              \
  C(tonemapAgx, 5e-5f, 5e-6f, (pad(tonemap(kTonemapAgx, a.c * a.w.x))))                                                \
  C(tonemapReinhard, 1e-6f, 0.0f, (pad(tonemap(kTonemapReinhard, a.c * a.w.x))))                                       \
  C(tonemapNone, 0.0f, 0.0f, (pad(tonemap(kTonemapNone, a.c * a.w.x))))                                                \
  C(octahedralFromDirection, 5e-7f, 5e-7f, (pad(octahedralFromDirection(a.n))))                                        \
  C(directionFromOctahedral, 5e-7f, 5e-7f, (pad(directionFromOctahedral(vec2(a.u.x * 2.0f - 1.0f, a.n.y)))))           \
  C(rotateToEnvironment, 5e-7f, 5e-7f, (pad(rotateToEnvironment(a.n, a.l.x, a.l.y))))                                  \
  C(lobeDirection, 5e-7f, 3e-6f, (pad(lobeDirection(a.n, a.v, 0.99f * a.u.x))))                                        \
  C(lobeTexture, 5e-7f, 0.0f, (pad(lobeTexture(a.u.x, a.u.y, 16.0f))))                                                 \
  C(octahedralTexture, 5e-7f, 0.0f, (pad(octahedralTexture(vec2(a.n.x, a.n.y), 64.0f))))                               \
  C(equirectangular, 0.0f, 8e-5f, (panorama(a.n)))                                                                     \
  C(projectToClip, 5e-7f, 5e-4f, (projectToClip(someProjection(a), a.n * a.w.x)))                                      \
  C(viewDepth, 5e-6f, 0.0f, (pad(viewDepth(someProjection(a), a.u.z))))                                                \
  C(deviceDepth, 5e-7f, 1e-6f, (pad(deviceDepth(someProjection(a), a.w.x))))                                           \
  C(viewPositionAtDepth, 1e-6f, 5e-4f, (pad(viewPositionAtDepth(someProjection(a), vec2(a.n.x, a.n.y), a.w.x))))       \
  C(viewRay, 1e-6f, 5e-7f, (pad(viewRay(someProjection(a), vec2(a.n.x, a.n.y)))))                                      \
  C(pixelToNdc, 5e-7f, 5e-7f, (pad(pixelToNdc(vec2(a.w.x, a.w.y), vec2(640.0f, 480.0f)))))                             \
  C(positionFromDepth, 1e-5f, 1e-4f, (pad(positionFromDepth(someContext(a)))))                                         \
  C(rotateToView, 1e-6f, 1e-6f, (pad(rotateToView(someContext(a).view, a.v))))                                         \
  C(rotateToWorld, 1e-6f, 1e-6f, (pad(rotateToWorld(someContext(a).view, a.v))))                                       \
  C(toBits, 0.0f, 1.0f, (pad(float(toBits(a.u.x, 12u)))))                                                              \
  C(fromBits, 3e-7f, 0.0f, (pad(fromBits(a.k, 1u + (a.k >> 28u)))))                                                    \
  C(packNormal24, 0.0f, 3.0e-3f, (pad(unpackNormal24(someEncoding(a), packNormal24(someEncoding(a), a.n)))))           \
  C(unpackNormal24, 5e-7f, 5e-7f, (pad(unpackNormal24(someEncoding(a), a.k & 0xffffffu))))                             \
  C(packColor24, 0.0f, 1.0f, (bytes(packColor24(a.c))))                                                                \
  C(samplePlace, 3e-7f, 0.0f, (pad(samplePlace(someSamples(a), (a.k >> 8u) % someSamples(a)))))                        \
  C(unpackColor24, 4e-6f, 1e-7f, (pad(unpackColor24(a.k))))

// Does not return early, because compilers nest such branches, and lavapipe ignores conditions more than 80 deep.
SH_FUNC vec4 evaluateFunction(uint function, Arguments a) {
  uint index = 0u;
  vec4 found = vec4(0.0f, 0.0f, 0.0f, 0.0f);
#define EVALUATE(name, relative, absolute, result) \
  if (function == index) found = result;           \
  index += 1u;
  FUNCTION_CASES(EVALUATE)
#undef EVALUATE
  return found;
}

SH_END

#endif
