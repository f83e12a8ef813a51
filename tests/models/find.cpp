#include <cstdio>

#include "models/models.h"
#include "scene/gltf_builder.h"

namespace latelight::models {

namespace {

std::filesystem::path realModel(const std::string& name) {
  return std::filesystem::path(LATELIGHT_SOURCE_DIR) / "../shared/models" / name;
}

}  // namespace

std::vector<std::string> withReal(std::vector<std::string> made, const std::vector<std::string>& real) {
  for (const std::string& name : real) {
    if (std::filesystem::exists(realModel(name)))
      made.push_back(name);
    else
      std::printf("the optional model %s is not there: only what the tests make is tested\n", name.c_str());
  }
  return made;
}

std::filesystem::path modelPath(const std::string& name) {
  static const scene::test::TemporaryFolder folder;
  static const std::map<std::string, Bytes> made = allModels();
  const auto found = made.find(name);
  if (found == made.end()) return realModel(name);
  const std::filesystem::path path = folder.path() / name;
  if (!std::filesystem::exists(path)) scene::test::writeBytes(path, found->second);
  return path;
}

}  // namespace latelight::models
