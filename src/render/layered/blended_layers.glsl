// Forward shading of a blended or transmissive surface that may have coats, with refraction of the background in screen
// space (KHR_materials_transmission, KHR_materials_volume, KHR_materials_dispersion).
#include "render/glsl/pixel_ray.glsl"
#include "render/layered/layered_light.glsl"
#include "render/layered/behind.glsl"

// The radiance transmitted through the surface. With dispersion, each channel follows its own refracted ray.
vec3 radianceThrough(FrameConstants frame, uint view, LayeredBrdf b, vec2 own) {
  vec3 found = backgroundRadiance(frame, view, transmittedRay(b, 1u), own);
  if (!disperses(b)) return found;
  found.r = backgroundRadiance(frame, view, transmittedRay(b, 0u), own).r;
  found.b = backgroundRadiance(frame, view, transmittedRay(b, 2u), own).b;
  return found;
}

// The fraction of the background that the surface replaces.
float coverage(Material m, SurfacePoint p) {
  float alpha = clamp(baseColor(m, p).a, 0.0, 1.0);
  if ((m.flags & kMaterialMasked) != 0u) return alpha < m.alphaCutoff ? 0.0 : 1.0;
  return (m.flags & kMaterialBlended) != 0u ? alpha : 1.0;
}

// As blendedColor() for surfaces without coats: returns radiance times exposure, premultiplied by alpha, and alpha.
// Transmitted light replaces the background. The background already includes the light of the fog in front of the
// surface, so that light is subtracted before the surface tints the background, and fog is added once, in front of
// both.
vec4 blendedColor(FrameConstants frame, uint viewIndex, Material m, SurfacePoint p, vec2 own, bool shows) {
  LayeredPoint point = layeredPoint(frame, viewIndex, m, p);
  float alpha = coverage(m, p);
  LayeredBrdf b = layeredBrdfAt(point);
  vec3 radiance = layeredEnvironment(frame, b, point.toEye);
  radiance += layeredAreaLight(frame, b);
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
