// latelight doctor: what is missing, and how to get it.
#include "vk/doctor.h"

#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "base/log.h"

namespace latelight::app {

namespace {

void printText(const vk::Diagnosis& diagnosis) {
  for (const vk::Finding& finding : diagnosis.findings) {
    fmt::print("{} {}\n", finding.ok ? "ok     " : "problem", printable(finding.sentence));
    if (!finding.remedy.empty()) fmt::print("        {}\n", finding.remedy);
  }
  fmt::print("{}\n", diagnosis.usable ? "Latelight can render here." : "Latelight can't render here yet.");
}

void printJson(const vk::Diagnosis& diagnosis) {
  nlohmann::ordered_json json{{"usable", diagnosis.usable}, {"findings", nlohmann::ordered_json::array()}};
  for (const vk::Finding& finding : diagnosis.findings)
    json["findings"].push_back({{"ok", finding.ok}, {"sentence", finding.sentence}, {"remedy", finding.remedy}});
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

void addDoctorCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("doctor", "Say what is missing to render here, and how to get it");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Findings as JSON");
  command->callback([json] {
    const vk::Diagnosis diagnosis = vk::diagnose();
    *json ? printJson(diagnosis) : printText(diagnosis);
    if (!diagnosis.usable) throw Exit{ExitCode::NoDevice};
  });
}

}  // namespace latelight::app
