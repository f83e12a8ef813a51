// How pictures are made while something moves: as many pixels as leave ten pictures a second, by measurement.
#pragma once

#include "render/settings/settings.h"

namespace latelight::view {

class Draft {
 public:
  explicit Draft(bool slow);  // `slow`: begins with few pixels, as on a CPU

  // The same picture, cheaper.
  render::Settings of(const render::Settings& whole) const;
  // Of a picture that was made so. True: the next one is made in another way.
  bool took(double seconds);
  bool isWhole() const { return divisor_ == 1 && means_ == All; }  // nothing is left out

 private:
  double divisor_;  // of width and height
  // Where fewer pixels are not enough it is the triangles: first shadow maps, then the graphics pipeline, which shades
  // each of them, are left out.
  enum Means : int { All, WithoutShadows, InCompute } means_ = All;
};

}  // namespace latelight::view
