// Dynamic resolution while something moves: reduces the resolution until the measured frame rate reaches ten pictures
// per second.
#pragma once

#include "render/settings/settings.h"

namespace latelight::view {

class Draft {
 public:
  explicit Draft(bool slow);  // `slow`: starts at low resolution, for CPU devices

  // Returns the settings for a draft of the same picture.
  render::Settings of(const render::Settings& whole) const;
  // Reports the render time of a draft. Returns true if the settings for the next draft differ.
  bool took(double seconds);
  bool isWhole() const { return divisor_ == 1 && means_ == All; }  // full resolution and all effects

 private:
  double divisor_;  // of width and height
  // If lower resolution is not enough, the cost is in the triangles: drafts first omit shadow maps, then replace the
  // graphics pipeline, which processes each triangle, by --raster compute.
  enum Means : int { All, WithoutShadows, InCompute } means_ = All;
};

}  // namespace latelight::view
