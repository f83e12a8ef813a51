// Mutations of glTF by its grammar, for the fuzz target gltf.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace latelight::fuzz {

struct Glb {
  nlohmann::json root;
  std::vector<uint8_t> binary;
};

// Returns an empty value if the bytes are not a .glb file with an object as its JSON.
std::optional<Glb> readGlb(std::span<const uint8_t> bytes);
std::vector<uint8_t> writeGlb(const Glb& glb);

class GltfMutator {
 public:
  GltfMutator(nlohmann::json& root, std::minstd_rand& random) : root_(root), random_(random) {}

  // Makes one change: replaces a value, adds or removes a member or an element, or replaces a part by another one with
  // the same name.
  void mutate();

 private:
  using Json = nlohmann::json;
  struct Part {
    Json* value;
    std::string name;    // its key, or that of the array that contains it
    Json* parent;        // null for the root
    std::string key;     // in the parent, if that is an object
    size_t element = 0;  // in the parent, if that is an array
  };

  size_t below(size_t count) { return random_() % count; }
  void collect(Json& value, const Part& part, int depth);
  Part& anyPart() { return parts_[below(parts_.size())]; }
  void replace(Part& part);
  void add(Part& part);
  void remove(Part& part);
  void copy(Part& part);
  Json number(const Json& before);
  Json text();

  Json& root_;
  std::minstd_rand& random_;
  std::vector<Part> parts_;
};

}  // namespace latelight::fuzz
