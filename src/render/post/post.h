// Post-processing of a picture after all of its frames are lit: bloom, tone mapping and FXAA, in the order in post.cpp.
// Each effect has a folder next to this file.
#pragma once

#include <optional>

#include "render/base/pass.h"
#include "render/base/readback.h"
#include "render/settings/settings.h"

namespace latelight::render {

struct FinishedPicture {
  graph::ImageId linear;  // before tone mapping, with fog and bloom
  float scale = 1;        // factor still to be applied to `linear`
};

// `scale` is 1 / number of frames summed in `picture`. `display` is the destination of the finished picture, as written
// by addCompose(); if none, only the linear picture is computed. `covered`: as in ComposeSettings, of `picture`.
FinishedPicture finishPicture(const Builder& b, graph::ImageId picture, float scale, const Settings& settings,
                              const std::optional<ResultTarget>& display, graph::BufferId covered = {});

}  // namespace latelight::render
