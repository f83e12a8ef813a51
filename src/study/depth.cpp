// The error of depth formats and packings in view depth, under each kind of projection, and in device depth.
#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "output/debug.h"
#include "study/constant_ids.h"
#include "study/depth_formats.h"
#include "study/device_evaluation.h"
#include "study/picture.h"
#include "study/projections.h"
#include "study/statistics.h"
#include "study/study.h"

namespace latelight::study {

namespace {

using shared::vec4;

struct Format {
  const char* name;
  uint32_t id;
  std::array<uint8_t, 3> color;
  const char* colorName;
};
constexpr Format kFormats[] = {
    {"d32", shared::kDepth32, {236, 236, 232}, "white"},
    {"d24", shared::kDepth24, {90, 170, 255}, "blue"},
    {"d16", shared::kDepth16, {255, 170, 60}, "orange"},
    {"rgba8", shared::kDepthRgba8, {120, 220, 120}, "green"},
    {"rgba8-classic", shared::kDepthRgba8Classic, {255, 90, 90}, "red"},
};

class DepthStudy {
 public:
  explicit DepthStudy(const Options& options) : device_(options), count_(options.samples / 4) {
    errors_ = {"depth",
               {"format", "projection", "mean rel", "rms rel", "max rel", "worst m", "lost", "device mean rel",
                "device max rel", "device lost"},
               {},
               true};
    packing_ = {
        "depth-packing", {"format", "mean", "max", "device mean", "device max", "0 becomes", "1 becomes"}, {}, true};
  }

  Result run() {
    for (const Format& format : kFormats) pack(format);
    std::vector<output::Labelled> plots;
    for (const NamedProjection& p : perspectives()) plots.push_back({p.name, plot(p)});
    device_.expectSilence();
    Result result{device_.name(), {std::move(packing_), std::move(errors_)}, {}};
    std::string legend;
    for (const Format& format : kFormats) legend += fmt::format("; {} {}", format.colorName, format.name);
    plots[0].label += ": relative error 1e-8 to 1 over 0.1 to 1000 m";
    plots[1].label += legend;
    result.pictures.push_back({"depth", output::contactSheet(plots, 2, kPlotWidth)});
    return result;
  }

 private:
  // Samples device depth: half of the samples evenly over [0, 1] and half evenly over its floats, both including 0 and
  // 1.
  void pack(const Format& format) {
    std::vector<vec4> depths;
    const uint32_t one = std::bit_cast<uint32_t>(1.0f);
    for (uint32_t i = 0; i < count_; ++i) {
      const double share = i / (count_ - 1.0);
      depths.emplace_back(float(share), 0, 0, 0);
      depths.emplace_back(std::bit_cast<float>(uint32_t(share * one)), 0, 0, 0);
    }
    const vk::Pipeline pipeline = device_.make("study_depth.comp", {{kFormatConstant, format.id}});
    const std::vector<vec4> onDevice = device_.run(pipeline, depths, perspectives().front().projection);
    // A depth of 1 is a special case, because some packings turn it into 0; it has a column of its own.
    const auto below = [&](size_t i) { return depths[i].x < 1; };
    const auto summary = [&](const std::function<double(size_t)>& stored) {
      const std::vector<double> errors =
          errorsOf(depths.size(), [&](size_t i) { return std::abs(stored(i) - depths[i].x); });
      return summarize(errors, depths.size(), below);
    };
    const Statistics host = summary([&](size_t i) { return double{shared::storedDepth(format.id, depths[i].x)}; });
    const Statistics device = summary([&](size_t i) { return double{onDevice[i].x}; });
    packing_.rows.push_back({format.name, host.mean(), host.maximum, device.mean(), device.maximum,
                             double{shared::storedDepth(format.id, 0)}, double{shared::storedDepth(format.id, 1)}});
  }

  // Samples view depth from near to far, evenly on a logarithmic scale.
  output::Picture plot(const NamedProjection& named) {
    const shared::Projection& p = named.projection;
    std::vector<float> meters(count_);
    std::vector<vec4> depths;
    for (uint32_t i = 0; i < count_; ++i) {
      meters[i] = float(kNear * std::pow(kFar / kNear, (i + 0.5) / count_));
      depths.emplace_back(shared::saturate(shared::deviceDepth(p, meters[i])), 0, 0, 0);
    }
    std::vector<Line> lines;
    for (const Format& format : kFormats) {
      const vk::Pipeline pipeline = device_.make("study_depth.comp", {{kFormatConstant, format.id}});
      const std::vector<vec4> onDevice = device_.run(pipeline, depths, p);
      const auto relative = [&](size_t i, float depth) { return std::abs(double{depth} - meters[i]) / meters[i]; };
      const std::vector<double> host = errorsOf(count_, [&](size_t i) {
        return relative(i, shared::viewDepth(p, shared::storedDepth(format.id, depths[i].x)));
      });
      const std::vector<double> device = errorsOf(count_, [&](size_t i) { return relative(i, onDevice[i].y); });
      addRow(format, named, host, device, meters);
      lines.push_back({format.color, largestOfParts(host)});
    }
    return logPlot(lines, 1e-8, 1, 4);
  }

  void addRow(const Format& format, const NamedProjection& named, const std::vector<double>& host,
              const std::vector<double>& device, const std::vector<float>& meters) {
    const auto all = [](size_t) { return true; };
    const Statistics h = summarize(host, host.size(), all), d = summarize(device, device.size(), all);
    const double count = double(host.size());
    errors_.rows.push_back({format.name, named.name, h.mean(), h.rms(), h.maximum, double{meters[h.worst]},
                            double(h.lost) / count, d.mean(), d.maximum, double(d.lost) / count});
  }

  static std::vector<double> largestOfParts(const std::vector<double>& errors) {
    constexpr size_t kParts = 240;
    std::vector<double> largest(kParts);
    for (size_t i = 0; i < errors.size(); ++i) {
      double& part = largest[i * kParts / errors.size()];
      part = std::max(part, std::min(errors[i], 1.0));
    }
    return largest;
  }

  DeviceEvaluation device_;
  uint32_t count_;
  Table errors_, packing_;
};

}  // namespace

Result studyDepth(const Options& options) {
  return DepthStudy(options).run();
}

}  // namespace latelight::study
