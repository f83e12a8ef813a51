// The visibility buffer by rays (docs/compute.md#rays): a ray per sample through the BVHs of the scene or of the view's
// world instead of rasterization. The time grows with the number of pixels, and hardly with that of triangles.
#pragma once

#include "render/frame/frame.h"
#include "render/visibility/compute/raster_instances.h"

namespace latelight::render {

// Adds a visibility buffer of the frame's views. `share`: the instances that rays may hit. `blendedToo`: rays hit
// blended surfaces with alpha above 0, and transmissive ones.
VisibilityBuffer addTracedSurfaces(const FrameContext& f, const RasterInstances& rasterInstances,
                                   const RasterInstances::Share& share, bool blendedToo);

}  // namespace latelight::render
