// The error of each normal encoding at each number of bits, over the sphere and over the hemisphere towards the viewer,
// on the host and on the device.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "output/debug.h"
#include "render/gbuffer/layout.h"
#include "study/constant_ids.h"
#include "study/device_evaluation.h"
#include "study/normal_error.h"
#include "study/picture.h"
#include "study/statistics.h"
#include "study/study.h"

namespace latelight::study {

namespace {

using shared::vec3;
using shared::vec4;

constexpr size_t kHistogramBins = 120;

struct Directions {
  std::vector<vec4> all;
  size_t even;  // count of directions at the front that cover the sphere evenly; means use these
};

vec4 unit(double x, double y, double z) {
  const double scale = 1 / std::sqrt(x * x + y * y + z * z);
  return {float(x * scale), float(y * scale), float(z * scale), 0};
}

// Adds directions where encodings fold, wrap or end: axes, corners and edges of the octahedron, the three great circles
// through the axes and the neighborhoods of the poles, with steps to either side.
void addHardDirections(std::vector<vec4>& list) {
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x || y || z) list.push_back(unit(x, y, z));
  constexpr int kAround = 3600;
  for (const double step : {0.0, 1e-7, -1e-7, 1e-3, -1e-3})
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround, c = std::cos(angle), s = std::sin(angle);
      for (const vec4& d : {unit(c, s, step), unit(step, c, s), unit(c, step, s), unit(c * step, s * step, 1),
                            unit(c * step, s * step, -1)})
        list.push_back(d);
    }
}

// Returns a number in [0, 1) by splitmix64 (Steele et al. 2014).
double random(uint64_t& state) {
  uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// Returns the Fibonacci lattice (Gonzalez 2010, "Measurement of areas on a sphere using Fibonacci and
// latitude-longitude lattices") or random directions, followed by the difficult ones.
Directions makeDirections(const Options& options) {
  Directions directions{std::vector<vec4>(options.samples), options.samples};
  uint64_t state = options.seed.value_or(0);
  for (uint32_t i = 0; i < options.samples; ++i) {
    const double z = 1 - 2 * (options.seed ? random(state) : (i + 0.5) / options.samples);
    const double turn = options.seed ? random(state) : std::fmod(i / std::numbers::phi, 1.0);
    const double angle = 2 * std::numbers::pi * turn, r = std::sqrt(1 - z * z);
    directions.all[i] = unit(r * std::cos(angle), r * std::sin(angle), z);
  }
  addHardDirections(directions.all);
  return directions;
}

struct Regions {
  Statistics sphere, hemisphere;
};

class NormalStudy {
 public:
  explicit NormalStudy(const Options& options)
      : device_(options), directions_(makeDirections(options)), bits_(options.bits), pictures_(options.pictures) {
    if (bits_.empty()) bits_.assign(std::begin(kUsualNormalBits), std::end(kUsualNormalBits));
    table_ = {"normals",
              {"encoding", "bits", "region", "mean deg", "rms deg", "max deg", "device mean deg", "device rms deg",
               "device max deg", "worst x", "worst y", "worst z"},
              {},
              true};
    histogram_ = {"normals-histogram", {"encoding", "bits", "from deg", "to deg", "directions"}, {}, false};
  }

  Result run() {
    for (const uint32_t bits : bits_) {
      std::vector<output::Labelled> maps, histograms;
      for (const render::NormalEncoding& encoding : render::normalEncodings())
        measure(encoding, bits, maps, histograms);
      if (!pictures_) continue;
      const std::string name = bits == 0 ? "float" : fmt::format("{}", bits);
      result_.pictures.push_back({"normals-map-" + name, output::contactSheet(maps, 3)});
      result_.pictures.push_back({"normals-histogram-" + name, output::contactSheet(histograms, 3)});
    }
    device_.expectSilence();
    result_.device = device_.name();
    result_.tables = {std::move(table_), std::move(histogram_)};
    return std::move(result_);
  }

 private:
  vec3 direction(size_t i) const { return vec3(directions_.all[i]); }

  Regions regions(const std::vector<double>& errors) const {
    return {summarize(errors, directions_.even, [](size_t) { return true; }),
            summarize(errors, directions_.even, [&](size_t i) { return directions_.all[i].z >= 0; })};
  }

  void measure(const render::NormalEncoding& encoding, uint32_t bits, std::vector<output::Labelled>& maps,
               std::vector<output::Labelled>& histograms) {
    const auto errorOf = [&](vec3 n) { return normalError(encoding, bits, n); };
    const std::vector<double> host = errorsOf(directions_.all.size(), [&](size_t i) { return errorOf(direction(i)); });
    const std::vector<vec4> decoded =
        device_.run(device_.make("study_normals.comp", {{kEncodingConstant, encoding.index}, {kBitsConstant, bits}}),
                    directions_.all);
    const std::vector<double> device =
        errorsOf(directions_.all.size(), [&](size_t i) { return degreesBetween(vec3(decoded[i]), direction(i)); });
    const Regions onHost = regions(host), onDevice = regions(device);
    addRow(encoding, bits, "sphere", onHost.sphere, onDevice.sphere);
    addRow(encoding, bits, "hemisphere", onHost.hemisphere, onDevice.hemisphere);

    const std::vector<size_t> counts = addHistogram(encoding, bits, host);
    if (!pictures_) return;
    const Statistics& own = encoding.hemisphere ? onHost.hemisphere : onHost.sphere;
    const std::string label = fmt::format("{} {}: {:#.3g}/{:#.3g} deg", encoding.name,
                                          budgetName(bits, encoding.channels), own.mean(), own.maximum);
    maps.push_back({label, spherePicture(sphereMap(errorOf), topDegrees(bits))});
    histograms.push_back({label, histogramPicture(counts)});
  }

  void addRow(const render::NormalEncoding& encoding, uint32_t bits, const char* region, const Statistics& host,
              const Statistics& device) {
    const vec3 worst = direction(host.worst);
    table_.rows.push_back({encoding.name, budgetName(bits, encoding.channels), region, host.mean(), host.rms(),
                           host.maximum, device.mean(), device.rms(), device.maximum, double{worst.x}, double{worst.y},
                           double{worst.z}});
  }

  std::vector<size_t> addHistogram(const render::NormalEncoding& encoding, uint32_t bits,
                                   const std::vector<double>& errors) {
    const double top = topDegrees(bits), step = top / kHistogramBins;
    const std::vector<size_t> counts = histogramOf(errors, directions_.even, top, kHistogramBins, [&](size_t i) {
      return !encoding.hemisphere || directions_.all[i].z >= 0;
    });
    for (size_t i = 0; i < counts.size(); ++i)
      histogram_.rows.push_back({encoding.name, budgetName(bits, encoding.channels), double(i) * step,
                                 i + 1 < counts.size() ? double(i + 1) * step : 180.0, double(counts[i])});
    return counts;
  }

  DeviceEvaluation device_;
  Directions directions_;
  std::vector<uint32_t> bits_;
  bool pictures_;
  Table table_, histogram_;
  Result result_;
};

}  // namespace

Result studyNormals(const Options& options) {
  return NormalStudy(options).run();
}

}  // namespace latelight::study
