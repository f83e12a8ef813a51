// Plots by gnuplot, run as a program: its script is kept next to the picture, and can redraw it anywhere.
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

// Curves over logarithmic axes.
struct Plot {
  std::string name;  // of its files, without extension
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves;
};

// The script from which gnuplot 5 writes a PNG to its standard output. The same plot gives the same text.
std::string gnuplotScript(const Plot& plot);

// NAME.gnuplot for each plot, and NAME.png where gnuplot is installed; a warning where it is not or fails.
std::vector<NamedFile> drawPlots(const std::vector<Plot>& plots);

}  // namespace latelight::study
