#include "data/formats/categories.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "base/error.h"
#include "base/log.h"
#include "base/lowercase.h"
#include "data/cameras/json_file.h"
#include "data/formats/names.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void refuse(const std::string& format) {
  badUsage(
      "categories of the format {} takes mesh, node, material, an object of regular expressions of nodes' paths and "
      "the category of each, or a .json file with such an object",
      format);
}

Json rulesIn(const std::string& path) {
  Json json = readJson(path).json;
  if (!json.is_object()) badInput("'{}' is not a JSON object of regular expressions and categories", path);
  return json;
}

}  // namespace

Categories::Categories(std::string_view format, const Json* spec) : format_(format) {
  if (!spec) return;
  const std::string name = spec->is_string() ? spec->get<std::string>() : "";
  if (spec->is_object())
    readRules(*spec);
  else if (lowercaseExtension(name) == ".json")
    readRules(rulesIn(name));
  else if (name == "mesh" || name == "node" || name == "material")
    from_ = name;
  else
    refuse(format_);
}

void Categories::readRules(const Json& rules) {
  for (const auto& [pattern, category] : rules.items()) {
    if (!category.is_string() || category.get_ref<const std::string&>().empty()) refuse(format_);
    rules_.add(pattern, "categories of the format " + format_);
    names_.push_back(category.get<std::string>());
  }
  if (rules_.empty()) refuse(format_);
}

std::string Categories::of(uint32_t id, const output::IdManifest& ids) const {
  const output::IdEntry* entry = entryOf(ids, id);
  if (!entry) return "";
  if (rules_.empty()) return named(*entry, ids);
  const std::optional<size_t> rule = rules_.find(nameOf(*entry));
  return rule ? names_[*rule] : "";
}

std::string Categories::named(const output::IdEntry& entry, const output::IdManifest& ids) const {
  const std::vector<std::string> materials = from_ == "material" ? ids.materialsOf(entry) : std::vector<std::string>();
  const std::string& name = from_ == "node" ? entry.node : materials.empty() ? entry.mesh : materials.front();
  return name.empty() ? entry.node : name;
}

std::vector<uint64_t> Categories::countsOf(std::span<const Json> frames) {
  std::vector<uint64_t> counts;
  for (const Json& frame : frames) counts.push_back(frame["objects"].size());
  return counts;
}

void Categories::warnIfUnused(std::span<const uint64_t> counts) const {
  if (rules_.empty() || counts.empty() || std::ranges::any_of(counts, [](uint64_t count) { return count > 0; })) return;
  warn(
      "the data set of the format {} has no objects: no visible object matches an expression of its categories; "
      "expressions match parts of paths of nodes, such as \"/Root/Arm\"",
      format_);
}

uint64_t Categories::numberOf(const Json& object, const std::map<std::string, uint64_t>& numbers) {
  const std::string& category = object["category"].get_ref<const std::string&>();
  const auto found = numbers.find(category);
  if (found == numbers.end())
    badInput("a frame has an object of the category \"{}\", which the job does not define: run the job with --resume",
             category);
  return found->second;
}

Json Categories::ofScene(const output::IdManifest& ids) const {
  if (!rules_.empty()) return nullptr;
  std::set<std::string> names;
  for (const output::IdEntry& entry : ids.ids)
    if (!entry.parts.empty()) names.insert(named(entry, ids));
  names.erase("");
  return names;
}

std::vector<std::string> Categories::all(const SetEntries& set) const {
  std::vector<std::string> names;
  for (const std::string& category : names_)
    if (std::ranges::find(names, category) == names.end()) names.push_back(category);
  if (!names.empty()) return names;
  std::set<std::string> ofScenes, ofFrames;
  for (const Json& scene : set.scenes)
    for (const Json& category : scene) ofScenes.insert(category.get<std::string>());
  for (const Json& entry : set.frames)
    for (const Json& object : entry["objects"]) ofFrames.insert(object["category"].get<std::string>());
  names.assign(ofScenes.begin(), ofScenes.end());
  std::ranges::set_difference(ofFrames, ofScenes, std::back_inserter(names));
  return names;
}

}  // namespace latelight::data
