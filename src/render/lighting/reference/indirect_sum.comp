#version 460
#extension GL_GOOGLE_include_directive : require
// Adds filtered indirect light, times the albedos of its lobes, to the lit picture.
#include "render/glsl/common.glsl"
#include "render/lighting/reference/indirect_filter_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray scatteredLight;
layout(set = 0, binding = 1) uniform sampler2DArray mirroredLight;
layout(set = 0, binding = 2) uniform sampler2DArray scatteredAlbedo;
layout(set = 0, binding = 3) uniform sampler2DArray mirroredAlbedo;
layout(set = 0, binding = 4, rgba16f) uniform image2DArray litPicture;

layout(push_constant, scalar) uniform Push { IndirectFilterPush push; };

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(litPicture).xy))) return;
  vec4 mirrored = texelFetch(mirroredAlbedo, place, 0);
  if (mirrored.a == 0.0) return;
  vec3 light = texelFetch(scatteredLight, place, 0).rgb * texelFetch(scatteredAlbedo, place, 0).rgb +
               texelFetch(mirroredLight, place, 0).rgb * mirrored.rgb;
  vec4 before = imageLoad(litPicture, place);
  vec3 after = clamp(before.rgb + light * frameOf(push.frame, uint(place.z)).exposure, vec3(0.0), vec3(65504.0));
  imageStore(litPicture, place, vec4(after, before.a));
}
