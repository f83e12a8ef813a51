// Compares two files output by output, each by the measure that fits its contents.
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
  Color,       // the largest |a - b| of the channels; for all pixels also PSNR and FLIP
  Relative,    // |a - b| / max(|a|, |b|), of lengths and positions
  Angle,       // degrees between two directions
  Identity,    // equal or not
  Pixels,      // distance between the end points of two motion vectors; the larger of the two directions
  Difference,  // the largest |a - b| of the channels
};

// Selects the measure by the output's entry in the table of outputs.
Measure measureOf(const AovInfo& aov);
std::string_view unitOf(Measure measure);  // "degrees", "pixels"; empty if the measure has no unit

struct OutputDifference {
  std::string output;  // its name, or the common name of channels that belong to no output
  std::vector<std::string> channels;
  Measure measure = Measure::Difference;
  double tolerance = 0;  // in units of the measure

  // Over the pixels that both files have, in units of the measure.
  double maximum = 0, mean = 0;
  uint32_t worstX = 0, worstY = 0;  // the pixel of `maximum`; if that is 0, the first unlike one
  std::string worstChannel;         // Color and Difference only
  uint64_t pixels = 0;              // pixels of the image
  uint64_t beyond = 0;              // pixels above the tolerance, and pixels that only one file has
  uint64_t unlike = 0;              // infinite, NaN or background in one file only
  double psnr = 0, flip = 0;        // Color only; as in Comparison, and the mean from 0 to 1
  double share() const { return pixels ? static_cast<double>(beyond) / static_cast<double>(pixels) : 0; }

  std::vector<double> excesses;  // by pixel, in units of the tolerance
};

struct OutputOptions {
  std::optional<double> tolerance;            // for every output except ids; default: that of the measure
  std::map<std::string, double> tolerances;   // per output; these take precedence
  std::vector<std::string> channels;          // channels to compare; empty: all
  double pixelsPerDegree = kPixelsPerDegree;  // for FLIP
};

// If a .png or .npy file is named after an output, as in "out.depth.png" or "depth.npy", returns the decoded values of
// that output. Returns any other image unchanged.
ReadImage asOutput(const ReadImage& image, const std::filesystem::path& path);

// Returns the differences in the order of the table of outputs. The colors of two PNG files are compared as stored:
// sRGB codes, with straight alpha. If only one file is a PNG, its colors are first converted to those of a float file,
// which are linear and premultiplied with alpha; the default tolerance is then one level next to white, where levels
// are largest. FLIP always compares linear, premultiplied colors. Throws Error(BadInput) if sizes or channels differ.
// Throws Error(Usage) for a channel that neither image has, and for a tolerance of an output that is absent or of ids.
std::vector<OutputDifference> compareOutputs(const ReadImage& a, const ReadImage& b, const OutputOptions& options = {});

}  // namespace latelight::output
