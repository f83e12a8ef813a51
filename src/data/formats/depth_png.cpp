// The format "depth-png": depth or distance as a 16-bit PNG file.
#include <fmt/format.h>

#include <span>

#include "base/error.h"
#include "data/formats/depth_png.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "output/png.h"

namespace latelight::data {

namespace {

class DepthPng : public Format {
 public:
  explicit DepthPng(const nlohmann::ordered_json& json) {
    FormatOptions options("depth-png", json);
    file_ = options.frameFile("file", "depth/{name}.png", ".png");
    aov_ = options.choice("output", {"depth", "distance"}) == "depth" ? output::Aov::Depth : output::Aov::Distance;
    if (options.find("unit") && options.find("scale"))
      badUsage("the format depth-png has a \"unit\" and a \"scale\", which replaces it: remove one of them");
    const bool kitti = options.choice("unit", {"mm", "kitti"}) == "kitti";
    stepsPerMetre_ = 1000 / options.number("scale", kitti ? 1000.0 / 256 : 1, 1e-3, 1e4);
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return {aov_}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    return {{frameFile(file_, frame), depthPngContents(aov_, stepsPerMetre_)}};
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    writeOf(record, folder, frameFile(file_, frame), encodeDepthPng(imageOf(frame.picture, aov_), stepsPerMetre_));
  }

 private:
  std::string file_;
  output::Aov aov_;
  double stepsPerMetre_;
};

void quantize(std::span<const float> depth, double stepsPerMetre, uint16_t* out) {
  for (size_t i = 0; i < depth.size(); ++i) {
    // Without branches and calls, so that it vectorizes. Below 65536 truncation is floor().
    const double step = depth[i] * stepsPerMetre + 0.5;
    const bool fits = (step >= 1) & (step < 65536);
    out[i] = static_cast<uint16_t>(static_cast<int32_t>(fits ? step : 0.0));
  }
}

}  // namespace

std::vector<uint16_t> depthSteps(const output::AovImage& depth, double stepsPerMetre) {
  std::vector<uint16_t> steps(depth.values.size());
  quantize(depth.values, stepsPerMetre, steps.data());
  return steps;
}

std::vector<std::byte> encodeDepthPng(const output::AovImage& depth, double stepsPerMetre) {
  const output::PngLayout layout{depth.width, depth.height, 1, 16};
  return output::encodePng(layout, [&](size_t begin, size_t end, std::byte* out) {
    const std::span<const float> values(depth.values);
    quantize(values.subspan(begin * depth.width, (end - begin) * depth.width), stepsPerMetre,
             reinterpret_cast<uint16_t*>(out));
  });
}

std::string depthPngContents(output::Aov aov, double stepsPerMetre) {
  return fmt::format("PNG of {}, {} steps per meter", output::info(aov).name, stepsPerMetre);
}

std::unique_ptr<Format> makeDepthPng(const nlohmann::ordered_json& options) {
  return std::make_unique<DepthPng>(options);
}

}  // namespace latelight::data
