// Dense correspondence and scene flow between two images: for each pixel of the first, the position of its surface in
// the second, at another time and through another camera (Vedula et al. 1999, "Three-Dimensional Scene Flow").
#pragma once

#include <vector>

#include "render/submit/renderer.h"

namespace latelight::labels {

// One value per pixel of the first image, rows from the top.
struct Correspondence {
  uint32_t width = 0, height = 0;
  std::vector<glm::vec2>
      pixels;                    // in the second image, which they may lie outside of; NaN: background or not projected
  std::vector<float> depth;      // in the second image, as the output `depth`; NaN likewise
  std::vector<uint8_t> visible;  // 1: the second image shows the same point, between its camera's planes
  std::vector<glm::vec3> flow;   // displacement of the point in the frame of the settings' axes, meters; 0: background
};
inline constexpr uint64_t kBytesPerPixel = 25;  // of a Correspondence

// An image of a sequence: its camera, and the scene at its time.
struct Shot {
  const scene::Camera& camera;
  const scene::Pose& pose;         // empty: at rest
  uint32_t width = 0, height = 0;  // of the image, in pixels; 0: as in the settings
};

// The parts of correspond() before and after the rays, for callers that cast them.
//
// The slack of lines of sight: the share of the distance within which a surface counts as the point itself.
inline constexpr double kPixelSlack = 1e-4;
struct LocatedPixels {
  Correspondence result;           // nothing is visible yet
  std::vector<size_t> inside;      // pixels whose points lie within the second image
  std::vector<glm::dvec3> points;  // theirs, moved, in the frame of the settings' axes
};
// `first`: the outputs id, position, relative to `origin`, and scene flow to the second image. `second`: the camera of
// the second image, for which `others` are the settings.
LocatedPixels locate(const output::FrameOutput& first, const glm::dvec3& origin, const scene::Camera& second,
                     const scene::Scene& scene, const render::Settings& others);

// The settings select surfaces, axes and raster. Each image shows an instant, without an exposure time and a rolling
// shutter. A point is visible in the second image if it lies within that image, between its camera's near and far
// planes, and no surface is before it.
Correspondence correspond(render::Renderer& renderer, const scene::Scene& scene, const Shot& first, const Shot& second,
                          const render::Settings& settings);

}  // namespace latelight::labels
