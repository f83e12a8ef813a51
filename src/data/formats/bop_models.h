// The models of a BOP set: groups objects of the same shape to models and assigns the models' numbers (obj_id).
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/formats/path_rules.h"
#include "data/frame.h"

namespace latelight::data {

// The format's option "models", which may fix the numbers of models.
class BopNumbers {
 public:
  struct Model {
    uint32_t number = 0;  // obj_id
    std::string name;     // the name of the mesh, or of the node if the mesh has none
    std::string node;     // the node of the first object with this shape
    Shape shape;
    nlohmann::ordered_json info;  // its entry in models_info.json
  };

  // `spec` is null, an object that maps regular expressions of node paths to numbers, the list of models that an
  // earlier set has written, or the name of a .json file that contains such an object or list. Throws Error(Usage), and
  // Error(BadInput) for invalid files.
  explicit BopNumbers(const nlohmann::ordered_json* spec);

  // Returns true if an object is part of the set. If there are rules, objects that match none are excluded.
  bool takes(const std::string& node) const { return rules_.empty() || rules_.find(node); }

 private:
  friend class BopModels;
  void readRules(const nlohmann::ordered_json& rules);
  void readModels(const nlohmann::ordered_json& models, const std::string& place);

  PathRules rules_;
  std::vector<uint32_t> numbers_;  // by rule
  std::vector<Model> known_;       // models of an earlier set
};

// The models of a set, collected object by object in the order of its frames.
class BopModels {
 public:
  explicit BopModels(const BopNumbers& numbers);

  // Adds an object of a frame's entry, with "node", "name", "shape" and "modelInfo".
  void add(const nlohmann::ordered_json& object);
  // Assigns numbers after all objects have been added. Rules and models of the earlier set fix numbers; other models
  // are numbered after these, sorted by name. Throws Error(BadInput) if two shapes have the same number.
  void number();
  uint32_t numberOf(const nlohmann::ordered_json& object) const;

  nlohmann::ordered_json info() const;  // models_info.json
  nlohmann::ordered_json list() const;  // models.json, a value for the option "models" of another set

 private:
  size_t find(const Shape& shape, uint32_t fixed) const;  // the model's index; models_.size() if there is none

  const BopNumbers& numbers_;
  std::vector<BopNumbers::Model> models_;
  std::multimap<uint64_t, size_t> byGeometry_;  // model indices by the geometry hash of the first part
};

}  // namespace latelight::data
