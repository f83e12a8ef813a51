#include "render/submit/job.h"

#include <algorithm>

#include "render/frame/view.h"

namespace latelight::render {

RenderJob::RenderJob(std::span<const scene::Camera> cameras, const Settings& settings, const SceneState& moment,
                     uint32_t rows)
    : now(cameras.begin(), cameras.end()),
      previous(moment.previousCameras),
      next(moment.nextCameras),
      settings(settings),
      rows(rows),
      continues(moment.continues),
      placedWorlds(moment.worlds.inputs ? moment.worlds.count : 0) {
  if (moment.worlds.inputs) inputs = moment.worlds.inputs->memory;
}

std::vector<float> ViewBatch::exposures() const {
  if (job.meteredExposures.empty()) return {};
  const auto begin = job.meteredExposures.begin() + static_cast<ptrdiff_t>(first);
  return {begin, begin + static_cast<ptrdiff_t>(count)};
}

ViewsInTime ViewBatch::views(const glm::dvec3& origin, glm::vec2 jitter) const {
  if (job.placedWorlds > 0) {
    shared::View view{};
    view.size = {static_cast<float>(job.settings.width), static_cast<float>(job.settings.height)};
    std::vector<shared::View> placed(count, view);
    for (size_t i = 0; i < count; ++i) placed[i].world = static_cast<uint32_t>((first + i) / job.now.size());
    return {.now = placed, .previous = placed, .next = placed, .lens = nullptr, .exposures = exposures()};
  }
  const auto viewsOf = [&](const std::vector<scene::Camera>& cameras, glm::vec2 jitter) {
    std::vector<shared::View> views;
    for (size_t i = first; i < first + count; ++i)
      views.push_back(viewOf(makeView(cameras[i], job.settings.width, job.settings.height, jitter, origin), strip));
    return views;
  };
  ViewsInTime views{viewsOf(job.now, jitter), {}, {}};
  const bool still = job.previous.empty() || job.next.empty();
  std::vector<shared::View> steady;
  if (still) steady = jitter == glm::vec2(0) ? views.now : viewsOf(job.now, glm::vec2(0));
  views.previous = job.previous.empty() ? steady : viewsOf(job.previous, glm::vec2(0));
  views.next = job.next.empty() ? steady : viewsOf(job.next, glm::vec2(0));
  views.exposures = exposures();
  return views;
}

std::vector<float> RenderJob::exposures() const {
  return meteredExposures.empty() ? std::vector(viewCount(), exposureFactor(settings)) : meteredExposures;
}

// Strips arrive from top to bottom.
void RenderJob::keep(const ViewBatch& part, std::vector<output::FrameOutput>&& some) {
  std::vector<output::FrameOutput>& pictures = result.frames;
  if (part.strip.rows == rows) {
    std::move(some.begin(), some.end(), std::back_inserter(pictures));
    return;
  }
  if (pictures.size() < part.first + part.count) pictures.resize(part.first + part.count, emptyOutput(settings, rows));
  for (size_t view = 0; view < part.count; ++view) append(pictures[part.first + view], some[view]);
}

void addTimes(std::vector<graph::PassTime>& times, const graph::Submission& done) {
  for (const graph::PassTime& time : done.times()) {
    const auto known = std::ranges::find(times, time.name, &graph::PassTime::name);
    if (known == times.end()) {
      times.push_back(time);
      continue;
    }
    known->milliseconds += time.milliseconds;
    known->trafficBytes += time.trafficBytes;
  }
}

output::FrameOutput emptyOutput(const Settings& settings, uint32_t rows) {
  output::FrameOutput empty{.width = settings.width, .height = rows, .aovs = {}, .display = {}};
  for (output::Aov aov : settings.aovs) empty.aovs.push_back({aov, settings.width, rows, {}, {}});
  return empty;
}

}  // namespace latelight::render
