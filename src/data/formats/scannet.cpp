// The format "scannet": the folders that ScanNet's SensReader and its archives of 2D annotations unpack (Dai et al.
// 2017, "ScanNet: Richly-annotated 3D Reconstructions of Indoor Scenes"). Each variation of a scene is a scan.
#include <fmt/format.h>
#include <turbojpeg.h>

#include <memory>

#include "base/error.h"
#include "base/text.h"
#include "data/formats/camera_support.h"
#include "data/formats/depth_png.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/object_numbers.h"
#include "data/formats/options.h"
#include "output/png.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
using output::Aov;

constexpr double kStepsPerMeter = 1000;
constexpr uint32_t kMaxNumber = 65535;  // of a 16-bit PNG

// A frame's files in the folder of its scan.
struct Image {
  const char *folder, *extension;
};
constexpr Image kColor{"color", "jpg"}, kDepth{"depth", "png"}, kPose{"pose", "txt"}, kInstances{"instance", "png"},
    kLabels{"label", "png"};

// The files of a scan, below its folder.
constexpr const char* kIntrinsics[] = {"/intrinsic/intrinsic_color.txt", "/intrinsic/intrinsic_depth.txt"};
constexpr const char* kExtrinsics[] = {"/intrinsic/extrinsic_color.txt", "/intrinsic/extrinsic_depth.txt"};
constexpr const char* kLabelTable = "/labels.tsv";

// Chroma is not subsampled, so that edges stay sharp.
std::vector<std::byte> encodeJpeg(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t height, int quality) {
  const std::unique_ptr<void, int (*)(void*)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* file = nullptr;
  unsigned long bytes = 0;
  const bool encoded =
      encoder && tjCompress2(encoder.get(), rgb.data(), static_cast<int>(width), 0, static_cast<int>(height), TJPF_RGB,
                             &file, &bytes, TJSAMP_444, quality, TJFLAG_ACCURATEDCT) == 0;
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(file, tjFree);
  if (!encoded) fail(ExitCode::Internal, "an image could not be encoded: {}", tjGetErrorStr2(encoder.get()));
  const auto* begin = reinterpret_cast<const std::byte*>(file);
  return {begin, begin + bytes};
}

std::string matrixText(const glm::dmat4& m) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", m[0][row], m[1][row], m[2][row], m[3][row]);
  return text;
}

// ScanNet's pixel centers are whole numbers, which moves the principal point by half a pixel.
std::string intrinsicText(const std::array<double, 9>& k) {
  glm::dmat4 m(1);
  m[0][0] = k[0];
  m[1][1] = k[4];
  m[2][0] = k[2] - 0.5;
  m[2][1] = k[5] - 0.5;
  return matrixText(m);
}

std::vector<std::byte> numbersPng(const output::AovImage& image, const std::vector<uint32_t>& numbers, uint32_t bits) {
  const std::vector<std::byte> pixels = packNumbers(numbers, bits / 8);
  return output::encodePng(image.width, image.height, 1, bits, pixels.data(), output::PngLight::Data);
}

class Scannet : public Format {
 public:
  explicit Scannet(const Json& json) : categories_("scannet", nullptr) {
    FormatOptions options("scannet", json);
    folder_ = options.setFolder("folder", "scans");
    categories_ = Categories("scannet", options.find("categories"));
    quality_ = static_cast<int>(options.number("quality", 95, 1, 100));
    options.finish();
  }

  std::vector<Aov> needs() const override { return {Aov::Depth, Aov::Id}; }
  bool needsDisplay() const override { return true; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files;
    for (const Image& image : {kColor, kDepth, kPose, kInstances, kLabels}) files.push_back({fileOf(frame, image)});
    for (const char* name : kIntrinsics) files.push_back({.name = scanOf(frame) + name, .ofSet = true});
    for (const char* name : kExtrinsics) files.push_back({.name = scanOf(frame) + name, .ofSet = true});
    files.push_back({.name = scanOf(frame) + kLabelTable, .ofSet = true});
    return files;
  }

  void check(const DataFrame& frame) const override { requirePinhole("scannet", frame.metadata.camera); }
  void checkTogether(const DataFrame& first, const DataFrame& other) const override {
    const output::CameraMetadata &a = first.metadata.camera, &b = other.metadata.camera;
    if (intrinsicText(a.intrinsics) != intrinsicText(b.intrinsics) || first.picture.width != other.picture.width ||
        first.picture.height != other.picture.height)
      badUsage(
          "the format scannet has one camera matrix and size per scan, but those of the cameras \"{}\" and \"{}\" "
          "differ: choose other cameras or another format",
          a.name, b.name);
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const output::CameraMetadata& camera = frame.metadata.camera;
    const output::FrameOutput& picture = frame.picture;
    const auto write = [&](const Image& image, std::span<const std::byte> bytes) {
      writeOf(record, folder, fileOf(frame, image), bytes);
    };
    write(kColor, encodeJpeg(rgbOverBlack(picture), picture.width, picture.height, quality_));
    write(kDepth, encodeDepthPng(imageOf(picture, Aov::Depth), kStepsPerMeter));
    const std::string pose = matrixText(glm::inverse(openCvFromWorld(camera)));
    write(kPose, std::as_bytes(std::span(pose)));
    const std::shared_ptr<const ObjectNumbers> numbers = scenes_.of(frame, categories_);
    if (numbers->instances() > kMaxNumber)
      badUsage("the format scannet numbers up to {} objects per scene, not {}: make groups with --id-depth", kMaxNumber,
               numbers->instances());
    const output::AovImage& ids = imageOf(picture, Aov::Id);
    // ScanNet has 8 bits per pixel; scenes with more objects require 16.
    write(kInstances, numbersPng(ids, numbers->instancesOf(ids), numbers->instances() > 255 ? 16 : 8));
    write(kLabels, numbersPng(ids, numbers->categoriesOf(ids), 16));
    record.entry = {
        {"scan", scanOf(frame)}, {"intrinsic", intrinsicText(camera.intrinsics)}, {"labels", numbers->categories()}};
  }

  // The files of each scan, from its frames.
  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    std::map<std::string, std::vector<const Json*>> scans;
    for (const Json& entry : entries) scans[entry["scan"].get<std::string>()].push_back(&entry);
    std::vector<std::string> written;
    for (const auto& entry : scans) {
      const std::string& scan = entry.first;
      const Json& frame = *entry.second.front();
      const auto write = [&](const std::string& name, const std::string& text) {
        writeIn(folder, scan + name, std::as_bytes(std::span(text)));
        written.push_back(scan + name);
      };
      // checkTogether() ensures that all frames of a scan have the same camera matrix.
      for (const char* name : kIntrinsics) write(name, frame["intrinsic"]);
      for (const char* name : kExtrinsics) write(name, matrixText(glm::dmat4(1)));
      write(kLabelTable, labelText(frame["labels"]));
    }
    return written;
  }

 private:
  // The name of a scan's folder, without the slash at its end.
  std::string scanOf(const DataFrame& frame) const {
    return fmt::format("{}/scene{:04}_{:02}", folder_, frame.scene, frame.variation);
  }
  std::string fileOf(const DataFrame& frame, const Image& image) const {
    return fmt::format("{}/{}/{}.{}", scanOf(frame), image.folder, frame.camera, image.extension);
  }

  // Returns a field of a tab-separated table as RFC 4180 defines it for commas: text with quotation marks is quoted,
  // and its marks are doubled. White space that ends a field or a line becomes a space, because many readers of such
  // tables split lines at tabs.
  static std::string field(std::string text) {
    std::ranges::replace_if(
        text, [](char c) { return c == '\t' || c == '\n' || c == '\r'; }, ' ');
    if (text.find('"') == std::string::npos) return text;
    replaceAll(text, "\"", "\"\"");
    return '"' + text + '"';
  }

  // The first columns of scannetv2-labels.combined.tsv.
  static std::string labelText(const Json& labels) {
    std::string text = "id\traw_category\tcategory\n";
    for (size_t i = 0; i < labels.size(); ++i) {
      const std::string name = field(labels[i]);
      text += fmt::format("{}\t{}\t{}\n", i + 1, name, name);
    }
    return text;
  }

  std::string folder_;
  Categories categories_;
  int quality_ = 95;
  mutable NumberedScenes scenes_;
};

}  // namespace

std::unique_ptr<Format> makeScannet(const Json& options) {
  return std::make_unique<Scannet>(options);
}

}  // namespace latelight::data
