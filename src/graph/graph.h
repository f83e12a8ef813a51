// The frame graph (O'Donnell 2017, "FrameGraph: Extensible Rendering Architecture in Frostbite", GDC). Passes declare
// the resources that they read and write. The graph derives from that which passes run (pass culling), the barriers
// between them, the aliased memory of transients, GPU timers and debug labels. Passes run in the order they were added,
// after the prologue.
//
//   Graph graph(executor);
//   ImageId color = graph.create(ImageDesc{...});
//   graph.pass(Stage::Lighting, "light", {{color, Use::StorageWrite}}, [=](Context& c) { ... c.image(color) ... });
//   graph.exports(color, Use::CopySource);  // what must survive: passes that lead to no export are culled
//
//   Plan plan = graph.compile();                     // plain data, no device: tests read it
//   Submission done = executor.submit(graph, plan);  // returns at once
//   done.wait();
//   done.image(color) ...
#pragma once

#include <volk.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::graph {

struct ImageId {
  uint32_t index = ~0u;
  explicit operator bool() const { return index != ~0u; }
  bool operator==(const ImageId&) const = default;
};
struct BufferId {
  uint32_t index = ~0u;
  explicit operator bool() const { return index != ~0u; }
  bool operator==(const BufferId&) const = default;
};

// How a pass uses a resource as a whole: every layer, level and byte. A table in use.cpp lists the stages, access,
// image layout and usage flags of each use, so callers of create() keep an image's `usage` 0. A pass that writes only
// some layers or parts, while the rest holds results of other passes, must declare a use that keeps contents: ...Load,
// StorageReadWrite.
enum class Use : uint8_t {
  ColorAttachment,      // cleared or overwritten: earlier contents are not needed
  ColorAttachmentLoad,  // read and written: blending, drawing over
  DepthAttachment,      // cleared or overwritten
  DepthAttachmentLoad,  // tested and written; earlier contents are kept
  DepthTest,            // tested, not written: store operation NONE
  SampledFragment,
  SampledCompute,
  StorageRead,        // compute
  StorageWrite,       // compute: overwritten completely
  StorageReadWrite,   // compute
  FragmentWrite,      // storage in fragment shaders: earlier contents are not needed
  FragmentReadWrite,  // atomics
  VertexRead,         // buffers read by address in vertex or fragment shaders
  IndirectRead,
  CopySource,
  CopyTarget,  // copies, fills, clears, possibly partial: earlier contents are kept
  HostRead,    // after the frame, by the host
};
bool writes(Use use);
bool reads(Use use);  // true if it needs earlier contents, or keeps part of them

struct Access {
  Access(ImageId image, Use use) : image(image), use(use) {}
  Access(BufferId buffer, Use use) : buffer(buffer), use(use) {}
  ImageId image;
  BufferId buffer;
  Use use;
};

class ConstantChunk;
class ConstantPool;
class Context;
class Executor;

using Record = std::function<void(Context&)>;

// The purpose of a pass: reports and studies sum times by stage, independent of the names of passes.
enum class Stage : uint8_t {
  Upload,       // scene data to the device
  Deformation,  // skins and morph targets
  Visibility,   // the visible surface of each sample
  Shadows,      // shadow maps, and images computed from them
  Geometry,     // evaluation of materials into the G-buffer
  Lighting,
  Transparency,  // alpha-blended surfaces
  Post,          // composition and post-processing
  Output,        // packing and read-back
};
const char* name(Stage stage);  // "visibility"

struct Pass {
  Stage stage;
  std::string name;
  std::vector<Access> accesses;
  Record record;
  bool prologue = false;
  uint64_t trafficBytes = 0;  // see PassTime
};

// The context of a running pass.
class Context {
 public:
  vk::Commands& commands() { return *commands_; }
  VkCommandBuffer get() const { return commands_->get(); }
  // Returns a resource that the pass declared. Throws Error(Internal) for others, because they may not exist in every
  // graph.
  const vk::Image& image(ImageId id) const;
  const vk::Buffer& buffer(BufferId id) const;
  bool declares(BufferId id) const;

 private:
  friend class Executor;
  vk::Commands* commands_ = nullptr;
  const Pass* pass_ = nullptr;  // the running pass
  const std::vector<const vk::Image*>* images_ = nullptr;
  const std::vector<const vk::Buffer*>* buffers_ = nullptr;
};

struct Barrier {
  ImageId image;  // at most one of image and buffer is set; if neither is set, the barrier covers all memory
  BufferId buffer;
  VkPipelineStageFlags2 sourceStage = 0, targetStage = 0;
  VkAccessFlags2 sourceAccess = 0, targetAccess = 0;
  VkImageLayout oldLayout = VK_IMAGE_LAYOUT_UNDEFINED, newLayout = VK_IMAGE_LAYOUT_UNDEFINED;  // images only
};

// The result of compile(): the barriers before each pass that runs, the barriers after the last pass, which transition
// imported and exported resources to their final use, and the lifetimes of the transients.
struct Plan {
  struct Step {
    uint32_t pass;  // index in the order added
    std::vector<Barrier> before;
  };
  struct Transient {
    ImageId image;  // exactly one of image and buffer is set
    BufferId buffer;
  };
  // The lifetime of a transient that may share its memory with others before and after it.
  struct Lifetime : Transient {
    uint32_t first = 0, last = 0;           // first and last step that use it, inclusive
    VkPipelineStageFlags2 firstStages = 0;  // of its first use
    VkAccessFlags2 firstAccess = 0;
    VkPipelineStageFlags2 lastStages = 0;  // the next user of the memory waits for these
    VkAccessFlags2 lastWrites = 0;         // writes of these stages that are not yet available
  };
  std::vector<Step> steps;
  std::vector<Barrier> after;
  std::vector<Lifetime> lives;  // transients in device memory that are not exported, by first step
  std::vector<Transient> kept;  // the others: exported or host-visible
};

class Graph {
 public:
  Graph() = default;                   // plain data, without a device
  explicit Graph(Executor& executor);  // supports constants()

  // Copies data known on the host, such as a frame's constants or views, to memory that shaders read. It stays valid
  // while the graph lives or a submission of it runs. Use it only for small data, because a GPU reads it over the bus.
  VkDeviceAddress constants(std::span<const std::byte> bytes);

  // Creates a transient, whose contents are undefined at first. If it is in device memory and not exported, it shares
  // memory with others that are used before or after it (aliasing).
  ImageId create(const vk::ImageDesc& desc);
  BufferId create(const vk::BufferDesc& desc);
  // Imports an external resource. `before` is its last use, or empty if its contents are not needed (images) or came
  // from the host (buffers). Resources that are not exported return to `before` if passes changed them.
  ImageId import(const vk::Image& image, std::optional<Use> before);
  BufferId import(const vk::Buffer& buffer, std::optional<Use> before);

  // Adds a pass. Throws Error(Internal) if it uses one image in several layouts. `trafficBytes` is for PassTime.
  void pass(Stage stage, std::string_view name, std::vector<Access> accesses, Record record, uint64_t trafficBytes = 0);

  // Adds a pass that writes, by copies or in compute shaders, external buffers that other passes read by address:
  // uploads and deformation. It is never culled. Passes of the prologue run before all others, in the order added.
  // Their writes are visible to every later pass, including those of the prologue.
  void prologue(Stage stage, std::string_view name, Record record);

  // Declares that the resource is needed after the frame, for `use`.
  void exports(ImageId image, Use use);
  void exports(BufferId buffer, Use use);

  // Throws Error(Internal) if a pass or an export reads a resource that nothing wrote.
  Plan compile() const;

  // Returns the graph in Graphviz's DOT language: passes as boxes (culled ones dashed), resources as ellipses with
  // format and size.
  std::string graphviz() const;

  size_t passCount() const { return passes_.size(); }
  const std::string& passName(uint32_t pass) const { return passes_[pass].name; }
  const vk::ImageDesc& desc(ImageId id) const;
  const vk::BufferDesc& desc(BufferId id) const;

 private:
  friend class Executor;
  struct ImageNode {
    vk::ImageDesc desc;
    const vk::Image* imported = nullptr;
    std::optional<Use> before, exported;
  };
  struct BufferNode {
    vk::BufferDesc desc;
    const vk::Buffer* imported = nullptr;
    std::optional<Use> before, exported;
  };
  void require(const Access& access);  // checks that the use is valid, and adds the usage flags that it requires
  std::vector<bool> alive() const;     // indexed by pass
  std::vector<Pass> passes_;
  std::vector<ImageNode> images_;
  std::vector<BufferNode> buffers_;
  std::shared_ptr<ConstantPool> constantPool_;  // null without an executor
  std::vector<std::shared_ptr<ConstantChunk>> constants_;
};

struct PassTime {
  Stage stage;
  std::string name;
  double milliseconds;
  uint64_t trafficBytes;  // bytes of the resources that it reads and writes in full; 0: unknown
};

// The recorded commands of a graph, everything that they use, and its results.
class RecordedGraph;

// A graph in flight, then its results. It owns the exported transient resources: once it is dropped and has finished,
// other submissions may use them. It may outlive its executor but not the device, and another thread may hold it.
class Submission {
 public:
  Submission();  // empty: done
  Submission(Submission&&) noexcept;
  Submission& operator=(Submission&&) noexcept;
  ~Submission();
  bool done() const;
  void wait() const;
  // Waits, and returns GPU milliseconds per pass, in order. Empty if the device has no timestamps.
  const std::vector<PassTime>& times() const;
  // Returns an exported transient or an imported resource. Throws Error(Internal) for all others. The host may read it
  // after wait().
  const vk::Image& image(ImageId id) const;
  const vk::Buffer& buffer(BufferId id) const;

 private:
  friend class Executor;
  struct State;
  explicit Submission(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

// Bytes of device memory that a plan's transients require; known before anything runs.
struct TransientBytes {
  uint64_t peak = 0;             // as placed: transients with disjoint lifetimes share memory
  uint64_t withoutAliasing = 0;  // if each had its own memory
};
TransientBytes transientBytes(vk::Device& device, const Graph& graph, const Plan& plan);

// Runs graphs on a device. It keeps transient images and buffers from one submission to the next.
class Executor {
 public:
  static constexpr size_t kInFlight = 3;           // maximum submissions in flight; a further one waits for the oldest
  static constexpr size_t kRecordedInFlight = 64;  // the same before a recorded graph, which needs no further memory

  explicit Executor(vk::Device& device);
  ~Executor();
  // Records the plan with a debug label and two timestamps per pass, and submits it without waiting. It begins with a
  // barrier over all memory, so that submissions may use the same transients one after the other. Exceptions from
  // passes are rethrown, and nothing is submitted. If the device is out of memory, resources kept from other graphs are
  // freed first.
  Submission submit(const Graph& graph, const Plan& plan);

  // Records the plan for any number of submissions. Whatever differs between these is data in imported buffers.
  std::shared_ptr<RecordedGraph> record(const Graph& graph, const Plan& plan);
  // Submits recorded commands without waiting. Requires isIdle(recorded), because the results of all its submissions
  // are in the same memory.
  Submission submit(const std::shared_ptr<RecordedGraph>& recorded);
  // Returns true if no submission of it is in flight, and nobody holds one. `recorded` must be its only other owner.
  bool isIdle(const std::shared_ptr<RecordedGraph>& recorded);

  // Submits and waits; the members below refer to the last run.
  const Submission& run(const Graph& graph, const Plan& plan);
  const std::vector<PassTime>& times() const { return last_.times(); }
  const vk::Image& image(ImageId id) const { return last_.image(id); }
  const vk::Buffer& buffer(BufferId id) const { return last_.buffer(id); }

 private:
  friend class Graph;
  struct Impl;
  std::unique_ptr<Impl> impl_;
  Submission last_;
};

}  // namespace latelight::graph
