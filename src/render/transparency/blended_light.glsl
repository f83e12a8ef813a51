// Forward shading of a point of a blended surface, with the same material, BRDF and lights, in the same order, as
// deferred surfaces. Include after fragment_point.glsl or surface_point.glsl, which provide the point and its textures.
// Lights come from the light tree, because a fragment lies in front of the surfaces for which the lists of `tiled` and
// `clustered` are built.
#include "render/glsl/surface.glsl"
#include "shared/gbuffer.h"
#include "render/glsl/environment.glsl"
#include "render/glsl/area_lights.glsl"
#include "render/glsl/fog.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/tree_lights.glsl"

layout(constant_id = kEveryLightConstant) const uint kEveryLight = 0;  // 1: no light tree (reference, or no subgroups)

// Applies the fog in front of a surface. If the surface covers only a fraction of the pixel, so does this fog: the
// surfaces behind it already include their own fog.
vec4 throughFog(Fog fog, View view, vec3 position, vec4 color) {
  vec3 seen = view.worldToView * vec4(position, 1.0);
  return applyFog(fog, color, fogTransmittanceTo(fog, view, seen));
}

#ifdef COATED
#include "render/layered/blended_layers.glsl"
#else
// Returns radiance times exposure, premultiplied by alpha, and alpha. The over operator of glTF 2.0, section 3.9.4,
// applies to all light from the surface, including emission and reflections. Every invocation of the subgroup must call
// it, for the same view; `shows` is false for those without a point. `own` is the point's position in the picture, in
// pixels.
vec4 blendedColor(FrameConstants frame, uint view, Material m, SurfacePoint p, vec2 own, bool shows) {
  Surface s = evaluateMaterial(frame, m, p);
  float alpha = clamp(baseColor(m, p).a, 0.0, 1.0);
  vec3 emitted = emittedRadiance(s);
  s = litSurface(s);
  vec3 toEye = directionToEye(frameView(frame, view), s.position);
  vec3 radiance = environmentLight(frame, s, toEye);
  prepareForLights(s, toEye);
  radiance += areaLight(frame, s, toEye);
  SurfaceBrdf brdf = surfaceBrdf(s, toEye, kShading);
  bool lit = shows && alpha > 0.0;
  radiance += kEveryLight != 0u ? shadeAllLightsPlainly(frame, view, s, brdf) : shadeAllByTree(frame, view, s, brdf,
                                                                                               lit);
  vec3 sum = min(emitted * frame.exposure, vec3(65504.0)) + radiance * frame.exposure;
  vec4 color = vec4(min(sum, vec3(65504.0)), 1.0);
  if (frame.fog.density > 0.0) color = throughFog(frame.fog, frameView(frame, view), s.position, color);
  return vec4(color.rgb * alpha, alpha);
}
#endif
