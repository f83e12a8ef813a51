// Helpers for drawing with the graphics pipeline. Hardware visibility, the techniques that draw the scene with their
// own shaders, and full-screen passes share them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/frame/frame.h"
#include "render/visibility/draw_order.h"
#include "render/visibility/draw_push.h"
#include "vk/object_cache.h"

namespace latelight::render {

// Draw lists in device memory, one per view or one per shadow map.
class DeviceDraws {
 public:
  DeviceDraws(vk::Device& device, std::vector<DrawList> lists);
  const std::vector<Draw>& operator[](size_t list) const { return draws_[list]; }
  size_t lists() const { return draws_.size(); }
  bool empty() const;                                                                   // true if all lists are empty
  uint32_t instance(uint32_t place) const { return instances_.as<uint32_t>()[place]; }  // index in the scene
  VkBuffer instances() const { return instances_.get(); }  // uint[], the instance-rate vertex buffer of the draws

 private:
  std::vector<std::vector<Draw>> draws_;  // `first` is an offset into instances_, across all lists
  vk::Buffer instances_;
};

// The pipelines that draw a scene: `opaque` for opaque materials; `masked` for alpha-tested materials, which include
// blended ones that are drawn as opaque surfaces; `layered` for layered materials if they have their own pipeline.
struct ScenePipelines {
  vk::PipelineRef opaque, masked;
  std::optional<vk::PipelineRef> layered{};
  std::optional<vk::PipelineRef> vastOpaque{}, vastMasked{};  // for vast triangles; empty if the scene has none
};
// Returns the vertex buffers of a scene vertex shader. scene_depth.vert reads only positions; the others also read
// attributes.
std::vector<vk::VertexBuffer> sceneVertexBuffers(const std::string& vertexShader);
// Returns a description, with its vertex buffers, of a pipeline that draws the same for vast triangles (kVastFan).
vk::GraphicsDesc forVast(vk::GraphicsDesc desc);
// Completes `desc` with its vertex shader (default scene.vert) and buffers, the material sets and
// kAlphaMaskedConstant, which fragment shaders declare. The push constants are DrawPush unless desc.pushBytes is set.
ScenePipelines scenePipelines(const FrameContext& f, const vk::GraphicsDesc& desc);
ScenePipelines scenePipelines(const FrameContext& f, const vk::GraphicsDesc& opaque, const vk::GraphicsDesc& masked);

// The view that a SceneBinder draws.
struct DrawnView {
  VkDeviceAddress frame;      // shared::FrameConstants
  VkBuffer views;             // its View[]
  uint32_t view;              // index into views
  VkDeviceAddress instances;  // shared::Instance[] of the view's world
};
DrawnView drawnView(const FrameContext& f, uint32_t view);

// Binds the state of the draws of one view (pipeline, sets, material, culling, vertex buffers) and skips redundant
// changes.
class SceneBinder {
 public:
  // `images` are set 0 of all pipelines.
  SceneBinder(graph::Context& context, const GpuScene& scene, const DeviceDraws& draws, const DrawnView& view,
              const ScenePipelines& pipelines, std::span<const vk::BoundImage> images = {});
  const vk::Pipeline& bind(const Draw& draw);  // returns the pipeline that is now bound

 private:
  graph::Context& context_;
  const GpuScene& scene_;
  shared::DrawPush push_;
  const ScenePipelines& pipelines_;
  std::span<const vk::BoundImage> images_;
  const vk::Pipeline* bound_ = nullptr;
  uint32_t material_ = ~0u, mesh_ = ~0u;
};

// Records a draw with the bound state.
void recordDraw(graph::Context& context, const GpuScene& scene, const Draw& draw);

// Push constants that follow DrawPush: the total size for the pipeline's description, and the command that sets them.
template <typename More>
constexpr uint32_t pushBytesWith() {
  return sizeof(shared::DrawPush) + sizeof(More);
}
template <typename More>
void pushMore(graph::Context& context, const vk::Pipeline& pipeline, const More& more) {
  vkCmdPushConstants(context.get(), pipeline.layout.get(), VK_SHADER_STAGE_ALL, sizeof(shared::DrawPush), sizeof(More),
                     &more);
}

// Adds a full-screen triangle per view that writes the depth that the fragment shader computes from `from`.
graph::ImageId addScreenDepth(const FrameContext& f, graph::Stage stage, const char* name, const char* shader,
                              graph::ImageId from);
// Returns the frame's depth in a format for depth tests. Depth that compute shaders wrote is copied.
graph::ImageId attachableDepth(const FrameContext& f, graph::ImageId depth);

// Draws one full-screen triangle without face culling.
void recordScreen(graph::Context& context);

struct DepthUse {
  graph::ImageId image;
  bool clear;  // clears depth, and stencil if present; otherwise depth is only tested
};
enum class ColorUse { Clear, Keep };

// Renders to one array layer of these targets, with y up as in projection.h, from its construction to its destruction.
// Colors are cleared to 0, or kept; those that are not `written` (bit i: color i) become undefined.
//
// On CPU devices, many triangles are drawn by several renderings, so that the vertices of one are processed while the
// one before is rasterized. lavapipe does each of these on threads of its own, but it rasterizes a rendering only when
// one with other targets or another area begins, or at a barrier, where it waits for all. So there are no barriers
// between the renderings. lavapipe rasterizes them in their order.
class ViewRendering {
 public:
  ViewRendering(graph::Context& context, const FrameContext& f, uint32_t view, std::span<const graph::ImageId> colors,
                DepthUse depth, ColorUse use = ColorUse::Clear, uint32_t written = ~0u);
  ~ViewRendering();
  ViewRendering(const ViewRendering&) = delete;
  ViewRendering& operator=(const ViewRendering&) = delete;

  graph::Context& context() const { return context_; }
  // Records all draws of a list.
  void draw(const GpuScene& scene, SceneBinder& binder, const std::vector<Draw>& draws);

 private:
  void begin(VkExtent2D extent);
  void makeSpace(uint32_t triangles);
  void drawInParts(const GpuScene& scene, const vk::Pipeline& pipeline, const Draw& draw);
  graph::Context& context_;
  std::vector<VkRenderingAttachmentInfo> colors_;
  VkRenderingAttachmentInfo depth_;
  bool hasStencil_;
  VkExtent2D extent_;
  bool overlaps_;          // the driver is lavapipe
  uint32_t inPart_ = 0;    // triangles per rendering, if there are several
  uint64_t recorded_ = 0;  // triangles since the last rendering began
};

// Clears one array layer of these targets to 0.
void recordClear(graph::Context& context, const FrameContext& f, uint32_t view, std::span<const graph::ImageId> colors);

}  // namespace latelight::render
