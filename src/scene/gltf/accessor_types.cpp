// The table of permitted types, from glTF 2.0 (3.7.2.1, 3.7.2.2 and 3.11), KHR_mesh_quantization and
// EXT_mesh_gpu_instancing. Files may use the types of KHR_mesh_quantization without declaring it, and integers need not
// be marked as normalized: exporters omit both, and the values stay unambiguous. JOINTS_n may also be UNSIGNED_INT.
#include "scene/gltf/accessor_types.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

#include "base/error.h"

namespace latelight::scene::gltf {
namespace {

struct PermittedTypes {
  AccessorUse use;
  std::string_view values;              // without the number of a set, such as "_0"
  size_t minComponents, maxComponents;  // of an element
  std::vector<int> componentTypes;
};

const std::vector<PermittedTypes>& permittedTypes() {
  using file::kByte, file::kFloat, file::kShort, file::kUnsignedByte, file::kUnsignedInt, file::kUnsignedShort;
  using enum AccessorUse;
  static const std::vector<int> all{kFloat, kByte, kUnsignedByte, kShort, kUnsignedShort};
  static const std::vector<PermittedTypes> rows{
      {Vertices, "POSITION", 3, 3, all},
      {Vertices, "NORMAL", 3, 3, {kFloat, kByte, kShort}},
      {Vertices, "TANGENT", 4, 4, {kFloat, kByte, kShort}},
      {Vertices, "TEXCOORD", 2, 2, all},
      {Vertices, "COLOR", 3, 4, {kFloat, kUnsignedByte, kUnsignedShort}},
      {Vertices, "JOINTS", 4, 4, {kUnsignedByte, kUnsignedShort, kUnsignedInt}},
      {Vertices, "WEIGHTS", 4, 4, {kFloat, kUnsignedByte, kUnsignedShort}},
      {MorphTarget, "POSITION", 3, 3, {kFloat, kByte, kShort}},
      {MorphTarget, "NORMAL", 3, 3, {kFloat, kByte, kShort}},
      {MorphTarget, "TANGENT", 3, 3, {kFloat, kByte, kShort}},
      {MorphTarget, "TEXCOORD", 2, 2, all},
      {MorphTarget, "COLOR", 3, 4, all},
      {Instances, "TRANSLATION", 3, 3, {kFloat}},
      {Instances, "ROTATION", 4, 4, {kFloat, kByte, kShort}},
      {Instances, "SCALE", 3, 3, {kFloat}},
      {Animation, "translation", 3, 3, {kFloat}},
      {Animation, "rotation", 4, 4, all},
      {Animation, "scale", 3, 3, {kFloat}},
      {Animation, "weights", 1, 1, all},
  };
  return rows;
}

std::string_view withoutSet(std::string_view values) {
  const size_t end = values.find_last_not_of("0123456789");
  return end < values.size() - 1 && values[end] == '_' ? values.substr(0, end) : values;
}

std::string_view nameOfComponents(int componentType) {
  constexpr std::array<std::string_view, 7> kNames{"BYTE", "UNSIGNED_BYTE", "SHORT", "UNSIGNED_SHORT",
                                                   "",     "UNSIGNED_INT",  "FLOAT"};
  return kNames[size_t(componentType - file::kByte)];
}

std::string nameOfElements(size_t columns, size_t components) {
  if (columns > 1) return fmt::format("MAT{}", columns);
  return components == 1 ? "SCALAR" : fmt::format("VEC{}", components);
}

}  // namespace

void checkType(const Elements& elements, AccessorUse use, std::string_view values, const std::string& name) {
  const auto row = std::ranges::find_if(
      permittedTypes(), [&](const PermittedTypes& r) { return r.use == use && r.values == withoutSet(values); });
  if (row == permittedTypes().end()) return;
  const bool fits = elements.columns == 1 && elements.components >= row->minComponents &&
                    elements.components <= row->maxComponents &&
                    std::ranges::find(row->componentTypes, elements.componentType) != row->componentTypes.end();
  if (fits) return;
  std::string types = nameOfElements(1, row->minComponents);
  if (row->maxComponents > row->minComponents) types += " or " + nameOfElements(1, row->maxComponents);
  std::vector<std::string_view> componentTypes;
  for (const int type : row->componentTypes) componentTypes.push_back(nameOfComponents(type));
  badInput("{} is {} of {}, in {}; it must be {} of {}", name, nameOfElements(elements.columns, elements.components),
           nameOfComponents(elements.componentType), elements.name, types, fmt::join(componentTypes, ", "));
}

}  // namespace latelight::scene::gltf
