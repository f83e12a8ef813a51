// Reads and writes the binary files of COLMAP models.
#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "data/cameras/colmap.h"

namespace latelight::data {

static_assert(std::endian::native == std::endian::little, "COLMAP's files are little-endian, and copied as they are");

namespace {

class BinaryFile {
 public:
  explicit BinaryFile(const std::filesystem::path& file)
      : file_(file), bytes_(readFile(file)), memory_(bytes_.size(), file.string()) {}

  std::string where() const { return fmt::format("byte {} of {}", at_, file_.string()); }
  bool done() const { return at_ == bytes_.size(); }

  template <typename T>
  T take() {
    need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  // Reads the number of entries that follow. Each entry has at least `bytesEach` bytes.
  uint64_t takeCount(uint64_t bytesEach) {
    const std::string begin = where();
    const auto count = take<uint64_t>();
    if (count > (bytes_.size() - at_) / bytesEach)
      badInput("{} declares {} entries, but the file is too short for them", begin, count);
    return count;
  }
  std::string takeText() {
    const void* end = at_ < bytes_.size() ? std::memchr(bytes_.data() + at_, 0, bytes_.size() - at_) : nullptr;
    if (!end) badInput("{} begins a name that does not end", where());
    std::string text(reinterpret_cast<const char*>(bytes_.data() + at_));
    at_ += text.size() + 1;
    return text;
  }
  void skip(uint64_t bytes) {
    need(bytes);
    at_ += bytes;
  }

 private:
  void need(uint64_t bytes) const {
    if (bytes > bytes_.size() - at_)
      badInput("{} ends at byte {} in the middle of an entry", file_.string(), bytes_.size());
  }

  std::filesystem::path file_;
  std::vector<std::byte> bytes_;
  MemoryClaim memory_;
  size_t at_ = 0;
};

std::map<uint32_t, scene::Lens> readLensesBinary(const std::filesystem::path& path) {
  BinaryFile file(path);
  std::map<uint32_t, scene::Lens> lenses;
  for (uint64_t left = file.takeCount(24); left > 0; --left) {
    const std::string where = file.where();
    const auto id = file.take<uint32_t>();
    const auto modelId = file.take<int32_t>();
    const ColmapModel* model = findColmapModel(modelId);
    if (!model) badInput("{} has the unknown camera model {}", where, modelId);
    const auto width = static_cast<double>(file.take<uint64_t>()), height = static_cast<double>(file.take<uint64_t>());
    std::vector<double> parameters(model->parameters);
    for (double& parameter : parameters) parameter = file.take<double>();
    if (!lenses.try_emplace(id, lensOfColmap(*model, width, height, parameters, where)).second)
      badInput("{} has the camera {} a second time", where, id);
  }
  return lenses;
}

CalibratedCamera readImage(BinaryFile& file, const std::map<uint32_t, scene::Lens>& lenses) {
  constexpr uint64_t kPointBytes = 24;  // two coordinates and a point's number
  const std::string where = file.where();
  file.take<uint32_t>();  // the image's number
  ColmapPose pose;
  for (int i = 0; i < 4; ++i) pose.rotation[i] = file.take<double>();
  for (int i = 0; i < 3; ++i) pose.translation[i] = file.take<double>();
  const auto lens = lenses.find(file.take<uint32_t>());
  if (lens == lenses.end()) badInput("{} has a camera that is missing from cameras.bin", where);
  CalibratedCamera camera{file.takeText(), lens->second, poseOfColmap(pose, where)};
  file.skip(file.takeCount(kPointBytes) * kPointBytes);
  return camera;
}

class BinaryText {
 public:
  template <typename T>
  void put(T value) {
    const auto* begin = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof(T));
  }
  void put(const std::string& text) {
    for (const char c : text) put(c);
    put('\0');
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

std::vector<std::byte> encodeLenses(const ColmapLenses& lenses) {
  BinaryText file;
  file.put(uint64_t{lenses.cameras.size()});
  for (uint32_t i = 0; i < lenses.cameras.size(); ++i) {
    const ColmapCamera camera = colmapCameraOf(*lenses.cameras[i]);
    file.put(i + 1);
    file.put(int32_t{camera.model->id});
    file.put(static_cast<uint64_t>(lenses.cameras[i]->lens->width));
    file.put(static_cast<uint64_t>(lenses.cameras[i]->lens->height));
    for (const double parameter : camera.parameters) file.put(parameter);
  }
  return file.take();
}

std::vector<std::byte> encodeImages(std::span<const CalibratedCamera> cameras, const ColmapFeatures& features) {
  const ColmapLenses lenses = differentLenses(cameras);
  BinaryText file;
  file.put(uint64_t{cameras.size()});
  for (uint32_t i = 0; i < cameras.size(); ++i) {
    const auto [q, t] = colmapPoseOf(cameras[i].pose);
    file.put(i + 1);
    for (int part = 0; part < 4; ++part) file.put(q[part]);
    for (int part = 0; part < 3; ++part) file.put(t[part]);
    file.put(lenses.lensOf[i] + 1);
    file.put(cameras[i].name);
    file.put(uint64_t{features.ofImage[i].size()});
    for (const ColmapFeature& feature : features.ofImage[i]) {
      file.put(feature.pixel.x);
      file.put(feature.pixel.y);
      file.put(feature.point + 1);
    }
  }
  return file.take();
}

std::vector<std::byte> encodePoints(std::span<const ColmapPoint> points, const ColmapFeatures& features) {
  BinaryText file;
  file.put(uint64_t{points.size()});
  for (size_t i = 0; i < points.size(); ++i) {
    file.put(uint64_t{i + 1});
    for (int axis = 0; axis < 3; ++axis) file.put(points[i].position[axis]);
    for (const uint8_t channel : points[i].color) file.put(channel);
    file.put(0.0);  // reprojection error
    file.put(uint64_t{points[i].track.size()});
    for (size_t k = 0; k < points[i].track.size(); ++k) {
      file.put(points[i].track[k].image + 1);
      file.put(features.ofPoint[i][k]);
    }
  }
  return file.take();
}

}  // namespace

std::vector<CalibratedCamera> readColmapBinary(const std::filesystem::path& folder) {
  const std::map<uint32_t, scene::Lens> lenses = readLensesBinary(folder / "cameras.bin");
  BinaryFile file(folder / "images.bin");
  std::vector<CalibratedCamera> cameras;
  CameraMemory memory;
  for (uint64_t left = file.takeCount(73); left > 0; --left) {
    CalibratedCamera camera = readImage(file, lenses);
    memory.add(camera);
    cameras.push_back(std::move(camera));
  }
  if (cameras.empty()) badInput("{} has no images", (folder / "images.bin").string());
  return cameras;
}

void writeColmapBinary(const std::filesystem::path& folder, std::span<const CalibratedCamera> cameras,
                       std::span<const ColmapPoint> points) {
  const ColmapFeatures features = featuresOf(cameras.size(), points);
  FileGroup files;
  files.add(folder / "cameras.bin", encodeLenses(differentLenses(cameras)));
  files.add(folder / "images.bin", encodeImages(cameras, features));
  files.add(folder / "points3D.bin", encodePoints(points, features));
  files.commit();
}

std::vector<CalibratedCamera> readColmap(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (std::filesystem::exists(folder / "cameras.bin", ignored)) return readColmapBinary(folder);
  if (std::filesystem::exists(folder / "cameras.txt", ignored)) return readColmapText(folder);
  badInput("{} has neither cameras.bin nor cameras.txt: give the folder of a COLMAP model", folder.string());
}

}  // namespace latelight::data
