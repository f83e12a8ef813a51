// Everything requested of some views, as one graph: picture, data and counts share visibility.
#pragma once

#include <optional>

#include "output/files.h"
#include "render/outputs/outputs.h"
#include "render/post/post.h"
#include "render/post/taa/taa.h"
#include "render/submit/frame_passes.h"
#include "render/submit/view_set.h"

namespace latelight::render {

FrameConfig frameSetup(const Settings& settings, bool shadows);
bool isLit(const Settings& settings);  // data outputs require no lighting
bool tracesPaths(const Settings& settings);

// The sum of several frames of a picture.
struct PictureSum {
  vk::Image image;        // null for a picture of one frame
  uint32_t count = 1;     // frames of the finished sum
  bool complete = false;  // the sum has all frames before finish(); otherwise that adds the last one
};

// The histories of a sequence that a picture continues or begins.
struct Histories {
  FrameHistory* temporal = nullptr;  // of temporal anti-aliasing; null: the picture has none
  FrameHistory* indirect = nullptr;  // of filtered indirect light; null: the picture has none
  bool continues = false;            // `temporal` holds the frame before this picture
  bool continuesIndirect = false;    // `indirect` holds it
};

class FrameGraphBuilder {
 public:
  // `steady`: the views without jitter; `jittered`: the same with the jitter of the picture's current frame. `shadows`:
  // of these views, or null; `shadowState`: of their maps before this graph. `yUp`: world positions and directions are
  // output in glTF's frame. `arrays`: the arrays that exported results are written to, which live as long as the graph
  // runs.
  FrameGraphBuilder(const RenderState& state, const Settings& settings, bool yUp, const ViewsInTime& steady,
                    const ViewsInTime& jittered, const FrameShadows* shadows, ShadowMapState shadowState,
                    const ResultArrays& arrays);

  // Adds only the picture's frame, and adds its result to `sum`: one of several samples per pixel.
  void accumulate(const vk::Image& sum, bool first);
  // Adds everything requested. The histories advance.
  void finish(const PictureSum& sum, const Histories& histories);
  void exportResults(Results results);  // exports the requested results, as the last step
  // Adds the constants of views that shaders write to the prologue. Call it last, after the scene's changes.
  void addConstants();
  // Replaces all views by as many others without jitter, for a recorded graph that runs again.
  void update(const ViewsInTime& views, const FrameShadows* shadows);

  graph::Graph& graph() { return graph_; }
  ShadowMapState shadowState() const { return shadowState_; }  // after this graph

  // Call after the graph has run.
  void read(const graph::Submission& done, std::vector<output::FrameOutput>& pictures) const;
  void countShadings(const graph::Submission& done, std::optional<ShadingCounts>& counts) const;

 private:
  ViewSet& steady();
  ViewSet& jittered();
  bool isSteady() const;  // the picture's frame has one sample per pixel, at its center
  bool resolvesSurfaces() const;
  FrameContext litContext(const ViewSet& set, const FrameConfig& setup);
  LitFrame addPicture(const SurfaceOutputs* outputs = nullptr, const Histories& histories = {});
  graph::ImageId addLastFrame(const PictureSum& sum, const Histories& histories);
  void addPost(graph::ImageId picture, uint32_t count, graph::BufferId covered);
  void addLightCounts();
  void addSampleCounts();
  bool showsBlendedData();
  bool packsWithPicture();
  const SurfaceOutputs* packSurfaces();
  void addData();
  void addSurfaceData(ViewSet& set, const VisibilityBuffer& visible);
  void addCoordinates(ViewSet& set, const VisibilityBuffer& visible);
  void addRasterData();
  const VisibilityBuffer& steadyVisible();

  const RenderState& state_;
  const Settings& settings_;
  ViewsInTime steadyViews_, jitteredViews_;
  const FrameShadows* shadows_;
  ShadowMapState shadowState_;
  graph::Graph graph_;
  std::optional<ViewSet> steady_, jittered_;
  std::optional<ViewSet> solid_;     // counts blended surfaces as opaque
  std::optional<ViewSet> rastered_;  // in compute, if steady_ is not
  std::optional<VisibilityBuffer> steadyVisible_;
  std::optional<LitFrame> lit_;  // the picture's, before transparency

  PackedOutputs outputs_;
  std::optional<SurfaceOutputs> surfaceOutputs_;  // if visibility packs them
  graph::BufferId surfaces_;
};

}  // namespace latelight::render
