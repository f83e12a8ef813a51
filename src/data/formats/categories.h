// The categories of objects, for formats that name or number them.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "data/format.h"
#include "data/formats/path_rules.h"
#include "output/id_manifest.h"

namespace latelight::data {

class Categories {
 public:
  // Reads the option "categories" of a format, or null for its default: mesh, node or material, an object of regular
  // expressions and categories, or a .json file with one. Throws Error(Usage) that names the format.
  Categories(std::string_view format, const nlohmann::ordered_json* spec);

  // Returns the category of the object with an id. It is empty if the object has none, or no object has the id; the
  // object is then excluded.
  std::string of(uint32_t id, const output::IdManifest& ids) const;

  // Returns the number of objects of each frame's entry, which has "objects" with a "category" each.
  static std::vector<uint64_t> countsOf(std::span<const nlohmann::ordered_json> frames);

  // Warns if there are rules and no object of a set has a category, so that formats omit all objects. `counts`: the
  // number of objects with a category by frame.
  void warnIfUnused(std::span<const uint64_t> counts) const;

  // Returns the number of the category of an object of an entry. Throws Error(BadInput) if the entry is of a job whose
  // categories differ.
  static uint64_t numberOf(const nlohmann::ordered_json& object, const std::map<std::string, uint64_t>& numbers);

  // Returns the list of names of a scene's categories, sorted, for all(). It is null if there are rules.
  nlohmann::ordered_json ofScene(const output::IdManifest& ids) const;

  // Returns the names of all categories of a set, in the order of the rules, or sorted by name if there are no rules.
  // They do not depend on what is visible: those of rules and scenes are listed even if no object of a frame has them.
  // The entries of scenes are those of ofScene(), and those of frames have "objects" with a "category". Categories that
  // only frames have follow.
  std::vector<std::string> all(const SetEntries& set) const;

 private:
  void readRules(const nlohmann::ordered_json& rules);
  std::string named(const output::IdEntry& entry, const output::IdManifest& ids) const;

  std::string format_;
  std::string from_ = "mesh";
  PathRules rules_;
  std::vector<std::string> names_;  // categories by rule
};

}  // namespace latelight::data
