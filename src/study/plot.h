// Plots of curves on logarithmic axes as SVG: as files of their own, and as parts of HTML pages.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "study/fit.h"

namespace latelight::study {

struct Curve {
  std::string name;
  std::vector<Sample> samples;  // only positive ones are drawn
};

struct Plot {
  std::string name;  // base name of its file
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves;
};

// The elements of a plot without its title and legend. The element of curve i has the class part{i % kCurveStyles},
// whose color and dashes the document defines; the grid has the class rule.
struct PlotDrawing {
  static constexpr double kWidth = 760, kHeight = 384;
  std::string elements;             // empty if no curve has a sample that can be drawn
  std::vector<std::string> curves;  // names of the curves that are drawn, in order
};
inline constexpr size_t kCurveStyles = 8;
PlotDrawing drawPlot(const Plot& plot);

// Returns a document with title and legend, or an empty text if no curve has a sample that can be drawn. The same plot
// produces the same text.
std::string svgOf(const Plot& plot);

}  // namespace latelight::study
