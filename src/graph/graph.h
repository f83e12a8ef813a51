// The frame graph: passes declare what they read and write; from that follow which passes run, the barriers between
// them, the memory of transients, GPU timers and debug labels. Passes run in the order they were added, after the
// prologue.
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

// How a pass uses a resource as a whole: every layer, level and byte. One table in use.cpp gives each use its stages,
// access and image layout (and vk::Image usage: callers that create() an image leave `usage` 0). A pass that writes
// only some layers or parts, with others' results in the rest, must declare that it keeps them: ...Load,
// StorageReadWrite.
enum class Use : uint8_t {
  ColorAttachment,      // cleared or overwritten: earlier contents are not needed
  ColorAttachmentLoad,  // read and written: blending, drawing over
  DepthAttachment,      // cleared or overwritten
  DepthAttachmentLoad,  // tested and written, keeping earlier contents
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
bool reads(Use use);  // needs earlier contents, or keeps part of them

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

// The purpose of a pass: reports and studies sum times by stage, whatever passes are called.
enum class Stage : uint8_t {
  Upload,       // scene data to the device
  Deformation,  // skins and morph targets
  Visibility,   // the surface that each sample shows
  Shadows,      // shadow maps and images made from them
  Geometry,     // materials into the G-buffer
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
  uint64_t trafficBytes = 0;  // as PassTime has them
};

// The context of a running pass.
class Context {
 public:
  vk::Commands& commands() { return *commands_; }
  VkCommandBuffer get() const { return commands_->get(); }
  // Only for resources that the pass declared; others may not exist in every graph: Error(Internal).
  const vk::Image& image(ImageId id) const;
  const vk::Buffer& buffer(BufferId id) const;
  bool declares(BufferId id) const;

 private:
  friend class Executor;
  vk::Commands* commands_ = nullptr;
  const Pass* pass_ = nullptr;  // that runs
  const std::vector<const vk::Image*>* images_ = nullptr;
  const std::vector<const vk::Buffer*>* buffers_ = nullptr;
};

struct Barrier {
  ImageId image;  // at most one of image and buffer is set; with neither it covers all memory
  BufferId buffer;
  VkPipelineStageFlags2 sourceStage = 0, targetStage = 0;
  VkAccessFlags2 sourceAccess = 0, targetAccess = 0;
  VkImageLayout oldLayout = VK_IMAGE_LAYOUT_UNDEFINED, newLayout = VK_IMAGE_LAYOUT_UNDEFINED;  // images only
};

// The result of compile(): the barriers before each pass that runs; the barriers after the last pass, which bring
// imported and exported resources to their final use; and the memory that each transient needs, and when.
struct Plan {
  struct Step {
    uint32_t pass;  // index in the order added
    std::vector<Barrier> before;
  };
  struct Transient {
    ImageId image;  // exactly one of image and buffer is set
    BufferId buffer;
  };
  // The life of a transient that may share its memory with others before and after it.
  struct Lifetime : Transient {
    uint32_t first = 0, last = 0;           // steps that use it, both included
    VkPipelineStageFlags2 firstStages = 0;  // of its first use
    VkAccessFlags2 firstAccess = 0;
    VkPipelineStageFlags2 lastStages = 0;  // its successor waits for these
    VkAccessFlags2 lastWrites = 0;         // of these stages: not yet available
  };
  std::vector<Step> steps;
  std::vector<Barrier> after;
  std::vector<Lifetime> lives;  // transients in device memory that are not exported, by first step
  std::vector<Transient> kept;  // the others: exported or host-visible
};

class Graph {
 public:
  Graph() = default;                   // plain data
  explicit Graph(Executor& executor);  // with room for constants()

  // Copies data known on the host, such as a frame's constants or views, to memory that shaders read. It stays valid
  // while the graph lives or a submission of it runs. Meant for little data: a GPU reads it over the bus.
  VkDeviceAddress constants(std::span<const std::byte> bytes);

  // Transient: contents are undefined at first. In device memory and not exported, it shares bytes with others used
  // before or after it.
  ImageId create(const vk::ImageDesc& desc);
  BufferId create(const vk::BufferDesc& desc);
  // Resources from outside. `before`: how they were used last, or nothing if their contents don't matter (images) or
  // came from the host (buffers). Those that are not exported go back to `before` after passes that changed them.
  ImageId import(const vk::Image& image, std::optional<Use> before);
  BufferId import(const vk::Buffer& buffer, std::optional<Use> before);

  // Several uses of one image in one pass must share a layout, else Error(Internal). `trafficBytes`: for PassTime.
  void pass(Stage stage, std::string_view name, std::vector<Access> accesses, Record record, uint64_t trafficBytes = 0);

  // A pass that writes, by copies or in compute shaders, buffers outside the graph that others read by address:
  // uploads, deformation. It always runs, before all passes outside the prologue, in the order added; its writes are
  // visible to every later pass, including those of the prologue.
  void prologue(Stage stage, std::string_view name, Record record);

  // The resource is needed after the frame, for `use`.
  void exports(ImageId image, Use use);
  void exports(BufferId buffer, Use use);

  // Throws Error(Internal) where a pass or an export reads what nothing wrote.
  Plan compile() const;

  // Graphviz: passes as boxes (culled ones dashed), resources as ellipses with format and size.
  std::string graphviz() const;

  size_t passCount() const { return passes_.size(); }
  const std::string& passName(uint32_t pass) const { return passes_[pass].name; }
  Stage passStage(uint32_t pass) const { return passes_[pass].stage; }
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
  void require(const Access& access);  // checks that the use fits, and adds the usage flags it needs
  std::vector<bool> alive() const;     // one per pass
  std::vector<Pass> passes_;
  std::vector<ImageNode> images_;
  std::vector<BufferNode> buffers_;
  std::shared_ptr<ConstantPool> constantPool_;  // none without an executor
  std::vector<std::shared_ptr<ConstantChunk>> constants_;
};

struct PassTime {
  Stage stage;
  std::string name;
  double milliseconds;
  uint64_t trafficBytes;  // of what it reads and writes as a whole; 0: it says of nothing that it does
};

// A graph in flight, then its results. It owns the exported transient resources: once it is dropped and has finished,
// others may use them. It may outlive its executor but not the device, and may be held by another thread.
class Submission {
 public:
  Submission();  // empty: done
  Submission(Submission&&) noexcept;
  Submission& operator=(Submission&&) noexcept;
  ~Submission();
  bool done() const;
  void wait() const;
  // GPU milliseconds per pass, in order; waits. Empty where the device has no timestamps.
  const std::vector<PassTime>& times() const;
  // A transient resource that was exported, or an imported one: Error(Internal) for all others. To be read by the host
  // after wait().
  const vk::Image& image(ImageId id) const;
  const vk::Buffer& buffer(BufferId id) const;

 private:
  friend class Executor;
  struct State;
  explicit Submission(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

// Bytes of device memory that a plan's transients take: known before anything runs.
struct TransientBytes {
  uint64_t peak = 0;             // as placed: those whose lives do not overlap share memory
  uint64_t withoutAliasing = 0;  // if each had its own
};
TransientBytes transientBytes(vk::Device& device, const Graph& graph, const Plan& plan);

// Runs graphs on a device; keeps transient images and buffers from one submission to the next.
class Executor {
 public:
  static constexpr size_t kInFlight = 3;  // concurrent submissions; one more waits for the oldest

  explicit Executor(vk::Device& device);
  ~Executor();
  // Records the plan with a debug label and two timestamps per pass, and submits it without waiting. It begins with a
  // barrier over all memory, so that submissions may use the same transients one after the other. Exceptions from
  // passes are rethrown, and nothing is submitted. Where the device has no room, resources kept from other graphs are
  // freed first.
  Submission submit(const Graph& graph, const Plan& plan);

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
