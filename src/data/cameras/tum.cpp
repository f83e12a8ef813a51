#include "data/cameras/tum.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"
#include "data/cameras/text_lines.h"

namespace latelight::data {

std::vector<CalibratedCamera> readTum(const std::filesystem::path& file) {
  TextLines lines(file);
  std::vector<CalibratedCamera> cameras;
  CameraMemory memory;
  while (const auto line = lines.nextUsed()) {
    const std::vector<std::string_view> words = lines.words(*line, 8);
    const std::vector<double> n = lines.numbers(words, 0, 8);
    CalibratedCamera camera{.name = std::string(words[0]), .pose = glm::dmat4(rotationOf({n[7], n[4], n[5], n[6]}))};
    camera.pose[3] = {n[1], n[2], n[3], 1};
    if (!makeRigid(camera.pose)) badInput("{} has a pose that is no rotation and translation", lines.where());
    memory.add(camera);
    cameras.push_back(std::move(camera));
  }
  if (cameras.empty()) badInput("{} has no poses", file.string());
  return cameras;
}

void writeTum(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const CalibratedCamera& camera : cameras) {
    if (!parseNumber<double>(camera.name)) badUsage("TUM's format requires times as names, not \"{}\"", camera.name);
    const glm::dvec4 q = quaternionOf(glm::dmat3(camera.pose));
    const glm::dvec4 t = camera.pose[3];
    text += fmt::format("{} {} {} {} {} {} {} {}\n", camera.name, t.x, t.y, t.z, q[1], q[2], q[3], q[0]);
  }
  writeFile(file, std::as_bytes(std::span(text)));
}

}  // namespace latelight::data
