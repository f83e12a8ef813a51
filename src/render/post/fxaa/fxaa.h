// FXAA (docs/post/fxaa.md): composes the picture and softens its jagged edges.
#pragma once

#include "render/post/resolve.h"

namespace latelight::render {

// Like addCompose().
void addFxaa(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultPlace& to);

}  // namespace latelight::render
