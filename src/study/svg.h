// Elements of SVG drawings, in files and inside HTML.
#pragma once

#include <string>
#include <string_view>

namespace latelight::study {

std::string escaped(std::string_view text);  // for text and for attributes in double quotes

// `anchor`: start, middle or end of the text at x.
std::string svgText(double x, double y, std::string_view anchor, std::string_view text);

std::string svgRule(double x1, double y1, double x2, double y2);  // a line of a chart's grid

}  // namespace latelight::study
