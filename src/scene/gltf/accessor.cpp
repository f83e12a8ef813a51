// Resolves accessors, with bounds checks, sparse storage and conversion to floats and integers.
#include "scene/gltf/accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"

namespace latelight::scene::gltf {
namespace {

// Returns the bytes of one element. Matrix columns start at multiples of 4 bytes (glTF 2.0, 3.6.2.4).
size_t elementBytes(const file::Accessor& accessor, size_t component) {
  const size_t column = accessor.rows * component;
  return accessor.columns == 1 ? column : accessor.columns * ((column + 3) / 4 * 4);
}

// Throws unless `count` elements of `size` bytes, `stride` apart, lie within the view. None of the products can
// overflow: counts are below 2^32, strides below 2^12, offsets below 2^41.
const std::byte* within(const Document& document, int view, size_t offset, size_t count, size_t stride, size_t size,
                        const std::string& name) {
  Bytes bytes = document.views[size_t(view)].bytes;
  size_t end = offset + (count - 1) * stride + size;
  if (end > bytes.size())
    badInput("{} reaches to byte {} of bufferViews[{}], which has {}", name, end, view, bytes.size());
  return bytes.data() + offset;
}

// Allocates separate storage for elements that are not a plain slice of the file.
std::byte* own(const Document& document, Elements& elements, size_t size) {
  size_t bytes = elements.count * size;
  document.budget.charge(bytes, elements.name);
  elements.owned = std::make_shared<std::byte[]>(bytes);
  elements.data = elements.owned.get();
  elements.stride = size;
  return elements.owned.get();
}

uint32_t indexAt(const std::byte* p, int componentType) {
  switch (componentType) {
    case file::kUnsignedByte:
      return uint32_t(*p);
    case file::kUnsignedShort: {
      uint16_t v;
      std::memcpy(&v, p, 2);
      return v;
    }
    default: {
      uint32_t v;
      std::memcpy(&v, p, 4);
      return v;
    }
  }
}

bool isIndexType(int componentType) {
  return componentType == file::kUnsignedByte || componentType == file::kUnsignedShort ||
         componentType == file::kUnsignedInt;
}

void applySparse(const Document& document, const file::Sparse& sparse, Elements& elements, size_t size) {
  size_t count = sparse.count, indexBytes = componentBytes(sparse.indices.componentType);
  if (!isIndexType(sparse.indices.componentType)) badInput("{} has sparse indices of an invalid type", elements.name);
  const std::byte* indices = within(document, sparse.indices.bufferView, sparse.indices.byteOffset, count, indexBytes,
                                    indexBytes, elements.name + "'s sparse indices");
  const std::byte* values = within(document, sparse.values.bufferView, sparse.values.byteOffset, count, size, size,
                                   elements.name + "'s sparse values");
  Elements dense = elements;
  std::byte* target = own(document, elements, size);
  if (dense.data)
    for (size_t i = 0; i < dense.count; ++i) std::memcpy(target + i * size, dense.data + i * dense.stride, size);
  for (size_t i = 0; i < count; ++i) {
    uint32_t at = indexAt(indices + i * indexBytes, sparse.indices.componentType);
    if (at >= elements.count)
      badInput("{} has the sparse index {}, but {} elements", elements.name, at, elements.count);
    std::memcpy(target + at * size, values + i * size, size);
  }
}

template <typename T>
float toFloat(T value, bool normalized) {
  if constexpr (std::is_same_v<T, float>) {
    return value;
  } else {
    if (!normalized) return float(value);
    return std::max(float(value) / float(std::numeric_limits<T>::max()), -1.0f);
  }
}

template <typename T, int N>
void convert(const Elements& e, size_t first, size_t count, glm::vec<N, float>* out, float fill) {
  const std::byte* source = e.data + first * e.stride;
  if (std::is_same_v<T, float> && e.components == N && e.stride == N * sizeof(float)) {
    std::memcpy(out, source, count * N * sizeof(float));
    return;
  }
  int have = std::min(int(e.components), N);
  for (size_t i = 0; i < count; ++i, source += e.stride) {
    for (int c = 0; c < have; ++c) {
      T value;
      std::memcpy(&value, source + size_t(c) * sizeof(T), sizeof(T));
      out[i][c] = toFloat(value, e.normalized);
    }
    for (int c = have; c < N; ++c) out[i][c] = fill;
  }
}

}  // namespace

size_t componentBytes(int componentType) {
  switch (componentType) {
    case file::kByte:
    case file::kUnsignedByte:
      return 1;
    case file::kShort:
    case file::kUnsignedShort:
      return 2;
    case file::kUnsignedInt:
    case file::kFloat:
      return 4;
    default:
      return 0;
  }
}

Elements resolve(const Document& document, int index) {
  const file::Accessor& accessor = document.model.accessors[size_t(index)];
  Elements elements{.count = accessor.count,
                    .componentType = accessor.componentType,
                    .normalized = accessor.normalized,
                    .name = fmt::format("accessors[{}]", index)};
  size_t component = componentBytes(accessor.componentType);
  if (component == 0)
    badInput("{} has the componentType {}, which glTF does not have", elements.name, accessor.componentType);
  elements.components = accessor.columns * accessor.rows;
  elements.columns = accessor.columns;
  size_t size = elementBytes(accessor, component);
  if (accessor.bufferView >= 0) {
    elements.stride = document.views[size_t(accessor.bufferView)].byteStride;
    if (elements.stride == 0) elements.stride = size;
    if (elements.stride < size) badInput("{} has elements of {} bytes, {} apart", elements.name, size, elements.stride);
    elements.data = within(document, accessor.bufferView, accessor.byteOffset, elements.count, elements.stride, size,
                           elements.name);
  }
  if (accessor.sparse)
    applySparse(document, *accessor.sparse, elements, size);
  else if (accessor.bufferView < 0)
    own(document, elements, size);  // zeros, as the specification requires
  return elements;
}

template <int N>
void readVectors(const Elements& e, size_t first, size_t count, glm::vec<N, float>* out, float fill) {
  switch (e.componentType) {
    case file::kByte:
      return convert<int8_t>(e, first, count, out, fill);
    case file::kUnsignedByte:
      return convert<uint8_t>(e, first, count, out, fill);
    case file::kShort:
      return convert<int16_t>(e, first, count, out, fill);
    case file::kUnsignedShort:
      return convert<uint16_t>(e, first, count, out, fill);
    case file::kUnsignedInt:
      return convert<uint32_t>(e, first, count, out, fill);
    default:
      return convert<float>(e, first, count, out, fill);
  }
}

template <int N>
std::vector<glm::vec<N, float>> readRepaired(const Elements& e, size_t first, size_t count, bool& anyBroken,
                                             float otherwise, float fill) {
  std::vector<glm::vec<N, float>> out(count);
  readVectors(e, first, count, out.data(), fill);
  if (e.componentType != file::kFloat) return out;
  for (glm::vec<N, float>& value : out) {
    bool finite = true;
    for (int c = 0; c < N; ++c) finite &= std::isfinite(value[c]);
    if (finite) continue;
    value = glm::vec<N, float>(otherwise);
    anyBroken = true;
  }
  return out;
}

std::vector<glm::mat4> readMatrices(const Elements& e) {
  if (e.components != 16 || e.componentType != file::kFloat) badInput("{} should hold 4x4 matrices of floats", e.name);
  std::vector<glm::mat4> out(e.count);
  for (size_t i = 0; i < e.count; ++i) {
    std::memcpy(&out[i], e.data + i * e.stride, sizeof(glm::mat4));
    for (int c = 0; c < 16; ++c)
      if (!std::isfinite(out[i][c / 4][c % 4]))
        badInput("{} has a value that is not a finite number, at element {}", e.name, i);
  }
  return out;
}

std::vector<uint32_t> readIndices(const Elements& e) {
  if (e.components != 1 || !isIndexType(e.componentType)) badInput("{} should hold indices: unsigned scalars", e.name);
  std::vector<uint32_t> out(e.count);
  for (size_t i = 0; i < e.count; ++i) out[i] = indexAt(e.data + i * e.stride, e.componentType);
  return out;
}

std::vector<glm::uvec4> readJoints(const Elements& e, size_t first, size_t count) {
  if (e.components != 4 || !isIndexType(e.componentType))
    badInput("{} should hold joints: four unsigned numbers each", e.name);
  size_t component = componentBytes(e.componentType);
  std::vector<glm::uvec4> out(count);
  for (size_t i = 0; i < count; ++i)
    for (size_t c = 0; c < 4; ++c)
      out[i][int(c)] = indexAt(e.data + (first + i) * e.stride + c * component, e.componentType);
  return out;
}

template void readVectors<1>(const Elements&, size_t, size_t, glm::vec1*, float);
template void readVectors<2>(const Elements&, size_t, size_t, glm::vec2*, float);
template void readVectors<3>(const Elements&, size_t, size_t, glm::vec3*, float);
template void readVectors<4>(const Elements&, size_t, size_t, glm::vec4*, float);
template std::vector<glm::vec1> readRepaired<1>(const Elements&, size_t, size_t, bool&, float, float);
template std::vector<glm::vec2> readRepaired<2>(const Elements&, size_t, size_t, bool&, float, float);
template std::vector<glm::vec3> readRepaired<3>(const Elements&, size_t, size_t, bool&, float, float);
template std::vector<glm::vec4> readRepaired<4>(const Elements&, size_t, size_t, bool&, float, float);

}  // namespace latelight::scene::gltf
