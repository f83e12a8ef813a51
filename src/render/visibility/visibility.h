// Visibility: the visible surface of each sample in all views of a frame at once, and what follows from it: the frame's
// depth, G-buffer, motion vectors and fragments. Two techniques implement these functions, the graphics pipeline
// (hardware.h) and software rasterization in compute shaders (compute/compute.h). The rest of the frame does not depend
// on the technique.
#pragma once

#include "render/frame/frame.h"
#include "render/visibility/compute/shown_push.h"
#include "shared/fragment_lists.h"

namespace latelight::render {

// The purpose of motion vectors: reprojection into the previous frame (half floats), data outputs (floats), or the
// histories of surfaces (floats), which a history compares with those of the previous frame.
enum class MotionUse { Reproject, Data, Surfaces };

constexpr VkFormat motionFormat(MotionUse use) {
  return use == MotionUse::Reproject ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
}

// The union of the material flags (kMaterial*) of all surfaces that may be visible.
struct VisibleMaterials {
  uint32_t solid = 0, translucent = 0;
  void add(uint32_t flags) { (shared::translucent(flags) ? translucent : solid) |= flags; }
  bool operator==(const VisibleMaterials&) const = default;
};

// Storage of blended fragments (shared/fragment_lists.h), as buffers of the graph.
struct FragmentBuffers {
  graph::BufferId fragments, counts, starts, totals, lists;
  uint32_t capacity;  // in fragments
  uint32_t longest;   // length of the longest list
};

// Options that select the surfaces that count as opaque, and the sample positions.
struct VisibilityOptions {
  bool blendedToo = false;  // blended surfaces with alpha above 0 count as opaque: for data outputs
  bool resolves = false;    // addGbuffer() or addTriangles() follow, so hardware may draw the triangles with the depths
  bool inCompute = false;   // rasterizes in compute shaders regardless of the settings
  bool traced = false;      // rays find the visible surfaces instead of rasterization; the rest is as in compute
  bool atCenters = false;   // one sample at the pixel's center; instances that cover no center are culled
};

// Finds the nearest surface per sample (setup.samples) and per pixel. At equal depth the surface that is drawn last
// wins; the order is by material, then mesh, then position in the scene.
VisibilityBuffer addVisibility(const FrameContext& f);
// Fills the layout's targets and the light target from gbuffer.visible. Returns the G-buffer with these targets and,
// with several samples per pixel, the groups of samples that show one surface, and the depths at which they are lit.
Gbuffer addGbuffer(const FrameContext& f, Gbuffer gbuffer);
// Returns the motion vectors at the pixel centers in motionFormat(): xy to the previous frame, zw to the next frame. In
// pixels, y down, without jitter. For MotionUse::Surfaces, z is the surface's distance from the eye in the previous
// frame divided by that in this frame, and w the number of its instance, from 1; both are 1 and 0 in the background.
graph::ImageId addMotion(const FrameContext& f, const VisibilityBuffer& visible, MotionUse use);
// Returns the triangles that are visible at the pixel centers, as R32G32_UINT: the number of the instance, from 1, and
// the index of the triangle in its mesh; 0: background. Requires one sample per pixel.
graph::ImageId addTriangles(const FrameContext& f, const VisibilityBuffer& visible);
// Renders the shadow maps of f.shadows into `atlas`. If the technique supports virtual shadow maps, only the pages that
// the G-buffer's pixels look up are rendered.
void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas);
// Renders the maps of f.placedShadows and returns their atlas. Requires the raster compute.
graph::ImageId addPlacedShadowMaps(const FrameContext& f);
// addFragments() stores the fragments of blended surfaces that no opaque surface occludes, in any order. After they are
// in lists (unsorted, as FragmentLists::lists), lightFragments() lights those that are not lit yet; with the method
// `sorted` it also sets their sort keys.
void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers);
void lightFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers);
bool anyBlended(const FrameContext& f);  // true if any view may show blended surfaces
VisibleMaterials visibleMaterials(const FrameContext& f);

// For compute passes with the setup's constants that evaluate the surfaces of visible.ids themselves
// (visible_surface.glsl): readVisibleSurfaces() adds the resources that they read. surfacePush() returns their push
// constants, which are zeros for a pass that does not read them.
void readVisibleSurfaces(const FrameContext& f, const VisibilityBuffer& visible, ComputePass& pass);
shared::VisibleSurfacePush surfacePush(const VisibilityBuffer& visible, graph::Context& context);

}  // namespace latelight::render
