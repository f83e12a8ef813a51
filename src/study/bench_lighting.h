// What `bench lights` and `bench shade` share: the passes that light, and what each light that is used takes.
#pragma once

#include "study/light_counts.h"
#include "study/pass_samples.h"
#include "study/table.h"

namespace latelight::study {

// Milliseconds of a frame's light lists, and of the passes that light from them or without any.
struct LightTimes {
  double lists = 0, lighting = 0;
  double spread = 0;        // of both together, per cent
  uint64_t wholeBytes = 0;  // of lighting
  double both() const { return lists + lighting; }
};
LightTimes lightTimes(const PassSamples& passes);

// Picoseconds, for each pixel and each light that it uses; 0 where there is none.
double picosecondsALight(double milliseconds, double usedAPixel, const render::Settings& settings);

// One cell: nothing for a value that is 0.
Cell cellOf(double value);

}  // namespace latelight::study
