#include "vk/interface_check.h"

#include <algorithm>

#include "base/error.h"
#include "vk/reflection.h"

namespace latelight::vk {

namespace {

constexpr uint32_t kMaxPushBytes = 128;  // in bytes; every Vulkan device supports it

const char* kindName(std::optional<Binding> kind) {
  if (!kind) return "something else";
  switch (*kind) {
    case Binding::Sampled:
      return "a sampled image";
    case Binding::Storage:
      return "a storage image";
    case Binding::Uniform:
    case Binding::DynamicUniform:
      return "a uniform buffer";
    case Binding::TextureArray:
      return "an array of textures";
  }
  fail(ExitCode::Internal, "There is no binding of kind {}.", static_cast<int>(*kind));
}

bool isKind(std::optional<Binding> used, Binding declared) {
  return used == declared || (used == Binding::Uniform && declared == Binding::DynamicUniform);
}

void checkBindings(const std::string& shader, const Reflection& found, const DeclaredInterface& declared) {
  for (const UsedBinding& used : found.bindings) {
    if (used.set == kTexelSet) continue;
    if (used.set > declared.sceneSets.size())
      fail(ExitCode::Internal, "{} uses {} of descriptor set {}, which its pipeline does not have.", shader, used.name,
           used.set);
    const std::span<const Binding> bindings = used.set == 0 ? declared.bindings : declared.sceneSets[used.set - 1];
    if (used.binding >= bindings.size())
      fail(ExitCode::Internal, "{} uses binding {} ({}), but its pipeline declares only {}.", shader, used.binding,
           used.name, bindings.size());
    const Binding kind = bindings[used.binding];
    if (!isKind(used.kind, kind))
      fail(ExitCode::Internal, "Binding {} ({}) of {} is {}, but its pipeline declares {}.", used.binding, used.name,
           shader, kindName(used.kind), kindName(kind));
  }
}

void checkConstants(const std::string& shader, const Reflection& found, std::span<const Constant> given) {
  for (const DeclaredConstant& constant : found.constants) {
    const bool isGiven =
        std::any_of(given.begin(), given.end(), [&](const Constant& c) { return c.id == ConstantId{constant.id}; });
    if (isGiven && !constant.isWord)
      fail(ExitCode::Internal, "Specialization constant {} ({}) of {} is neither a bool nor a 32-bit integer.",
           constant.id, constant.name, shader);
  }
}

bool fits(const PushBlock& block, uint32_t bytes) {
  const uint32_t padded = (block.bytes + block.alignment - 1) / block.alignment * block.alignment;
  return block.bytes <= bytes && bytes <= padded;
}

void checkPush(std::span<const CheckedStage> stages, std::span<const Reflection> found, uint32_t bytes) {
  if (bytes > kMaxPushBytes)
    fail(ExitCode::Internal, "The pipeline of {} pushes {} bytes, but devices may support no more than {}.",
         stages[0].shader, bytes, kMaxPushBytes);
  size_t longest = 0;
  for (size_t i = 0; i < found.size(); ++i)
    if (found[i].push && (!found[longest].push || found[i].push->bytes > found[longest].push->bytes)) longest = i;
  const std::optional<PushBlock>& block = found[longest].push;
  if (!block)
    fail(ExitCode::Internal, "{} has no push constants, but its pipeline pushes {} bytes.", stages[0].shader, bytes);
  if (!fits(*block, bytes))
    fail(ExitCode::Internal, "The push constants ({}) of {} take {} bytes, but its pipeline pushes {}.", block->name,
         stages[longest].shader, block->bytes, bytes);
}

}  // namespace

void checkInterface(std::span<const CheckedStage> stages, const DeclaredInterface& declared) {
  std::vector<Reflection> found;
  for (const auto& [shader, code] : stages) {
    found.push_back(reflect(code));
    checkBindings(shader, found.back(), declared);
    checkConstants(shader, found.back(), declared.constants);
  }
  if (declared.pushBytes > 0) checkPush(stages, found, declared.pushBytes);
}

}  // namespace latelight::vk
