// Lights at a surface from a list, or straight from the light tree. After lights.glsl.
#include "render/glsl/light_tree.glsl"

// The frame's directional lights, then `count` lights of a list (uint[] by address), then, where `walks`, all local
// lights that the tree has near the surfaces; each part in the order of the lights. One loop for all: shading a light is
// most of a shader, and lavapipe compiles it wherever it stands, and takes more for a loop than for a round of it.
void shadeNear(inout Shading shading, FrameConstants frame, uint64_t list, uint count, bool walks) {
  TreeWalk walk = startWalk(frame, shading.low, shading.high, walks);
  uint next = 0u, end = frame.directionalLights + count;
  if (shading.lit) lightsTested += float(end);
  bool listed = true;
  while (true) {
    if (next >= end) {  // on to a leaf of the tree
      listed = false;
      if (!nextLeaf(walk, frame, next)) break;
      end = min(next + kLightTreeWidth, frame.lightCount);
      if (shading.lit) lightsTested += float(end - next);
    }
    uint light = min(next + laneRank, end - 1u);
    if (listed && light >= frame.directionalLights) light = UintRef(list).v[light - frame.directionalLights];
    DealtLight mine = dealtLight(frame, shading.view, light);
    shadeDealt(shading, frame, mine, next + laneRank < end && reaches(mine.light, shading.low, shading.high));
    next += lanesPresent;
  }
}
