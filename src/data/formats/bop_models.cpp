#include "data/formats/bop_models.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "base/lowercase.h"
#include "data/cameras/json_file.h"
#include "data/formats/shape_json.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr std::string_view kTakes =
    "models of the format bop takes an object of regular expressions of nodes' paths and the obj_id of each, from 1, "
    "or a .json file with such an object or with the list models/models.json of another set";

constexpr uint64_t kLargestNumber = 2'147'483'647;

uint32_t numberIn(const Json& value) {
  if (!value.is_number_integer() || value < 1 || value > kLargestNumber) badUsage("{}", kTakes);
  return value.get<uint32_t>();
}

uint64_t keyOf(const Shape& shape) {
  return shape.parts.empty() ? 0 : shape.parts.front().geometry;
}

}  // namespace

BopNumbers::BopNumbers(const Json* spec) {
  if (!spec) return;
  const std::string file = spec->is_string() ? spec->get<std::string>() : "";
  const bool isFile = lowercaseExtension(file) == ".json";
  if (!isFile && !spec->is_structured()) badUsage("{}", kTakes);
  const Json contents = isFile ? readJson(file).json : *spec;
  contents.is_object() ? readRules(contents)
                       : readModels(contents, isFile ? fmt::format("'{}'", file) : "models of the format bop");
}

void BopNumbers::readRules(const Json& rules) {
  for (const auto& [expression, number] : rules.items()) {
    numbers_.push_back(numberIn(number));
    rules_.add(expression, "models of the format bop");
  }
  if (rules_.empty()) badUsage("{}", kTakes);
}

void BopNumbers::readModels(const Json& models, const std::string& place) try {
  for (const Json& model : models)
    known_.push_back({numberIn(model.at("obj_id")), model.at("name").get<std::string>(),
                      model.at("node").get<std::string>(), shapeIn(model.at("shape")), model.at("info")});
} catch (const Json::exception&) {
  badInput("{} is no list of models: give models/models.json of another set, or an object of regular expressions",
           place);
}

BopModels::BopModels(const BopNumbers& numbers) : numbers_(numbers), models_(numbers.known_) {
  for (size_t i = 0; i < models_.size(); ++i) byGeometry_.emplace(keyOf(models_[i].shape), i);
}

size_t BopModels::find(const Shape& shape, uint32_t fixed) const {
  const auto [first, end] = byGeometry_.equal_range(keyOf(shape));
  for (auto at = first; at != end; ++at) {
    const BopNumbers::Model& model = models_[at->second];
    if ((fixed == 0 || model.number == fixed) && labels::isSameShape(model.shape, shape)) return at->second;
  }
  return models_.size();
}

void BopModels::add(const Json& object) {
  const std::string node = object["node"].get<std::string>();
  const auto rule = numbers_.rules_.find(node);
  const uint32_t fixed = rule ? numbers_.numbers_[*rule] : 0;
  Shape shape = shapeIn(object["shape"]);
  if (find(shape, fixed) < models_.size()) return;
  byGeometry_.emplace(keyOf(shape), models_.size());
  models_.push_back({fixed, object["name"].get<std::string>(), node, std::move(shape), object["modelInfo"]});
}

void BopModels::number() {
  std::map<uint32_t, const BopNumbers::Model*> taken;
  for (const BopNumbers::Model& model : models_) {
    if (model.number == 0) continue;
    const auto [other, isNew] = taken.emplace(model.number, &model);
    if (!isNew)
      badInput(
          "models of the format bop gives the obj_id {} to \"{}\" and \"{}\", whose shapes differ: give each its own",
          model.number, other->second->node, model.node);
  }
  uint32_t last = taken.empty() ? 0 : taken.rbegin()->first;
  std::vector<size_t> order(models_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](size_t i) { return std::string_view(models_[i].name); });
  for (const size_t i : order)
    if (models_[i].number == 0) models_[i].number = ++last;
}

uint32_t BopModels::numberOf(const Json& object) const {
  const auto rule = numbers_.rules_.find(object["node"].get<std::string>());
  return models_[find(shapeIn(object["shape"]), rule ? numbers_.numbers_[*rule] : 0)].number;
}

Json BopModels::info() const {
  std::map<uint32_t, const Json*> sorted;
  for (const BopNumbers::Model& model : models_) sorted[model.number] = &model.info;
  Json all = Json::object();
  for (const auto& [number, info] : sorted) all[std::to_string(number)] = *info;
  return all;
}

Json BopModels::list() const {
  std::map<uint32_t, const BopNumbers::Model*> sorted;
  for (const BopNumbers::Model& model : models_) sorted[model.number] = &model;
  Json all = Json::array();
  for (const auto& [number, model] : sorted)
    all.push_back({{"obj_id", number},
                   {"name", model->name},
                   {"node", model->node},
                   {"shape", describeShape(model->shape)},
                   {"info", model->info}});
  return all;
}

}  // namespace latelight::data
