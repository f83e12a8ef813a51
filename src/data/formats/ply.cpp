// The format "ply": a point cloud of a frame's visible surfaces as binary PLY.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"

namespace latelight::data {

namespace {

static_assert(std::endian::native == std::endian::little, "points are written as they lie in memory");

constexpr size_t kPointBytes = 6 * sizeof(float) + 3 + sizeof(uint32_t);

std::string plyHeader(size_t points) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points);
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) text += fmt::format("property float {}\n", name);
  for (const char* name : {"red", "green", "blue"}) text += fmt::format("property uchar {}\n", name);
  return text + "property uint id\nend_header\n";
}

// Encodes one point per pixel that is not background.
std::vector<std::byte> encodePly(const output::FrameOutput& picture) {
  const std::vector<uint32_t>& ids = imageOf(picture, output::Aov::Id).ids;
  const float* positions = imageOf(picture, output::Aov::Position).values.data();
  const float* normals = imageOf(picture, output::Aov::Normal).values.data();
  const size_t points = ids.size() - static_cast<size_t>(std::ranges::count(ids, 0u));
  const std::string header = plyHeader(points);
  std::vector<std::byte> bytes(header.size() + points * kPointBytes);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::byte* at = bytes.data() + header.size();
  const auto put = [&](const void* values, size_t size) {
    std::memcpy(at, values, size);
    at += size;
  };
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == 0) continue;
    put(positions + 3 * i, 3 * sizeof(float));
    put(normals + 3 * i, 3 * sizeof(float));
    put(&picture.display[4 * i], 3);
    put(&ids[i], sizeof(uint32_t));
  }
  return bytes;
}

class Ply : public Format {
 public:
  explicit Ply(const nlohmann::ordered_json& json) {
    FormatOptions options("ply", json);
    file_ = options.frameFile("file", "points/{name}.ply", ".ply");
    options.finish();
  }

  std::vector<output::Aov> needs() const override {
    return {output::Aov::Position, output::Aov::Normal, output::Aov::Id};
  }
  bool needsDisplay() const override { return true; }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{frameFile(file_, frame)}}; }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    writeOf(record, folder, frameFile(file_, frame), encodePly(frame.picture));
  }

 private:
  std::string file_;
};

}  // namespace

std::unique_ptr<Format> makePly(const nlohmann::ordered_json& options) {
  return std::make_unique<Ply>(options);
}

}  // namespace latelight::data
