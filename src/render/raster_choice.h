// --raster auto: the raster that suits a device, by measurement.
#pragma once

#include <string>

#include "render/settings.h"
#include "vk/device.h"

namespace latelight::render {

struct RasterChoice {
  Raster raster;    // Hardware or Compute
  std::string why;  // a sentence without its full stop
};

// What `settings.raster` stands for on this device: itself, or the choice of `auto`. That takes what is possible at
// all; of two, the one that finds the depth of 300,000 small triangles sooner. The first time on a device and driver it
// is measured, then kept in the cache folder. Throws Error(NoDevice) where the device has neither.
RasterChoice chooseRaster(vk::Device& device, const Settings& settings);

}  // namespace latelight::render
