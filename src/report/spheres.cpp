#include "report/spheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "output/color_map.h"
#include "render/gbuffer/layout.h"
#include "report/html.h"
#include "study/normal_error.h"
#include "study/picture.h"

namespace latelight::report {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t kLevels = 255;  // 0 is outside the discs

Json palette() {
  Json colors = Json::array();
  for (uint32_t level = 1; level <= kLevels; ++level) {
    const output::Rgb color = output::cubehelix(float(level - 1) / (kLevels - 1));
    Json& bytes = colors.emplace_back(Json::array());
    for (const float c : color) bytes.push_back(std::lround(std::clamp(c, 0.0f, 1.0f) * 255));
  }
  return colors;
}

std::vector<uint32_t> levelsOf(const study::SphereMap& map, double top) {
  std::vector<uint32_t> levels;
  for (const double value : map.values)
    levels.push_back(
        std::isnan(value) ? 0 : 1 + static_cast<uint32_t>(std::lround(std::min(value / top, 1.0) * (kLevels - 1))));
  return levels;
}

std::string captionOf(const render::NormalEncoding& encoding, uint32_t bits, const study::Table& errors) {
  const std::string budget = study::budgetName(bits, encoding.channels);
  const std::string region = encoding.hemisphere ? "hemisphere" : "sphere";
  for (const std::vector<study::Cell>& row : errors.rows)
    if (row[0] == study::Cell(encoding.name) && row[1] == study::Cell(budget) && row[2] == study::Cell(region))
      return fmt::format("{} bits: mean {}°, at most {}°", budget, study::shortText(row[3]), study::shortText(row[5]));
  return budget + " bits";
}

std::string nameOf(uint32_t bits) {
  return bits == 0 ? "float" : fmt::format("{}", bits);
}

}  // namespace

Json describeSpheres(std::span<const uint32_t> bits, const study::Table& errors, Planes& planes) {
  Json budgets = Json::array();
  study::SphereMap map{};
  for (const uint32_t b : bits) {
    const double top = study::topDegrees(b);
    Json spheres = Json::array();
    for (const render::NormalEncoding& encoding : render::normalEncodings()) {
      map = study::sphereMap([&](shared::vec3 n) { return study::normalError(encoding, b, n); });
      spheres.push_back({{"plane", planes.add(levelsOf(map, top))}, {"caption", captionOf(encoding, b, errors)}});
    }
    budgets.push_back({{"top", fmt::format("{:.3g}", top)}, {"spheres", spheres}});
  }
  return {{"width", map.width}, {"height", map.height}, {"palette", palette()}, {"budgets", budgets}};
}

std::string spheresHtml(std::span<const uint32_t> bits) {
  std::string html = "<div class=\"controls\">\n<label>Bits a channel <select id=\"sphere-bits\">\n";
  for (size_t i = 0; i < bits.size(); ++i)
    html += fmt::format("<option value=\"{}\">{}</option>\n", i, nameOf(bits[i]));
  html +=
      "</select></label>\n"
      "<label>Turn <input id=\"sphere-turn\" type=\"range\" min=\"-180\" max=\"180\" step=\"5\" value=\"30\"></label>\n"
      "<label>Tilt <input id=\"sphere-tilt\" type=\"range\" min=\"-90\" max=\"90\" step=\"5\" value=\"25\"></label>\n"
      "</div>\n"
      "<p class=\"scale\">0° <canvas id=\"sphere-scale\" width=\"255\" height=\"12\" role=\"img\" "
      "aria-label=\"from black for no error to white\"></canvas> <span id=\"sphere-top\"></span>° or more. "
      "Drag a sphere to turn them all.</p>\n<div class=\"spheres\">\n";
  for (const render::NormalEncoding& encoding : render::normalEncodings())
    html += fmt::format(
        "<figure><canvas class=\"sphere\" width=\"220\" height=\"220\" role=\"img\" "
        "aria-label=\"Errors of {0} over the sphere of directions\"></canvas><figcaption><b>{0}</b> {1}<br>"
        "<span></span></figcaption></figure>\n",
        escaped(encoding.name), escaped(encoding.description));
  return html + "</div>\n";
}

}  // namespace latelight::report
