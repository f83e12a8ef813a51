#version 460
#extension GL_GOOGLE_include_directive : require
// Lists the tiles of kPixelGroupX x kPixelGroupY pixels in which any pixel shows a surface. Input: the depth image.
// Output: CoveredTiles, in any order. Each subgroup tests one tile.
#include "render/glsl/common.glsl"
#include "render/glsl/covered_tiles.glsl"
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require

layout(local_size_x = 128) in;
layout(set = 0, binding = 0) uniform sampler2DArray depthImage;  // reversed; 0: background
layout(push_constant, scalar) uniform Push { CoveredTilesPush push; };

void main() {
  uvec3 tile = uvec3(gl_WorkGroupID.x * gl_NumSubgroups + gl_SubgroupID, gl_WorkGroupID.yz);
  ivec2 size = textureSize(depthImage, 0).xy, corner = ivec2(tile.xy * uvec2(kPixelGroupX, kPixelGroupY));
  bool inside = corner.x < size.x;
  float nearest = 0.0;
  uint i = gl_SubgroupInvocationID;
  do {  // tested at the end, because lavapipe would execute the body once more
    // lavapipe gathers four texels in less time than it fetches two. Those outside of the image are those at its edge.
    ivec2 quad = corner + 2 * ivec2(i % (kPixelGroupX / 2u), i / (kPixelGroupX / 2u));
    vec4 four = textureGather(depthImage, vec3(vec2(quad + 1) / vec2(size), tile.z));
    nearest = max(nearest, max(max(four.x, four.y), max(four.z, four.w)));
    i += gl_SubgroupSize;
  } while (i < kPixelGroupX * kPixelGroupY / 4u);
  if (subgroupAny(nearest > 0.0) && inside && subgroupElect()) appendTile(push.covered, tile);
}
