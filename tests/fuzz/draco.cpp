// KHR_draco_mesh_compression: the first bytes select the types of two accessors; the rest is the compressed mesh.
#include "scene/gltf/draco.h"

#include "fuzz/fuzz.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  if (size < 5) return 0;
  namespace file = scene::gltf::file;
  scene::gltf::Document document;
  document.views.push_back({.bytes = fuzz::bytesOf(data, size).subspan(4)});
  document.budget.setInput(size);
  const auto accessor = [](uint8_t type, uint8_t components) {
    return file::Accessor{.componentType = 5120 + type % 7, .normalized = type >= 128, .rows = 1 + components % 5u};
  };
  document.model.accessors = {accessor(data[0], data[1]), accessor(data[2], data[3])};
  file::Primitive primitive;
  primitive.attributes = {{"POSITION", 0}, {"NORMAL", 1}};
  primitive.draco = {.bufferView = 0, .attributes = {{"POSITION", 0}, {"NORMAL", 1}}};
  fuzz::expectErrors({ExitCode::BadInput}, [&] { scene::gltf::decodeDraco(document, primitive, "a primitive"); });
  return 0;
}
