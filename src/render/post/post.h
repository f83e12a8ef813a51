// What happens to a picture after its frames are lit: the list of post-processing passes (post.cpp). Each effect is a
// folder beside this file.
#pragma once

#include "render/pass.h"
#include "render/settings.h"

namespace latelight::render {

struct FinishedPicture {
  graph::ImageId linear;    // before the tonemap; fog and bloom included
  float scale = 1;          // that it still has to be multiplied by
  graph::BufferId display;  // RGBA8 as addCompose() has it; none unless asked for
};

// `scale`: 1 / number of frames that `picture` is the sum of.
FinishedPicture finishPicture(const Builder& b, graph::ImageId picture, float scale, const Settings& settings);

}  // namespace latelight::render
