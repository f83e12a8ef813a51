// Packs data outputs of surfaces from the images of the geometry pass (hardware raster), as surface_outputs.glsl packs
// them from resolved surfaces. Include after surface_outputs.glsl, and define packedTargets().
#include "render/glsl/covered_tiles.glsl"
#include "render/glsl/pixel_group.glsl"
#include "render/glsl/uniform_loads.glsl"

layout(set = 0, binding = 0) uniform sampler2DArray depthImage;
layout(push_constant, scalar) uniform Push { PackSurfacesPush push; };

// Returns the words of a pixel that outputs are packed from.
ExactTargets packedTargets(ivec3 pixel);

void main() {
  uvec3 block = ownBlock(push.covered);
  View view = uniformView(uniformFrame(push.frame, block.z), block.z);
  ivec3 pixel = pixelOf(block);
  ivec2 size = textureSize(depthImage, 0).xy;
  if (any(greaterThanEqual(pixel.xy, size))) return;
  float depth = texelFetch(depthImage, pixel, 0).r;
  writePushedOutputs(push.frame, view, push.slots, packedTargets(pixel), depth, pixel, size.x);
}
