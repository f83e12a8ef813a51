// Writes the models of the tests to a folder, for inspection and measurement.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "models/models.h"

int main(int count, char** arguments) {
  using namespace latelight::models;
  if (count != 2) {
    std::fprintf(stderr, "usage: make_models FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  std::filesystem::create_directories(folder);
  for (const auto& [name, bytes] : allModels()) {
    std::ofstream file(folder / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "can't write %s\n", (folder / name).c_str());
      return 1;
    }
  }
}
