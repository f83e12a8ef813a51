#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// Evaluates the material of the visible triangle of each pixel (triangle.frag, visible_triangles.comp) once, and writes
// the G-buffer and data outputs, on CPU devices (resolve.h). A dispatch evaluates the materials of one texture group,
// in the tiles that show any.
#define LOADS_TEXELS
#define BINDS_TEXTURES
#include "render/glsl/common.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/glsl/surface.glsl"
#include "render/outputs/surface_outputs.glsl"
#include "render/glsl/gbuffer_write.glsl"
#include "render/glsl/covered_tiles.glsl"
#include "render/glsl/pixel_group.glsl"
#include "render/glsl/uniform_loads.glsl"
#include "render/visibility/group_resolve_push.h"
#ifdef GBUFFER_KEEPS_MOTION
#include "render/visibility/compute/visible_motion.glsl"
#endif
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require

layout(push_constant, scalar) uniform Push { GroupResolvePush push; };
#include "render/visibility/resolve.glsl"

void packSurface(View view, Surface s, float depth, ivec3 pixel) {
  writePushedOutputs(push.frame, view, push.slots, exactTargets(s), depth, pixel, int(view.size.x));
}

layout(set = 0, binding = 1 GBUFFER_TARGETS(COUNT)) uniform usampler2DArray triangles;
layout(set = 0, binding = 2 GBUFFER_TARGETS(COUNT)) uniform sampler2DArray depths;

bool isInGroup(FrameConstants frame, uvec2 drawn) {
  if (drawn.x == 0u) return false;
  if (push.group == kOnlyTextureGroup) return true;
  uint material = frameInstance(frame, drawn.x - 1u).material;
  return textureGroup(frameMaterial(frame, material).textures) == push.group;
}

void main() {
  uvec3 block = ownBlock(push.covered);
  FrameConstants frame = uniformFrame(push.frame, block.z);
  View view = uniformView(frame, block.z);
  ivec3 pixel = pixelOf(block);
  bool inside = all(lessThan(pixel.xy, ivec2(view.size)));
  uvec2 drawn = inside ? texelFetch(triangles, pixel, 0).xy : uvec2(0u);
  bool shown = isInGroup(frame, drawn);
  uvec4 lanes = subgroupBallot(shown);
  if (lanes == uvec4(0u)) return;
  // Lanes that wait also load and compute, on lavapipe, so they do what another lane does.
  drawn = shown ? drawn : subgroupShuffle(drawn, subgroupBallotFindLSB(lanes));
  vec2 place = vec2(pixel.xy) + 0.5;
  float depth = texelFetch(depths, pixel, 0).r;
  VisibleTriangle t = drawnTriangle(frame, drawn);
  if (shown) resolveTriangle(frame, view, pixel, pixel, place, t, depth);
}
