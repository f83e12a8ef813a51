// Runs a compiled frame graph: creates or reuses its resources, records its passes with barriers, debug labels and
// timestamps, and submits them.
#include <algorithm>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include "base/error.h"
#include "base/keep.h"
#include "graph/constants.h"
#include "graph/graph.h"
#include "graph/timers.h"
#include "graph/transients.h"

namespace latelight::graph {
namespace {

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

VkMemoryBarrier2 translate(const Barrier& barrier) {
  VkMemoryBarrier2 result{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  result.srcStageMask = barrier.sourceStage;
  result.srcAccessMask = barrier.sourceAccess;
  result.dstStageMask = barrier.targetStage;
  result.dstAccessMask = barrier.targetAccess;
  return result;
}

// True for the barrier of an image whose contents are discarded but that must wait for earlier uses, usually uses of
// other resources in the same memory (aliasing).
bool beginsInUsedMemory(const Barrier& barrier) {
  return barrier.image && barrier.oldLayout == VK_IMAGE_LAYOUT_UNDEFINED && barrier.sourceStage != 0;
}

// Records a full barrier where aliased memory changes its owner. Once images and buffers of several sizes have shared
// the memory, synchronization validation recognizes no narrower barrier.
void recordFullBarrier(VkCommandBuffer commands) {
  vk::recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                          VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
}

// Shaders of CPU devices also read buffers as texels, all of which are one buffer to synchronization validation
// (vk/texel_window.h). So this barrier for any of them accompanies those of single resources.
constexpr Barrier kBeforeTexelLoads{
    .sourceStage = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    .targetStage = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    .sourceAccess = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
    .targetAccess = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT};

// `images` and `buffers` are indexed by the graph's ids. `texels`: shaders may load buffers as texels.
void recordBarriers(VkCommandBuffer commands, const std::vector<Barrier>& barriers,
                    const std::vector<const vk::Image*>& images, const std::vector<const vk::Buffer*>& buffers,
                    bool texels) {
  if (barriers.empty()) return;
  if (std::any_of(barriers.begin(), barriers.end(), beginsInUsedMemory)) recordFullBarrier(commands);
  std::vector<VkImageMemoryBarrier2> ofImages;
  std::vector<VkBufferMemoryBarrier2> ofBuffers;
  std::vector<VkMemoryBarrier2> ofMemory;
  if (texels) ofMemory.push_back(translate(kBeforeTexelLoads));
  for (const Barrier& barrier : barriers) {
    if (barrier.image) {
      ofImages.push_back(translate(barrier, *images.at(barrier.image.index)));
    } else if (barrier.buffer) {
      ofBuffers.push_back(translate(barrier, *buffers.at(barrier.buffer.index)));
    } else {
      ofMemory.push_back(translate(barrier));
    }
  }
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = static_cast<uint32_t>(ofMemory.size());
  info.pMemoryBarriers = ofMemory.data();
  info.imageMemoryBarrierCount = static_cast<uint32_t>(ofImages.size());
  info.pImageMemoryBarriers = ofImages.data();
  info.bufferMemoryBarrierCount = static_cast<uint32_t>(ofBuffers.size());
  info.pBufferMemoryBarriers = ofBuffers.data();
  vkCmdPipelineBarrier2(commands, &info);
}

// Both are null if VK_EXT_debug_utils is not enabled.
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

}  // namespace

const vk::Image& Context::image(ImageId id) const {
  if (std::none_of(pass_->accesses.begin(), pass_->accesses.end(),
                   [&](const Access& access) { return access.image == id; }))
    fail(ExitCode::Internal, "frame graph: pass '{}' requests image {}, which it does not declare", pass_->name,
         id.index);
  return *images_->at(id.index);
}

const vk::Buffer& Context::buffer(BufferId id) const {
  if (!declares(id))
    fail(ExitCode::Internal, "frame graph: pass '{}' requests buffer {}, which it does not declare", pass_->name,
         id.index);
  return *buffers_->at(id.index);
}

bool Context::declares(BufferId id) const {
  return std::any_of(pass_->accesses.begin(), pass_->accesses.end(),
                     [&](const Access& access) { return access.buffer == id; });
}

namespace {

// The recording objects of a submission, reused once it has finished.
struct CommandRecorder {
  explicit CommandRecorder(vk::Device& device) : descriptors(device), timers(device) {}
  vk::DescriptorPool descriptors;
  Timers timers;
};

// The pools from which submissions borrow recorders, transients and constants. It lives as long as any submission.
struct SubmissionPool {
  explicit SubmissionPool(vk::Device& device)
      : device(device), transients(device), constants(std::make_shared<ConstantPool>(device)) {}
  std::unique_ptr<CommandRecorder> takeRecorder();
  void recycle(std::unique_ptr<CommandRecorder> recorder);

  vk::Device& device;
  TransientPool transients;
  std::shared_ptr<ConstantPool> constants;
  std::mutex mutex;  // guards the following
  std::vector<std::unique_ptr<CommandRecorder>> recorders;
};

std::unique_ptr<CommandRecorder> SubmissionPool::takeRecorder() {
  std::lock_guard lock(mutex);
  if (recorders.empty()) return std::make_unique<CommandRecorder>(device);
  std::unique_ptr<CommandRecorder> recorder = std::move(recorders.back());
  recorders.pop_back();
  recorder->descriptors.reset();
  return recorder;
}

void SubmissionPool::recycle(std::unique_ptr<CommandRecorder> recorder) {
  std::lock_guard lock(mutex);
  keepForReuse(recorders, std::move(recorder));
}

}  // namespace

namespace {

// A secondary command buffer, which a primary one may execute in many submissions.
class SecondaryCommands {
 public:
  explicit SecondaryCommands(vk::Device& device) : device_(device), pool_(makePool(device)) {}
  SecondaryCommands(const SecondaryCommands&) = delete;
  SecondaryCommands& operator=(const SecondaryCommands&) = delete;

  template <typename Record>
  void record(Record&& record) {
    VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    info.commandPool = pool_.get();
    info.level = VK_COMMAND_BUFFER_LEVEL_SECONDARY;
    info.commandBufferCount = 1;
    VK_CHECK(vkAllocateCommandBuffers(device_.get(), &info, &commands_));
    const VkCommandBufferInheritanceInfo inherited{VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.pInheritanceInfo = &inherited;
    VK_CHECK(vkBeginCommandBuffer(commands_, &begin));
    record(commands_);
    VK_CHECK(vkEndCommandBuffer(commands_));
  }
  void execute(VkCommandBuffer primary) const { vkCmdExecuteCommands(primary, 1, &commands_); }

 private:
  static vk::Handle<VkCommandPool> makePool(vk::Device& device) {
    VkCommandPoolCreateInfo info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    info.queueFamilyIndex = device.queueFamily();
    VkCommandPool pool = VK_NULL_HANDLE;
    VK_CHECK(vkCreateCommandPool(device.get(), &info, nullptr, &pool));
    return {device, pool};
  }
  vk::Device& device_;
  vk::Handle<VkCommandPool> pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

}  // namespace

// Constants that return to their pool once no submission reads them.
struct ConstantsInUse final : vk::Deletion {
  std::vector<std::shared_ptr<ConstantChunk>> chunks;
};

class RecordedGraph {
 public:
  explicit RecordedGraph(std::shared_ptr<SubmissionPool> pool)
      : pool(std::move(pool)), recorder(this->pool->takeRecorder()) {}
  ~RecordedGraph();
  RecordedGraph(const RecordedGraph&) = delete;
  RecordedGraph& operator=(const RecordedGraph&) = delete;

  std::shared_ptr<SubmissionPool> pool;
  std::unique_ptr<CommandRecorder> recorder;
  // Indexed by the graph's ids. After recording, only results remain: imported or exported resources.
  std::vector<const vk::Image*> images;
  std::vector<const vk::Buffer*> buffers;
  std::vector<std::unique_ptr<PooledImage>> pooledImages;
  std::vector<std::unique_ptr<PooledBuffer>> pooledBuffers;
  std::unique_ptr<ConstantsInUse> constants = std::make_unique<ConstantsInUse>();
  std::vector<PassTime> passes;  // without times
  // Only for repeated submission: the commands, and the transients that they use.
  std::unique_ptr<SecondaryCommands> commands;
  std::shared_ptr<TransientPlacement> placement;
};

// Runs when the results are no longer needed and all submissions have finished; until then the executor keeps a
// reference. Without an executor, nothing returned here is reused, but graphs may still request constants.
RecordedGraph::~RecordedGraph() {
  if (recorder) pool->recycle(std::move(recorder));
  for (auto& image : pooledImages) pool->transients.recycle(std::move(image));
  for (auto& buffer : pooledBuffers) pool->transients.recycle(std::move(buffer));
  if (!constants->chunks.empty()) pool->device.deferDeletion(std::move(constants));
}

struct Submission::State {
  explicit State(std::shared_ptr<RecordedGraph> recorded) : recorded(std::move(recorded)) {}
  void finish();
  vk::Device& device() const { return recorded->pool->device; }

  std::shared_ptr<RecordedGraph> recorded;
  uint64_t value = 0;  // on the device's timeline
  std::mutex mutex;    // guards the rest, until it has finished
  bool finished = false;
  std::vector<PassTime> times;
};

// Waits until the submission has finished, and reads the times from the queries before another submission overwrites
// them.
void Submission::State::finish() {
  device().wait(value);
  std::lock_guard lock(mutex);
  if (std::exchange(finished, true)) return;
  const std::vector<double> milliseconds = recorded->recorder->timers.read();
  times = recorded->passes;
  times.resize(milliseconds.size());  // empty without timestamps
  for (size_t i = 0; i < milliseconds.size(); ++i) times[i].milliseconds = milliseconds[i];
  if (recorded->commands) return;
  recorded->pool->recycle(std::move(recorded->recorder));
  recorded->constants->chunks.clear();
}

Submission::Submission() = default;
Submission::Submission(std::shared_ptr<State> state) : state_(std::move(state)) {}
Submission::Submission(Submission&&) noexcept = default;
Submission& Submission::operator=(Submission&&) noexcept = default;
Submission::~Submission() = default;

bool Submission::done() const {
  return !state_ || state_->device().finished(state_->value);
}

void Submission::wait() const {
  if (state_) state_->finish();
}

const std::vector<PassTime>& Submission::times() const {
  static const std::vector<PassTime> none;
  if (!state_) return none;
  state_->finish();
  return state_->times;
}

const vk::Image& Submission::image(ImageId id) const {
  const vk::Image* image = state_ ? state_->recorded->images.at(id.index) : nullptr;
  if (!image) fail(ExitCode::Internal, "frame graph: image {} is not a result of the submission", id.index);
  return *image;
}

const vk::Buffer& Submission::buffer(BufferId id) const {
  const vk::Buffer* buffer = state_ ? state_->recorded->buffers.at(id.index) : nullptr;
  if (!buffer) fail(ExitCode::Internal, "frame graph: buffer {} is not a result of the submission", id.index);
  return *buffer;
}

struct Executor::Impl {
  explicit Impl(vk::Device& device) : labels(device.instance()), pool(std::make_shared<SubmissionPool>(device)) {}
  void finishOldest();
  void finishDone();
  void begin(size_t most = kInFlight);
  std::shared_ptr<RecordedGraph> prepare(const Graph& graph, Plan& plan);
  void materialize(const Graph& graph, Plan& plan, RecordedGraph& recorded);
  void record(const Graph& graph, const Plan& plan, RecordedGraph& recorded, VkCommandBuffer buffer);
  static void storeResults(const Graph& graph, RecordedGraph& recorded);
  Submission submit(std::shared_ptr<RecordedGraph> recorded, const std::function<void(VkCommandBuffer)>& commands);

  LabelCalls labels;
  std::shared_ptr<SubmissionPool> pool;
  std::deque<std::shared_ptr<Submission::State>> inFlight;  // oldest first
};

Executor::Executor(vk::Device& device) : impl_(std::make_unique<Impl>(device)) {}

Executor::~Executor() = default;

Graph::Graph(Executor& executor) : constantPool_(executor.impl_->pool->constants) {}

void Executor::Impl::finishOldest() {
  inFlight.front()->finish();
  inFlight.pop_front();
}

void Executor::Impl::finishDone() {
  while (!inFlight.empty() && pool->device.finished(inFlight.front()->value)) finishOldest();
}

// Prepares for another submission, before which at most `most` - 1 may be in flight.
void Executor::Impl::begin(size_t most) {
  while (inFlight.size() >= most) finishOldest();
  finishDone();
  pool->transients.tick();
  pool->constants->tick();
}

// Creates or reuses everything that the plan needs. If an allocation fails while other graphs' resources are kept, it
// is retried without them.
std::shared_ptr<RecordedGraph> Executor::Impl::prepare(const Graph& graph, Plan& plan) {
  const auto tryTo = [&] {
    auto recorded = std::make_shared<RecordedGraph>(pool);
    recorded->constants->chunks = graph.constants_;
    materialize(graph, plan, *recorded);
    return recorded;
  };
  try {
    return tryTo();
  } catch (const Error& error) {
    if (error.code() != ExitCode::OutOfMemory) throw;
  }
  while (!inFlight.empty()) finishOldest();
  pool->transients.clear();
  return tryTo();
}

// Collects the imported resources, creates one resource for each transient of the plan, and adds the aliasing barriers.
void Executor::Impl::materialize(const Graph& graph, Plan& plan, RecordedGraph& recorded) {
  for (const Graph::ImageNode& node : graph.images_) recorded.images.push_back(node.imported);
  for (const Graph::BufferNode& node : graph.buffers_) recorded.buffers.push_back(node.imported);
  for (const Plan::Transient& kept : plan.kept) {
    if (kept.image) {
      recorded.pooledImages.push_back(pool->transients.take(graph.desc(kept.image)));
      recorded.images[kept.image.index] = &recorded.pooledImages.back()->resource;
    } else {
      recorded.pooledBuffers.push_back(pool->transients.take(graph.desc(kept.buffer)));
      recorded.buffers[kept.buffer.index] = &recorded.pooledBuffers.back()->resource;
    }
  }
  recorded.placement = pool->transients.place(graph, plan);
  const TransientPlacement& placed = *recorded.placement;
  for (size_t i = 0; i < plan.lives.size(); ++i) {
    if (plan.lives[i].image) {
      recorded.images[plan.lives[i].image.index] = &std::get<vk::Image>(placed.resources[i]);
    } else {
      recorded.buffers[plan.lives[i].buffer.index] = &std::get<vk::Buffer>(placed.resources[i]);
    }
  }
  addAliasingBarriers(plan, placed.footprints, placed.packing);
}

void Executor::Impl::record(const Graph& graph, const Plan& plan, RecordedGraph& recorded, VkCommandBuffer buffer) {
  vk::Commands commands(buffer, recorded.recorder->descriptors);
  Context context;
  context.commands_ = &commands;
  context.images_ = &recorded.images;
  context.buffers_ = &recorded.buffers;
  Timers& timers = recorded.recorder->timers;
  const bool texels = pool->device.memory().window() != nullptr;
  recordFullBarrier(buffer);  // earlier submissions on the queue use the same memory for their transients
  timers.begin(buffer, static_cast<uint32_t>(plan.steps.size()));
  uint32_t mark = 0;
  for (const Plan::Step& step : plan.steps) {
    const Pass& pass = graph.passes_[step.pass];
    recorded.passes.push_back({pass.stage, pass.name, 0, pass.trafficBytes});
    const Label label(labels, buffer, pass.name);
    timers.mark(buffer, mark++);
    recordBarriers(buffer, step.before, recorded.images, recorded.buffers, texels);
    context.pass_ = &pass;
    if (pass.record) pass.record(context);
    timers.mark(buffer, mark++);
  }
  recordBarriers(buffer, plan.after, recorded.images, recorded.buffers, texels);
  timers.end(buffer);
}

// Drops the references to other transients, because another submission may use them by the time results are read.
void Executor::Impl::storeResults(const Graph& graph, RecordedGraph& recorded) {
  for (size_t i = 0; i < recorded.images.size(); ++i)
    if (!graph.images_[i].imported && !graph.images_[i].exported) recorded.images[i] = nullptr;
  for (size_t i = 0; i < recorded.buffers.size(); ++i)
    if (!graph.buffers_[i].imported && !graph.buffers_[i].exported) recorded.buffers[i] = nullptr;
}

Submission Executor::Impl::submit(std::shared_ptr<RecordedGraph> recorded,
                                  const std::function<void(VkCommandBuffer)>& commands) {
  const auto state = std::make_shared<Submission::State>(std::move(recorded));
  inFlight.push_back(state);  // first: if it fails, the device must not run commands that nothing refers to
  try {
    state->value = pool->device.submit(commands);
  } catch (...) {
    inFlight.pop_back();
    throw;
  }
  return Submission(state);
}

Submission Executor::submit(const Graph& graph, const Plan& plan) {
  Impl& impl = *impl_;
  impl.begin();
  Plan placed = plan;
  const std::shared_ptr<RecordedGraph> recorded = impl.prepare(graph, placed);
  Submission submission =
      impl.submit(recorded, [&](VkCommandBuffer buffer) { impl.record(graph, placed, *recorded, buffer); });
  recorded->placement = nullptr;  // the pool shares its memory with other graphs, and frees it when nothing uses it
  Impl::storeResults(graph, *recorded);
  return submission;
}

std::shared_ptr<RecordedGraph> Executor::record(const Graph& graph, const Plan& plan) {
  Impl& impl = *impl_;
  Plan placed = plan;
  std::shared_ptr<RecordedGraph> recorded = impl.prepare(graph, placed);
  recorded->commands = std::make_unique<SecondaryCommands>(impl.pool->device);
  recorded->commands->record([&](VkCommandBuffer buffer) { impl.record(graph, placed, *recorded, buffer); });
  Impl::storeResults(graph, *recorded);
  return recorded;
}

Submission Executor::submit(const std::shared_ptr<RecordedGraph>& recorded) {
  impl_->begin(kRecordedInFlight);
  impl_->pool->transients.use(*recorded->placement);
  return impl_->submit(recorded, [&](VkCommandBuffer buffer) { recorded->commands->execute(buffer); });
}

bool Executor::isIdle(const std::shared_ptr<RecordedGraph>& recorded) {
  impl_->finishDone();
  return recorded.use_count() == 1;
}

const Submission& Executor::run(const Graph& graph, const Plan& plan) {
  last_ = Submission();
  last_ = submit(graph, plan);
  last_.wait();
  return last_;
}

}  // namespace latelight::graph
