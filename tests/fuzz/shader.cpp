// SPIR-V of a folder of shaders: reflection, the check against a pipeline's declarations, specialization, and removal
// of dead code. Two words of the header that no parser reads, the generator and the schema, choose the declarations.
// Mutations know the format: they change, copy and remove whole instructions, and their operands by others of the
// module, so that most inputs remain sequences of instructions.
#include <cstring>
#include <random>
#include <vector>

#include "fuzz/fuzz.h"
#include "vk/dead_code.h"
#include "vk/interface_check.h"
#include "vk/reflection.h"
#include "vk/specialize.h"
#include "vk/spirv.h"

using namespace latelight;

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t maxSize);

namespace {

using Words = std::vector<uint32_t>;

constexpr size_t kGenerator = 2, kSchema = 4;  // words of the header
constexpr vk::Binding kKinds[] = {vk::Binding::Storage, vk::Binding::Sampled, vk::Binding::Uniform,
                                  vk::Binding::DynamicUniform, vk::Binding::TextureArray};

Words wordsOf(const uint8_t* data, size_t size) {
  Words words(size / sizeof(uint32_t));
  if (!words.empty()) std::memcpy(words.data(), data, words.size() * sizeof(uint32_t));
  return words;
}

void checkDeclarations(const Words& code, std::span<const vk::Constant> constants) {
  const uint32_t generator = code.size() > kGenerator ? code[kGenerator] : 0;
  const uint32_t schema = code.size() > kSchema ? code[kSchema] : 0;
  std::vector<vk::Binding> bindings;
  for (uint32_t i = 0; i < generator % 8; ++i) bindings.push_back(kKinds[(generator >> (3 + 3 * i)) % 5]);
  const std::vector<vk::Binding> sets[] = {{vk::Binding::TextureArray}};
  const vk::CheckedStage stages[] = {{"a shader", code}, {"the same shader", code}};
  vk::checkInterface(stages, {.bindings = bindings,
                              .sceneSets = std::span(sets).first(schema % 2),
                              .constants = constants,
                              .pushBytes = schema / 2 % 160});
}

// One change of a module of instructions.
class ModuleMutator {
 public:
  ModuleMutator(Words& module, std::minstd_rand& random) : module_(module), random_(random) {
    for (size_t at = vk::spirv::kHeaderWords; at < module.size();) {
      const size_t words = module[at] >> spv::WordCountShift;
      if (words == 0 || words > module.size() - at) break;
      starts_.push_back(at);
      at += words;
    }
  }
  void mutate() {
    if (starts_.empty() || upTo(16) == 0) {
      module_[upTo(2) ? kGenerator : kSchema] = random_();
      return;
    }
    const size_t at = starts_[upTo(starts_.size())], words = module_[at] >> spv::WordCountShift;
    const auto begin = module_.begin() + ptrdiff_t(at), end = begin + ptrdiff_t(words);
    switch (upTo(8)) {
      case 0:
        module_.erase(begin, end);
        break;
      case 1: {  // a copy elsewhere
        const Words copy(begin, end);
        module_.insert(module_.begin() + ptrdiff_t(starts_[upTo(starts_.size())]), copy.begin(), copy.end());
        break;
      }
      case 2:  // another operation with the same operands
        *begin = (*begin & ~spv::OpCodeMask) | (module_[starts_[upTo(starts_.size())]] & spv::OpCodeMask);
        break;
      case 3:  // one operand less
        if (words > 1) {
          *begin -= 1u << spv::WordCountShift;
          module_.erase(end - 1);
        }
        break;
      case 4:  // one operand more
        *begin += 1u << spv::WordCountShift;
        module_.insert(end, operand());
        break;
      default:
        if (words > 1) begin[ptrdiff_t(1 + upTo(words - 1))] = operand();
    }
  }

 private:
  size_t upTo(size_t count) { return random_() % count; }
  // A word of an instruction, which is likely an id, or a small number.
  uint32_t operand() {
    if (upTo(4) == 0) return uint32_t(upTo(64));
    const uint32_t word = module_[vk::spirv::kHeaderWords + upTo(module_.size() - vk::spirv::kHeaderWords)];
    return upTo(8) == 0 ? word ^ 1u << upTo(32) : word;
  }

  Words& module_;
  std::minstd_rand& random_;
  std::vector<size_t> starts_;  // of instructions
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  const Words words = wordsOf(data, size);
  fuzz::expectErrors({ExitCode::Internal}, [&] { vk::reflect(words); });
  const vk::Constant constants[] = {{vk::ConstantId{0}, 1}, {vk::ConstantId{1}, 7}};
  fuzz::expectErrors({ExitCode::Internal}, [&] { checkDeclarations(words, constants); });
  fuzz::expectErrors({ExitCode::Internal}, [&] { vk::removeDeadCode(vk::specialize(words, constants)); });
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t maxSize, unsigned int number) {
  std::minstd_rand random(number);
  Words words = wordsOf(data, size);
  if (words.size() <= vk::spirv::kHeaderWords || random() % 16 == 0) return LLVMFuzzerMutate(data, size, maxSize);
  for (unsigned int count = 1 + random() % 3; count > 0; --count) ModuleMutator(words, random).mutate();
  const size_t written = words.size() * sizeof(uint32_t);
  if (written > maxSize) return LLVMFuzzerMutate(data, size, maxSize);
  std::memcpy(data, words.data(), written);
  return written;
}
