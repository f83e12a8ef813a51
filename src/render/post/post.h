// Post-processing, after a picture's frames are lit: the list of passes is in post.cpp. Each effect is a folder next to
// this file.
#pragma once

#include "render/pass.h"
#include "render/settings.h"

namespace latelight::render {

struct FinishedPicture {
  graph::ImageId linear;    // before the tonemap; fog and bloom included
  float scale = 1;          // by which it still has to be multiplied
  graph::BufferId display;  // RGBA8 as from addCompose(); none unless asked for
};

// `scale`: 1 / number of frames summed in `picture`.
FinishedPicture finishPicture(const Builder& b, graph::ImageId picture, float scale, const Settings& settings);

}  // namespace latelight::render
