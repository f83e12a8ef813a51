// Coordinates on the visible surfaces, as data outputs: where a point lies in its triangle and in its object, and the
// tangent frame there.
#pragma once

#include <string_view>

#include "render/frame/frame.h"

namespace latelight::render {

// Returns the output of Origin::Coordinates with this name, one texel per pixel. `triangles`: addTriangles() of the
// same views (visibility/visibility.h).
graph::ImageId addSurfaceCoordinate(const FrameContext& f, graph::ImageId triangles, std::string_view name);

}  // namespace latelight::render
