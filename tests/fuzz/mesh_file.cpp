// Mesh files: OBJ with its materials, PLY and STL. The first byte selects the format. In OBJ, the text after the first
// form feed is that of the file of materials.

#include "fuzz/fuzz.h"
#include "scene/mesh_files/load.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  if (size == 0) return 0;
  const auto format = static_cast<scene::MeshFormat>(data[0] % 3);
  const std::string_view text = fuzz::textOf(data + 1, size - 1);
  size_t end = text.size();
  if (format == scene::MeshFormat::Obj) end = std::min(end, text.find('\f'));
  const std::string_view materials = end < text.size() ? text.substr(end + 1) : std::string_view();
  fuzz::writeInput("m.mtl", std::as_bytes(std::span(materials)));
  const auto path = fuzz::writeInput("scene", std::as_bytes(std::span(text.substr(0, end))));
  fuzz::expectErrors({ExitCode::BadInput}, [&] { scene::loadMeshFile(path, format, {}); });
  return 0;
}
