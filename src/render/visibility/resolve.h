// Evaluation of the materials of visible triangles in compute (resolve.glsl).
#pragma once

#include "render/frame/frame.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// Creates the targets of the setup's layout. Returns those that are written (writtenTargets()).
uint32_t createTargets(const FrameContext& f, Gbuffer& gbuffer);

struct TargetUses {
  graph::Use targets, light;  // StorageWrite or StorageReadWrite
};
// Returns a pass that writes the `written` targets and gbuffer.sampleLight. Its bindings are the targets, then light.
ComputePass resolvePass(const FrameContext& f, const Gbuffer& gbuffer, uint32_t written, const char* shader,
                        const TargetUses& uses);

// Devices without descriptor indexing bind textures before a dispatch, so there each texture group has a dispatch of
// its own, over the tiles that show it:
//
//   depth, triangles ──► covered tiles ──► tiles of each texture group ──► G-buffer, data outputs
//
// Returns true if a frame's surfaces can be resolved like this: on a CPU device, with one sample per pixel.
bool resolvesByGroup(const FrameContext& f);
// Adds these passes. Requires gbuffer.visible.covered.
void addGroupResolve(const FrameContext& f, Gbuffer& gbuffer, graph::ImageId triangles);

// Returns true if the raster hardware should draw triangles for this instead of the G-buffer. lavapipe executes
// fragment shaders for four times as many pixels as small triangles cover, and a second draw processes all vertices
// once more. Large triangles, however, have few such pixels, and their attributes are not loaded for each one.
bool drawsTriangles(const FrameContext& f);

}  // namespace latelight::render
