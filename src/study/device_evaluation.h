// A compute shader as a function from one vec4 to another, over many inputs: for measurements on the device.
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
  // The device, and buffers for a batch.
  explicit DeviceEvaluation(const Options& options);

  // A shader of src/study with the push constants of evaluation.glsl.
  vk::Pipeline make(const std::string& shader, const std::vector<vk::Constant>& constants);
  // Its results for all inputs. `projection` for those that use one.
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
