// Tiles of pixels that surfaces cover. On a CPU device a pixel without a surface costs a compute pass as much as one
// with a surface, because both sides of a branch run. Passes that have nothing to do there are therefore dispatched
// indirectly, with one workgroup per covered tile. On a GPU the list would cost more than it saves.
#pragma once

#include "render/frame/covered_tiles_push.h"
#include "render/frame/frame.h"

namespace latelight::render {

// Adds the passes that list the tiles of kPixelGroupX x kPixelGroupY pixels in which `depth` shows a surface. Returns
// null if the device is not a CPU, or if the images are too large for the list.
graph::BufferId addCoveredTiles(const FrameContext& f, graph::ImageId depth);

inline constexpr shared::CoveredTiles kNoTiles{.groups = {0, 0, 1}, .count = 0};
// The bytes of such a list, with space for all tiles of the frame.
uint64_t coveredTilesBytes(const FrameContext& f);

// Restricts a pass whose shader calls ownBlock() (glsl/covered_tiles.glsl) to these tiles; if null, to nothing. The
// shader finds the list at coveredAddress().
void restrictTo(graph::BufferId covered, ComputePass& pass);
VkDeviceAddress coveredAddress(graph::BufferId covered, graph::Context& context);

}  // namespace latelight::render
