// The format "exr": all outputs of a frame in one OpenEXR file.
#include <fmt/format.h>

#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "output/exr.h"

namespace latelight::data {

namespace {

using output::Aov;
using output::AovImage;

// Returns a channel's name in Blender's multilayer files, as a pass of the first view layer. Outputs that Blender lacks
// are named like a pass that a shader outputs.
std::string blenderNames(const output::AovInfo& aov, uint32_t channel) {
  const auto pass = [&](std::string_view name, std::string_view letters) {
    return fmt::format("ViewLayer.{}.{}", name, letters[channel]);
  };
  switch (aov.aov) {
    case Aov::Color:
      return pass("Combined", "RGBA");
    case Aov::Depth:
      return pass("Depth", "Z");
    case Aov::Normal:
      return pass("Normal", "XYZ");
    case Aov::Position:
      return pass("Position", "XYZ");
    case Aov::Uv:
      return pass("UV", "UV");
    case Aov::Motion:
      return pass("Vector", "XYZW");
    case Aov::Id:
      return pass("IndexOB", "X");
    case Aov::Material:
      return pass("IndexMA", "X");
    case Aov::Albedo:
      return pass("Denoising Albedo", "RGB");
    case Aov::Emissive:
      return pass("Emit", "RGB");
    default:
      return pass(aov.name, aov.channels == 1 ? "X" : aov.channels == 2 ? "UV" : "XYZ");
  }
}

// Converts motion vectors to Blender's convention: y points up, and Z and W lead from the next frame back to this one.
AovImage blenderVector(const AovImage& motion) {
  AovImage vector = motion;
  for (size_t i = 0; i < vector.values.size(); ++i)
    if (i % 4 == 1 || i % 4 == 2) vector.values[i] = -vector.values[i];
  return vector;
}

class Exr : public Format {
 public:
  explicit Exr(const nlohmann::ordered_json& json) {
    FormatOptions options("exr", json);
    outputs_ = options.outputs("outputs", {Aov::Color, Aov::Depth, Aov::Normal, Aov::Id});
    file_ = options.frameFile("file", "{name}.exr", ".exr");
    blender_ = options.choice("names", {"latelight", "blender"}) == "blender";
    idManifest_ = options.flag("id-manifest", true);
    options.finish();
  }

  std::vector<Aov> needs() const override { return outputs_; }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{frameFile(file_, frame)}}; }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    AovImage vector;
    std::vector<const AovImage*> images;
    for (const Aov aov : outputs_) {
      images.push_back(&imageOf(frame.picture, aov));
      if (!blender_ || aov != Aov::Motion) continue;
      vector = blenderVector(*images.back());
      images.back() = &vector;
    }
    output::ExrExtras extras{.idManifest = idManifest_};
    if (blender_) extras.names = blenderNames;
    writeOf(record, folder, frameFile(file_, frame), output::encodeExr(images, metadataOf(frame), extras));
  }

 private:
  std::vector<Aov> outputs_;
  std::string file_;
  bool blender_, idManifest_;
};

}  // namespace

std::unique_ptr<Format> makeExr(const nlohmann::ordered_json& options) {
  return std::make_unique<Exr>(options);
}

}  // namespace latelight::data
