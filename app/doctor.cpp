// `latelight doctor`: reports missing components and how to install them.
#include "vk/doctor.h"

#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "base/log.h"
#include "render/submit/raster_choice.h"
#include "vk/device.h"

namespace latelight::app {

namespace {

// Reports the raster that `auto` selects on the device that `auto` selects.
vk::Finding examineRaster() {
  try {
    vk::Device device;
    const render::RasterChoice choice = render::chooseRaster(device, {}, {});
    return {true, fmt::format("`--raster auto` chooses {}: {}.", render::nameOf(choice.raster), choice.why), ""};
  } catch (const Error& error) {
    return {false, fmt::format("Rasterization cannot be measured: {}", error.what()), ""};
  }
}

void printText(const vk::Diagnosis& diagnosis) {
  for (const vk::Finding& finding : diagnosis.findings) {
    fmt::print("{} {}\n", finding.ok ? "ok     " : "problem", printable(finding.sentence));
    if (!finding.remedy.empty()) fmt::print("        {}\n", finding.remedy);
  }
  fmt::print("{}\n", diagnosis.usable ? "Latelight can render on this machine."
                                      : "Latelight cannot render on this machine yet.");
}

void printJson(const vk::Diagnosis& diagnosis) {
  nlohmann::ordered_json json{{"usable", diagnosis.usable}, {"findings", nlohmann::ordered_json::array()}};
  for (const vk::Finding& finding : diagnosis.findings)
    json["findings"].push_back({{"ok", finding.ok}, {"sentence", finding.sentence}, {"remedy", finding.remedy}});
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

void addDoctorCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("doctor", "Diagnose this machine: what is missing, and how to install it");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->callback([json] {
    vk::Diagnosis diagnosis = vk::diagnose();
    if (diagnosis.usable) diagnosis.findings.push_back(examineRaster());
    *json ? printJson(diagnosis) : printText(diagnosis);
    if (!diagnosis.usable) throw Exit{ExitCode::NoDevice};
  });
}

}  // namespace latelight::app
