#include "report/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "report/html.h"
#include "study/svg.h"

namespace latelight::report {

namespace {

using study::kCurveStyles;  // the style sheet has .part0 ... .part7
using study::svgRule, study::svgText;

constexpr double kWidth = study::PlotDrawing::kWidth, kNames = 150, kRight = 24;

std::string svg(double height, const std::string& title, const std::string& body) {
  return fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Chart: {2}\"><svg class=\"chart\" "
      "role=\"img\" "
      "viewBox=\"0 0 {0} {1}\" aria-label=\"{2}; the table below has its numbers\">\n{3}</svg></div>\n",
      kWidth, height, escaped(title), body);
}

// The legend is HTML outside the SVG, so that its text wraps and can be copied.
std::string legend(const std::vector<std::string>& names, const char* shape) {
  std::string items;
  for (size_t i = 0; i < names.size(); ++i)
    items += fmt::format("<li><svg class=\"swatch {}\" viewBox=\"0 0 24 12\" aria-hidden=\"true\">{}</svg>{}</li>\n",
                         fmt::format("part{}", i % kCurveStyles), shape, escaped(names[i]));
  return "<ul class=\"legend\">\n" + items + "</ul>\n";
}

// Returns 1, 2 or 5 times a power of ten, such that about five steps reach `most`.
double stepTo(double most) {
  const double power = std::pow(10, std::floor(std::log10(most / 5)));
  const double times = most / 5 / power;
  return power * (times <= 1 ? 1 : times <= 2 ? 2 : times <= 5 ? 5 : 10);
}

std::string barRow(const BarChart& chart, const BarChart::Bar& bar, double y, double scale) {
  std::string html = svgText(kNames - 8, y + 15, "end", bar.name);
  double x = kNames;
  for (size_t i = 0; i < bar.values.size(); ++i) {
    html += fmt::format(
        "<rect class=\"part{}\" x=\"{:.2f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"18\"><title>{}, {}: {:.3g} "
        "{}</title>"
        "</rect>\n",
        i % kCurveStyles, x, y, bar.values[i] * scale, escaped(bar.name), escaped(chart.parts[i]), bar.values[i],
        escaped(chart.unit));
    x += bar.values[i] * scale;
  }
  return html;
}

double sumOf(const BarChart::Bar& bar) {
  return std::accumulate(bar.values.begin(), bar.values.end(), 0.0);
}

bool isNumber(const study::Table& table, size_t column) {
  return std::ranges::any_of(table.rows, [&](const auto& row) { return std::holds_alternative<double>(row[column]); });
}

std::string cellHtml(const study::Cell& cell, bool first) {
  const std::string text = escaped(study::shortText(cell));
  if (first) return "<th scope=\"row\">" + text + "</th>";
  const auto* number = std::get_if<double>(&cell);
  return number ? fmt::format("<td class=\"number\"><data value=\"{}\">{}</data></td>", *number, text)
                : "<td>" + text + "</td>";
}

}  // namespace

std::string toHtml(const BarChart& chart) {
  double most = 0;
  for (const BarChart::Bar& bar : chart.bars) most = std::max(most, sumOf(bar));
  if (!(most > 0)) return "";
  const double scale = (kWidth - kNames - kRight) / most, step = stepTo(most);
  const double bottom = 26.0 * static_cast<double>(chart.bars.size());
  std::string body;
  for (double value = 0; value <= most * 1.001; value += step)
    body += svgRule(kNames + value * scale, 0, kNames + value * scale, bottom) +
            svgText(kNames + value * scale, bottom + 18, "middle", fmt::format("{:g}", value));
  body += svgText(kNames - 8, bottom + 18, "end", chart.unit);
  for (size_t i = 0; i < chart.bars.size(); ++i) body += barRow(chart, chart.bars[i], 26.0 * double(i) + 2, scale);
  return legend(chart.parts, "<rect width=\"24\" height=\"12\"/>") + svg(bottom + 26, chart.title, body);
}

std::string toHtml(const study::Plot& plot) {
  const study::PlotDrawing drawing = study::drawPlot(plot);
  if (drawing.elements.empty()) return "";
  return fmt::format("<h3>{}</h3>\n", escaped(plot.title)) + legend(drawing.curves, "<polyline points=\"0,6 24,6\"/>") +
         svg(study::PlotDrawing::kHeight, plot.title, drawing.elements);
}

std::string toHtml(const study::Table& table, const std::string& caption) {
  std::string html = fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\"><table>\n<caption>{0}</caption>\n"
      "<thead><tr>",
      escaped(caption));
  for (size_t i = 0; i < table.columns.size(); ++i)
    html += fmt::format("<th scope=\"col\"{}>{}</th>", isNumber(table, i) ? " class=\"number\"" : "",
                        escaped(table.columns[i]));
  html += "</tr></thead>\n<tbody>\n";
  for (const std::vector<study::Cell>& row : table.rows) {
    html += "<tr>";
    for (size_t i = 0; i < row.size(); ++i) html += cellHtml(row[i], i == 0);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace latelight::report
