// Charts as SVG. Each is followed by a table of its numbers, for which its words ask.
#pragma once

#include <string>
#include <vector>

#include "study/plot.h"
#include "study/table.h"

namespace latelight::report {

// A bar a row, of parts that add up.
struct BarChart {
  std::string title, unit;
  std::vector<std::string> parts;
  struct Bar {
    std::string name;
    std::vector<double> values;  // one for each part
  };
  std::vector<Bar> bars;
};
std::string toHtml(const BarChart& chart);

// Curves over logarithmic axes; empty where none has a point that they can show.
std::string toHtml(const study::Plot& plot);

// Numbers of three significant digits, and in full for programs that read the page.
std::string toHtml(const study::Table& table, const std::string& caption);

}  // namespace latelight::report
