// FXAA, fast approximate anti-aliasing (docs/post/fxaa.md): composes the picture and softens its jagged edges.
#pragma once

#include "render/post/resolve.h"

namespace latelight::render {

// Writes the finished picture as addCompose() does, with FXAA.
void addFxaa(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultTarget& to);

}  // namespace latelight::render
