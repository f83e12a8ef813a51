#include "study/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "study/svg.h"

namespace latelight::study {

namespace {

constexpr double kPlotLeft = 75, kPlotRight = PlotDrawing::kWidth - 24, kPlotTop = 24, kPlotBottom = 340;

bool isDrawable(const Sample& sample) {
  return sample.x > 0 && sample.y > 0;
}

// The powers of ten that enclose positive values.
struct Decades {
  double low = 1e300, high = 1e-300;
  void add(double value) {
    low = std::min(low, std::pow(10, std::floor(std::log10(value))));
    high = std::max(high, std::pow(10, std::ceil(std::log10(value))));
  }
  // 0 at `low`, 1 at `high`
  double at(double value) const { return high > low ? std::log10(value / low) / std::log10(high / low) : 0.5; }
};

struct PlotAxes {
  Decades across, up;
  double x(double value) const { return kPlotLeft + across.at(value) * (kPlotRight - kPlotLeft); }
  double y(double value) const { return kPlotBottom - up.at(value) * (kPlotBottom - kPlotTop); }
};

// "0.01", "10", "1k", "10M"
std::string tickText(double value) {
  constexpr std::array<std::pair<double, char>, 3> kPrefixes{{{1e9, 'G'}, {1e6, 'M'}, {1e3, 'k'}}};
  for (const auto& [factor, letter] : kPrefixes)
    if (value > factor * 0.999) return fmt::format("{:g}{}", value / factor, letter);
  return fmt::format("{:g}", value);
}

std::string gridOf(const PlotAxes& axes) {
  const auto& [across, up] = axes;
  std::string svg;
  for (double x = across.low; x <= across.high * 1.01; x *= 10)
    svg += svgRule(axes.x(x), axes.y(up.low), axes.x(x), axes.y(up.high)) +
           svgText(axes.x(x), kPlotBottom + 18, "middle", tickText(x));
  for (double y = up.low; y <= up.high * 1.01; y *= 10)
    svg += svgRule(axes.x(across.low), axes.y(y), axes.x(across.high), axes.y(y)) +
           svgText(kPlotLeft - 6, axes.y(y) + 4, "end", tickText(y));
  return svg;
}

// Returns an empty text if the curve has no sample that can be drawn.
std::string curveOf(const Curve& curve, const PlotAxes& axes, size_t style) {
  std::string points, dots;
  for (const Sample& sample : curve.samples) {
    if (!isDrawable(sample)) continue;
    const double x = axes.x(sample.x), y = axes.y(sample.y);
    points += fmt::format("{:.1f},{:.1f} ", x, y);
    dots += fmt::format("<circle class=\"part{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"/>\n", style, x, y);
  }
  if (points.empty()) return "";
  return fmt::format("<polyline class=\"part{}\" points=\"{}\"><title>{}</title></polyline>\n", style, points,
                     escaped(curve.name)) +
         dots;
}

// Okabe and Ito's colors, which are distinguishable with any color vision, and dashes: those of the light theme in
// web/report/style.css.
struct Style {
  const char *color, *dashes;
};
constexpr std::array<Style, kCurveStyles> kStyles{{{"#0072b2", "none"},
                                                   {"#d55e00", "9 3"},
                                                   {"#009e73", "3 3"},
                                                   {"#cc79a7", "12 3 3 3"},
                                                   {"#e69f00", "6 6"},
                                                   {"#56b4e9", "2 5"},
                                                   {"#6b4fa0", "15 4"},
                                                   {"#8a8f96", "9 3 2 3 2 3"}}};

std::string styleSheet() {
  std::string css =
      "text { fill: #1c1e21; font: 12px sans-serif; } .title { font-size: 15px; } .rule { stroke: #d4d8dd; }\n"
      "polyline { fill: none; stroke-width: 2.5; } circle { stroke: none; }\n";
  for (size_t i = 0; i < kStyles.size(); ++i)
    css += fmt::format("polyline.part{0} {{ stroke: {1}; stroke-dasharray: {2}; }} circle.part{0} {{ fill: {1}; }}\n",
                       i, kStyles[i].color, kStyles[i].dashes);
  return css;
}

}  // namespace

PlotDrawing drawPlot(const Plot& plot) {
  PlotAxes axes;
  for (const Curve& curve : plot.curves)
    for (const Sample& sample : curve.samples)
      if (isDrawable(sample)) axes.across.add(sample.x), axes.up.add(sample.y);
  if (axes.across.low > axes.across.high) return {};
  PlotDrawing drawing;
  drawing.elements =
      gridOf(axes) + svgText(4, 14, "start", plot.yLabel) + svgText(kPlotRight, kPlotBottom + 36, "end", plot.xLabel);
  for (const Curve& curve : plot.curves) {
    const std::string drawn = curveOf(curve, axes, drawing.curves.size() % kCurveStyles);
    if (drawn.empty()) continue;
    drawing.elements += drawn;
    drawing.curves.push_back(curve.name);
  }
  return drawing;
}

std::string svgOf(const Plot& plot) {
  constexpr double kLegend = 180, kTitle = 30, kLine = 20;
  const PlotDrawing drawing = drawPlot(plot);
  if (drawing.elements.empty()) return "";
  std::string legend;
  for (size_t i = 0; i < drawing.curves.size(); ++i) {
    const double y = kPlotTop + kLine * static_cast<double>(i);
    legend += fmt::format("<polyline class=\"part{0}\" points=\"{1},{2} {3},{2}\"/>\n", i % kCurveStyles,
                          PlotDrawing::kWidth, y, PlotDrawing::kWidth + 30) +
              svgText(PlotDrawing::kWidth + 38, y + 4, "start", drawing.curves[i]);
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n"
      "<title>{2}</title>\n<style>\n{3}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
      "<text class=\"title\" x=\"{4}\" y=\"20\" text-anchor=\"middle\">{2}</text>\n"
      "<g transform=\"translate(0 {5})\">\n{6}{7}</g>\n</svg>\n",
      PlotDrawing::kWidth + kLegend, PlotDrawing::kHeight + kTitle, escaped(plot.title), styleSheet(),
      (PlotDrawing::kWidth + kLegend) / 2, kTitle, drawing.elements, legend);
}

}  // namespace latelight::study
