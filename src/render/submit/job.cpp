#include "render/submit/job.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "render/frame/view.h"

namespace latelight::render {

namespace {

Settings withLongestExposure(const Settings& requested, const SceneState& moment) {
  const auto magnitude = [](double seconds) { return std::abs(seconds); };
  Settings settings = requested;
  if (!moment.shutters.empty()) settings.shutter = std::ranges::max(moment.shutters);
  if (!moment.readouts.empty()) settings.readout = *std::ranges::max_element(moment.readouts, {}, magnitude);
  return settings;
}

// Returns true if pictures depend on the projections of the previous and the next cameras.
bool usesNeighbors(const Settings& settings) {
  return requestsOutput(settings, Origin::Motion) || keepsHistory(settings);
}

}  // namespace

RenderJob::RenderJob(std::span<const scene::Camera> cameras, const scene::Scene& scene, const Settings& requested,
                     const SceneState& moment, uint32_t rows)
    : motion({cameras.begin(), cameras.end()}, moment.previousCameras, moment.nextCameras, moment.motion, requested),
      settings(withLongestExposure(requested, moment)),
      shutters(moment.shutters),
      readouts(moment.readouts),
      rowsAreViews(settings.readout != 0 && (motion.movesScene() || motion.movesCameras())),
      rows(rowsAreViews ? settings.height : rows),
      exposes(false),
      exposesMotion(showsPicture(settings) && settings.shutter > 0 && (motion.movesScene() || motion.movesCameras())),
      lenses(thinLensesOf(cameras, settings, scene, moment.worlds)),
      continues(moment.continues),
      placedWorlds(moment.worlds.inputs ? moment.worlds.count : 0) {
  const bool blurs = std::ranges::any_of(lenses, [](const ThinLens& lens) { return lens.radius > 0; });
  exposes = exposesMotion || (showsPicture(settings) && blurs);
  inputs = moment.worlds.deformations.memory;
  if (moment.worlds.inputs)
    inputs.insert(inputs.end(), moment.worlds.inputs->memory.begin(), moment.worlds.inputs->memory.end());
  if (posesScene()) poses = moment.poses;
  if (!rowsAreViews) {
    now.assign(cameras.begin(), cameras.end());
    previous = moment.previousCameras;
    next = moment.nextCameras;
    return;
  }
  for (size_t view = 0; view < cameras.size() * rows; ++view)
    now.push_back(motion.at(pictureOf(view), secondsOf(view)));
}

double RenderJob::secondsOf(size_t view) const {
  if (!rowsAreViews) return 0;
  const double readout = readouts.empty() ? settings.readout : readouts[pictureOf(view)];
  return ((static_cast<double>(view % rows) + 0.5) / rows - 0.5) * readout;
}

double RenderJob::secondsOf(size_t view, const CameraSample& sample) const {
  const bool scales = !shutters.empty() && settings.shutter > 0;
  return scales ? sample.seconds * (shutterOf(view) / settings.shutter) : sample.seconds;
}

scene::Camera RenderJob::cameraAt(size_t view, double seconds) const {
  return seconds == 0 ? now[view] : motion.at(pictureOf(view), secondsOf(view) + seconds);
}

std::array<scene::Lens, 2> RenderJob::neighborLenses(size_t view) const {
  const auto lensOf = [&](const std::vector<scene::Camera>& cameras) {
    return *(cameras.empty() || !usesNeighbors(settings) ? now[view] : cameras[view]).lens;
  };
  return {lensOf(previous), lensOf(next)};
}

void RenderJob::checkNeighbors() const {
  if (!usesNeighbors(settings)) return;
  for (const auto* neighbors : {&previous, &next})
    if (!std::ranges::equal(*neighbors, std::span(now).first(neighbors->size()), {}, bendsRays, bendsRays))
      badUsage(
          "a camera with a lens that bends rays needs such a lens in its previous and next cameras as well, and a "
          "camera without one needs neighbors without one");
}

shared::View RenderJob::viewOf(size_t view, const CameraSample& sample, const glm::dvec3& origin) const {
  const scene::Camera camera = cameraAt(view, secondsOf(view, sample));
  const ThinLens& lens = lensOf(view);
  const glm::dvec2 offset = lens.radius * sample.lens;
  if (offset == glm::dvec2(0)) return makeView(camera, settings.width, settings.height, sample.jitter, origin);
  shared::View shown = makeView(atAperture(camera, offset), settings.width, settings.height, sample.jitter, origin);
  if (!bendsRays(camera)) focusView(shown, offset, lens.focus);
  return shown;
}

Strip ViewBatch::stripOf(size_t view) const {
  return job.rowsAreViews ? Strip{static_cast<uint32_t>(view % job.rows), 1} : strip;
}

std::vector<float> ViewBatch::exposures() const {
  std::vector<float> some;
  if (!job.meteredExposures.empty())
    for (size_t view = first; view < first + count; ++view) some.push_back(job.meteredExposures[job.pictureOf(view)]);
  return some;
}

ViewsInTime ViewBatch::views(const glm::dvec3& origin, const CameraSample& sample) const {
  ViewsInTime views{.centered = sample == CameraSample{}, .exposures = exposures()};
  for (size_t i = first; i < first + count; ++i)
    views.now.push_back(render::viewOf(job.viewOf(i, sample, origin), stripOf(i)));
  const auto viewsOf = [&](const std::vector<scene::Camera>& cameras) {
    std::vector<shared::View> some;
    for (size_t i = first; i < first + count; ++i)
      some.push_back(render::viewOf(makeView(cameras[i], job.settings.width, job.settings.height, glm::vec2(0), origin),
                                    stripOf(i)));
    return some;
  };
  const bool still = job.previous.empty() || job.next.empty();
  std::vector<shared::View> steady;
  if (still) steady = views.centered ? views.now : viewsOf(job.now);
  views.previous = job.previous.empty() ? steady : viewsOf(job.previous);
  views.next = job.next.empty() ? steady : viewsOf(job.next);
  return views;
}

std::vector<shared::View> ViewBatch::placedViews() const {
  std::vector<shared::View> views(count);
  for (size_t i = 0; i < count; ++i) {
    views[i].size = {static_cast<float>(job.settings.width), static_cast<float>(job.settings.height)};
    views[i].world = static_cast<uint32_t>((first + i) / job.now.size());
  }
  return views;
}

std::vector<float> RenderJob::exposures() const {
  const size_t pictures = rowsAreViews ? viewCount() / rows : viewCount();
  return meteredExposures.empty() ? std::vector(pictures, exposureFactor(settings)) : meteredExposures;
}

// Strips and rows arrive from top to bottom.
void RenderJob::keep(const ViewBatch& part, std::vector<output::FrameOutput>&& some) {
  std::vector<output::FrameOutput>& pictures = result.frames;
  if (!rowsAreViews && part.strip.rows == rows) {
    std::move(some.begin(), some.end(), std::back_inserter(pictures));
    return;
  }
  const size_t count = pictureOf(part.first + part.count - 1) + 1;
  if (pictures.size() < count) pictures.resize(count, emptyOutput(settings, rows));
  for (size_t view = 0; view < part.count; ++view) append(pictures[pictureOf(part.first + view)], some[view]);
}

void addTimes(std::vector<graph::PassTime>& times, std::span<const graph::PassTime> some) {
  for (const graph::PassTime& time : some) {
    const auto known = std::ranges::find(times, time.name, &graph::PassTime::name);
    if (known == times.end()) {
      times.push_back(time);
      continue;
    }
    known->milliseconds += time.milliseconds;
    known->trafficBytes += time.trafficBytes;
  }
}

void addTimes(std::vector<graph::PassTime>& times, const graph::Submission& done) {
  addTimes(times, done.times());
}

output::FrameOutput emptyOutput(const Settings& settings, uint32_t rows) {
  output::FrameOutput empty{.width = settings.width, .height = rows, .aovs = {}, .display = {}};
  for (output::Aov aov : settings.aovs) empty.aovs.push_back({aov, settings.width, rows, {}, {}});
  return empty;
}

}  // namespace latelight::render
