// Drawing with the graphics pipeline: what hardware visibility, the techniques that draw the scene with shaders of
// their own, and passes over the whole picture have in common.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/frame/frame.h"
#include "render/visibility/draw_order.h"
#include "render/visibility/draw_push.h"
#include "vk/object_cache.h"

namespace latelight::render {

// Lists of draws in device memory: one a view, or one a shadow map.
class DeviceDraws {
 public:
  DeviceDraws(vk::Device& device, std::vector<DrawList> lists);
  const std::vector<Draw>& operator[](size_t list) const { return draws_[list]; }
  size_t lists() const { return draws_.size(); }
  bool empty() const;                                                                   // none has any
  uint32_t instance(uint32_t place) const { return instances_.as<uint32_t>()[place]; }  // as the scene numbers them
  VkBuffer instances() const { return instances_.get(); }  // uint[], which the draws find their instances by

 private:
  std::vector<std::vector<Draw>> draws_;  // `first` counts over all lists
  vk::Buffer instances_;
};

// The pipelines that draw a scene: for opaque materials, and for those that alpha cuts out of (masked ones, and blended
// ones where they are drawn as solid); `layered`: for those with layers, where they have one of their own.
struct ScenePipelines {
  vk::PipelineRef opaque, masked;
  std::optional<vk::PipelineRef> layered{};
  std::optional<vk::PipelineRef> vastOpaque{}, vastMasked{};  // for vast triangles, where the scene has some
};
// Vertex buffers of a shader of scene draws: of scene_depth.vert, or of those that read attributes too.
std::vector<vk::VertexBuffer> sceneVertexBuffers(const std::string& vertexShader);
// `desc` without its vertex shader and buffers, material sets and kAlphaMasked (kFirstOwnConstant), which this fills
// in; fragment shaders have the constant. It pushes DrawPush alone unless desc.pushBytes says more.
ScenePipelines scenePipelines(const FrameContext& f, const vk::GraphicsDesc& desc);
ScenePipelines scenePipelines(const FrameContext& f, const vk::GraphicsDesc& opaque, const vk::GraphicsDesc& masked);

// Makes state follow the draws of one view: pipeline, set 0, material, culling. What stays the same is not set again.
struct DrawnView {
  VkDeviceAddress frame;  // shared::FrameConstants
  VkBuffer views;         // its View[]
  uint32_t view;          // of them
};

class SceneBinder {
 public:
  // `images`: set 0 of both pipelines.
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

// Draws with what is bound: all of a draw's instances, or some.
void recordDraw(graph::Context& context, const GpuScene& scene, const Draw& draw);
void recordDraws(graph::Context& context, const GpuScene& scene, SceneBinder& binder, const std::vector<Draw>& draws);

// Push constants of a draw, DrawPush and what stands behind it: bytes for its pipeline's description, and setting them.
template <typename More>
constexpr uint32_t pushBytesWith() {
  return sizeof(shared::DrawPush) + sizeof(More);
}
template <typename More>
void pushMore(graph::Context& context, const vk::Pipeline& pipeline, const More& more) {
  vkCmdPushConstants(context.get(), pipeline.layout.get(), VK_SHADER_STAGE_ALL, sizeof(shared::DrawPush), sizeof(More),
                     &more);
}

// One triangle over each view that leaves depth as a fragment shader finds it in `from`.
graph::ImageId addScreenDepth(const FrameContext& f, graph::Stage stage, const char* name, const char* shader,
                              graph::ImageId from);
// A frame's depth as draws can be tested against it: a copy where compute shaders found it.
graph::ImageId attachableDepth(const FrameContext& f, graph::ImageId depth);

// One triangle over the picture, seen from both sides.
void recordScreen(graph::Context& context);

// Begins rendering to a layer of these targets, y up as projection.h has it. Colours are cleared to 0, or kept; those
// that are not `written` (bit i: color i) are left undefined.
struct DepthUse {
  graph::ImageId image;
  bool clear;  // stencil too where there is any; else tested only
};
enum class ColorUse { Clear, Keep };
void beginView(graph::Context& context, const FrameContext& f, uint32_t view, std::span<const graph::ImageId> colors,
               DepthUse depth, ColorUse use = ColorUse::Clear, uint32_t written = ~0u);

}  // namespace latelight::render
