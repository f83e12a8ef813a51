// --correspond: where the surfaces of a frame are in a second picture, in a file of the data set format
// "correspondence".
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "app/render_options.h"
#include "labels/correspondence.h"
#include "output/metadata.h"

namespace latelight::app {

// Throws Error(Usage) for errors that can be detected before the scene is loaded.
void checkCorrespond(const RenderOptions& options);

// Returns the number of frames from a frame to its second picture; 0: both are at the same time.
int64_t stepToSecond(const RenderOptions& options);
// Returns the options with which `render` shows the second picture through its camera.
RenderOptions optionsOfSecond(const RenderOptions& options);

// Writes the file of a frame, whole or not at all, and returns its path. `metadata` describes the frame.
std::filesystem::path writeCorrespondence(const std::string& pattern, const labels::Correspondence& match,
                                          const output::Metadata& metadata);

}  // namespace latelight::app
