// Compute visibility: software rasterization into a visibility buffer, which holds the depth and triangle id of the
// nearest surface per sample; depth, G-buffer, motion vectors and shadow maps are resolved from it. The device culls
// the clusters of all views in one chain of dispatches, with two-pass occlusion culling. The result does not depend on
// the order of workgroups. Nothing uses the graphics pipeline.
#pragma once

#include "render/visibility/compute/cluster_occlusion.h"
#include "render/visibility/compute/raster_chain.h"
#include "render/visibility/compute/raster_instances.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// Returns the feature that these shaders require and the device lacks, as the end of a sentence; empty if there is
// none.
std::string missingForComputeRaster(const vk::Device& device);

class ComputeVisibility {
 public:
  ComputeVisibility(const GpuScene& scene, const RasterInstances& rasterInstances, ClusterOcclusion& occluded,
                    const VisibilityOptions& options);

  // The functions of visibility.h.
  VisibilityBuffer addVisibility(const FrameContext& f) const;
  Gbuffer addGbuffer(const FrameContext& f, Gbuffer gbuffer) const;
  graph::ImageId addMotion(const FrameContext& f, const VisibilityBuffer& visible, MotionUse use) const;
  graph::ImageId addTriangles(const FrameContext& f, const VisibilityBuffer& visible) const;
  void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) const;
  graph::ImageId addPlacedShadowMaps(const FrameContext& f) const;
  void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const;
  void lightFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const;
  bool anyBlended() const { return rasterInstances_.anyBlended(); }
  VisibleMaterials materials() const { return rasterInstances_.materials(); }

  // Images that describe how the visible triangles were rasterized; outputs.def defines their contents.
  struct RasterImages {
    graph::ImageId numbers, classes;
  };
  RasterImages addRasterImages(const FrameContext& f, const VisibilityBuffer& visible) const;
  // Adds the overdraw: the number of opaque and masked triangles that cover each pixel's center, including occluded
  // ones.
  graph::ImageId addOverdraw(const FrameContext& f) const;

 private:
  VisibilityBuffer addFrameVisible(const FrameContext& f) const;
  VisibilityBuffer addVisible(const FrameContext& f, const RasterViews& views) const;
  RasterViews viewsOf(const FrameContext& f) const;
  RasterViews pinholeViews(const FrameContext& f) const;
  // Sets up views of one size that are not the frame's views.
  RasterViews viewsOf(const FrameContext& f, const std::vector<shared::View>& views) const;
  struct ShadowMaps;
  void addShadowMapsOf(const FrameContext& f, const ShadowMaps& maps, graph::ImageId atlas, graph::Use use) const;
  void storeShadowMaps(const FrameContext& f, const RasterViews& maps, VkDeviceAddress targets, graph::ImageId atlas,
                       graph::Use use) const;
  void addResolve(const FrameContext& f, const VisibilityBuffer& visible, ComputePass pass,
                  graph::BufferId outputs = {}, graph::BufferId covered = {}) const;
  graph::ImageId addTriangles(const FrameContext& f, const VisibilityBuffer& visible, graph::BufferId covered) const;
  Gbuffer addSurfaces(const FrameContext& f, Gbuffer gbuffer) const;
  Gbuffer addTriangleSurfaces(const FrameContext& f, Gbuffer gbuffer) const;
  Gbuffer addSurfacesBy(const FrameContext& f, Gbuffer gbuffer, vk::ShaderKey shader, Bindings bindings) const;

  const GpuScene& scene_;
  const RasterInstances& rasterInstances_;
  ClusterOcclusion& clusterOcclusion_;
  OcclusionHistory occlusionHistory_;
  RasterInstances::Share share_;
  bool leavesOutBlended_;     // share_ includes blended instances that do not belong to it
  bool traced_, blendedToo_;  // as in VisibilityOptions
};

}  // namespace latelight::render
