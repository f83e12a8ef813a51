// Ray tables for cameras whose lens bends rays. LensRays computes the ray of each pixel of a picture (`rays`), fits up
// to six pinhole views around them (`views`), and lists the rays in each pixel of those views (`starts`, `pixels`). The
// raster compute visits the pixels of the pinhole views that a triangle touches and intersects the triangle with their
// rays (visibility/compute/lens_rays.glsl).
#pragma once

#include <array>
#include <list>
#include <memory>
#include <vector>

#include "scene/lens.h"
#include "shared/lens_projection.h"
#include "shared/types.h"
#include "vk/resources.h"

namespace latelight::render {

// Identifies the rays: those of some rows of a picture. `jitter` is defined as in makeView(). `aperture`: the point of
// the lens's aperture that they pass through, right and up in meters. All rays through a pixel meet at `focus` meters:
// along the axis for `opencv`, along the ray for `fisheye` and `ftheta`.
struct LensPicture {
  scene::Lens lens;
  uint32_t width, height;  // of the full picture
  uint32_t first, rows;
  glm::vec2 jitter;
  glm::dvec2 aperture{0};
  double focus = 1;
  std::array<scene::Lens, 2> neighbors{};  // the lenses of the previous and the next frame, for motion
  bool operator==(const LensPicture&) const = default;
};

struct LensRays {
  // shared::LensRay[rows + 2][width]. A strip also stores the rows above and below it, so that textures are filtered
  // the same way. Rays outside of the picture are 0.
  vk::Buffer rays;
  // The pinhole views of a camera at the world's origin, aligned to the world's axes. All have the same size.
  std::vector<shared::View> views;
  std::array<shared::LensCalibration, 3> lenses;  // of the current, previous and next frame
  vk::Buffer starts, pixels;                      // the rays in each pixel of the views, as in shared::LensTarget
  glm::vec2 aperture;                             // as in LensPicture
  float focus;

  LensRays(vk::Device& device, const LensPicture& picture);
};

// A cache of the most recent tables, because cameras usually share a lens.
class LensRayCache {
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
