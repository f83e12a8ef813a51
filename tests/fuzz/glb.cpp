// The container of a .glb file and its JSON: chunks, nesting, the schema and the estimate of the JSON's memory.
#include "fuzz/fuzz.h"
#include "scene/gltf/document.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  fuzz::expectErrors({ExitCode::BadInput}, [&] {
    const scene::gltf::Container container = scene::gltf::readContainer(fuzz::bytesOf(data, size));
    scene::gltf::treeBytes(container.json);
    const JsonTree root = scene::gltf::readJson(container.json);
    scene::gltf::externalFiles(*root);
    scene::gltf::file::readModel(*root);
  });
  return 0;
}
