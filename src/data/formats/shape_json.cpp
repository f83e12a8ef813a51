#include "data/formats/shape_json.h"

#include <charconv>

#include "data/json_text.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

Json describeShape(const labels::Shape& shape) {
  Json parts = Json::array();
  for (const labels::Shape::Part& part : shape.parts)
    parts.push_back({{"geometry", hashText(part.geometry)}, {"place", part.place}});
  return {{"extent", shape.extent}, {"parts", std::move(parts)}};
}

labels::Shape shapeIn(const Json& json) {
  labels::Shape shape{.extent = json.at("extent").get<double>()};
  for (const Json& part : json.at("parts")) {
    const std::string& hash = part.at("geometry").get_ref<const std::string&>();
    labels::Shape::Part& added = shape.parts.emplace_back();
    std::from_chars(hash.data(), hash.data() + hash.size(), added.geometry, 16);
    added.place = part.at("place").get<std::array<double, 12>>();
  }
  return shape;
}

}  // namespace latelight::data
