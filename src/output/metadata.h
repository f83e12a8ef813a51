// Everything that a reader of the files must know besides the pixels, and the JSON side file with it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "output/aov.h"
#include "output/id_manifest.h"
#include "scene/lens.h"

namespace latelight::output {

struct CameraMetadata {
  std::string name;
  // A point (x, y, z) in the camera frame is seen at pixel coordinate ((K row 0).p / w, (K row 1).p / w), w = (K row
  // 2).p; for an orthographic camera K multiplies (x, y, 1) instead. Row-major, pixels. Pixel centres are at
  // half-integers: that of the first pixel, top left, is (0.5, 0.5), so a centred principal point is (width / 2, height
  // / 2).
  std::array<double, 9> intrinsics{1, 0, 0, 0, 1, 0, 0, 0, 1};
  glm::dmat4 cameraToWorld{1};  // for column vectors, in the camera frame that `convention` names
  // "opencv": X right, Y down, Z forward. "opengl": X right, Y up, Z backward.
  std::string convention = "opencv";
  bool orthographic = false;
  // One that bends rays, calibrated for the picture's size: `intrinsics` apply before its distortion, or not at all.
  std::optional<scene::Lens> lens;
  double nearClip = 0, farClip = 0;  // metres; farClip may be +inf
};

// A frame that the output motion leads to.
struct NeighborFrame {
  std::string name;            // its name in the data set; empty: the set does not have it
  std::optional<double> time;  // seconds of the scene; none: at rest
};
struct NeighborFrames {
  std::optional<NeighborFrame> previous, next;  // none: there is no such frame, and motion to it is NaN
};
nlohmann::ordered_json describe(const NeighborFrames& neighbors);

struct DeviceMetadata {
  std::string name, driver, uuid;
};

struct Metadata {
  std::string scene;         // the scene's name: {scene}
  std::string source;        // what the user named
  uint32_t frame = 0;        // {frame}
  uint32_t frameDigits = 4;  // width of the frame number, zero-padded
  CameraMetadata camera;
  // The frame that positions and poses are in: "gltf" (X right, Y up, Z towards the viewer) or "z-up".
  std::string axes = "gltf";
  // The frame that `normal` and `geonormal` are in: "world" (that of `axes`), "opencv" or "opengl".
  std::string normalFrame = "world";
  float exposure = 1;  // linear factor that colour was multiplied by
  // Without a name it is not said.
  DeviceMetadata device;
  std::map<std::string, std::string> versions;  // program, API, ...
  std::map<std::string, std::string> settings;  // the options that the picture depends on, as on the command line
  std::shared_ptr<const IdManifest> ids;        // null: not known
  std::optional<NeighborFrames> neighbors;      // of a frame of a data set with the output motion
  std::string idManifest;  // a file beside the side file that holds the ids instead of it; empty: none
};

// The coefficients that a lens's model has, in OpenCV's order; null: it has none.
nlohmann::ordered_json distortionOf(const scene::Lens& lens);
// The rows of a matrix, as JSON files have them.
nlohmann::ordered_json rowsOf(const glm::dmat4& m);

// The whole side file as JSON text. The same input gives the same bytes. `files` are the names of the files written,
// one per AOV, relative to the side file.
std::string sideFile(const Metadata& metadata, uint32_t width, uint32_t height, std::span<const Aov> aovs,
                     std::span<const std::string> files, ChannelNames names = ownNames);

}  // namespace latelight::output
