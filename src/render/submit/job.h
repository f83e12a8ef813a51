// A call of Renderer::submit() in flight: the request, its parts on the device, and the pictures so far.
#pragma once

#include <array>
#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/log.h"
#include "base/memory.h"
#include "render/deform/world_deformer.h"
#include "render/exposure/camera_motion.h"
#include "render/exposure/camera_samples.h"
#include "render/exposure/thin_lens.h"
#include "render/submit/request.h"
#include "render/submit/result.h"
#include "render/submit/scene_state.h"
#include "render/submit/strips.h"
#include "render/visibility/compute/world_placer.h"

namespace latelight::render {

struct RenderJob;

// Some of a job's views in one strip of their pictures. They are rendered together, with one graph per sample of a
// pixel. The part is read after its last graph has run.
struct ViewBatch {
  ViewBatch(RenderJob& job, size_t first, size_t count, Strip strip, std::shared_ptr<FrameShadows> shadows,
            ShadowMapState shadowState)
      : job(job), first(first), count(count), strip(strip), shadows(std::move(shadows)), shadowState(shadowState) {}

  // `origin`: the origin of the device's world space in the scene's.
  ViewsInTime views(const glm::dvec3& origin, const CameraSample& sample) const;
  // The views' sizes and worlds, if shaders place the views.
  std::vector<shared::View> placedViews() const;
  std::vector<float> exposures() const;  // the metered factor of each view; empty: that of the settings
  Strip stripOf(size_t view) const;      // the rows of its picture that a view of the job shows

  RenderJob& job;
  size_t first, count;  // views
  Strip strip;
  std::shared_ptr<FrameShadows> shadows;  // of all strips, or of the sample being rendered; null: there are none
  ShadowMapState shadowState;             // before the first graph; once started, after the last one
  bool replayed = false;                  // it submitted recorded commands again
  bool vast = false;                      // its passes support instances with kInstanceVast
  bool started = false;                   // at least once: after an overflow it is started again
  bool continues = false;          // the history of temporal anti-aliasing holds the previous frame of these views
  bool continuesIndirect = false;  // that of filtered indirect light does
  std::vector<graph::Submission> earlier;      // of all samples except the last
  std::vector<graph::PassTime> earlierTimes;   // of exposureSamples()
  std::shared_ptr<FrameGraphBuilder> request;  // of the last sample, as is `submission`; may be that of a replay
  graph::Submission submission;
  std::vector<Overflow::Check> checks;  // of `submission`; empty once it is known that nothing overflowed
};

// A job renders one view per picture. With a rolling shutter, each row of a picture is a view of its own, from where
// the camera is when the row is exposed: `rowsAreViews`.
struct RenderJob {
  // `rows`: the rows of the pictures, which may be those of a single strip.
  RenderJob(std::span<const scene::Camera> cameras, const scene::Scene& scene, const Settings& requested,
            const SceneState& moment, uint32_t rows);

  size_t viewCount() const { return now.size() * std::max(1u, placedWorlds); }
  const scene::Camera& camera(size_t view) const { return now[view % now.size()]; }
  size_t pictureOf(size_t view) const { return rowsAreViews ? view / rows : view; }
  std::vector<float> exposures() const;  // the factor of each picture
  // Returns when a view is exposed, in seconds from the picture's time.
  double secondsOf(size_t view) const;
  double shutterOf(size_t view) const { return shutters.empty() ? settings.shutter : shutters[pictureOf(view)]; }
  // Returns the time of a sample in a view's exposure, in seconds from the view's own time.
  double secondsOf(size_t view, const CameraSample& sample) const;
  scene::Camera cameraAt(size_t view, double seconds) const;  // seconds from the view's own time
  const ThinLens& lensOf(size_t view) const { return lenses[pictureOf(view)]; }
  // Throws Error(Usage) if the pictures depend on a previous or next camera, and only this camera or the picture's has
  // a lens that bends rays.
  void checkNeighbors() const;
  // Returns the lenses of a view's camera in the previous and the next frame. The view's camera has a lens that bends
  // rays, and checkNeighbors() succeeds.
  std::array<scene::Lens, 2> neighborLenses(size_t view) const;
  // Returns the full picture's view.
  shared::View viewOf(size_t view, const CameraSample& sample, const glm::dvec3& origin) const;
  bool posesScene() const { return motion.movesScene() && (exposesMotion || rowsAreViews); }
  void keep(const ViewBatch& part, std::vector<output::FrameOutput>&& pictures);

  CameraMotion motion;                     // of the pictures' cameras
  Settings settings;                       // with the longest exposure time and readout of all pictures
  std::vector<double> shutters, readouts;  // SceneState's
  std::optional<Settings> sensed;          // as requested, if applySensor() completes the pictures
  std::vector<float> meteredExposures;     // the factor of each picture; empty: that of the settings
  bool rowsAreViews;
  uint32_t rows;                                   // of the pictures
  bool exposes;                                    // the pictures are means of exposureSamples()
  bool exposesMotion;                              // at different times, too
  std::vector<ThinLens> lenses;                    // per picture
  std::vector<scene::Camera> now, previous, next;  // of the views; previous and next may be empty: as now
  Poses poses;                                     // at the pictures' time, if the job poses the scene
  bool continues;
  // If shaders place the worlds, `now` holds the cameras of each world, and this is the number of worlds. Otherwise 0.
  uint32_t placedWorlds;
  std::vector<std::shared_ptr<const void>> inputs;    // memory that the placing shaders read
  std::optional<WorldPlacer::Conversion> conversion;  // only if shaders place the worlds
  WorldDeformer::Arrays deformation;                  // belongs to the conversion
  Results results = Results::ToHost;
  std::deque<ViewBatch> parts;       // parts that have not been read, in order; their addresses are stable
  RenderResult result;               // of the parts that have been read
  MemoryClaim memory;                // of the pictures
  std::optional<Progress> progress;  // over all views, their strips and their samples
  std::exception_ptr error;          // caught by resolveOverflow(), rethrown when the job is read
};

// Adds the times of a graph to those of the same passes in earlier graphs.
void addTimes(std::vector<graph::PassTime>& times, std::span<const graph::PassTime> some);
void addTimes(std::vector<graph::PassTime>& times, const graph::Submission& done);

// Returns outputs that have no values yet, with `rows` rows.
output::FrameOutput emptyOutput(const Settings& settings, uint32_t rows);

}  // namespace latelight::render
