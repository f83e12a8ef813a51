// The format "colmap": a COLMAP workspace with images, depth maps, and a sparse model per scene and variation
// (Schoenberger and Frahm 2016, "Structure-from-Motion Revisited"; the files are those of COLMAP's page "Output
// Format").
#include "data/cameras/colmap.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "base/error.h"
#include "base/files.h"
#include "data/formats/camera_support.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"
#include "data/formats/sparse_points.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "depth maps are written as they lie in memory");

constexpr uint32_t kDefaultSpacing = 16;  // pixels between points

// COLMAP's arrays: "width&height&channels&" and the floats by row. Background is 0.
std::vector<std::byte> encodeDepthMap(const output::AovImage& depth) {
  const std::string header = fmt::format("{}&{}&1&", depth.width, depth.height);
  std::vector<float> values = depth.values;
  for (float& value : values)
    if (std::isinf(value)) value = 0;
  std::vector<std::byte> bytes(header.size() + values.size() * sizeof(float));
  std::memcpy(bytes.data(), header.data(), header.size());
  std::memcpy(bytes.data() + header.size(), values.data(), values.size() * sizeof(float));
  return bytes;
}

// Reads a depth map of a view's size. Throws Error(BadInput) if the file has another size.
std::vector<float> readDepthMap(const fs::path& path, const PointView& view) {
  const std::vector<std::byte> bytes = readFile(path);
  std::vector<float> values(static_cast<size_t>(view.lens.width * view.lens.height));
  const size_t size = values.size() * sizeof(float);
  if (bytes.size() < size)
    badInput("'{}' is not the depth map that was written: remove it, and run the job with --resume", path.string());
  std::memcpy(values.data(), bytes.data() + bytes.size() - size, size);
  return values;
}

class Colmap : public Format {
 public:
  explicit Colmap(const Json& json) {
    FormatOptions options("colmap", json);
    isText_ = options.choice("as", {"binary", "text"}) == "text";
    folder_ = options.setFolder("folder", "sparse");
    spacing_ = static_cast<uint32_t>(options.number("points", kDefaultSpacing, 0, 4096));
    picture_ = PictureFile(options);
    options.finish();
  }

  std::vector<output::Aov> needs() const override {
    return spacing_ > 0 ? std::vector{output::Aov::Depth} : std::vector<output::Aov>();
  }
  bool needsDisplay() const override { return picture_.isWritten(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    if (spacing_ > 0) files.push_back({depthFile(imageName(frame)), "COLMAP's depth map"});
    for (std::string& file : modelFiles(frame.state)) files.push_back({.name = std::move(file), .ofSet = true});
    return files;
  }

  void check(const DataFrame& frame) const override {
    requirePerspective("colmap", frame.metadata.camera);
    colmapCameraOf({frame.metadata.camera.name, pointViewOf(frame).lens});  // throws if COLMAP has no such model
    // COLMAP reads a name in images.txt up to the first white space.
    if (const std::string image = imageName(frame); isText_ && image.find_first_of(" \t\n\v\f\r") != std::string::npos)
      badUsage(
          "the format colmap cannot write the name \"{}\", which has a blank, as text: choose \"as\": \"binary\", or "
          "names without blanks",
          image);
  }

  void writeFiles(const DataFrame& frame, const fs::path& folder, FrameRecord& record) const override {
    const std::string picture = picture_.write(record, frame, folder), image = imageName(frame);
    record.entry = {{"state", {frame.scene, frame.variation}},
                    {"picture", picture},
                    {"image", image},
                    {"view", describe(pointViewOf(frame))}};
    if (spacing_ > 0) {
      const std::string depth = depthFile(image);
      writeOf(record, folder, depth, encodeDepthMap(imageOf(frame.picture, output::Aov::Depth)));
      record.entry["depth"] = depth;
    }
  }

  // Writes a model per scene and variation, numbered from 0.
  std::vector<std::string> writeSet(const SetEntries& set, const fs::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    std::map<std::pair<uint32_t, uint32_t>, std::vector<const Json*>> states;
    for (const Json& entry : entries) states[{entry["state"][0], entry["state"][1]}].push_back(&entry);
    std::vector<std::string> written;
    uint64_t number = 0;
    for (const auto& [state, frames] : states) {
      writeModel(frames, folder, modelFolder(number));
      for (std::string& file : modelFiles(number++)) written.push_back(std::move(file));
    }
    return written;
  }

 private:
  // Returns the frame's picture relative to the folder of all pictures.
  std::string imageName(const DataFrame& frame) const { return picture_.file(frame).substr(picture_.folder().size()); }
  static std::string depthFile(const std::string& image) {
    return fmt::format("stereo/depth_maps/{}.geometric.bin", image);
  }
  std::string modelFolder(uint64_t number) const { return fmt::format("{}/{}", folder_, number); }
  std::vector<std::string> modelFiles(uint64_t number) const {
    std::vector<std::string> files;
    for (const char* file : {"cameras", "images", "points3D"})
      files.push_back(fmt::format("{}/{}.{}", modelFolder(number), file, isText_ ? "txt" : "bin"));
    return files;
  }

  void writeModel(const std::vector<const Json*>& frames, const fs::path& folder, const std::string& model) const {
    std::vector<PointView> views;
    std::vector<CalibratedCamera> cameras;
    for (const Json* frame : frames) {
      views.push_back(pointView((*frame)["view"]));
      cameras.push_back({(*frame)["image"], views.back().lens, views.back().worldFromCamera});
    }
    const auto pathOf = [&](size_t i, const char* key) { return folder / (*frames[i])[key].get<std::string>(); };
    std::vector<ColmapPoint> points;
    if (spacing_ > 0) {
      points = findSparsePoints(
          views, spacing_, [&](size_t i) { return readDepthMap(pathOf(i, "depth"), views[i]); },
          [&](size_t i) { return output::readImage(pathOf(i, "picture")); });
      // In COLMAP's models, at least two images show each point.
      std::erase_if(points, [](const ColmapPoint& point) { return point.track.size() < 2; });
    }
    std::error_code ignored;  // errors are reported when the files are written
    fs::create_directories(folder / model, ignored);
    (isText_ ? writeColmapText : writeColmapBinary)(folder / model, cameras, points);
  }

  bool isText_ = false;
  std::string folder_;
  uint32_t spacing_ = 0;  // 0: no points
  PictureFile picture_;
};

}  // namespace

std::unique_ptr<Format> makeColmap(const Json& options) {
  return std::make_unique<Colmap>(options);
}

}  // namespace latelight::data
