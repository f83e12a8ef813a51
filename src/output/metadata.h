// The metadata that a reader of the files needs in addition to the pixels, and the JSON side file that holds it.
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
  // The camera matrix K, row-major, in pixels. A point p = (x, y, z) in the camera frame is projected to pixel
  // coordinate ((K row 0).p / w, (K row 1).p / w) with w = (K row 2).p; for an orthographic camera K multiplies (x, y,
  // 1) instead. Pixel centers are at half-integers: the center of the first pixel, top left, is (0.5, 0.5), so a
  // centered principal point is (width / 2, height / 2).
  std::array<double, 9> intrinsics{1, 0, 0, 0, 1, 0, 0, 0, 1};
  glm::dmat4 cameraToWorld{1};  // for column vectors, in the camera frame that `convention` names
  // "opencv": X right, Y down, Z forward. "opengl": X right, Y up, Z backward.
  std::string convention = "opencv";
  bool orthographic = false;
  // A lens with distortion, calibrated for the image's size. `intrinsics` apply to the distorted point, or not at all.
  std::optional<scene::Lens> lens;
  double nearClip = 0, farClip = 0;  // meters; farClip may be +inf
  // A thin lens, in meters. The radius is 0 for a pinhole.
  double apertureRadius = 0, focusDistance = 0;
};

// A frame to which the output motion leads.
struct NeighborFrame {
  std::string name;            // its name in the data set; empty: not part of the set
  std::optional<double> time;  // scene time in seconds; empty: at rest
};
struct NeighborFrames {
  std::optional<NeighborFrame> previous, next;  // empty: there is no such frame, and motion to it is NaN
};
nlohmann::ordered_json describe(const NeighborFrames& neighbors);

struct DeviceMetadata {
  std::string name, driver, uuid;
};

struct Metadata {
  std::string scene;         // the scene's name: {scene}
  std::string source;        // the scene as the user named it
  uint32_t frame = 0;        // {frame}
  uint32_t frameDigits = 4;  // width of the frame number, zero-padded
  CameraMetadata camera;
  // The frame of positions and poses: "gltf" (X right, Y up, Z towards the viewer) or "z-up".
  std::string axes = "gltf";
  // The frame of `normal` and `geonormal`: "world" (that of `axes`), "opencv" or "opengl".
  std::string normalFrame = "world";
  float exposure = 1;    // linear factor by which color was multiplied
  bool metered = false;  // the factor was metered: the file also states it in EV and as a camera's EV100
  // Not written if its name is empty.
  DeviceMetadata device;
  std::map<std::string, std::string> versions;  // program, API, ...
  std::map<std::string, std::string> settings;  // the options that affect the image, as on the command line
  std::shared_ptr<const IdManifest> ids;        // null: unknown
  std::optional<NeighborFrames> neighbors;      // set for a frame of a data set with the output motion
  std::string idManifest;  // file next to the side file that holds the ids in its place; empty: none
};

// Returns the coefficients of the lens model in OpenCV's order, or null if the model has none.
nlohmann::ordered_json distortionOf(const scene::Lens& lens);
// Returns the rows of a matrix in the form that JSON files use.
nlohmann::ordered_json rowsOf(const glm::dmat4& m);
nlohmann::ordered_json rowsOf(const std::array<double, 9>& m);  // of a row-major matrix of 3x3 numbers

// Returns the EV100 of the camera that has this exposure factor: its sensor saturates at a luminance of 1.2 * 2^EV100
// (Lagarde and de Rousiers 2014, Moving Frostbite to Physically Based Rendering, section 5.1.2).
double ev100Of(float exposure);

// Returns the complete side file as JSON text. The same input produces the same bytes. `files` are the names of the
// written files, one per AOV, relative to the side file.
std::string sideFile(const Metadata& metadata, uint32_t width, uint32_t height, std::span<const Aov> aovs,
                     std::span<const std::string> files, ChannelNames names = ownNames);

}  // namespace latelight::output
