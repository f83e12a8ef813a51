// The rays of a picture through a lens, and the pinhole views that together see along all of them.
#pragma once

#include <list>
#include <memory>
#include <vector>

#include "scene/lens.h"
#include "shared/types.h"
#include "vk/resources.h"

namespace latelight::render {

// Which rays: those of some rows of a picture. `jitter`: as makeView() has it.
struct LensPicture {
  scene::Lens lens;
  uint32_t width, height;  // of the whole picture
  uint32_t first, rows;
  glm::vec2 jitter;
  bool operator==(const LensPicture&) const = default;
};

struct LensRays {
  // shared::LensRay[rows + 2][width]: a strip knows the rows beside it, so that textures are filtered alike. 0 outside
  // of the picture.
  vk::Buffer rays;
  // The pinhole views, of a camera at the world's origin whose axes are the world's. All are of one size.
  std::vector<shared::View> views;
  vk::Buffer starts, pixels;  // the rays in each of their pixels, as shared::LensTarget has them

  LensRays(vk::Device& device, const LensPicture& picture);
};

// The latest: cameras mostly share a lens.
class KeptLensRays {
 public:
  std::shared_ptr<const LensRays> of(vk::Device& device, const LensPicture& picture);

 private:
  struct Entry {
    LensPicture picture;
    std::shared_ptr<const LensRays> rays;
  };
  std::list<Entry> latest_;
};

}  // namespace latelight::render
