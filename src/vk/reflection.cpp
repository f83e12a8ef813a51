// Shader reflection: reads the declarations of a SPIR-V module, follows the calls from its entry point to find the
// bindings that it uses statically, and determines the memory layout of its structs.
#include "vk/reflection.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "base/error.h"
#include "vk/spirv.h"

namespace latelight::vk {

namespace {

using namespace spirv;

constexpr uint32_t kStorageImage = 2;  // the operand "Sampled" of OpTypeImage for an image without a sampler

using Decorations = std::map<uint32_t, uint32_t>;  // decoration -> its first operand, or 0

// A module's declarations by id, and the bodies of its functions.
class Module {
 public:
  explicit Module(std::span<const uint32_t> code);

  std::vector<UsedBinding> bindings() const;
  std::optional<PushBlock> push() const;
  std::vector<DeclaredConstant> constants() const;
  std::vector<StructLayout> structs() const;

 private:
  void read(const Instruction& instruction);
  void declare(const Instruction& instruction);
  std::set<uint32_t> usedVariables() const;

  const Instruction& definition(uint32_t id) const;
  std::string name(uint32_t id) const;
  std::string memberName(uint32_t type, uint32_t member) const;
  std::optional<uint32_t> decoration(uint32_t id, spv::Decoration kind) const;
  uint32_t memberDecoration(uint32_t type, uint32_t member, spv::Decoration kind) const;  // 0 if it has none
  const Instruction& pointee(const Instruction& variable) const;
  std::string variableName(uint32_t id) const;

  std::optional<Binding> kindOf(const Instruction& variable) const;
  uint32_t bytesOf(uint32_t type, uint32_t matrixStride) const;
  uint32_t measure(uint32_t type, uint32_t matrixStride) const;
  uint32_t bytesOfStruct(const Instruction& type) const;
  uint32_t alignmentOf(uint32_t type) const;
  uint32_t strideOfArrays(uint32_t element) const;

  std::map<uint32_t, std::string> names_;
  std::map<uint32_t, std::map<uint32_t, std::string>> memberNames_;
  std::map<uint32_t, Decorations> decorations_;
  std::map<uint32_t, std::map<uint32_t, Decorations>> memberDecorations_;
  std::map<uint32_t, Instruction> definitions_;  // types, constants and variables of the module
  std::map<uint32_t, std::vector<Instruction>> functions_;
  uint32_t entry_ = 0, inside_ = 0;  // functions: the entry point, and the one being read
  mutable std::map<std::pair<uint32_t, uint32_t>, uint32_t> bytes_;  // by type and matrix stride
  mutable std::map<uint32_t, uint32_t> alignments_;                  // by type
  mutable uint32_t nesting_ = 0;
};

// Counts how deeply types are nested, which SPIR-V limits to 255 (SPIR-V 1.6, section 2.17).
class NestingScope {
 public:
  explicit NestingScope(uint32_t& nesting) : nesting_(nesting) {
    if (nesting_ == kMaxNesting) fail(ExitCode::Internal, "The types of a shader are nested too deeply.");
    ++nesting_;
  }
  ~NestingScope() { --nesting_; }
  NestingScope(const NestingScope&) = delete;
  NestingScope& operator=(const NestingScope&) = delete;

 private:
  static constexpr uint32_t kMaxNesting = 255;
  uint32_t& nesting_;
};

std::string text(std::span<const uint32_t> words) {
  const std::string all(reinterpret_cast<const char*>(words.data()), words.size_bytes());
  return all.substr(0, all.find('\0'));
}

Module::Module(std::span<const uint32_t> code) {
  forEachInstruction(code, [this](const Instruction& instruction) {
    read(instruction);
    return true;
  });
  if (inside_ != 0) fail(ExitCode::Internal, "The SPIR-V of a shader is truncated.");
}

void Module::read(const Instruction& instruction) {
  const auto& [op, operands] = instruction;
  switch (op) {
    case spv::OpName:
      names_[operands[0]] = text(operands.subspan(1));
      break;
    case spv::OpMemberName:
      memberNames_[operands[0]][operands[1]] = text(operands.subspan(2));
      break;
    case spv::OpEntryPoint:
      entry_ = operands[1];
      break;
    case spv::OpDecorate:
      decorations_[operands[0]][operands[1]] = operands.size() > 2 ? operands[2] : 0;
      break;
    case spv::OpMemberDecorate:
      memberDecorations_[operands[0]][operands[1]][operands[2]] = operands.size() > 3 ? operands[3] : 0;
      break;
    case spv::OpFunction:
      inside_ = operands[1];
      break;
    case spv::OpFunctionEnd:
      inside_ = 0;
      break;
    default:
      if (inside_ != 0)
        functions_[inside_].push_back(instruction);
      else
        declare(instruction);
  }
}

void Module::declare(const Instruction& instruction) {
  const auto& [op, operands] = instruction;
  if (op >= spv::OpTypeBool && op <= spv::OpTypePointer) definitions_[operands[0]] = instruction;
  const bool constant = op == spv::OpConstant || (op >= spv::OpSpecConstantTrue && op <= spv::OpSpecConstant);
  if (constant || op == spv::OpVariable) definitions_[operands[1]] = instruction;
}

const Instruction& Module::definition(uint32_t id) const {
  static const Instruction none;
  const auto found = definitions_.find(id);
  return found == definitions_.end() ? none : found->second;
}

std::string Module::name(uint32_t id) const {
  const auto found = names_.find(id);
  return found == names_.end() ? std::string() : found->second;
}

std::string Module::memberName(uint32_t type, uint32_t member) const {
  const auto of = memberNames_.find(type);
  return of == memberNames_.end() || !of->second.contains(member) ? std::string() : of->second.at(member);
}

std::optional<uint32_t> Module::decoration(uint32_t id, spv::Decoration kind) const {
  const auto of = decorations_.find(id);
  if (of == decorations_.end()) return std::nullopt;
  const auto found = of->second.find(kind);
  return found == of->second.end() ? std::nullopt : std::optional(found->second);
}

uint32_t Module::memberDecoration(uint32_t type, uint32_t member, spv::Decoration kind) const {
  const auto of = memberDecorations_.find(type);
  if (of == memberDecorations_.end() || !of->second.contains(member)) return 0;
  const Decorations& found = of->second.at(member);
  return found.contains(kind) ? found.at(kind) : 0;
}

const Instruction& Module::pointee(const Instruction& variable) const {
  return definition(definition(variable.operands[0]).operands[2]);
}

// A block without a name has the name of its type.
std::string Module::variableName(uint32_t id) const {
  const std::string own = name(id);
  const Instruction& type = pointee(definition(id));
  return own.empty() && !type.operands.empty() ? name(type.operands[0]) : own;
}

// --- used bindings --------------------------------------------------------------------------------------------------

// The operands of an instruction that may be pointers to module variables.
Operands pointersOf(const Instruction& instruction) {
  const auto& [op, operands] = instruction;
  switch (op) {
    case spv::OpStore:
      return operands.first(1);
    case spv::OpCopyMemory:
      return operands.first(2);
    case spv::OpLoad:
    case spv::OpImageTexelPointer:
    case spv::OpAccessChain:
    case spv::OpInBoundsAccessChain:
    case spv::OpPtrAccessChain:
    case spv::OpInBoundsPtrAccessChain:
    case spv::OpArrayLength:
    case spv::OpCopyObject:
      return operands.subspan(2).first(1);
    case spv::OpFunctionCall:
      return operands.subspan(3);  // arguments
    default:
      return {};
  }
}

std::set<uint32_t> Module::usedVariables() const {
  std::set<uint32_t> used, seen{entry_};
  std::vector<uint32_t> open{entry_};
  while (!open.empty()) {
    const auto function = functions_.find(open.back());
    open.pop_back();
    if (function == functions_.end()) continue;
    for (const Instruction& instruction : function->second) {
      for (uint32_t id : pointersOf(instruction))
        if (definition(id).op == spv::OpVariable) used.insert(id);
      if (instruction.op == spv::OpFunctionCall && seen.insert(instruction.operands[2]).second)
        open.push_back(instruction.operands[2]);
    }
  }
  return used;
}

std::optional<Binding> Module::kindOf(const Instruction& variable) const {
  const Instruction& type = pointee(variable);
  if (variable.operands[2] == spv::StorageClassUniform && type.op == spv::OpTypeStruct) return Binding::Uniform;
  if (variable.operands[2] != spv::StorageClassUniformConstant) return std::nullopt;
  if (type.op == spv::OpTypeRuntimeArray)
    return definition(type.operands[1]).op == spv::OpTypeSampledImage ? std::optional(Binding::TextureArray)
                                                                      : std::nullopt;
  const Instruction& image = type.op == spv::OpTypeSampledImage ? definition(type.operands[1]) : type;
  if (image.op != spv::OpTypeImage || image.operands[2] == spv::DimBuffer) return std::nullopt;
  if (type.op == spv::OpTypeSampledImage) return Binding::Sampled;
  return image.operands[6] == kStorageImage ? std::optional(Binding::Storage) : std::nullopt;
}

std::vector<UsedBinding> Module::bindings() const {
  std::vector<UsedBinding> found;
  for (uint32_t id : usedVariables())
    if (const std::optional<uint32_t> binding = decoration(id, spv::DecorationBinding))
      found.push_back({decoration(id, spv::DecorationDescriptorSet).value_or(0), *binding, kindOf(definition(id)),
                       variableName(id)});
  std::sort(found.begin(), found.end(), [](const UsedBinding& a, const UsedBinding& b) {
    return std::pair(a.set, a.binding) < std::pair(b.set, b.binding);
  });
  return found;
}

std::vector<DeclaredConstant> Module::constants() const {
  std::vector<DeclaredConstant> found;
  for (const auto& [id, instruction] : definitions_) {
    const std::optional<uint32_t> number = decoration(id, spv::DecorationSpecId);
    if (!number) continue;
    const Instruction& type = definition(instruction.operands[0]);
    const bool isWord = type.op == spv::OpTypeBool || (type.op == spv::OpTypeInt && type.operands[1] == 32);
    found.push_back({*number, isWord, name(id)});
  }
  return found;
}

// --- struct layouts -------------------------------------------------------------------------------------------------

// Each type is measured once, so that types that contain many others, or themselves, end as well.
uint32_t Module::bytesOf(uint32_t id, uint32_t matrixStride) const {
  const auto [known, isNew] = bytes_.try_emplace({id, matrixStride}, 0u);
  if (isNew) {
    const NestingScope scope(nesting_);
    known->second = measure(id, matrixStride);
  }
  return known->second;
}

uint32_t Module::measure(uint32_t id, uint32_t matrixStride) const {
  const auto& [op, operands] = definition(id);
  switch (op) {
    case spv::OpTypeInt:
    case spv::OpTypeFloat:
      return operands[1] / 8;
    case spv::OpTypeVector:
      return bytesOf(operands[1], 0) * operands[2];
    case spv::OpTypeMatrix:
      return matrixStride * (operands[2] - 1) + bytesOf(operands[1], 0);
    case spv::OpTypeArray: {
      const Instruction& length = definition(operands[2]);
      const uint32_t count = length.op == spv::OpConstant || length.op == spv::OpSpecConstant ? length.operands[2] : 1;
      return decoration(id, spv::DecorationArrayStride).value_or(0) * (count - 1) + bytesOf(operands[1], matrixStride);
    }
    case spv::OpTypeStruct:
      return bytesOfStruct(definition(id));
    case spv::OpTypePointer:
      return sizeof(VkDeviceAddress);
    default:
      return 0;  // a runtime array
  }
}

uint32_t Module::bytesOfStruct(const Instruction& type) const {
  const uint32_t id = type.operands[0];
  uint32_t end = 0;
  for (uint32_t i = 0; i + 1 < type.operands.size(); ++i)
    end = std::max(end, memberDecoration(id, i, spv::DecorationOffset) +
                            bytesOf(type.operands[i + 1], memberDecoration(id, i, spv::DecorationMatrixStride)));
  return end;
}

uint32_t Module::alignmentOf(uint32_t id) const {
  const auto [known, isNew] = alignments_.try_emplace(id, 1u);
  if (!isNew) return known->second;
  const NestingScope scope(nesting_);
  const auto& [op, operands] = definition(id);
  uint32_t most = 1;
  if (op == spv::OpTypeVector || op == spv::OpTypeMatrix || op == spv::OpTypeArray)
    most = alignmentOf(operands[1]);
  else if (op == spv::OpTypeStruct)
    for (uint32_t member : operands.subspan(1)) most = std::max(most, alignmentOf(member));
  else
    most = std::max(bytesOf(id, 0), 1u);
  return known->second = most;
}

uint32_t Module::strideOfArrays(uint32_t element) const {
  for (const auto& [id, type] : definitions_)
    if ((type.op == spv::OpTypeArray || type.op == spv::OpTypeRuntimeArray) && type.operands[1] == element)
      if (const std::optional<uint32_t> stride = decoration(id, spv::DecorationArrayStride)) return *stride;
  return 0;
}

std::optional<PushBlock> Module::push() const {
  for (const auto& [id, instruction] : definitions_) {
    if (instruction.op != spv::OpVariable || instruction.operands[2] != spv::StorageClassPushConstant) continue;
    const Instruction& type = pointee(instruction);
    if (type.op != spv::OpTypeStruct) fail(ExitCode::Internal, "The push constants of a shader are not a block.");
    return PushBlock{name(type.operands[0]), bytesOfStruct(type), alignmentOf(type.operands[0])};
  }
  return std::nullopt;
}

std::vector<StructLayout> Module::structs() const {
  std::vector<StructLayout> found;
  for (const auto& [id, members] : memberDecorations_) {
    const Instruction& type = definition(id);
    if (type.op != spv::OpTypeStruct || !members.contains(0) || !members.at(0).contains(spv::DecorationOffset))
      continue;
    StructLayout layout{
        name(id), decoration(id, spv::DecorationBlock).has_value(), bytesOfStruct(type), strideOfArrays(id), {}};
    for (const auto& [index, decorations] : members)
      layout.members.push_back({memberName(id, index), memberDecoration(id, index, spv::DecorationOffset),
                                memberDecoration(id, index, spv::DecorationMatrixStride)});
    found.push_back(std::move(layout));
  }
  return found;
}

}  // namespace

Reflection reflect(std::span<const uint32_t> code) {
  const Module module(code);
  return {module.bindings(), module.push(), module.constants(), module.structs()};
}

}  // namespace latelight::vk
