// Visibility in compute shaders: triangles are rasterized into a buffer that holds, for each pixel, the depth and the
// number of the nearest one, and from that into whatever asks. Instances are culled on the device, for all views in one
// chain of dispatches. The result is the same whatever order workgroups run in. Nothing is drawn.
#pragma once

#include "render/visibility/compute/cluster_occlusion.h"
#include "render/visibility/compute/raster_chain.h"
#include "render/visibility/compute/raster_instances.h"
#include "render/visibility/compute/shown_push.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// What a device lacks that these shaders need, as the end of a sentence; empty: nothing.
std::string computeRasterLacks(const vk::Device& device);

class ComputeVisibility final : public Visibility {
 public:
  ComputeVisibility(const GpuScene& scene, const RasterInstances& ranks, ClusterOcclusion& hidden,
                    const VisibilityOptions& options);

  FrameDepth addDepth(const FrameContext& f) const override;
  void addGbuffer(const FrameContext& f, Gbuffer& gbuffer) const override;
  graph::ImageId addMotion(const FrameContext& f, graph::ImageId depth, MotionUse use) const override;
  void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) const override;
  void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const override;
  void lightFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const override;
  bool anyBlended() const override { return ranks_.anyBlended(); }
  ShownMaterials materials() const override { return ranks_.materials(); }
  const HardwareVisibility* asHardware() const override { return nullptr; }
  const ComputeVisibility* asCompute() const override { return this; }

  // Of a pass that has the setup's constants and finds the surfaces that pixels show: what it reads, and is pushed.
  void readsShown(const FrameContext& f, ComputePass& pass) const;
  shared::ShownPush shown(graph::Context& context) const {
    return {ranks_.address(), context.buffer(visible_).address()};
  }

  // How what shows was rasterized, once addDepth() was called: outputs.def says what each image holds.
  struct RasterImages {
    graph::ImageId numbers, classes;
  };
  RasterImages addRasterImages(const FrameContext& f) const;
  // How many triangles of solid instances cover each pixel's centre, hidden ones too.
  graph::ImageId addOverdraw(const FrameContext& f) const;

 private:
  graph::BufferId addVisible(const FrameContext& f, const RasterViews& views) const;
  RasterViews viewsOf(const FrameContext& f) const;
  RasterViews pinholeViews(const FrameContext& f) const;
  // Views of one size that are not the frame's.
  RasterViews viewsBeside(const FrameContext& f, const std::vector<shared::View>& views) const;
  struct ShadowMaps;
  void addShadowMapsOf(const FrameContext& f, const ShadowMaps& maps, graph::ImageId atlas, graph::Use use) const;
  void addResolve(const FrameContext& f, ComputePass pass, graph::BufferId outputs = {}) const;
  void addSurfaces(const FrameContext& f, Gbuffer& gbuffer) const;
  void addTriangleSurfaces(const FrameContext& f, Gbuffer& gbuffer) const;
  void addSurfacesBy(const FrameContext& f, Gbuffer& gbuffer, std::string shader, Bindings bindings) const;

  const GpuScene& scene_;
  const RasterInstances& ranks_;
  ClusterOcclusion& hidden_;
  HiddenOf hiddenOf_;
  RasterInstances::Share share_;
  // Of the graph that is being built, once addDepth() was called.
  mutable graph::BufferId visible_;
  mutable graph::BufferId pyramid_;  // none: nothing is culled that is hidden
};

}  // namespace latelight::render
