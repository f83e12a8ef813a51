// The error of three methods that reconstruct position from a 32-bit float depth buffer, against the drawn point. Also
// reports the part of the error that the method adds to that of the depth buffer.
#include <fmt/format.h>

#include <cmath>

#include "output/debug.h"
#include "render/settings/settings.h"
#include "study/constant_ids.h"
#include "study/device_evaluation.h"
#include "study/picture.h"
#include "study/projections.h"
#include "study/statistics.h"
#include "study/study.h"

namespace latelight::study {

namespace {

using glm::dvec3;
using shared::Projection;
using shared::vec2;
using shared::vec3;
using shared::vec4;

struct Samples {
  std::vector<vec4> inputs;        // NDC and device depth
  std::vector<dvec3> drawn;        // the points
  std::vector<dvec3> represented;  // points that NDC and device depth represent, by the same formula in double
};

dvec3 pointAt(const Projection& p, double ndcX, double ndcY, double depth) {
  const double w = p.kind == shared::kPerspective ? depth : 1.0;
  return {(ndcX - p.X) * w / p.H, depth, (ndcY - p.Z) * w / p.V};
}

double exactDepth(const Projection& p, double d) {
  return p.kind == shared::kPerspective ? double{p.B} / (d - p.A) : (d - p.B) / p.A;
}

// Samples the image by a low-discrepancy sequence (Roberts 2018, R2), with depths evenly on a logarithmic scale.
Samples makeSamples(const Projection& p, uint32_t count) {
  constexpr double kG = 1.32471795724474602596;
  Samples s;
  for (uint32_t i = 0; i < count; ++i) {
    const float x = float(2 * std::fmod(0.5 + i / kG, 1.0) - 1), y = float(2 * std::fmod(0.5 + i / (kG * kG), 1.0) - 1);
    const float meters = float(kNear * std::pow(kFar / kNear, (i + 0.5) / count));
    const float d = shared::saturate(shared::deviceDepth(p, meters));
    s.inputs.emplace_back(x, y, d, 0);
    s.drawn.push_back(pointAt(p, x, y, meters));
    s.represented.push_back(pointAt(p, x, y, exactDepth(p, d)));
  }
  return s;
}

constexpr std::array<uint8_t, 3> kMethodColors[] = {{236, 236, 232}, {90, 170, 255}, {255, 170, 60}};

class PositionStudy {
 public:
  explicit PositionStudy(const Options& options) : device_(options), count_(options.samples / 4) {
    table_ = {"position",
              {"projection", "principal point", "method", "mean m", "rms m", "max m", "own mean m", "own max m",
               "device mean m", "device max m", "device own max m"},
              {},
              true};
  }

  Result run() {
    std::vector<NamedProjection> projections = perspectives();
    for (const NamedProjection& p : orthographics()) projections.push_back(p);
    std::vector<output::Labelled> plots;
    for (const NamedProjection& named : projections) {
      plots.push_back({named.name, measure(named, "centered")});
      NamedProjection off = named;
      off.projection.X = 0.3f;
      off.projection.Z = -0.2f;
      measure(off, "off-center");
    }
    plots[0].label += ": own error 1e-9 to 10 m over 0.1 to 1000 m";
    plots[1].label += ": white ray, blue matrix, orange reciprocal";
    device_.expectSilence();
    return {device_.name(), {std::move(table_)}, {{"position", output::contactSheet(plots, 2, kPlotWidth)}}};
  }

 private:
  output::Picture measure(const NamedProjection& named, const char* principal) {
    const Projection& p = named.projection;
    const Samples s = makeSamples(p, count_);
    const auto all = [](size_t) { return true; };
    std::vector<Line> lines;
    for (uint32_t method = 0; method < render::choices<render::PositionMethod>().size(); ++method) {
      const std::vector<vec4> onDevice =
          device_.run(device_.make("study_position.comp", {{kMethodConstant, method}}), s.inputs, p);
      const auto hostPoint = [&](size_t i) {
        const vec4& in = s.inputs[i];
        return dvec3(shared::viewPosition(p, method, vec2(in.x, in.y), in.z));
      };
      const auto summary = [&](const std::function<double(size_t)>& error) {
        return summarize(errorsOf(count_, error), count_, all);
      };
      const std::vector<double> own =
          errorsOf(count_, [&](size_t i) { return glm::distance(hostPoint(i), s.represented[i]); });
      const Statistics host = summary([&](size_t i) { return glm::distance(hostPoint(i), s.drawn[i]); });
      const Statistics hostOwn = summarize(own, count_, all);
      const Statistics device = summary([&](size_t i) { return glm::distance(dvec3(onDevice[i]), s.drawn[i]); });
      const Statistics deviceOwn =
          summary([&](size_t i) { return glm::distance(dvec3(onDevice[i]), s.represented[i]); });
      table_.rows.push_back({named.name, principal, render::choices<render::PositionMethod>()[method].name, host.mean(),
                             host.rms(), host.maximum, hostOwn.mean(), hostOwn.maximum, device.mean(), device.maximum,
                             deviceOwn.maximum});
      lines.push_back({kMethodColors[method], largestOfParts(own)});
    }
    return logPlot(lines, 1e-9, 10, 4);
  }

  static std::vector<double> largestOfParts(const std::vector<double>& errors) {
    constexpr size_t kParts = 240;
    std::vector<double> largest(kParts);
    for (size_t i = 0; i < errors.size(); ++i) {
      double& part = largest[i * kParts / errors.size()];
      part = std::max(part, errors[i]);
    }
    return largest;
  }

  DeviceEvaluation device_;
  uint32_t count_;
  Table table_;
};

}  // namespace

Result studyPosition(const Options& options) {
  return PositionStudy(options).run();
}

}  // namespace latelight::study
