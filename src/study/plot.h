// Plots by gnuplot, which runs as a program. The script is saved next to the image, and can redraw it anywhere.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "study/fit.h"

namespace latelight::study {

struct NamedFile {
  std::string name;
  std::vector<std::byte> bytes;
};

struct Curve {
  std::string name;
  std::vector<Sample> samples;
};

// Curves on logarithmic axes.
struct Plot {
  std::string name;  // base name of its files
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves;
};

// Returns the script from which gnuplot 5 writes a PNG to its standard output. The same plot produces the same text.
std::string gnuplotScript(const Plot& plot);

// Returns NAME.gnuplot for each plot, and NAME.png if gnuplot is installed; warns if it is absent or fails.
std::vector<NamedFile> drawPlots(const std::vector<Plot>& plots);

}  // namespace latelight::study
