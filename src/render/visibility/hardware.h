// Visibility by the graphics pipeline: the scene is drawn, a view after the other. Culling and draw lists are its own.
#pragma once

#include <memory>
#include <vector>

#include "render/visibility/draw.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// Of one set of views. Culls them when it is made, once for all that is drawn.
class HardwareVisibility final : public Visibility {
 public:
  HardwareVisibility(vk::Device& device, const GpuScene& scene, const DrawOrder& order,
                     std::span<const shared::View> views, const VisibilityOptions& options = {});

  FrameDepth addDepth(const FrameContext& f) const override;
  void addGbuffer(const FrameContext& f, Gbuffer& gbuffer) const override;
  graph::ImageId addMotion(const FrameContext& f, graph::ImageId depth, MotionUse use) const override;
  void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) const override;
  void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const override;
  void lightFragments(const FrameContext&, const Gbuffer&, const FragmentBuffers&) const override {}  // they are
  bool anyBlended() const override;
  ShownMaterials materials() const override { return materials_; }
  const HardwareVisibility* asHardware() const override { return this; }
  const ComputeVisibility* asCompute() const override { return nullptr; }

  // What techniques draw that have shaders of their own.
  const DeviceDraws& solid() const { return solid_; }      // a list a view
  const DeviceDraws& blended() const { return blended_; }  // the same
  // Adds a pass named desc.name that shades what addDepth() left visible, into `colors`: a target of each of
  // desc.colorsWritten. `desc` as behindDepth() makes it; its bindings and colours are filled in here.
  void addSolid(const FrameContext& f, graph::Stage stage, vk::GraphicsDesc desc, const Bindings& inputs,
                graph::ImageId depth, const std::vector<graph::ImageId>& colors) const;
  // Draws what is solid in a view, within a rendering that has begun.
  void recordSolid(graph::Context& context, const FrameContext& f, uint32_t view, const ScenePipelines& pipelines,
                   std::span<const vk::BoundImage> images = {}) const;

 private:
  DeviceDraws select(DrawOrder::Kind kind, std::span<const shared::View> views) const;

  vk::Device& device_;
  const GpuScene& scene_;
  const DrawOrder& order_;
  VisibilityOptions options_;
  DeviceDraws solid_, blended_;
  ShownMaterials materials_;
};

// What all draws behind the depth pass have: only surfaces at the very depth that it left are shaded.
vk::GraphicsDesc behindDepth(const FrameConfig& setup);

// The frame's, for a technique that draws the scene itself. Error(Usage) where visibility is another's.
const HardwareVisibility& hardwareOf(const FrameContext& f, const char* technique);

}  // namespace latelight::render
