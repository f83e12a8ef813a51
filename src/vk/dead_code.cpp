// Dead code elimination on SPIR-V.
//
// One shader of the renderer serves many settings, which are specialization constants; most of its code is for others
// than those of a pipeline. Drivers translate all of it before they find that out, which takes a CPU device most of the
// time until a pipeline is ready. Each function passes through these steps:
//
//   all instructions  --ReachedBlocks-->  blocks that run  --FunctionBody-->  instructions that run
//
// Sweep keeps those that have an effect, in the functions that are called.
//
// SPIR-V's control flow is structured (SPIR-V 1.6, section 2.11): a header names the block where its selection or loop
// ends, and a loop's header the block from which it repeats. A selection whose branch leads one way becomes a plain
// branch, and its end a block like any other. Other headers remain, and so do the blocks that they name: those that
// nothing reaches end in OpUnreachable, or lead back to the header of their loop.
#include "vk/dead_code.h"

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "vk/reached_blocks.h"
#include "vk/spirv.h"

namespace latelight::vk {

namespace {

using namespace spirv;
using Words = std::vector<uint32_t>;

constexpr uint32_t kMaxBound = 0x3fffff;  // SPIR-V 1.6, section 2.17, "Universal Limits"

// The parts of a module. Instructions refer to its words, and to those that `made` owns.
struct Module {
  uint32_t bound = 0;
  std::vector<Instruction> globals;
  std::vector<std::vector<Instruction>> functions;
  std::map<uint32_t, uint32_t> undefined;  // ids of OpUndef by type
  std::deque<Words> made;
  bool isSupported = true;  // has neither debug information nor groups of decorations

  Instruction make(uint32_t op, Words operands) {
    made.push_back(std::move(operands));
    return {op, Operands(made.back())};
  }
  // The id of an undefined value of a type.
  uint32_t undefinedOf(uint32_t type) {
    const auto [found, isNew] = undefined.try_emplace(type, bound);
    if (isNew) globals.push_back(make(spv::OpUndef, {type, bound++}));
    return found->second;
  }
};

// Debug information comes as OpLine, or as instructions without semantics (SPV_KHR_non_semantic_info).
bool isSupported(const Instruction& instruction) {
  const auto& [op, x] = instruction;
  if (op == spv::OpExtInstImport) {
    const std::span<const uint32_t> name = x.subspan(1);
    return !std::string_view(reinterpret_cast<const char*>(name.data()), name.size_bytes()).starts_with("NonSemantic");
  }
  return op != spv::OpLine && op != spv::OpGroupDecorate && op != spv::OpGroupMemberDecorate;
}

Module parse(std::span<const uint32_t> code) {
  Module module;
  forEachInstruction(code, [&](const Instruction& instruction) {
    module.bound = code[3];
    if (module.bound > kMaxBound) fail(ExitCode::Internal, "The SPIR-V of a shader is invalid: it has too many ids.");
    if (const auto id = resultId(instruction); id && *id >= module.bound)
      fail(ExitCode::Internal, "The SPIR-V of a shader is invalid: id {} is out of bounds.", *id);
    module.isSupported &= isSupported(instruction);
    if (instruction.op == spv::OpFunction) module.functions.emplace_back();
    (module.functions.empty() ? module.globals : module.functions.back()).push_back(instruction);
    return true;
  });
  return module;
}

// The ids that instructions of functions define.
std::vector<bool> localIds(const Module& module) {
  std::vector<bool> isLocal(module.bound);
  for (const auto& function : module.functions)
    for (const Instruction& instruction : function)
      if (const auto id = resultId(instruction)) isLocal[*id] = true;
  return isLocal;
}

// Writes the instructions of a function that run.
class FunctionBody {
 public:
  FunctionBody(std::span<const Instruction> function, const ReachedBlocks& flow, Module& module);
  std::vector<Instruction> out;

 private:
  void findEnds();
  void putReached(const Block& block);
  void putEnd(const Block& block);
  Instruction merged(const Block& block, const Instruction& phi) const;

  const ReachedBlocks& flow_;
  Module& module_;
  std::set<uint32_t> ends_;                 // blocks where a remaining selection or loop ends
  std::map<uint32_t, uint32_t> loopHeads_;  // by the block from which a remaining loop repeats
};

FunctionBody::FunctionBody(std::span<const Instruction> function, const ReachedBlocks& flow, Module& module)
    : flow_(flow), module_(module) {
  out.reserve(function.size());
  for (const Instruction& instruction : function) {
    if (instruction.op == spv::OpLabel) break;
    out.push_back(instruction);
  }
  if (flow.blocks().empty()) return;
  findEnds();
  for (const Block& block : flow.blocks()) block.reached ? putReached(block) : putEnd(block);
  out.push_back({spv::OpFunctionEnd, {}});
}

bool leadsOneWay(const ReachedBlocks& flow, const Block& block) {
  return block.instructions.back().op == spv::OpBranchConditional && flow.onlyTarget(block);
}

void FunctionBody::findEnds() {
  for (const Block& block : flow_.blocks()) {
    if (!block.reached || block.instructions.size() < 2) continue;
    const auto& [op, x] = block.instructions[block.instructions.size() - 2];
    if (op == spv::OpLoopMerge || (op == spv::OpSelectionMerge && !leadsOneWay(flow_, block))) ends_.insert(x[0]);
    if (op == spv::OpLoopMerge) loopHeads_[x[1]] = block.label;
  }
}

void FunctionBody::putReached(const Block& block) {
  out.push_back(module_.make(spv::OpLabel, {block.label}));
  for (const Instruction& instruction : block.instructions.first(block.instructions.size() - 1))
    out.push_back(instruction.op == spv::OpPhi ? merged(block, instruction) : instruction);
  const Instruction& terminator = block.instructions.back();
  const auto only = flow_.onlyTarget(block);
  if (!only) {
    out.push_back(terminator);
  } else if (terminator.op == spv::OpSwitch) {  // nested selections may branch to its end
    out.push_back(module_.make(spv::OpSwitch, {terminator.operands[0], *only}));
  } else {
    if (out.back().op == spv::OpSelectionMerge) out.pop_back();
    out.push_back(module_.make(spv::OpBranch, {*only}));
  }
}

// A block that nothing reaches, but a header names.
void FunctionBody::putEnd(const Block& block) {
  const auto loop = loopHeads_.find(block.label);
  if (loop == loopHeads_.end() && !ends_.contains(block.label)) return;
  out.push_back(module_.make(spv::OpLabel, {block.label}));
  out.push_back(loop == loopHeads_.end() ? Instruction{spv::OpUnreachable, {}}
                                         : module_.make(spv::OpBranch, {loop->second}));
}

// A phi of the blocks that lead to `block`.
Instruction FunctionBody::merged(const Block& block, const Instruction& phi) const {
  Words words{phi.operands[0], phi.operands[1]};
  for (size_t i = 2; i + 1 < phi.operands.size(); i += 2)
    if (std::ranges::find(block.from, phi.operands[i + 1]) != block.from.end())
      words.insert(words.end(), {phi.operands[i], phi.operands[i + 1]});
  for (const auto& [repeats, head] : loopHeads_)
    if (head == block.label && !flow_.block(repeats).reached)
      words.insert(words.end(), {module_.undefinedOf(phi.operands[0]), repeats});
  return module_.make(spv::OpPhi, std::move(words));
}

// Returns true if each loop has a branch that leads back to its header.
bool loopsRepeat(const std::vector<Instruction>& function) {
  std::map<uint32_t, bool> heads;
  uint32_t label = 0;
  for (const auto& [op, x] : function) {
    if (op == spv::OpLabel) label = x[0];
    if (op == spv::OpLoopMerge) heads[label] = false;
    if (op == spv::OpBranch || op == spv::OpBranchConditional)
      for (const uint32_t target : x)
        if (const auto head = heads.find(target); head != heads.end()) head->second = true;
  }
  return std::ranges::all_of(heads, [](const auto& head) { return head.second; });
}

// Returns true if an instruction has no effect besides its result.
bool isPure(const Instruction& instruction) {
  const uint32_t op = instruction.op;
  const Operands& x = instruction.operands;
  const auto in = [op](uint32_t first, uint32_t last) { return op >= first && op <= last; };
  if (op == spv::OpLoad) return x.size() < 4 || (x[3] & spv::MemoryAccessVolatileMask) == 0;
  constexpr uint32_t kModf = 35, kFrexp = 51;  // GLSL.std.450: they write through a pointer
  if (op == spv::OpExtInst) return x[3] != kModf && x[3] != kFrexp;
  return op == spv::OpUndef || op == spv::OpVariable || op == spv::OpPhi ||
         in(spv::OpAccessChain, spv::OpInBoundsPtrAccessChain) || in(spv::OpVectorExtractDynamic, spv::OpImageRead) ||
         in(spv::OpImage, spv::OpImageQuerySamples) || in(spv::OpConvertFToU, spv::OpBitcast) ||
         in(spv::OpSNegate, spv::OpFUnordGreaterThanEqual) || in(spv::OpShiftRightLogical, spv::OpBitCount) ||
         in(spv::OpDPdx, spv::OpFwidthCoarse);
}

// Marks the instructions that have an effect, those whose results they use, and the functions that they call.
class Sweep {
 public:
  explicit Sweep(const Module& module);
  // The module without what is not marked, nor names and decorations of ids of `isLocal` that are gone.
  Words result(std::span<const uint32_t> header, std::vector<bool> isLocal) const;

 private:
  struct Entry {
    const Instruction* instruction;
    bool isUsed;
  };
  void use(uint32_t id);
  void useFunction(size_t index);

  const Module& module_;
  std::vector<std::vector<Entry>> functions_;
  std::vector<bool> isCalled_;
  std::vector<Entry*> definitions_;    // by id: the instruction of a function that defines it
  std::vector<uint32_t> functionIds_;  // by id: one more than the index of the function
  std::vector<uint32_t> pending_;      // used ids whose operands are not marked
};

Sweep::Sweep(const Module& module)
    : module_(module), isCalled_(module.functions.size()), definitions_(module.bound), functionIds_(module.bound) {
  for (const auto& function : module.functions) {
    auto& entries = functions_.emplace_back();
    for (const Instruction& instruction : function) entries.push_back({&instruction, false});
    for (Entry& entry : entries)
      if (const auto id = resultId(*entry.instruction)) definitions_[*id] = &entry;
    functionIds_[function.front().operands[1]] = static_cast<uint32_t>(functions_.size());
  }
  for (const Instruction& global : module.globals)
    if (global.op == spv::OpEntryPoint) use(global.operands[1]);
  while (!pending_.empty()) {
    const uint32_t id = pending_.back();
    pending_.pop_back();
    for (const uint32_t operand : definitions_[id]->instruction->operands) use(operand);
  }
}

// Any operand may be an id: one that is a number marks at most an instruction too many.
void Sweep::use(uint32_t id) {
  if (id >= definitions_.size()) return;
  if (functionIds_[id] != 0) useFunction(functionIds_[id] - 1);
  Entry* entry = definitions_[id];
  if (!entry || entry->isUsed) return;
  entry->isUsed = true;
  pending_.push_back(id);
}

void Sweep::useFunction(size_t index) {
  if (isCalled_[index]) return;
  isCalled_[index] = true;
  for (Entry& entry : functions_[index])
    if (!isPure(*entry.instruction)) {
      entry.isUsed = true;
      for (const uint32_t operand : entry.instruction->operands) use(operand);
    }
}

// Returns true if an instruction names or decorates an id, its first operand.
bool isAnnotation(uint32_t op) {
  return op == spv::OpName || op == spv::OpDecorate || op == spv::OpDecorateId || op == spv::OpDecorateString;
}

Words Sweep::result(std::span<const uint32_t> header, std::vector<bool> isLocal) const {
  Words code(header.begin(), header.end());
  code[3] = module_.bound;
  const auto put = [&code](const Instruction& instruction) {
    code.push_back(instruction.firstWord());
    code.insert(code.end(), instruction.operands.begin(), instruction.operands.end());
  };
  std::vector<const Instruction*> kept;
  for (size_t f = 0; f < functions_.size(); ++f)
    for (const auto& [instruction, isUsed] : functions_[f])
      if (isCalled_[f] && isUsed) {
        kept.push_back(instruction);
        if (const auto id = resultId(*instruction)) isLocal[*id] = false;
      }
  for (const Instruction& global : module_.globals)
    if (!isAnnotation(global.op) || global.operands[0] >= isLocal.size() || !isLocal[global.operands[0]]) put(global);
  for (const Instruction* instruction : kept) put(*instruction);
  return code;
}

}  // namespace

std::vector<uint32_t> removeDeadCode(std::span<const uint32_t> code) {
  Module module = parse(code);
  if (!module.isSupported) return {code.begin(), code.end()};
  const std::vector<bool> isLocal = localIds(module);
  Values values(module.bound);
  for (const Instruction& global : module.globals) values.addGlobal(global);
  for (auto& function : module.functions) {
    const ReachedBlocks flow(function, values);
    FunctionBody body(function, flow, module);
    if (loopsRepeat(body.out)) function = std::move(body.out);
  }
  return Sweep(module).result(code.first(kHeaderWords), isLocal);
}

}  // namespace latelight::vk
