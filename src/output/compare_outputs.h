// How much two files differ, output by output, each by the measure that fits what it holds.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "output/compare.h"
#include "output/flip.h"

namespace latelight::output {

enum class Measure {
  Color,       // PSNR and FLIP
  Relative,    // |a - b| / max(|a|, |b|), of lengths and places
  Angle,       // degrees between two directions
  Identity,    // equal or not
  Pixels,      // distance between the ends of two motions, the larger one of both directions
  Difference,  // the largest |a - b| of the channels
};

// By what the table of outputs says of it.
Measure measureOf(const AovInfo& aov);
std::string_view unitOf(Measure measure);  // "degrees", "pixels"; empty: none

struct OutputDifference {
  std::string output;  // its name, or that of channels that belong to none
  std::vector<std::string> channels;
  Measure measure = Measure::Difference;
  double tolerance = 0;  // of the measure

  // Of the pixels that both files have; by the measure.
  double maximum = 0, mean = 0;
  uint32_t worstX = 0, worstY = 0;
  std::string worstChannel;   // Color and Difference only
  uint64_t pixels = 0;        // of the picture
  uint64_t beyond = 0;        // above the tolerance, and those that only one file has
  uint64_t unlike = 0;        // infinite, NaN or background in one file only
  double psnr = 0, flip = 0;  // Color only; decibels, and the mean from 0 to 1
  double share() const { return pixels ? static_cast<double>(beyond) / static_cast<double>(pixels) : 0; }

  std::vector<double> excesses;  // by pixel, in units of the tolerance
};

struct OutputOptions {
  std::optional<double> tolerance;            // of every output except ids; unset: its measure's
  std::map<std::string, double> tolerances;   // by output; these come first
  std::vector<std::string> channels;          // to compare; empty: all
  double pixelsPerDegree = kPixelsPerDegree;  // of FLIP
};

// Where a .png or .npy file is named after an output, as in "out.depth.png" or "depth.npy", the numbers of that output,
// decoded; any other picture as it is.
ReadImage asOutput(const ReadImage& image, const std::filesystem::path& path);

// In the order of the table of outputs. Throws Error(BadInput) where sizes or channels differ, Error(Usage) for a
// channel that neither has and for a tolerance of an output that is not there.
std::vector<OutputDifference> compareOutputs(const ReadImage& a, const ReadImage& b, const OutputOptions& options = {});

}  // namespace latelight::output
