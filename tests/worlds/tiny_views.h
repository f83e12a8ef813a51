// A camera and options for small pictures of worlds.
#pragma once

#include <latelight/latelight.h>

#include <string>
#include <utility>
#include <vector>

namespace latelight::test {

// A camera at z = 4 that looks along -Z.
inline Camera frontCamera() {
  Camera camera;
  camera.cameraToWorld = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 4, 0, 0, 0, 1};
  return camera;
}

inline Options tinyOptions(std::vector<std::string> aovs) {
  Options options;
  options.width = 24;
  options.height = 16;
  options.aovs = std::move(aovs);
  return options;
}

}  // namespace latelight::test
