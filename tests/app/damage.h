// Valid files, and a thousand ways to damage them. Every run uses the same cases.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/folder.h"
#include "models/models.h"

namespace latelight::app {

using namespace models;

struct GoodScene {
  std::string name;                    // used in messages
  std::string main;                    // the file to load
  std::map<std::string, Bytes> files;  // by name, including `main`
};

// Valid scenes: files that the tests create, and the installed files of assimp-testmodels and ../shared/models.
const std::vector<GoodScene>& goodScenes();

// Environment pictures.
const std::vector<GoodScene>& goodPictures();

struct Damage {
  std::string what;  // "textured.glb: 4 bytes at 17 of textured.glb become ff ff ff ff"
  std::string main;
  std::map<std::string, Bytes> files;
};

// Damages one file of one entry of `good`: truncates it, or changes some of its bits, bytes, words, numbers or ranges.
// The result depends only on `seed`.
Damage damage(const std::vector<GoodScene>& good, uint32_t seed);

// Writes the files and returns the path of the main one.
std::filesystem::path writeTo(const Folder& folder, const Damage& damage);

}  // namespace latelight::app
