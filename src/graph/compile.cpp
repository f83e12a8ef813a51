// Derives barriers from declared uses. compile() tracks one state per resource through the passes that run, in order,
// and treats each image or buffer as one unit. It writes a Plan: the barriers before each step, the final barriers and
// the lifetimes of transients. The terms are those of the Vulkan specification, chapter 7 (Synchronization): a write
// must be made available, then visible to the stages and accesses that read it; a read only has to be finished before
// the resource is written again.
#include <algorithm>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "graph/graph.h"
#include "graph/use.h"

namespace latelight::graph {
namespace {

// Stages and accesses to which a barrier made the contents visible.
struct Visible {
  VkPipelineStageFlags2 stages;
  VkAccessFlags2 access;
};

// The state of one resource so far.
struct State {
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
  bool defined = false;  // contents are defined
  bool changed = false;  // written, or transitioned to another layout, by this plan
  // The source of the contents: the last write. After a layout transition, it is the stages that waited for the
  // transition, because no stage performs it and its result is available at once. A barrier from these stages is
  // ordered after the transition.
  VkPipelineStageFlags2 sourceStages = 0;
  VkAccessFlags2 sourceAccess = 0;
  VkPipelineStageFlags2 readStages = 0;  // stages of all reads since the last write
  std::vector<Visible> visible;          // stages and accesses that can read the last write

  // The stages and writes that must finish before the memory is used otherwise. Reads follow the write, and their
  // barriers made it available, so an execution dependency on the reads is enough.
  VkPipelineStageFlags2 lastStages() const { return readStages ? readStages : sourceStages; }
  VkAccessFlags2 lastWrites() const { return readStages ? 0 : sourceAccess; }

  // Returns the stages of `need` to which the contents are not yet visible.
  VkPipelineStageFlags2 stagesWithoutVisibility(const ResourceUse& need) const;
  void startWith(const ResourceUse& before);
  std::optional<Barrier> use(const ResourceUse& need);
};

VkPipelineStageFlags2 State::stagesWithoutVisibility(const ResourceUse& need) const {
  VkPipelineStageFlags2 result = 0;
  for (VkPipelineStageFlags2 rest = need.stages; rest; rest &= rest - 1) {
    const VkPipelineStageFlags2 stage = rest & (~rest + 1);  // lowest bit
    VkAccessFlags2 access = 0;
    for (const Visible& v : visible) access |= v.stages & stage ? v.access : 0;
    if ((access & need.access) != need.access) result |= stage;
  }
  return result;
}

// Starts with the state after another graph, or after the previous user of the resource.
void State::startWith(const ResourceUse& before) {
  layout = before.layout;
  defined = true;
  sourceStages = before.stages;
  sourceAccess = before.writing;
  if (before.writing) return;
  readStages = before.stages;
  visible = {{before.stages, before.access}};
}

// The barrier required before `need`, and the state after it.
std::optional<Barrier> State::use(const ResourceUse& need) {
  const bool transition = layout != need.layout;
  const bool overwrite = transition || need.writing;
  const bool unwritten = sourceStages == 0;  // new, or written only by the host: visible to all
  const VkPipelineStageFlags2 waiting = overwrite ? need.stages : (unwritten ? 0 : stagesWithoutVisibility(need));

  std::optional<Barrier> barrier;
  if (transition || (waiting && (sourceStages | readStages))) {
    barrier = Barrier{.sourceStage = overwrite ? lastStages() : sourceStages,
                      .targetStage = waiting,
                      .sourceAccess = overwrite ? lastWrites() : sourceAccess,
                      .targetAccess = unwritten && !transition ? 0 : need.access,
                      .oldLayout = transition && !need.keeps ? VK_IMAGE_LAYOUT_UNDEFINED : layout,
                      .newLayout = need.layout};
  }
  if (overwrite) {
    changed = true;
    sourceStages = need.stages;
    sourceAccess = need.writing;
    readStages = 0;
    visible.clear();
  }
  if (!need.writing) {
    readStages |= need.stages;
    if (barrier) visible.push_back({waiting, need.access});
  }
  layout = need.layout;
  defined = true;
  return barrier;
}

// The states of all images, or of all buffers.
template <typename Id>
class States {
  static constexpr bool kImages = std::is_same_v<Id, ImageId>;

 public:
  template <typename Nodes>
  explicit States(const Nodes& nodes) : states_(nodes.size()), needs_(nodes.size()), lives_(nodes.size()) {
    for (size_t i = 0; i < nodes.size(); ++i) {
      names_.push_back(&nodes[i].desc.name);
      // A buffer that the host filled is visible to everything submitted later.
      states_[i].defined = !kImages && nodes[i].imported;
      if (!nodes[i].before) continue;
      ResourceUse before;
      before.add(*nodes[i].before, kImages);
      states_[i].startWith(before);
    }
  }

  const State& operator[](size_t index) const { return states_[index]; }

  void gather(Id id, Use use) {
    if (needs_[id.index].stages == 0) touched_.push_back(id);
    needs_[id.index].add(use, kImages);
  }

  // Appends the barriers for all uses gathered since the last call. `who` names the reader in the error message.
  void apply(const std::string& who, uint32_t step, std::vector<Barrier>& barriers) {
    for (const Id id : touched_) {
      const ResourceUse need = std::exchange(needs_[id.index], {});
      State& state = states_[id.index];
      noteUse(lives_[id.index], step, need);
      if (need.reads && !state.defined) {
        fail(ExitCode::Internal, "frame graph: {} reads '{}', which nothing wrote", who, *names_[id.index]);
      }
      std::optional<Barrier> barrier = state.use(need);
      if (!barrier) continue;
      if constexpr (kImages) {
        barrier->image = id;
      } else {
        barrier->buffer = id;
      }
      barriers.push_back(*barrier);
    }
    touched_.clear();
  }

  // Adds the lifetimes of the transients that were used.
  template <typename Nodes>
  void addTransients(const Nodes& nodes, Plan& plan) const {
    for (uint32_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].imported || lives_[i].firstStages == 0) continue;
      Plan::Lifetime life = lives_[i];
      if constexpr (kImages) {
        life.image = {i};
      } else {
        life.buffer = {i};
      }
      life.lastStages = states_[i].lastStages();
      life.lastWrites = states_[i].lastWrites();
      if (nodes[i].exported || !inDeviceMemory(nodes[i].desc)) {
        plan.kept.push_back(life);
      } else {
        plan.lives.push_back(life);
      }
    }
  }

 private:
  static void noteUse(Plan::Lifetime& life, uint32_t step, const ResourceUse& need) {
    if (life.firstStages == 0) {
      life.first = step;
      life.firstStages = need.stages;
      life.firstAccess = need.access;
    }
    life.last = step;
  }
  static bool inDeviceMemory(const vk::ImageDesc&) { return true; }
  static bool inDeviceMemory(const vk::BufferDesc& desc) { return desc.kind == vk::MemoryKind::Device; }

  std::vector<State> states_;
  std::vector<ResourceUse> needs_;  // of the current pass
  std::vector<Plan::Lifetime> lives_;
  std::vector<Id> touched_;
  std::vector<const std::string*> names_;
};

// Transitions exported resources to their final use. Imported ones that changed return to their previous use.
template <typename Id, typename Nodes>
void gatherFinal(const Nodes& nodes, States<Id>& states) {
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    const auto& node = nodes[i];
    if (node.exported) {
      states.gather({i}, *node.exported);
    } else if (node.before && states[i].changed) {
      states.gather({i}, *node.before);
    }
  }
}

// The barrier after a pass of the prologue, over all memory. Later passes may read its results and overwrite its
// inputs.
constexpr Barrier kAfterPrologue{
    .sourceStage = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    .targetStage = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
    .sourceAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
    .targetAccess = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};

// Adds the passes of the prologue. Each of their barriers precedes the next pass.
std::vector<Barrier> addPrologue(const std::vector<Pass>& passes, Plan& plan) {
  std::vector<Barrier> barriers;
  for (uint32_t i = 0; i < passes.size(); ++i) {
    if (!passes[i].prologue) continue;
    plan.steps.push_back({i, std::exchange(barriers, {kAfterPrologue})});
  }
  return barriers;
}

}  // namespace

Plan Graph::compile() const {
  Plan plan;
  std::vector<Barrier> first = addPrologue(passes_, plan);
  States<ImageId> images(images_);
  States<BufferId> buffers(buffers_);
  const std::vector<bool> runs = alive();
  for (uint32_t i = 0; i < passes_.size(); ++i) {
    if (!runs[i] || passes_[i].prologue) continue;
    for (const Access& access : passes_[i].accesses) {
      if (access.image) {
        images.gather(access.image, access.use);
      } else {
        buffers.gather(access.buffer, access.use);
      }
    }
    const uint32_t index = static_cast<uint32_t>(plan.steps.size());
    Plan::Step& step = plan.steps.emplace_back(Plan::Step{i, std::exchange(first, {})});
    const std::string who = "pass '" + passes_[i].name + "'";
    images.apply(who, index, step.before);
    buffers.apply(who, index, step.before);
  }
  images.addTransients(images_, plan);
  buffers.addTransients(buffers_, plan);
  std::stable_sort(plan.lives.begin(), plan.lives.end(),
                   [](const Plan::Lifetime& a, const Plan::Lifetime& b) { return a.first < b.first; });
  gatherFinal(images_, images);
  gatherFinal(buffers_, buffers);
  plan.after = std::move(first);
  const uint32_t end = static_cast<uint32_t>(plan.steps.size());
  images.apply("the export", end, plan.after);
  buffers.apply("the export", end, plan.after);
  return plan;
}

}  // namespace latelight::graph
