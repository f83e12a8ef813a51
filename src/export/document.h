// A glTF document under construction: its JSON, and the binary buffer that its accessors and images refer to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::exports {

using Json = nlohmann::ordered_json;

// Return the array or the object under a key of an object, after adding it if there is none. Letting nlohmann::json
// make an array or an object of a null value is no alternative: if memory runs out, the value's destructor crashes.
inline Json& arrayIn(Json& object, const char* key) {
  Json& value = object[key];
  return value.is_null() ? value = Json::array() : value;
}
inline Json& objectIn(Json& object, const char* key) {
  Json& value = object[key];
  return value.is_null() ? value = Json::object() : value;
}

enum class Target { None = 0, Vertices = 34962, Indices = 34963 };  // of a bufferView, as OpenGL's numbers

class Document {
 public:
  Json root = Json::object();

  // Appends to the array under `key`, and returns the element's index.
  size_t add(const char* key, Json element);
  void use(std::string_view extension) { extensions_.insert(std::string(extension)); }
  Json& extension(Json& object, const char* name) {
    use(name);
    return objectIn(objectIn(object, "extensions"), name);
  }

  size_t addView(std::span<const std::byte> bytes, Target target = Target::None);
  size_t addFloats(std::span<const float> values, Target target = Target::None) {
    return addNumbers(values, "SCALAR", target);
  }
  size_t addVectors(std::span<const glm::vec2> v) { return addNumbers(floatsOf(v), "VEC2", Target::Vertices); }
  size_t addVectors(std::span<const glm::vec3> v) { return addNumbers(floatsOf(v), "VEC3", Target::Vertices); }
  size_t addVectors(std::span<const glm::vec4> v) { return addNumbers(floatsOf(v), "VEC4", Target::Vertices); }
  // As addVectors(), with the bounds that POSITION requires.
  size_t addPositions(std::span<const glm::vec3> positions);
  size_t addIndices(std::span<const uint32_t> indices);
  size_t addMatrices(std::span<const glm::mat4> matrices);
  // Values of an animation: `type` is "SCALAR" or "VECn".
  size_t addNumbers(std::span<const float> values, const char* type, Target target);
  size_t addBytes(std::span<const uint8_t> values);    // SCALAR
  size_t addJoints(std::span<const uint16_t> joints);  // VEC4
  size_t addZeros(size_t count);                       // VEC3, without bytes

  // Returns the .glb file. Throws Error(Usage) if it would exceed the container's limit of 4 GiB.
  std::vector<std::byte> glb();

 private:
  template <int N>
  static std::span<const float> floatsOf(std::span<const glm::vec<N, float>> v) {
    return {v.empty() ? nullptr : &v[0].x, v.size() * N};
  }
  size_t addAccessor(std::span<const std::byte> bytes, int componentType, const char* type, size_t count,
                     Target target);

  std::vector<std::byte> binary_;
  std::set<std::string> extensions_;
};

// A float as the shortest decimal that is this float, so that the file's text is not longer than necessary.
double shortest(float value);
template <int N>
Json arrayOf(const glm::vec<N, float>& v) {
  Json array = Json::array();
  for (int i = 0; i < N; ++i) array.push_back(shortest(v[i]));
  return array;
}

}  // namespace latelight::exports
