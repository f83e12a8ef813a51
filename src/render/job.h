// A call of Renderer::submit() on its way: what was asked, what the device has of it, and the pictures so far.
#pragma once

#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/memory.h"
#include "render/moment.h"
#include "render/request.h"
#include "render/strips.h"

namespace latelight::render {

struct RenderJob;

// Some of a job's views, a strip of their pictures: what is rendered at once, a graph for each sample of a pixel. It is
// read once the last graph has run.
struct RenderPart {
  RenderPart(RenderJob& job, size_t first, size_t count, Strip strip, std::shared_ptr<FrameShadows> shadows)
      : job(job), first(first), count(count), strip(strip), shadows(std::move(shadows)) {}

  // `origin`: of the device's world space.
  ViewsInTime views(const glm::dvec3& origin, glm::vec2 jitter) const;

  RenderJob& job;
  size_t first, count;  // views
  Strip strip;
  std::shared_ptr<FrameShadows> shadows;  // of all strips; null where no light casts any
  bool started = false;                   // once, at least: what overflows is started again
  bool continues = false;  // the history of temporal anti-aliasing is that of these views, a frame before
  std::vector<graph::Submission> earlier;  // of all samples but the last
  std::optional<Request> request;          // the last, and its submission
  graph::Submission submission;
  std::vector<Overflow::Check> checks;  // of that; none any more once it is known that nothing overflowed
};

struct RenderJob {
  // `rows`: of the pictures, where they are not whole.
  RenderJob(std::span<const scene::Camera> cameras, const Settings& settings, const Moment& moment, uint32_t rows);

  size_t viewCount() const { return now.size(); }
  void keep(const RenderPart& part, std::vector<output::FrameOutput>&& pictures);
  void addTimes(const graph::Submission& done);

  std::vector<scene::Camera> now, previous, next;
  Settings settings;
  uint32_t rows;  // of the pictures
  bool continues;
  Results results = Results::ToHost;
  std::deque<RenderPart> parts;  // that have not been read, in their order; they stay where they are
  std::vector<output::FrameOutput> pictures;
  std::vector<ExportedArray> arrays;  // instead, for Results::Exported
  MemoryClaim memory;                 // of the pictures
  std::optional<Progress> progress;   // over all views, their strips, and the samples that each takes
  std::exception_ptr error;           // what went wrong behind the caller's back
  std::vector<graph::PassTime> times;
  std::optional<ShadingCounts> shadingCounts;
  std::string graphviz;
};

// Outputs that nothing is in yet, of so many rows.
output::FrameOutput emptyOutput(const Settings& settings, uint32_t rows);

}  // namespace latelight::render
