// The models of a BOP set: which objects share one, and the numbers (obj_id) that they have.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/formats/path_rules.h"
#include "data/shape.h"

namespace latelight::data {

// What decides an object's number besides its shape, by the format's option "models".
class BopNumbers {
 public:
  struct Model {
    uint32_t number = 0;  // obj_id
    std::string name;     // of its mesh, or of its node
    std::string node;     // of the first object of its shape
    Shape shape;
    nlohmann::ordered_json info;  // its entry in models_info.json
  };

  // Null, an object of regular expressions of nodes' paths and their numbers, or the name of a .json file with such an
  // object or with the list that an earlier set has written. Throws Error(Usage), and Error(BadInput) for a file.
  explicit BopNumbers(const nlohmann::ordered_json* spec);

  // Whether an object takes part: with rules, one that matches none is left out.
  bool takes(const std::string& node) const { return rules_.empty() || rules_.find(node); }

 private:
  friend class BopModels;
  void readRules(const nlohmann::ordered_json& rules);
  void readModels(const nlohmann::ordered_json& models, const std::string& file);

  PathRules rules_;
  std::vector<uint32_t> numbers_;  // of the rules
  std::vector<Model> known_;       // of an earlier set
};

// The models of a set, collected object by object in the order of its frames.
class BopModels {
 public:
  explicit BopModels(const BopNumbers& numbers);

  // An object as a frame's entry has it, with "node", "name", "shape" and "modelInfo".
  void add(const nlohmann::ordered_json& object);
  // After all have been added: numbers are those of the rules, or of the earlier set, or follow them, by name.
  // Throws Error(BadInput) where two shapes have one number.
  void number();
  uint32_t numberOf(const nlohmann::ordered_json& object) const;

  nlohmann::ordered_json info() const;  // models_info.json
  nlohmann::ordered_json list() const;  // what another set's option "models" takes

 private:
  size_t find(const Shape& shape, uint32_t fixed) const;  // the models' count where there is none

  const BopNumbers& numbers_;
  std::vector<BopNumbers::Model> models_;
  std::multimap<uint64_t, size_t> byGeometry_;  // of the first part
};

}  // namespace latelight::data
