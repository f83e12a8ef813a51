// What a visibility technique gives: which surface each sample of a frame's views shows, and what is made of those
// surfaces. All views of a frame at once. Everything else in the frame is the same whatever the technique.
#pragma once

#include "render/frame/frame.h"
#include "shared/fragment_lists.h"

namespace latelight::render {

// What motion is for: to find a pixel in the frame before, in half floats; or data outputs, in floats.
enum class MotionUse { Reproject, Data };

// Flags of materials (kMaterial*), of all that may show together.
struct ShownMaterials {
  uint32_t solid = 0, translucent = 0;
  void add(uint32_t flags) { (shared::translucent(flags) ? translucent : solid) |= flags; }
};

// Where blended fragments are kept (shared/fragment_lists.h), as buffers of the graph.
struct FragmentBuffers {
  graph::BufferId fragments, counts, starts, totals, lists;
  uint32_t capacity;  // fragments
  uint32_t longest;   // list
};

// Which surfaces count as solid, and where pixels are looked at.
struct VisibilityOptions {
  bool blendedToo = false;  // what is blended is a surface like any other where its alpha is above 0: for data outputs
  bool inCompute = false;   // rasterized in compute shaders, whatever the settings say
  bool atCentres = false;   // pixels have one sample, at their centre: what holds none is not drawn
};

class ComputeVisibility;
class HardwareVisibility;

class Visibility {
 public:
  virtual ~Visibility() = default;

  // Depth of the nearest surface of every sample (setup.samples), and of every pixel. Where two surfaces have the very
  // same depth, the later one shows: by material, mesh, then their order in the scene.
  virtual FrameDepth addDepth(const FrameContext& f) const = 0;
  // Adds the layout's targets to the G-buffer and fills them and its light target, from the surfaces that show; with
  // several samples also which samples show one surface, and the depths to light them at.
  virtual void addGbuffer(const FrameContext& f, Gbuffer& gbuffer) const = 0;
  // R16G16B16A16_SFLOAT or R32G32B32A32_SFLOAT: xy to the frame before, zw to the frame after, of what shows at the
  // pixels' centres. Pixels, y down, without jitter.
  virtual graph::ImageId addMotion(const FrameContext& f, graph::ImageId depth, MotionUse use) const = 0;
  // What is to be drawn of the shadow maps of f.shadows, into `atlas`: where it can be told, only what is looked up
  // from the G-buffer.
  virtual void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) const = 0;
  // Fragments of blended surfaces that nothing hides, in no order. Then, once they are in lists (unsorted, as
  // FragmentLists::lists), their light, where they have none yet; with the method `sorted`, their keys too.
  virtual void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const = 0;
  virtual void lightFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) const = 0;
  virtual bool anyBlended() const = 0;  // may any of its views show blended surfaces?
  virtual ShownMaterials materials() const = 0;
  // What draws by the graphics pipeline; null: nothing does.
  virtual const HardwareVisibility* asHardware() const = 0;
  // What rasterizes in compute shaders; null: nothing does.
  virtual const ComputeVisibility* asCompute() const = 0;
};

}  // namespace latelight::render
