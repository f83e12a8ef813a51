// `latelight devices`: lists every Vulkan device and states if it can be used.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/commands.h"
#include "base/log.h"
#include "vk/added_drivers.h"
#include "vk/device.h"

namespace latelight::app {

namespace {

std::optional<uint32_t> automaticChoice(const std::vector<vk::DeviceInfo>& devices) {
  try {
    return vk::chooseDevice(devices, "auto").device.index;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void printJson(const std::vector<vk::DeviceInfo>& devices, std::optional<uint32_t> automatic) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const vk::DeviceInfo& device : devices)
    json.push_back({{"index", device.index},
                    {"name", device.name},
                    {"type", device.type},
                    {"uuid", device.uuid},
                    {"vulkan", device.apiVersion},
                    {"driver", device.driver},
                    {"memory_bytes", device.memory},
                    {"usable", device.missing.empty()},
                    {"auto", device.index == automatic},
                    {"missing", device.missing}});
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

void printTable(const std::vector<vk::DeviceInfo>& devices, std::optional<uint32_t> automatic) {
  using Row = std::array<std::string, 7>;
  std::vector<Row> rows{{"", "name", "type", "vulkan", "memory", "driver", "uuid"}};
  for (const vk::DeviceInfo& device : devices)
    rows.push_back({fmt::format("{}", device.index), device.name, device.type, device.apiVersion,
                    fmt::format("{:.1f} GiB", static_cast<double>(device.memory) / (1 << 30)), device.driver,
                    device.uuid});
  std::array<size_t, 7> widths{};
  for (const Row& row : rows)
    for (size_t column = 0; column < row.size(); ++column)
      widths[column] = std::max(widths[column], row[column].size());
  for (size_t line = 0; line < rows.size(); ++line) {
    for (size_t column = 0; column + 1 < widths.size(); ++column)
      fmt::print("{:<{}}  ", rows[line][column], widths[column]);
    fmt::print("{}\n", rows[line].back());
    if (line > 0 && !devices[line - 1].missing.empty())
      fmt::print("   can't be used: it lacks {}\n", fmt::join(devices[line - 1].missing, ", "));
  }
  for (const vk::AddedDriver& driver : vk::addedDrivers()) fmt::print("{}\n", printable(driver.why));
  if (automatic) fmt::print("--device auto takes {}.\n", *automatic);
}

}  // namespace

void addDevicesCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("devices", "List the Vulkan devices and whether they are usable");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print JSON");
  command->callback([json] {
    const std::vector<vk::DeviceInfo> devices = vk::listDevices();
    if (devices.empty() && !*json)
      fail(ExitCode::NoDevice, "There is no Vulkan device: run `latelight doctor` to find out what is missing.");
    const std::optional<uint32_t> automatic = automaticChoice(devices);
    *json ? printJson(devices, automatic) : printTable(devices, automatic);
    if (!automatic) throw Exit{ExitCode::NoDevice};
  });
}

}  // namespace latelight::app
