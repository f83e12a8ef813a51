// Visibility by the graphics pipeline: draws the scene view by view, with its own culling and draw lists.
#pragma once

#include <memory>
#include <vector>

#include "render/visibility/draw.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// Hardware visibility of one set of views. The constructor culls the instances once for all passes.
class HardwareVisibility {
 public:
  HardwareVisibility(vk::Device& device, const GpuScene& scene, const DrawOrder& order,
                     std::span<const shared::View> views, const VisibilityOptions& options = {});

  // The functions of visibility.h.
  VisibilityBuffer addVisibility(const FrameContext& f) const;
  Gbuffer addGbuffer(const FrameContext& f, Gbuffer gbuffer) const;
  graph::ImageId addMotion(const FrameContext& f, const VisibilityBuffer& visible, MotionUse use) const;
  graph::ImageId addTriangles(const FrameContext& f, const VisibilityBuffer& visible) const;
  void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) const;
  void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const;
  bool anyBlended() const;
  VisibleMaterials materials() const { return materials_; }

  // The draw lists, for techniques that draw the scene with their own shaders.
  const DeviceDraws& solid() const { return solid_; }      // one list per view
  const DeviceDraws& blended() const { return blended_; }  // one list per view
  // Adds a pass named desc.name that shades the visible surfaces of addVisibility() into `colors`, one target for each
  // of desc.colorsWritten. `desc` comes from depthTestedDesc(); its bindings and colors are set here.
  void addSolid(const FrameContext& f, graph::Stage stage, vk::GraphicsDesc desc, const Bindings& inputs,
                graph::ImageId depth, const std::vector<graph::ImageId>& colors) const;
  // Draws the opaque and masked surfaces of a view.
  void drawOpaque(ViewRendering& rendering, const FrameContext& f, uint32_t view, const ScenePipelines& pipelines,
                  std::span<const vk::BoundImage> images = {}) const;

 private:
  struct WrittenTargets {
    Gbuffer gbuffer;
    std::vector<graph::ImageId> data;  // one per element of `words`
  };
  VisibilityBuffer addDrawn(const FrameContext& f, vk::GraphicsDesc desc) const;
  // Adds the geometry pass. `words`: dataWordsOf() the outputs that it also writes.
  WrittenTargets addTargets(const FrameContext& f, Gbuffer gbuffer, std::span<const uint32_t> words) const;
  DeviceDraws select(DrawOrder::Kind kind, std::span<const shared::View> views) const;

  vk::Device& device_;
  const GpuScene& scene_;
  const DrawOrder& order_;
  VisibilityOptions options_;
  DeviceDraws solid_, blended_;
  VisibleMaterials materials_;
};

// The state common to all draws after the depth pass: the depth test is EQUAL, so only visible surfaces are shaded.
vk::GraphicsDesc depthTestedDesc(const FrameConfig& setup);

// Returns the frame's hardware visibility, for passes of `user` that draw the scene themselves. Throws Error(Usage) if
// the frame uses another raster.
const HardwareVisibility& hardwareOf(const FrameContext& f, const char* user);

}  // namespace latelight::render
