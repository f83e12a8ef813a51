// Lights at a surface straight from the light tree, without lists. After lights.glsl.
#include "render/glsl/light_tree.glsl"

// All local lights that the tree has near the surfaces, in the order of the lights.
void shadeTree(inout Shading shading, FrameConstants frame) {
  TreeWalk walk = startWalk(frame, shading.low, shading.high, true);
  uint leaf;
  while (nextLeaf(walk, frame, leaf)) {
    uint end = min(leaf + kLightTreeWidth, frame.lightCount);
    if (shading.lit) lightsTested += float(end - leaf);
    shadeRange(shading, frame, leaf, end);
  }
}
