// JSON of files, whose destruction allocates nothing.
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

namespace latelight {

// Makes a value null, from its leaves up. The destructor of nlohmann::json lists all elements of a value instead, in
// memory that it allocates, and ends the process if there is none. Recurses as deep as the value is nested.
template <typename Json>
void clearJson(Json& value) noexcept {
  if (auto* const array = value.template get_ptr<typename Json::array_t*>()) {
    for (Json& element : *array) clearJson(element);
    array->clear();
  } else if (auto* const object = value.template get_ptr<typename Json::object_t*>()) {
    for (auto& [key, element] : *object) clearJson(element);
    object->clear();
  }
  value = nullptr;
}

// Owns a value, which is destroyed by clearJson(). Its nesting must be limited.
class JsonTree {
 public:
  JsonTree() = default;
  JsonTree(nlohmann::json value) noexcept : value_(std::move(value)) {}
  JsonTree(JsonTree&&) noexcept = default;
  JsonTree& operator=(JsonTree&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  JsonTree(const JsonTree&) = default;
  JsonTree& operator=(const JsonTree& other) { return *this = JsonTree(other); }
  ~JsonTree() { clearJson(value_); }

  nlohmann::json& operator*() { return value_; }
  const nlohmann::json& operator*() const { return value_; }
  const nlohmann::json* operator->() const { return &value_; }

 private:
  nlohmann::json value_;
};

}  // namespace latelight
