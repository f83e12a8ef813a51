// The colour of a blended or transmissive surface that may have layers.
#include "render/glsl/pixel_ray.glsl"
#include "render/layered/layered_light.glsl"
#include "render/layered/behind.glsl"

// What is seen through the surface: of each channel where its refraction leads, when they are dispersed.
vec3 radianceThrough(FrameConstants frame, uint view, LayeredBrdf b, vec2 own) {
  vec3 found = radianceBehind(frame, view, transmittedRay(b, 1u), own);
  if (!disperses(b)) return found;
  found.r = radianceBehind(frame, view, transmittedRay(b, 0u), own).r;
  found.b = radianceBehind(frame, view, transmittedRay(b, 2u), own).b;
  return found;
}

// The share of the pixel's light that the surface takes the place of.
float coverage(Material m, SurfacePoint p) {
  float alpha = clamp(baseColor(m, p).a, 0.0, 1.0);
  if ((m.flags & kMaterialMasked) != 0u) return alpha < m.alphaCutoff ? 0.0 : 1.0;
  return (m.flags & kMaterialBlended) != 0u ? alpha : 1.0;
}

// As for surfaces without layers: radiance times exposure, premultiplied by alpha, and alpha. What transmission shows takes
// the place of what lies behind. Light from there has passed the fog in front already, which is taken off before the
// surface colours it, and added in front of both.
vec4 blendedColor(FrameConstants frame, uint viewIndex, Material m, SurfacePoint p, vec2 own, bool shows) {
  LayeredPoint point = layeredPoint(frame, viewIndex, m, p);
  float alpha = coverage(m, p);
  LayeredBrdf b = layeredBrdfAt(point);
  vec3 radiance = layeredEnvironment(frame, b, point.toEye);
  radiance += lightsAtPoint(frame, viewIndex, point, b, shows && alpha > 0.0, kEveryLight != 0u);
  vec4 color = vec4(exposedRadiance(frame, point, b, radiance), 1.0), fog = vec4(0.0);
  View view = frameView(frame, viewIndex);
  if (frame.fog.density > 0.0) {
    fog = throughFog(frame.fog, view, point.s.position, vec4(0.0));
    color = throughFog(frame.fog, view, point.s.position, color);
  }
  if (b.layers.transmission > 0.0) {
    vec3 through = max(radianceThrough(frame, viewIndex, b, own) - fog.rgb, vec3(0.0));
    color.rgb = min(color.rgb + transmittedRadiance(b, through), vec3(65504.0));
  }
  return vec4(color.rgb * alpha, alpha);
}
