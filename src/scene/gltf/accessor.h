// Accessors: typed views of bytes, and their conversion to floats and indices.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/gltf/document.h"

namespace latelight::scene::gltf {

// The elements of one accessor, regardless of their storage. Bounds are checked, so reading `count` elements is safe.
struct Elements {
  const std::byte* data = nullptr;
  size_t count = 0;
  size_t stride = 0;      // bytes from one element to the next
  int componentType = 0;  // file::ComponentType
  size_t components = 0;  // per element: 1 for scalars, 16 for MAT4
  size_t columns = 1;     // above 1 for matrices
  bool normalized = false;
  std::shared_ptr<std::byte[]> owned;  // set if the bytes are not the file's: sparse, absent or Draco-compressed
  std::string name;                    // for messages: "accessors[3]"
};

// Returns the bytes of a component type, or 0 if glTF has no such type.
size_t componentBytes(int componentType);

// Throws Error(BadInput) if the accessor exceeds its bufferView or is malformed. Sparse accessors are assembled.
Elements resolve(const Document& document, int accessor);

// Reads `count` elements starting at `first` as vectors of N floats, converted as glTF 2.0 (3.6.2.2) and
// KHR_mesh_quantization specify. Missing components become `fill`; surplus ones are dropped.
template <int N>
void readVectors(const Elements& elements, size_t first, size_t count, glm::vec<N, float>* out, float fill = 0);

// Reads vectors in the same way. If a component is not finite, all components of its vector become `otherwise`, and
// `anyBroken` is set.
template <int N>
std::vector<glm::vec<N, float>> readRepaired(const Elements& elements, size_t first, size_t count, bool& anyBroken,
                                             float otherwise = 0, float fill = 0);

std::vector<glm::mat4> readMatrices(const Elements& elements);

// Reads unsigned integers with one component. Throws Error(BadInput) for other types.
std::vector<uint32_t> readIndices(const Elements& elements);
// Reads elements of four unsigned integers (JOINTS_n).
std::vector<glm::uvec4> readJoints(const Elements& elements, size_t first, size_t count);

}  // namespace latelight::scene::gltf
