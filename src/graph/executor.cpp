#include <algorithm>
#include <memory>

#include "base/error.h"
#include "graph/graph.h"

namespace latelight::graph {
namespace {

// Transient resources of one kind, found again by their whole description.
template <typename Resource, typename Desc>
class Shelf {
 public:
  // One that nobody took in this run. Runs are numbered from 1.
  const Resource* take(vk::Device& device, const Desc& desc, uint64_t run) {
    for (Entry& entry : entries_) {
      if (entry.lastRun == run || entry.desc != desc) continue;
      entry.lastRun = run;
      return entry.resource.get();
    }
    entries_.push_back({desc, std::make_unique<Resource>(device, desc), run});
    return entries_.back().resource.get();
  }

  // Frees what no recent run took: pictures of another size, a graph that ran once.
  void tidy(uint64_t run) {
    constexpr uint64_t kKeptRuns = 4;
    std::erase_if(entries_, [&](const Entry& entry) { return entry.lastRun + kKeptRuns < run; });
  }

 private:
  struct Entry {
    Desc desc;  // as asked for: the resource may round its own up
    std::unique_ptr<Resource> resource;
    uint64_t lastRun;
  };
  std::vector<Entry> entries_;
};

VkImageMemoryBarrier2 translate(const Barrier& barrier, const vk::Image& image) {
  VkImageMemoryBarrier2 result{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  result.srcStageMask = barrier.sourceStage;
  result.srcAccessMask = barrier.sourceAccess;
  result.dstStageMask = barrier.targetStage;
  result.dstAccessMask = barrier.targetAccess;
  result.oldLayout = barrier.oldLayout;
  result.newLayout = barrier.newLayout;
  result.srcQueueFamilyIndex = result.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  result.image = image.get();
  result.subresourceRange = {image.aspect(), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  return result;
}

VkBufferMemoryBarrier2 translate(const Barrier& barrier, const vk::Buffer& buffer) {
  VkBufferMemoryBarrier2 result{VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2};
  result.srcStageMask = barrier.sourceStage;
  result.srcAccessMask = barrier.sourceAccess;
  result.dstStageMask = barrier.targetStage;
  result.dstAccessMask = barrier.targetAccess;
  result.srcQueueFamilyIndex = result.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  result.buffer = buffer.get();
  result.size = VK_WHOLE_SIZE;
  return result;
}

// `images` and `buffers`: of the graph, by index.
void record(VkCommandBuffer commands, const std::vector<Barrier>& barriers, const std::vector<const vk::Image*>& images,
            const std::vector<const vk::Buffer*>& buffers) {
  if (barriers.empty()) return;
  std::vector<VkImageMemoryBarrier2> ofImages;
  std::vector<VkBufferMemoryBarrier2> ofBuffers;
  for (const Barrier& barrier : barriers) {
    if (barrier.image) {
      ofImages.push_back(translate(barrier, *images.at(barrier.image.index)));
    } else {
      ofBuffers.push_back(translate(barrier, *buffers.at(barrier.buffer.index)));
    }
  }
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.imageMemoryBarrierCount = static_cast<uint32_t>(ofImages.size());
  info.pImageMemoryBarriers = ofImages.data();
  info.bufferMemoryBarrierCount = static_cast<uint32_t>(ofBuffers.size());
  info.pBufferMemoryBarriers = ofBuffers.data();
  vkCmdPipelineBarrier2(commands, &info);
}

// Null where VK_EXT_debug_utils is not enabled.
struct LabelCalls {
  explicit LabelCalls(VkInstance instance)
      : begin(reinterpret_cast<PFN_vkCmdBeginDebugUtilsLabelEXT>(
            vkGetInstanceProcAddr(instance, "vkCmdBeginDebugUtilsLabelEXT"))),
        end(reinterpret_cast<PFN_vkCmdEndDebugUtilsLabelEXT>(
            vkGetInstanceProcAddr(instance, "vkCmdEndDebugUtilsLabelEXT"))) {}
  PFN_vkCmdBeginDebugUtilsLabelEXT begin;
  PFN_vkCmdEndDebugUtilsLabelEXT end;
};

// A debug label around a pass.
class Label {
 public:
  Label(const LabelCalls& calls, VkCommandBuffer commands, const std::string& name)
      : calls_(calls), commands_(commands) {
    if (!calls_.begin) return;
    VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
    label.pLabelName = name.c_str();
    calls_.begin(commands, &label);
  }
  ~Label() {
    if (calls_.end) calls_.end(commands_);
  }
  Label(const Label&) = delete;
  Label& operator=(const Label&) = delete;

 private:
  const LabelCalls& calls_;
  VkCommandBuffer commands_;
};

// Two timestamps a pass. Without any where the queue has none.
class Timers {
 public:
  explicit Timers(vk::Device& device) : device_(device) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device.physical(), &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device.physical(), &count, families.data());
    const uint32_t bits = families.at(device.queueFamily()).timestampValidBits;
    mask_ = bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
  }

  // Outside render passes; before any mark().
  void begin(VkCommandBuffer commands, uint32_t passes) {
    marks_ = mask_ ? 2 * passes : 0;
    if (marks_ == 0) return;
    if (marks_ > capacity_) {
      VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
      info.queryType = VK_QUERY_TYPE_TIMESTAMP;
      info.queryCount = capacity_ = std::max(marks_, 64u);
      VkQueryPool pool = VK_NULL_HANDLE;
      VK_CHECK(vkCreateQueryPool(device_.get(), &info, nullptr, &pool));
      pool_ = vk::Handle<VkQueryPool>(device_, pool);
    }
    vkCmdResetQueryPool(commands, pool_.get(), 0, marks_);
  }

  // The time when all work recorded so far is done.
  void mark(VkCommandBuffer commands, uint32_t index) {
    if (marks_ == 0) return;
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_.get(), index);
    if (!device_.isCpu()) return;
    // lavapipe takes the time when its rasterizer is flushed next, which copies and dispatches don't wait for: their
    // own time would fall before the mark. A barrier flushes.
    const VkDependencyInfo nothing{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    vkCmdPipelineBarrier2(commands, &nothing);
  }

  // Milliseconds between the marks 2i and 2i + 1, of a submission that has finished.
  std::vector<double> read() const {
    std::vector<double> result(marks_ / 2);
    std::vector<uint64_t> ticks(marks_);
    if (marks_ == 0) return result;
    VK_CHECK(vkGetQueryPoolResults(device_.get(), pool_.get(), 0, marks_, ticks.size() * sizeof(uint64_t), ticks.data(),
                                   sizeof(uint64_t), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
    const double period = device_.properties().limits.timestampPeriod;  // nanoseconds a tick
    for (size_t i = 0; i < result.size(); ++i) {
      result[i] = static_cast<double>((ticks[2 * i + 1] - ticks[2 * i]) & mask_) * period * 1e-6;
    }
    return result;
  }

 private:
  vk::Device& device_;
  uint64_t mask_ = 0;  // of the bits that count; 0: no timestamps
  vk::Handle<VkQueryPool> pool_;
  uint32_t capacity_ = 0, marks_ = 0;
};

}  // namespace

const vk::Image& Context::image(ImageId id) const {
  if (std::none_of(pass_->accesses.begin(), pass_->accesses.end(),
                   [&](const Access& access) { return access.image == id; }))
    fail(ExitCode::Internal, "frame graph: pass '{}' asks for image {}, which it does not declare", pass_->name,
         id.index);
  return *images_->at(id.index);
}

const vk::Buffer& Context::buffer(BufferId id) const {
  if (!declares(id))
    fail(ExitCode::Internal, "frame graph: pass '{}' asks for buffer {}, which it does not declare", pass_->name,
         id.index);
  return *buffers_->at(id.index);
}

bool Context::declares(BufferId id) const {
  return std::any_of(pass_->accesses.begin(), pass_->accesses.end(),
                     [&](const Access& access) { return access.buffer == id; });
}

struct Executor::Pool {
  explicit Pool(vk::Device& device) : labels(device.instance()), timers(device) {}
  Shelf<vk::Image, vk::ImageDesc> images;
  Shelf<vk::Buffer, vk::BufferDesc> buffers;
  LabelCalls labels;
  Timers timers;
  uint64_t run = 0;
};

Executor::Executor(vk::Device& device) : device_(device), pool_(std::make_unique<Pool>(device)), descriptors_(device) {}

Executor::~Executor() = default;

// Every imported resource, and a transient one for each that a pass of the plan uses.
void Executor::materialize(const Graph& graph, const Plan& plan) {
  const uint64_t run = ++pool_->run;
  images_.assign(graph.images_.size(), nullptr);
  buffers_.assign(graph.buffers_.size(), nullptr);
  for (size_t i = 0; i < images_.size(); ++i) images_[i] = graph.images_[i].imported;
  for (size_t i = 0; i < buffers_.size(); ++i) buffers_[i] = graph.buffers_[i].imported;
  for (const Plan::Step& step : plan.steps) {
    for (const Access& access : graph.passes_[step.pass].accesses) {
      if (access.image) {
        const vk::Image*& image = images_[access.image.index];
        if (!image) image = pool_->images.take(device_, graph.desc(access.image), run);
      } else {
        const vk::Buffer*& buffer = buffers_[access.buffer.index];
        if (!buffer) buffer = pool_->buffers.take(device_, graph.desc(access.buffer), run);
      }
    }
  }
  pool_->images.tidy(run);
  pool_->buffers.tidy(run);
}

void Executor::run(const Graph& graph, const Plan& plan) {
  times_.clear();
  materialize(graph, plan);
  descriptors_.reset();
  Timers& timers = pool_->timers;
  device_.submitAndWait([&](VkCommandBuffer buffer) {
    vk::Commands commands(device_, buffer, descriptors_);
    Context context;
    context.commands_ = &commands;
    context.images_ = &images_;
    context.buffers_ = &buffers_;
    timers.begin(buffer, static_cast<uint32_t>(plan.steps.size()));
    uint32_t mark = 0;
    for (const Plan::Step& step : plan.steps) {
      const Pass& pass = graph.passes_[step.pass];
      const Label label(pool_->labels, buffer, pass.name);
      timers.mark(buffer, mark++);
      record(buffer, step.before, images_, buffers_);
      context.pass_ = &pass;
      if (pass.record) pass.record(context);
      timers.mark(buffer, mark++);
    }
    record(buffer, plan.after, images_, buffers_);
  });
  const std::vector<double> milliseconds = timers.read();
  for (size_t i = 0; i < milliseconds.size(); ++i) {
    const uint32_t pass = plan.steps[i].pass;
    times_.push_back({graph.passStage(pass), graph.passName(pass), milliseconds[i]});
  }
}

const vk::Image& Executor::image(ImageId id) const {
  const vk::Image* image = images_.at(id.index);
  if (!image) fail(ExitCode::Internal, "frame graph: image {} was not part of the last run", id.index);
  return *image;
}

const vk::Buffer& Executor::buffer(BufferId id) const {
  const vk::Buffer* buffer = buffers_.at(id.index);
  if (!buffer) fail(ExitCode::Internal, "frame graph: buffer {} was not part of the last run", id.index);
  return *buffer;
}

}  // namespace latelight::graph
