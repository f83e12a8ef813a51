// Reads and writes the text files of COLMAP models.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "base/error.h"
#include "base/files.h"
#include "data/cameras/colmap.h"
#include "data/cameras/text_lines.h"

namespace latelight::data {

namespace {

// Reads lines of CAMERA_ID MODEL WIDTH HEIGHT PARAMS...
std::map<std::string, scene::Lens, std::less<>> readLensesText(const std::filesystem::path& file) {
  std::map<std::string, scene::Lens, std::less<>> lenses;
  TextLines lines(file);
  while (const auto line = lines.nextUsed()) {
    const std::vector<std::string_view> words = lines.words(*line, 4);
    const ColmapModel* model = findColmapModel(words[1]);
    if (!model) badInput("{} has the unknown camera model {}", lines.where(), words[1]);
    if (words.size() != 4 + model->parameters)
      badInput("{} has {} parameters, and {} has {}", lines.where(), words.size() - 4, model->name, model->parameters);
    const std::vector<double> numbers = lines.numbers(words, 2, words.size() - 2);
    const auto lens = lensOfColmap(*model, numbers[0], numbers[1], std::span(numbers).subspan(2), lines.where());
    if (!lenses.try_emplace(std::string(words[0]), lens).second)
      badInput("{} has the camera {} a second time", lines.where(), words[0]);
  }
  return lenses;
}

std::string pointsText(std::span<const ColmapPoint> points, const ColmapFeatures& features) {
  std::string text = "# POINT3D_ID X Y Z R G B ERROR TRACK[]\n";
  for (size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3& p = points[i].position;
    text += fmt::format("{} {} {} {} {} 0", i + 1, p.x, p.y, p.z, fmt::join(points[i].color, " "));
    for (size_t k = 0; k < points[i].track.size(); ++k)
      text += fmt::format(" {} {}", points[i].track[k].image + 1, features.ofPoint[i][k]);
    text += "\n";
  }
  return text;
}

}  // namespace

// images.txt has two lines per image: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and the points, which may be an
// empty line.
std::vector<CalibratedCamera> readColmapText(const std::filesystem::path& folder) {
  const auto lenses = readLensesText(folder / "cameras.txt");
  TextLines lines(folder / "images.txt");
  std::vector<CalibratedCamera> cameras;
  CameraMemory memory;
  while (const auto line = lines.nextUsed()) {
    const std::vector<std::string_view> words = lines.words(*line, 10);
    const std::vector<double> n = lines.numbers(words, 1, 7);
    const auto lens = lenses.find(words[8]);
    if (lens == lenses.end())
      badInput("{} has the camera {}, which is missing from cameras.txt", lines.where(), words[8]);
    const glm::dmat4 pose = poseOfColmap({{n[0], n[1], n[2], n[3]}, {n[4], n[5], n[6]}}, lines.where());
    // A name may contain spaces.
    const std::string name(line->substr(static_cast<size_t>(words[9].data() - line->data())));
    CalibratedCamera camera{name, lens->second, pose};
    memory.add(camera);
    cameras.push_back(std::move(camera));
    lines.next();
  }
  if (cameras.empty()) badInput("{} has no images", (folder / "images.txt").string());
  return cameras;
}

void writeColmapText(const std::filesystem::path& folder, std::span<const CalibratedCamera> cameras,
                     std::span<const ColmapPoint> points) {
  const ColmapLenses lenses = differentLenses(cameras);
  const ColmapFeatures features = featuresOf(cameras.size(), points);
  FileGroup files;
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (size_t i = 0; i < lenses.cameras.size(); ++i) {
    const ColmapCamera camera = colmapCameraOf(*lenses.cameras[i]);
    text += fmt::format("{} {} {} {} {}\n", i + 1, camera.model->name, lenses.cameras[i]->lens->width,
                        lenses.cameras[i]->lens->height, fmt::join(camera.parameters, " "));
  }
  files.add(folder / "cameras.txt", std::as_bytes(std::span(text)));
  text = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# POINTS2D[]\n";
  for (size_t i = 0; i < cameras.size(); ++i) {
    const auto [q, t] = colmapPoseOf(cameras[i].pose);
    text += fmt::format("{} {} {} {} {} {} {} {} {} {}\n", i + 1, q[0], q[1], q[2], q[3], t.x, t.y, t.z,
                        lenses.lensOf[i] + 1, cameras[i].name);
    for (const ColmapFeature& feature : features.ofImage[i])
      text += fmt::format("{} {} {} ", feature.pixel.x, feature.pixel.y, feature.point + 1);
    if (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  files.add(folder / "images.txt", std::as_bytes(std::span(text)));
  text = pointsText(points, features);
  files.add(folder / "points3D.txt", std::as_bytes(std::span(text)));
  files.commit();
}

}  // namespace latelight::data
