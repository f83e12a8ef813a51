// What the lighting shaders do around their lights: a pixel's surface and the environment's light on it, and the result.
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/environment.glsl"

struct LitPixel {
  ivec3 place;  // and view
  bool inside;  // the picture
  bool lit;     // a surface is there
  float depth;  // of the device
  Surface s;
  vec3 toEye;
  vec3 emitted;   // what the geometry pass left, exposure included
  vec3 radiance;  // by the environment
};

LitPixel readPixel(FrameConstants frame, View view, ivec3 place) {
  LitPixel p;
  p.place = place;
  p.inside = all(lessThan(vec2(place.xy), view.size));
  p.depth = p.inside ? texelFetch(gbufferDepth, place, 0).r : 0.0;
  p.lit = p.depth != 0.0;
  p.s = emptySurface();
  p.toEye = vec3(0.0, 0.0, 1.0);
  p.emitted = vec3(0.0);
  p.radiance = vec3(0.0);
  if (p.lit) {
    vec4 accumulated = imageLoad(lightTarget, place);
    p.emitted = accumulated.rgb;
    p.s = readSurface(view, place, p.depth, accumulated.a);
    p.s.ao *= visibleHemisphere(place);
    if ((p.s.flags & kSurfaceUnlit) != 0u) p.s = withoutReflection(p.s);
    p.toEye = directionToEye(view, p.s.position);
    p.radiance = environmentLight(frame, p.s, p.toEye);
  }
  return p;
}

// `counts`: lights tested and used.
void writePixel(FrameConstants frame, LitPixel p, vec3 byLights, vec4 counts) {
  vec3 radiance = p.emitted + (p.radiance + byLights) * frame.exposure;
  if (p.inside) imageStore(lightTarget, p.place, p.lit ? vec4(min(radiance, vec3(65504.0)), 1.0) : vec4(0.0));
  if (kCountLights != 0u && p.inside) imageStore(lightCounts, p.place, p.lit ? counts : vec4(0.0));
}
