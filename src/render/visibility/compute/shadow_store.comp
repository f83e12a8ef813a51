#version 460
#extension GL_GOOGLE_include_directive : require
// Converts the visibility buffer of shadow maps to their tiles in the atlas: depth, linear in meters, with the caster's
// slope bias, as in shadow.frag.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/visible_triangle.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/glsl/setup.glsl"
#include "shared/shadow.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { ShadowStorePush push; };
layout(set = 0, binding = 0) writeonly uniform image2DArray atlas;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TargetRef { ShadowTarget v[]; };

// Returns the slope of the triangle's plane: the change of y per texel to the right and down.
vec2 slopes(FrameConstants frame, View view, uint id, float y, vec2 texel) {
  VisibleTriangle t = visibleTriangle(frame, push.instances, id);
  vec3 corners[3] = cornersOf(frame, view, t);
  vec3 n = cross(corners[1] - corners[0], corners[2] - corners[0]);
  vec2 steps = vec2(2.0 / view.projection.H, 2.0 / view.projection.V) / float(push.size);
  if (view.projection.kind == kOrthographic) return -vec2(n.x, n.z) * steps / n.y;
  vec3 ray = viewRay(view.projection, pixelToNdc(texel, view.size));
  return -y * vec2(n.x, n.z) * steps / dot(n, ray);
}

float biasedDepth(FrameConstants frame, View view, ShadowTarget target, uint64_t visible, vec2 texel) {
  float y = viewDepth(view.projection, visibleDepth(visible));
  vec2 rise = 2.0 * target.A * slopes(frame, view, visibleId(visible), y, texel);
  float steep = abs(rise.x) + abs(rise.y);
  float unit = target.unit * (target.far > 0.0 ? y / target.far : 1.0);
  // A plane seen edge-on gets the steepest finite bias.
  float bias = shadowCasterBias(steep < 3.0e38 ? steep : 3.0e38, 0.0, unit, kShadowFilter);
  return clamp(2.0 * (target.A * y + target.B) + bias, 0.0, kShadowFarthest);
}

bool isDrawn(ShadowTarget target, uvec2 texel) {
  uvec2 page = texel / kRasterTile;
  return (UintRef(push.pages).v[target.firstRow + page.y * target.rowStep] >> page.x & 1u) != 0u;
}

void main() {
  uvec3 at = gl_GlobalInvocationID;
  if (at.x >= push.size || at.y >= push.size) return;
  ShadowTarget target = TargetRef(push.targets).v[at.z];
  if (!isDrawn(target, at.xy)) return;
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  uint64_t visible = VisibleRef(push.visible).v[visibleIndex(at, uvec2(push.size))];
  bool shows = visible != uint64_t(0);
  float depth = 1.0;
  if (shows) depth = biasedDepth(frame, frameView(frame, at.z), target, visible, vec2(at.xy) + 0.5);
  // Empty texels hold the farthest depth. rgba8-classic packs 1 as 0, so there they hold a value that no depth packs
  // to.
  vec4 texel = vec4(depth);
  if (kShadowFormat == kShadowRgba8) texel = packDepth(depth);
  if (kShadowFormat == kShadowRgba8Classic) texel = shows ? packDepthClassic(depth) : vec4(1.0);
  imageStore(atlas, ivec3(target.x + at.x, target.y + at.y, target.layer), texel);
}
