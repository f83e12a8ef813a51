// Access to the properties of validated JSON (schema.h), which have the expected types if they are present.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

namespace latelight::scene::gltf {

// Returns the property, or null if it is absent.
inline const nlohmann::json* findProperty(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

// Returns the object of an extension, or null.
inline const nlohmann::json* findExtension(const nlohmann::json& object, const char* name) {
  const nlohmann::json* all = findProperty(object, "extensions");
  return all ? findProperty(*all, name) : nullptr;
}

// Returns the property or, if it is absent, an empty array.
inline const nlohmann::json& arrayIn(const nlohmann::json& object, const char* key) {
  static const nlohmann::json kEmpty = nlohmann::json::array();
  const nlohmann::json* found = findProperty(object, key);
  return found ? *found : kEmpty;
}

template <typename Vector>
Vector vectorOf(const nlohmann::json& array) {
  Vector vector;
  for (int i = 0; i < Vector::length(); ++i)
    vector[i] = static_cast<typename Vector::value_type>(array[size_t(i)].get<double>());
  return vector;
}

// Returns the property or, if it is absent, `otherwise`.
template <typename Vector>
Vector vectorIn(const nlohmann::json& object, const char* key, const Vector& otherwise) {
  const nlohmann::json* found = findProperty(object, key);
  return found ? vectorOf<Vector>(*found) : otherwise;
}

}  // namespace latelight::scene::gltf
