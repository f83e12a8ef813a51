// Checks the scenes and cameras of a job before anything is rendered.
#pragma once

#include <functional>
#include <string>

#include "data/batch/loaded_scene.h"

namespace latelight::data {

// Throws Error(Usage) if the job's options require a light or an environment that the scene does not have.
void checkScene(const Job& job, const LoadedScene& loaded);

// Throws Error(Usage) if the renderer or one of the job's formats does not support a camera of the scene with the job's
// options. `frameName` returns the name of a frame of the camera with a name.
void checkCameras(const Job& job, const LoadedScene& loaded,
                  const std::function<std::string(const std::string& camera)>& frameName);

}  // namespace latelight::data
