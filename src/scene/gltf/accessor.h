// Accessors: typed views of bytes, and their conversion to floats and indices.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/gltf/document.h"

namespace latelight::scene::gltf {

// Elements of one accessor, wherever they are stored: bounds are checked, so reading `count` of them is safe.
struct Elements {
  const std::byte* data = nullptr;
  size_t count = 0;
  size_t stride = 0;      // bytes from one to the next
  int componentType = 0;  // glTF's: 5120 to 5126
  size_t components = 0;  // of a vector or scalar; 16 for MAT4
  bool normalized = false;
  std::shared_ptr<std::byte[]> owned;  // set where the bytes are not the file's: sparse, absent or Draco's
  std::string name;                    // for messages: "accessors[3]"
};

// Bytes of a component type, or 0 if glTF has no such type.
size_t componentBytes(int componentType);

// Throws Error(BadInput) if the accessor reaches past its bufferView or is malformed. Sparse ones are assembled.
Elements resolve(const Document& document, int accessor);

// `count` elements from `first` on as vectors of N floats, converted as glTF 2.0 (3.6.2.2) and KHR_mesh_quantization
// say. Missing components become `fill`; surplus ones are dropped.
template <int N>
void readVectors(const Elements& elements, size_t first, size_t count, glm::vec<N, float>* out, float fill = 0);

// The same; values with a component that is not finite become `otherwise` in all components, and `anyBroken` is set.
template <int N>
std::vector<glm::vec<N, float>> readRepaired(const Elements& elements, size_t first, size_t count, bool& anyBroken,
                                             float otherwise = 0, float fill = 0);

std::vector<glm::mat4> readMatrices(const Elements& elements);

// Unsigned integers, one component. Throws Error(BadInput) for other types.
std::vector<uint32_t> readIndices(const Elements& elements);
// Four unsigned integers each: JOINTS_n.
std::vector<glm::uvec4> readJoints(const Elements& elements, size_t first, size_t count);

}  // namespace latelight::scene::gltf
