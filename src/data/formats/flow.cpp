// The format "flow": optical flow as Middlebury's .flo file (Baker et al. 2011, "A Database and Evaluation Methodology
// for Optical Flow") or as KITTI's PNG file.
#include <bit>
#include <cmath>
#include <cstring>

#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/known_flow.h"
#include "data/formats/options.h"
#include "output/png.h"

namespace latelight::data {

namespace {

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

constexpr float kUnknownFlow = 1e10f;  // as Middlebury's tools write it; they treat values above 1e9 as unknown

std::vector<std::byte> encodeFlo(uint32_t width, uint32_t height, std::vector<float> flow) {
  constexpr char kMagic[4] = {'P', 'I', 'E', 'H'};
  for (float& value : flow)
    if (std::isnan(value)) value = kUnknownFlow;
  std::vector<std::byte> bytes(sizeof(kMagic) + 8 + flow.size() * sizeof(float));
  std::memcpy(bytes.data(), kMagic, 4);
  std::memcpy(bytes.data() + 4, &width, 4);
  std::memcpy(bytes.data() + 8, &height, 4);
  std::memcpy(bytes.data() + 12, flow.data(), flow.size() * sizeof(float));
  return bytes;
}

// Encodes flow as 16-bit RGB: red and green are 64 v + 2^15. Blue is 1 for valid pixels, and 0 if the flow is unknown
// or out of range.
std::vector<std::byte> encodeKittiFlow(uint32_t width, uint32_t height, std::vector<float> flow) {
  std::vector<uint16_t> codes(flow.size() / 2 * 3, 0);
  for (size_t i = 0; i < flow.size() / 2; ++i) {
    const double u = std::floor(64.0 * flow[2 * i] + 32768.5), v = std::floor(64.0 * flow[2 * i + 1] + 32768.5);
    if (!(u >= 0 && u <= 65535 && v >= 0 && v <= 65535)) continue;
    codes[3 * i] = static_cast<uint16_t>(u);
    codes[3 * i + 1] = static_cast<uint16_t>(v);
    codes[3 * i + 2] = 1;
  }
  return output::encodePng(width, height, 3, 16, reinterpret_cast<const std::byte*>(codes.data()),
                           output::PngLight::Data);
}

class Flow : public Format {
 public:
  explicit Flow(const nlohmann::ordered_json& json) {
    FormatOptions options("flow", json);
    kitti_ = options.choice("as", {"flo", "kitti"}) == "kitti";
    file_ = options.frameFile("file", kitti_ ? "flow/{name}.png" : "flow/{name}.flo", kitti_ ? ".png" : ".flo");
    target_ = options.choice("to", {"next", "previous"}) == "next" ? FlowTarget::Next : FlowTarget::Previous;
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return flowOutputs(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{frameFile(file_, frame)}}; }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    writeOf(
        record, folder, frameFile(file_, frame),
        (kitti_ ? encodeKittiFlow : encodeFlo)(frame.picture.width, frame.picture.height, knownFlow(frame, target_)));
  }

 private:
  bool kitti_;
  std::string file_;
  FlowTarget target_;
};

}  // namespace

std::unique_ptr<Format> makeFlow(const nlohmann::ordered_json& options) {
  return std::make_unique<Flow>(options);
}

}  // namespace latelight::data
