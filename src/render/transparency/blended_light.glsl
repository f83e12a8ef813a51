// A point of a blended surface, lit: the same material, BRDF and lights, in the same order, as deferred surfaces get. After
// what finds the point and its textures (fragment_point.glsl, surface_point.glsl). Lights come from the tree: a fragment
// lies in front of the surfaces that the lists of `tiled` and `clustered` are built for.
#include "render/glsl/surface.glsl"
#include "shared/gbuffer.h"
#include "render/glsl/environment.glsl"
#include "render/glsl/fog.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/tree_lights.glsl"

layout(constant_id = 16) const uint kEveryLight = 0;  // the reference, and for devices without subgroups here

// Where the surface covers a share of the pixel, fog in front of it covers the same share: surfaces behind have their
// own fog already.
vec4 throughFog(Fog fog, View view, vec3 position, vec4 color) {
  vec3 seen = view.worldToView * vec4(position, 1.0);
  return seenThroughFog(fog, color, fogTransmittanceTo(fog, view, seen));
}

#ifdef COATED
#include "render/layered/blended_layers.glsl"
#else
// Radiance times exposure, premultiplied by alpha, and alpha: the over operator of glTF 2.0, section 3.9.4, applies to
// everything that leaves the surface, emission and reflections included. Every invocation of the subgroup must call it,
// for the same view; `shows` is false for those without a point. `own`: its place in the picture, in pixels.
vec4 blendedColor(FrameConstants frame, uint view, Material m, SurfacePoint p, vec2 own, bool shows) {
  Surface s = evaluateMaterial(frame, m, p);
  float alpha = clamp(baseColor(m, p).a, 0.0, 1.0);
  vec3 emitted = emittedRadiance(s);
  s = litSurface(s);
  vec3 toEye = directionToEye(frameView(frame, view), s.position);
  vec3 radiance = environmentLight(frame, s, toEye);
  prepareForLights(s, toEye);
  SurfaceBrdf brdf = surfaceBrdf(s, toEye, kShading);
  bool lit = shows && alpha > 0.0;
  radiance += kEveryLight != 0u ? shadeAllLightsPlainly(frame, view, s, brdf) : shadeAllByTree(frame, view, s, brdf, lit);
  vec3 sum = min(emitted * frame.exposure, vec3(65504.0)) + radiance * frame.exposure;
  vec4 color = vec4(min(sum, vec3(65504.0)), 1.0);
  if (frame.fog.density > 0.0) color = throughFog(frame.fog, frameView(frame, view), s.position, color);
  return vec4(color.rgb * alpha, alpha);
}
#endif
