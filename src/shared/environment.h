// Lookups into an environment: directions to maps and back.
#ifndef LATELIGHT_SHARED_ENVIRONMENT_H
#define LATELIGHT_SHARED_ENVIRONMENT_H

#include "shared/lang.h"
#include "shared/normal/octahedral.h"

SH_BEGIN

// World direction to the environment's own frame: a turn about Z. At 0 the picture's centre column is at +X; at +90
// degrees it is at +Z of the glTF frame, which is -Y of the world.
SH_FUNC vec3 rotateToEnvironment(vec3 d, float cosine, float sine) {
  return vec3(cosine * d.x - sine * d.y, sine * d.x + cosine * d.y, d.z);
}

// Texture coordinate in [0, 1]^2 of an octahedral map `size` texels wide, its border of one texel included.
SH_FUNC vec2 octahedralTexture(vec2 o, float size) {
  float scale = (size - 2.0f) / size * 0.5f;
  return vec2(0.5f + o.x * scale, 0.5f + o.y * scale);
}

// Texture coordinate of a direction in an equirectangular picture: centre column +X, u grows towards +Z of the glTF
// frame (-Y of the world), top row the zenith.
SH_FUNC vec2 equirectangular(vec3 d) {
  return vec2(0.5f + atan2(-d.y, d.x) * (0.5f * kInvPi), acos(clamp(d.z, -1.0f, 1.0f)) * kInvPi);
}

SH_END

#endif
