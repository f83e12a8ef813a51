// SPIR-V of a folder of shaders: reflection, the check against a pipeline's declarations, specialization, and removal
// of dead code.
#include <cstring>
#include <vector>

#include "fuzz/fuzz.h"
#include "vk/dead_code.h"
#include "vk/interface_check.h"
#include "vk/reflection.h"
#include "vk/specialize.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  std::vector<uint32_t> words(size / sizeof(uint32_t));
  if (!words.empty()) std::memcpy(words.data(), data, words.size() * sizeof(uint32_t));
  fuzz::expectErrors({ExitCode::Internal}, [&] { vk::reflect(words); });
  const vk::Binding bindings[] = {vk::Binding::Storage, vk::Binding::Sampled};
  const vk::Constant constants[] = {{vk::ConstantId{0}, 1}, {vk::ConstantId{1}, 7}};
  const vk::CheckedStage stages[] = {{"a shader", words}};
  fuzz::expectErrors({ExitCode::Internal}, [&] {
    vk::checkInterface(stages, {.bindings = bindings, .constants = constants, .pushBytes = 16});
  });
  fuzz::expectErrors({ExitCode::Internal}, [&] { vk::removeDeadCode(vk::specialize(words, constants)); });
  return 0;
}
