// Parameters of cast.comp: rays from the host, and what they hit.
#ifndef LATELIGHT_RENDER_RAYS_CAST_PUSH_H
#define LATELIGHT_RENDER_RAYS_CAST_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct CastRay {  // origins and directions are pairs of floats, in the device's world space
  vec3 origin;
  float near;  // meters
  vec3 direction;
  float far;
  vec3 originLow;
  uint paddingA;
  vec3 directionLow;
  uint paddingB;
};
SH_CONST uint kCastRayBytes = 64u;

struct CastHit {
  float distance;  // meters; infinite: nothing is hit, and all other members are 0
  uint id, part, material;
  vec3 normal;  // the device's world space
  uint triangle;
  vec3 geonormal;
  uint front;  // 1: the ray hits the front face
  vec2 uv;
  float intensity;  // reflectance at normal incidence times the cosine of the angle of incidence
  uint padding;
};
SH_CONST uint kCastHitBytes = 64u;

struct CastPush {
  uint64_t frame;  // FrameConstants
  uint64_t rays;   // CastRay[count]
  uint64_t hits;   // CastHit[count]
  uint count;
  uint what;  // kRay* of glsl/rays.glsl
};
SH_CONST uint kCastAnySurface = 2u;  // CastPush::what: blended and transmissive surfaces, too

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::CastRay) == latelight::shared::kCastRayBytes);
static_assert(sizeof(latelight::shared::CastHit) == latelight::shared::kCastHitBytes);
#endif

#endif
