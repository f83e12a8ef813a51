#include "app/render_pick.h"

#include <fmt/core.h>

#include "base/error.h"
#include "base/log.h"
#include "base/text.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;

std::string text(glm::vec3 v) {
  return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z);
}

// Names come from the scene file and may contain any characters.
std::string nameOr(const std::string& name, const std::string& otherwise) {
  return name.empty() ? otherwise : printable(name);
}

Json array(glm::vec3 v) {
  return {v.x, v.y, v.z};
}

}  // namespace

std::vector<glm::uvec2> parsePixels(const std::vector<std::string>& texts) {
  std::vector<glm::uvec2> pixels;
  for (const std::string& text : texts) {
    const std::vector<std::string_view> parts = splitAtCommas(text);
    const auto x = parseNumber<uint32_t>(parts.front()), y = parseNumber<uint32_t>(parts.back());
    if (parts.size() != 2 || !x || !y)
      badUsage("--pick takes a pixel x,y in whole numbers from the upper left, not \"{}\"", text);
    pixels.push_back({*x, *y});
  }
  return pixels;
}

void printPicked(const std::vector<render::Picked>& picked, const std::string& frame, const std::string& normalFrame) {
  const std::string unnamed = "(without a name)";
  for (const render::Picked& p : picked) {
    if (p.id == 0) {
      fmt::print("pixel {},{}: background\n", p.pixel.x, p.pixel.y);
      continue;
    }
    fmt::print("pixel {},{}\n", p.pixel.x, p.pixel.y);
    fmt::print("  id         {}\n  part       {}\n  node       {}\n  mesh       {}\n  primitive  {}\n  material   {}\n",
               p.id, p.part, nameOr(p.node, unnamed), nameOr(p.mesh, unnamed), p.primitive,
               nameOr(p.material, unnamed));
    fmt::print("  position   {} m ({})\n", text(p.position), frame);
    fmt::print("  normal     {} ({})\n  geonormal  {} ({})\n", text(p.normal), normalFrame, text(p.geonormal),
               normalFrame);
    fmt::print("  depth      {:.6g} m\n  distance   {:.6g} m\n  uv         {:.6g} {:.6g}\n", p.depth, p.distance,
               p.uv.x, p.uv.y);
  }
}

Json describePicked(const std::vector<render::Picked>& picked) {
  Json all = Json::array();
  for (const render::Picked& p : picked) {
    Json row{{"pixel", {p.pixel.x, p.pixel.y}}, {"id", p.id}};
    if (p.id != 0) {
      row.update({{"part", p.part}, {"node", p.node}, {"mesh", p.mesh}});
      row.update({{"primitive", p.primitive}, {"material", p.material}});
      row.update({{"position", array(p.position)}, {"normal", array(p.normal)}, {"geonormal", array(p.geonormal)}});
      row.update({{"depth", p.depth}, {"distance", p.distance}, {"uv", {p.uv.x, p.uv.y}}});
    }
    all.push_back(std::move(row));
  }
  return all;
}

}  // namespace latelight::app
