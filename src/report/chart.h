// Charts as SVG inside HTML. A table of the same numbers follows each chart, as its description says.
#pragma once

#include <string>
#include <vector>

#include "study/plot.h"
#include "study/table.h"

namespace latelight::report {

// One bar per row, made of parts that add up.
struct BarChart {
  std::string title, unit;
  std::vector<std::string> parts;
  struct Bar {
    std::string name;
    std::vector<double> values;  // one per part
  };
  std::vector<Bar> bars;
};
std::string toHtml(const BarChart& chart);

// Returns curves on logarithmic axes, or an empty text if no curve has a point that the axes can show.
std::string toHtml(const study::Plot& plot);

// Numbers have three significant digits, and full precision for programs that read the page.
std::string toHtml(const study::Table& table, const std::string& caption);

}  // namespace latelight::report
