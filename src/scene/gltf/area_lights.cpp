#include "scene/gltf/area_lights.h"

#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/json.h"
#include "scene/light_types.h"
#include "shared/light.h"

namespace latelight::scene::gltf {

namespace {

using nlohmann::json;

// Reads the properties of extras, whose types nothing has checked. Throws Error(Input) with the name of the property.
class Reader {
 public:
  explicit Reader(const json& source) : source_(source) {
    if (!source.is_object()) badInput("it is not an object");
  }

  std::string text(const char* key) const {
    const json* value = findProperty(source_, key);
    if (value && !value->is_string()) badInput("its {} is not a string", key);
    return value ? value->get<std::string>() : "";
  }
  double length(const char* key, double otherwise = 1) const {
    const double value = number(key, otherwise);
    if (!(static_cast<float>(value) > 0)) badInput("its {} must be above 0, not {:g}", key, value);
    return value;
  }
  double notNegative(const char* key, double otherwise) const {
    const double value = number(key, otherwise);
    if (value < 0) badInput("its {} must be at least 0, not {:g}", key, value);
    return value;
  }
  std::optional<bool> flag(const char* key) const {
    const json* value = findProperty(source_, key);
    if (!value) return std::nullopt;
    if (!value->is_boolean()) badInput("its {} must be true or false", key);
    return value->get<bool>();
  }
  vec3 color() const {
    const json* value = findProperty(source_, "color");
    if (!value) return vec3(1);
    if (!value->is_array() || value->size() != 3) badInput("its color must have three numbers");
    vec3 color(0);
    for (int i = 0; i < 3; ++i) {
      const json& channel = (*value)[static_cast<size_t>(i)];
      color[i] = channel.is_number() ? channel.get<float>() : -1;
      if (!(color[i] >= 0) || !std::isfinite(color[i])) badInput("its color must have three numbers of at least 0");
    }
    return color;
  }
  // Reads a property of an object that may be absent.
  double lengthIn(const char* object, const char* key) const {
    const json* inner = findProperty(source_, object);
    return inner ? Reader(*inner).length(key) : 1;
  }

 private:
  double number(const char* key, double otherwise) const {
    const json* value = findProperty(source_, key);
    if (!value) return otherwise;
    if (!value->is_number() || !std::isfinite(value->get<float>())) badInput("its {} must be a finite number", key);
    return value->get<double>();
  }

  const json& source_;
};

Light read(const json& source) {
  const Reader reader(source);
  Light light;
  const std::string type = reader.text("type");
  const std::optional<uint32_t> found = findLightType(type);
  if (!found || !shared::lightIsArea(*found))
    badInput("its type must be rect, disk, sphere or tube, not \"{}\"", printable(type));
  light.type = *found;
  light.name = reader.text("name");
  light.color = reader.color();
  light.intensity = static_cast<float>(reader.notNegative("intensity", 1));
  light.castShadow = reader.flag("castShadow");
  const double size = reader.length("size");
  if (light.type == shared::kLightRect) {
    light.height = static_cast<float>(size);
    light.width = static_cast<float>(size * reader.lengthIn("rect", "aspect"));
    if (!(light.width > 0) || !std::isfinite(light.width)) badInput("its width is out of range");
  } else {
    light.size = static_cast<float>(size / 2);
  }
  if (light.type == shared::kLightTube) light.length = static_cast<float>(reader.lengthIn("tube", "length"));
  const std::optional<bool> twoSided = reader.flag("twoSided");
  if (twoSided && light.type != shared::kLightRect && light.type != shared::kLightDisk)
    badInput("only a rect or a disk can be twoSided");
  light.twoSided = twoSided.value_or(false);
  return light;
}

}  // namespace

std::optional<Light> readAreaLight(const json& source, const std::string& path) {
  try {
    return read(source);
  } catch (const Error& error) {
    warn("the areaLight in the extras of {} is left out: {}", path, error.what());
    return std::nullopt;
  }
}

}  // namespace latelight::scene::gltf
