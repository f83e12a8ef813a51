// Code that `bench lights` and `bench shade` share: the times of the lighting passes and the cost per used light.
#pragma once

#include "study/light_counts.h"
#include "study/pass_samples.h"
#include "study/table.h"

namespace latelight::study {

// Milliseconds of a frame's light lists, and of the lighting passes with or without lists.
struct LightTimes {
  double lists = 0, lighting = 0;
  double spread = 0;          // spread of the sum of both, in percent
  uint64_t trafficBytes = 0;  // total bytes that the lighting passes read and write
  double both() const { return lists + lighting; }
};
LightTimes lightTimes(const PassSamples& passes);

// Returns picoseconds per pixel and per light that the pixel uses; 0 if no light is used.
double picosecondsPerLight(double milliseconds, double usedPerPixel, const render::Settings& settings);

// Returns one cell, which is empty if the value is 0.
Cell cellOf(double value);

}  // namespace latelight::study
