#version 460
#extension GL_GOOGLE_include_directive : require
// Lists the tiles that show materials of each texture group (GpuMaterials::textureGroups()). Input: the covered tiles,
// and the visible triangles. Output: CoveredTiles of each group.
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/covered_tiles.glsl"
#include "render/glsl/pixel_group.glsl"
#include "render/visibility/group_resolve_push.h"
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require

layout(set = 0, binding = 0) uniform usampler2DArray triangles;
layout(push_constant, scalar) uniform Push { GroupTilesPush push; };

shared uint groups;  // bit i: the tile shows a material of group i

void main() {
  uvec3 block = ownBlock(push.covered);
  ivec3 pixel = pixelOf(block);
  if (gl_LocalInvocationID.x == 0u) groups = 0u;
  barrier();
  uint own = 0u;
  if (all(lessThan(pixel.xy, textureSize(triangles, 0).xy))) {
    uint instance = texelFetch(triangles, pixel, 0).x;
    if (instance != 0u) {
      FrameConstants frame = frameOf(push.frame, block.z);
      uint material = frameInstance(frame, instance - 1u).material;
      own = 1u << textureGroup(frameMaterial(frame, material).textures);
    }
  }
  uint shown = subgroupOr(own);
  if (subgroupElect()) atomicOr(groups, shown);
  barrier();
  uint group = gl_LocalInvocationID.x;
  if (group < kMaxTextureGroups && (groups >> group & 1u) != 0u)
    appendTile(push.lists + uint64_t(group) * push.bytes, block);
}
