// Valid files, and a thousand ways to damage them. Each case is the same in every run.
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
  std::string name;                    // for messages
  std::string main;                    // the file to load
  std::map<std::string, Bytes> files;  // by name, `main` among them
};

// Made by the tests, and those of assimp-testmodels and ../shared/models that are installed.
const std::vector<GoodScene>& goodScenes();

// Environment pictures.
const std::vector<GoodScene>& goodPictures();

struct Damage {
  std::string what;  // "textured.glb: 4 bytes at 17 of textured.glb become ff ff ff ff"
  std::string main;
  std::map<std::string, Bytes> files;
};

// One file of one of `good` is cut, or some of its bits, bytes, words, numbers or ranges are changed. Without a trace
// of chance: `seed` says all.
Damage damage(const std::vector<GoodScene>& good, uint32_t seed);

// Writes its files and gives the path of the main one.
std::filesystem::path writeTo(const Folder& folder, const Damage& damage);

}  // namespace latelight::app
