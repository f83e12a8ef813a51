// Post-processing, after a picture's frames are lit: the list of passes is in post.cpp. Each effect is a folder next to
// this file.
#pragma once

#include <optional>

#include "render/pass.h"
#include "render/readback.h"
#include "render/settings.h"

namespace latelight::render {

struct FinishedPicture {
  graph::ImageId linear;  // before the tonemap; fog and bloom included
  float scale = 1;        // by which it still has to be multiplied
};

// `scale`: 1 / number of frames summed in `picture`. `display`: where the picture to look at is to go, as from
// addCompose(); none: nobody does.
FinishedPicture finishPicture(const Builder& b, graph::ImageId picture, float scale, const Settings& settings,
                              const std::optional<ResultPlace>& display);

}  // namespace latelight::render
