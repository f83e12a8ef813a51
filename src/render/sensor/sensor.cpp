#include "render/sensor/sensor.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "render/outputs/outputs.h"
#include "render/sensor/development.h"
#include "render/sensor/exposure_plane.h"
#include "render/sensor/mosaic.h"
#include "render/sensor/vignetting.h"

namespace latelight::render {

using output::Aov;

namespace {

bool requestsRaw(const Settings& s) {
  return output::contains(s.aovs, Aov::Raw);
}

// Returns true if the picture differs from that of an ideal sensor.
bool changesPicture(const Settings& s) {
  return s.vignetting != Vignetting{} || s.bayer != Bayer::None || s.fullWell > 0 || s.whiteBalance != WhiteBalance{} ||
         !s.response.isDisplay();
}

output::AovImage& imageOf(output::FrameOutput& picture, Aov aov) {
  return *std::ranges::find(picture.aovs, aov, &output::AovImage::aov);
}

// Puts the light of a colored background behind premultiplied radiance, because a sensor has no alpha.
void addBackground(std::vector<float>& color, const Background& background) {
  if (background.kind != Background::Color) return;
  for (size_t i = 0; i < color.size(); i += 4) {
    for (int k = 0; k < 3; ++k) color[i + k] += (1 - color[i + 3]) * background.color[k];
    color[i + 3] = 1;
  }
}

}  // namespace

bool usesSensor(const Settings& s) {
  return showsPicture(s) && (changesPicture(s) || requestsRaw(s) || s.jpegQuality);
}

void checkSensor(const Settings& s) {
  const uint32_t highest = (1u << s.bitDepth) - 1;
  if (s.blackLevel >= highest)
    badUsage("--black-level {} must be below the highest value of --bit-depth {}, which is {}", s.blackLevel,
             s.bitDepth, highest);
  if (s.aa.fxaa && showsPicture(s) && changesPicture(s))
    badUsage("--aa fxaa smooths the finished picture, before which the sensor adds its noise: use ss2 or more");
}

Settings sensedSettings(const Settings& s) {
  checkSensor(s);
  if (!showsPicture(s) || (!changesPicture(s) && !requestsRaw(s))) return s;
  Settings sensed = s;
  if (changesPicture(s)) sensed.display = false;
  if (!output::contains(sensed.aovs, Aov::Color)) sensed.aovs.push_back(Aov::Color);
  return sensed;
}

Settings idealSensorSettings(const Settings& s) {
  static const Settings defaults;
  Settings ideal = s;
  ideal.vignetting = defaults.vignetting;
  ideal.bayer = defaults.bayer;
  ideal.fullWell = defaults.fullWell;
  ideal.gain = defaults.gain;
  ideal.readNoise = defaults.readNoise;
  ideal.bitDepth = defaults.bitDepth;
  ideal.blackLevel = defaults.blackLevel;
  ideal.noiseSeed = defaults.noiseSeed;
  ideal.whiteBalance = defaults.whiteBalance;
  ideal.response = defaults.response;
  ideal.jpegQuality = defaults.jpegQuality;
  return ideal;
}

void applySensor(output::FrameOutput& picture, const Settings& s, const scene::Camera& camera) {
  if (changesPicture(s) || requestsRaw(s)) {
    output::AovImage& color = imageOf(picture, Aov::Color);
    std::vector<float> light = color.values;
    addBackground(light, s.background);
    darken(light, s, camera);
    const SensorPlane raw = exposeSensor(light, s, camera.noiseSeed);
    if (requestsRaw(s)) imageOf(picture, Aov::Raw).values = mosaicOf(raw, s);
    if (changesPicture(s)) {
      color.values = linearPicture(raw, light, s);
      if (s.display) picture.display = developed(color.values, s);
    }
    if (!output::contains(s.aovs, Aov::Color))
      std::erase_if(picture.aovs, [](const output::AovImage& image) { return image.aov == Aov::Color; });
  }
  if (s.display && s.jpegQuality) addJpegArtifacts(picture.display, s.width, s.height, *s.jpegQuality);
}

}  // namespace latelight::render
