// The camera's sensor, after the lens: from the linear picture to electrons, digital numbers, and back to a picture.
//
//   linear picture -> vignetting -> color filters -> photons, well, read noise -> converter = raw
//     -> white balance -> interpolation of the mosaic -> linear picture -> response curve or tone mapping -> 8 bits
//     -> JPEG
//
// The noise follows the linear camera model of EMVA Standard 1288 (release 4.0, 2021, section 2): the number of
// electrons is Poisson distributed, reading adds normally distributed noise, and the converter rounds. All of it runs
// on the host, where several strips and rows are one picture. Noise depends only on the seeds, the pixel and the
// signal.
#pragma once

#include "output/files.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::render {

// Returns true if applySensor() changes or adds anything.
bool usesSensor(const Settings& settings);
// Throws Error(Usage) for options that the sensor does not support with the requested outputs.
void checkSensor(const Settings& settings);
// Returns the settings with which the device renders the pictures that applySensor() then completes: with the linear
// picture among the outputs, if the sensor reads it. Throws the errors of checkSensor().
Settings sensedSettings(const Settings& settings);
// Returns the settings with an ideal sensor, whose pictures are the light that reaches the lens.
Settings idealSensorSettings(const Settings& settings);

// Completes a picture that was rendered with sensedSettings(), and drops outputs that `settings` do not request.
void applySensor(output::FrameOutput& picture, const Settings& settings, const scene::Camera& camera);

// Replaces the colors of an RGBA picture by those that compression with this quality and 4:2:0 chroma returns.
void addJpegArtifacts(std::vector<uint8_t>& rgba, uint32_t width, uint32_t height, uint32_t quality);

}  // namespace latelight::render
