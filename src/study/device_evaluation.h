// Evaluates a compute shader as a function from vec4 to vec4 over many inputs, for measurements on the device.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "shared/lang.h"
#include "shared/projection.h"
#include "study/study.h"
#include "vk/device.h"
#include "vk/pipeline.h"
#include "vk/resources.h"

namespace latelight::study {

class DeviceEvaluation {
 public:
  // Opens the device and allocates buffers for a batch of inputs.
  explicit DeviceEvaluation(const Options& options);

  // Creates the pipeline of a shader of src/study that uses the push constants of evaluation.glsl.
  vk::Pipeline make(const char* shader, const std::vector<vk::Constant>& constants);
  // Returns the results for all inputs. `projection` is for shaders that use one.
  std::vector<shared::vec4> run(const vk::Pipeline& pipeline, std::span<const shared::vec4> inputs,
                                const shared::Projection& projection = {});

  std::string name() const { return device_.info().name; }
  // Throws Error(Internal) with the first message of the validation layers, if any.
  void expectSilence();

 private:
  vk::Device device_;
  vk::Buffer inputs_, outputs_;
};

}  // namespace latelight::study
