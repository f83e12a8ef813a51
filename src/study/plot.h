// Plots by gnuplot, which is called as a program: its script is kept beside the picture, and draws it anywhere.
#pragma once

#include <string>
#include <vector>

#include "study/fit.h"
#include "study/study.h"

namespace latelight::study {

struct Curve {
  std::string name;
  std::vector<Sample> samples;
};

// Curves over logarithmic axes.
struct Plot {
  std::string name;  // of its files, without ending
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves;
};

// What gnuplot 5 makes a PNG of on its standard output. The same plot gives the same text.
std::string gnuplotScript(const Plot& plot);

// NAME.gnuplot of each plot, and NAME.png where gnuplot is there; a warning where it is not or fails.
std::vector<NamedFile> drawPlots(const std::vector<Plot>& plots);

}  // namespace latelight::study
