// EXT_meshopt_compression: the first bytes select mode, filter, stride and count; the rest is the stream.
#include <array>

#include "fuzz/fuzz.h"
#include "scene/gltf/document.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  if (size < 6) return 0;
  constexpr std::array kModes{"ATTRIBUTES", "TRIANGLES", "INDICES"};
  constexpr std::array kFilters{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
  const size_t stride = 2 + data[2] % 255, count = 1 + size_t{data[3]} + (size_t{data[4]} << 8);
  const std::span<const std::byte> stream = fuzz::bytesOf(data, size).subspan(5);
  nlohmann::json compressed = {{"buffer", 0},
                               {"byteLength", stream.size()},
                               {"count", count},
                               {"byteStride", stride},
                               {"mode", kModes[data[0] % kModes.size()]},
                               {"filter", kFilters[data[1] % kFilters.size()]}};
  const nlohmann::json view = {{"buffer", 0},
                               {"byteLength", count * stride},
                               {"extensions", {{"EXT_meshopt_compression", std::move(compressed)}}}};
  fuzz::expectErrors({ExitCode::BadInput}, [&] {
    scene::gltf::Document document;
    document.budget.setInput(stream.size());
    document.views.resize(1);
    scene::gltf::decodeMeshopt(document, {{"bufferViews", {view}}}, {stream});
  });
  return 0;
}
