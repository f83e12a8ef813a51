#include "memory_model.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <set>

#include "base/hash.h"

namespace latelight::graph {
namespace {

using Stages = VkPipelineStageFlags2;
using Accesses = VkAccessFlags2;

// The effect of a use on memory.
struct Effect {
  Stages stages;
  Accesses access;
  Accesses writing;
  VkImageLayout layout;
  bool needsContents;  // undefined contents would be visible
  bool overwrites;     // overwrites the full contents
};

Effect effectOf(Use use) {
  const Stages color = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
  const Stages tests = VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
  const Stages fragment = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, compute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
  const Stages vertex = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, transfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  const Accesses colorWrite = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
  const Accesses colorBoth = colorWrite | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
  const Accesses depthRead = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
  const Accesses depthWrite = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  const Accesses sampled = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
  const Accesses load = VK_ACCESS_2_SHADER_STORAGE_READ_BIT, store = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
  const VkImageLayout attachment = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, readOnly = VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL;
  const VkImageLayout general = VK_IMAGE_LAYOUT_GENERAL, none = VK_IMAGE_LAYOUT_UNDEFINED;
  switch (use) {
    case Use::ColorAttachment:
      return {color, colorBoth, colorWrite, attachment, false, true};
    case Use::ColorAttachmentLoad:
      return {color, colorBoth, colorWrite, attachment, true, false};
    case Use::DepthAttachment:
      return {tests, depthRead | depthWrite, depthWrite, attachment, false, true};
    case Use::DepthAttachmentLoad:
      return {tests, depthRead | depthWrite, depthWrite, attachment, true, false};
    case Use::DepthTest:
      return {tests, depthRead, 0, readOnly, true, false};
    case Use::SampledFragment:
      return {fragment, sampled, 0, readOnly, true, false};
    case Use::SampledCompute:
      return {compute, sampled, 0, readOnly, true, false};
    case Use::StorageRead:
      return {compute, load, 0, general, true, false};
    case Use::StorageWrite:
      return {compute, store, store, general, false, true};
    case Use::StorageReadWrite:
      return {compute, load | store, store, general, true, false};
    case Use::FragmentWrite:
      return {fragment, store, store, general, false, true};
    case Use::FragmentReadWrite:
      return {fragment, load | store, store, general, true, false};
    case Use::VertexRead:
      return {vertex | fragment, load, 0, none, true, false};
    case Use::IndirectRead:
      return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, 0, none, true, false};
    case Use::CopySource:
      return {transfer, VK_ACCESS_2_TRANSFER_READ_BIT, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, true, false};
    case Use::CopyTarget:
      return {transfer,
              VK_ACCESS_2_TRANSFER_WRITE_BIT,
              VK_ACCESS_2_TRANSFER_WRITE_BIT,
              VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
              false,
              false};
    case Use::HostRead:
      return {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, 0, none, true, false};
  }
  return {};
}

// An access or a layout transition that later accesses may have to be ordered after.
struct Operation {
  Stages stages;             // where it is executed; empty for a transition
  Accesses writing;          // the access types of its writes; empty for reads and transitions
  Stages reached = 0;        // stages whose later work waits for it, through a chain of barriers
  Stages reachedMemory = 0;  // those to which its writes are also available
  std::vector<std::pair<Stages, Accesses>> visible;

  bool isTransition() const { return stages == 0; }

  void meet(const Barrier& barrier) {
    const bool whole = stages && (barrier.sourceStage & stages) == stages;
    const bool flushed = whole && writing && (barrier.sourceAccess & writing) == writing;
    if (whole || (reached & barrier.sourceStage)) reached |= barrier.targetStage;
    if (!flushed && !(reachedMemory & barrier.sourceStage)) return;
    reachedMemory |= barrier.targetStage;
    visible.push_back({barrier.targetStage, barrier.targetAccess});
  }

  bool isBefore(Stages later) const { return (reached & later) == later; }

  bool isVisible(Stages later, Accesses access) const {
    for (Stages rest = later; rest; rest &= rest - 1) {
      const Stages stage = Stages{1} << std::countr_zero(rest);
      Accesses seen = 0;
      for (const auto& [stages, accesses] : visible) seen |= stages & stage ? accesses : 0;
      if ((access & ~seen) != 0) return false;
    }
    return true;
  }
};

class Memory {
 public:
  explicit Memory(const Resource& resource) : isImage_(bool(resource.image)), defined_(!isImage_ && resource.imported) {
    if (resource.before.empty()) return;
    const Effect effect = effectOf(resource.before[0]);
    layout_ = isImage_ ? effect.layout : VK_IMAGE_LAYOUT_UNDEFINED;
    defined_ = true;
    if (effect.writing) {
      writes_ = {Operation{effect.stages, effect.writing}};
      return;
    }
    // The last write must be visible to this use.
    writes_ = {Operation{0, 0, effect.stages, effect.stages, {{effect.stages, effect.access}}}};
    reads_ = {Operation{effect.stages, 0}};
  }

  void barrier(const Barrier& barrier, std::vector<std::string>& wrong) {
    for (Operation& write : writes_) write.meet(barrier);
    for (Operation& read : reads_) read.meet(barrier);
    if (!isImage_) return;
    if (barrier.oldLayout != layout_ && barrier.oldLayout != VK_IMAGE_LAYOUT_UNDEFINED) {
      wrong.push_back("a barrier from a layout that the image is not in");
    }
    if (barrier.oldLayout == VK_IMAGE_LAYOUT_UNDEFINED) defined_ = false;
    if (barrier.oldLayout == barrier.newLayout) return;
    transition(barrier, wrong);
  }

  void access(const std::vector<Use>& uses, std::vector<std::string>& wrong) {
    Effect all{};
    for (const Use use : uses) {
      const Effect effect = effectOf(use);
      if (isImage_ && effect.layout != layout_) wrong.push_back("an access in the wrong layout");
      if (effect.needsContents && !defined_) wrong.push_back("a read of undefined contents");
      all.stages |= effect.stages;
      all.access |= effect.access;
      all.writing |= effect.writing;
    }
    for (const Operation& write : writes_) {
      if (!write.isBefore(all.stages)) wrong.push_back("an access that does not wait for the write before it");
      if (!write.isVisible(all.stages, all.access)) wrong.push_back("an access that the write is not visible to");
    }
    if (!all.writing) {
      reads_.push_back({all.stages, 0});
      return;
    }
    for (const Operation& read : reads_) {
      if (!read.isBefore(all.stages)) wrong.push_back("a write that does not wait for a read before it");
    }
    writes_ = {Operation{all.stages, all.writing}};
    reads_.clear();
    defined_ = changed_ = true;
  }

  // Checks the state at the end of the plan, which the next user expects.
  void finish(const Resource& resource, std::vector<std::string>& wrong) {
    if (!resource.exported.empty()) {
      access(resource.exported, wrong);
    } else if (!resource.before.empty() && changed_) {
      access(resource.before, wrong);
    }
  }

  // Other contents use the same bytes from here on: after these barriers, first in these stages.
  void handOver(const std::vector<Barrier>& barriers, Stages stages, std::vector<std::string>& wrong) const {
    for (const std::vector<Operation>* operations : {&writes_, &reads_}) {
      for (Operation operation : *operations) {
        for (const Barrier& barrier : barriers) operation.meet(barrier);
        if (!operation.isBefore(stages)) wrong.push_back("memory that is used anew while it is in use");
        if (operation.writing && (operation.reachedMemory & stages) != stages)
          wrong.push_back("memory that is used anew before a write to it is available");
      }
    }
  }

 private:
  // A transition reads and writes the full image between the barrier's two scopes.
  void transition(const Barrier& barrier, std::vector<std::string>& wrong) {
    for (const Operation& read : reads_) {
      if (!waitedFor(read, barrier)) wrong.push_back("a transition that does not wait for a read before it");
    }
    for (const Operation& write : writes_) {
      if (!waitedFor(write, barrier)) wrong.push_back("a transition that does not wait for the write before it");
      // Through this barrier or an earlier one.
      if (!write.isTransition() && !(write.reachedMemory & barrier.targetStage)) {
        wrong.push_back("a transition of memory that is not available");
      }
    }
    layout_ = barrier.newLayout;
    changed_ = true;
    writes_ = {
        Operation{0, 0, barrier.targetStage, barrier.targetStage, {{barrier.targetStage, barrier.targetAccess}}}};
    reads_.clear();
  }

  static bool waitedFor(const Operation& operation, const Barrier& barrier) {
    const bool direct = operation.stages && (barrier.sourceStage & operation.stages) == operation.stages;
    return direct || (operation.reached & barrier.sourceStage);
  }

  bool isImage_;
  bool defined_;
  bool changed_ = false;  // written, or transitioned to another layout
  VkImageLayout layout_ = VK_IMAGE_LAYOUT_UNDEFINED;
  std::vector<Operation> writes_;  // the last write, if any
  std::vector<Operation> reads_;   // since that write
};

bool concerns(const Barrier& barrier, const Resource& resource) {
  return resource.image ? barrier.image == resource.image : barrier.buffer == resource.buffer;
}

std::vector<Use> usesOf(const ModelPass& pass, const Resource& resource) {
  std::vector<Use> uses;
  for (const Access& access : pass.accesses) {
    if (resource.image ? access.image == resource.image : access.buffer == resource.buffer) uses.push_back(access.use);
  }
  return uses;
}

// The resource after all steps.
Memory runSteps(const Resource& resource, const std::vector<ModelPass>& passes, const Plan& plan,
                std::vector<std::string>& wrong) {
  Memory memory(resource);
  for (const Plan::Step& step : plan.steps) {
    for (const Barrier& barrier : step.before) {
      if (concerns(barrier, resource)) memory.barrier(barrier, wrong);
    }
    const std::vector<Use> uses = usesOf(passes[step.pass], resource);
    if (!uses.empty()) memory.access(uses, wrong);
  }
  return memory;
}

// The steps from a resource's first use to its last, and the barriers before the first; empty if it is not used.
struct Occupation {
  const Resource* resource;
  size_t first, last;
  Stages stages;
  std::vector<Barrier> barriers;
};

std::vector<Occupation> occupationsOf(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                      const Plan& plan, uint64_t byte) {
  std::vector<Occupation> occupations;
  for (const Resource& resource : resources) {
    if (byte < resource.begin || resource.end <= byte) continue;
    std::optional<Occupation> occupation;
    for (size_t i = 0; i < plan.steps.size(); ++i) {
      const std::vector<Use> uses = usesOf(passes[plan.steps[i].pass], resource);
      if (uses.empty()) continue;
      if (!occupation) {
        occupation = Occupation{.resource = &resource, .first = i};
        for (const Use use : uses) occupation->stages |= effectOf(use).stages;
        for (const Barrier& barrier : plan.steps[i].before)
          if (concerns(barrier, resource)) occupation->barriers.push_back(barrier);
      }
      occupation->last = i;
    }
    if (occupation) occupations.push_back(*occupation);
  }
  std::sort(occupations.begin(), occupations.end(),
            [](const Occupation& a, const Occupation& b) { return a.first < b.first; });
  return occupations;
}

}  // namespace

std::vector<std::string> findAliasingHazards(const std::vector<Resource>& resources,
                                             const std::vector<ModelPass>& passes, const Plan& plan) {
  std::vector<std::string> wrong, elsewhere;
  std::set<uint64_t> bytes;  // one per range that the same resources share
  for (const Resource& resource : resources) bytes.insert({resource.begin, resource.end});
  for (const uint64_t byte : bytes) {
    const std::vector<Occupation> occupations = occupationsOf(resources, passes, plan, byte);
    for (size_t i = 1; i < occupations.size(); ++i) {
      const Occupation &before = occupations[i - 1], &after = occupations[i];
      if (before.last >= after.first) wrong.push_back("two resources at once in the same bytes");
      runSteps(*before.resource, passes, plan, elsewhere).handOver(after.barriers, after.stages, wrong);
    }
  }
  return wrong;
}

std::vector<std::string> findHazards(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                     const Plan& plan) {
  std::vector<std::string> wrong;
  for (const Resource& resource : resources) {
    Memory memory = runSteps(resource, passes, plan, wrong);
    for (const Barrier& barrier : plan.after) {
      if (concerns(barrier, resource)) memory.barrier(barrier, wrong);
    }
    memory.finish(resource, wrong);
  }
  return wrong;
}

std::vector<uint64_t> exportedValues(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                     const std::vector<uint32_t>& order) {
  std::vector<uint64_t> values(resources.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = i + 1;
  for (const uint32_t pass : order) {
    std::vector<uint64_t> inputs = {pass};
    for (size_t i = 0; i < resources.size(); ++i) {
      for (const Use use : usesOf(passes[pass], resources[i])) {
        if (!effectOf(use).overwrites) inputs.push_back(values[i]);
      }
    }
    for (size_t i = 0; i < resources.size(); ++i) {
      for (const Use use : usesOf(passes[pass], resources[i])) {
        if (effectOf(use).writing) values[i] = hash64(inputs.data(), inputs.size() * sizeof(uint64_t), i);
      }
    }
  }
  std::vector<uint64_t> exported;
  for (size_t i = 0; i < resources.size(); ++i) {
    if (!resources[i].exported.empty()) exported.push_back(values[i]);
  }
  return exported;
}

}  // namespace latelight::graph
