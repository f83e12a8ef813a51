// `latelight doctor` and `devices` as processes, with parts of the system hidden by environment variables.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"

namespace latelight::app {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

using Environment = std::map<std::string, std::string>;

Outcome run(std::vector<std::string> arguments, Environment environment = {}) {
  return latelight({.arguments = std::move(arguments), .environment = std::move(environment)});
}

// --- doctor ---------------------------------------------------------------------------------------------------------

TEST(Doctor, IsContentHere) {
  const Outcome text = run({"doctor"}), structured = run({"doctor", "--json"});
  EXPECT_EQ(text.code, 0) << text.text();
  EXPECT_EQ(structured.code, 0);
  EXPECT_EQ(text.err + structured.err, "");
  EXPECT_THAT(text.out, HasSubstr("Latelight can render on this machine.\n"));
  EXPECT_THAT(text.out, HasSubstr("`--raster auto` chooses"));
  const json diagnosis = json::parse(structured.out);
  EXPECT_EQ(diagnosis["usable"], true);
  EXPECT_GE(diagnosis["findings"].size(), 3u);
  for (const json& finding : diagnosis["findings"])
    EXPECT_THAT(text.out, HasSubstr(finding["sentence"].get<std::string>()));
}

TEST(Doctor, SaysWhichDeviceAutoTakesAndWhy) {
  const json devices = json::parse(run({"devices", "--json"}).out);
  std::string taken;
  for (const json& device : devices)
    if (device["auto"]) taken = device["name"];
  ASSERT_NE(taken, "");
  EXPECT_THAT(run({"doctor"}).out, HasSubstr(taken));
}

// With what is hidden: exit 4, a problem that says `what`, and a remedy that says `how`.
void expectProblem(const Environment& hidden, const std::string& what, const std::string& how) {
  const Outcome text = run({"doctor"}, hidden), structured = run({"doctor", "--json"}, hidden);
  EXPECT_EQ(text.code, 4) << text.text();
  EXPECT_EQ(structured.code, 4);
  EXPECT_EQ(text.err, "");
  EXPECT_THAT(text.out, HasSubstr("Latelight cannot render on this machine yet.\n"));
  const json diagnosis = json::parse(structured.out);
  EXPECT_EQ(diagnosis["usable"], false);
  std::string problems, remedies;
  for (const json& finding : diagnosis["findings"]) {
    if (finding["ok"]) continue;
    problems += finding["sentence"].get<std::string>() + "\n";
    remedies += finding["remedy"].get<std::string>() + "\n";
  }
  EXPECT_THAT(problems, HasSubstr(what));
  EXPECT_THAT(remedies, HasSubstr(how));
}

TEST(Doctor, MissesTheLoader) {
  expectProblem({{"LATELIGHT_VULKAN_LOADER", "/nonexistent/libvulkan.so.1"}}, "/nonexistent/libvulkan.so.1",
                "Unset LATELIGHT_VULKAN_LOADER");
}

TEST(Doctor, MissesTheDrivers) {
  expectProblem({{"VK_DRIVER_FILES", "/nonexistent"}}, "driver", "mesa-vulkan-drivers");
}

TEST(Doctor, NamesADriverLibraryThatDoesNotLoad) {
  Folder folder;
  folder.write("lost_icd.json", R"({"file_format_version": "1.0.0",
                                    "ICD": {"library_path": "/nonexistent/libvulkan_lost.so", "api_version": "1.3.0"}})");
  expectProblem({{"VK_DRIVER_FILES", folder.at("lost_icd.json")}}, "libvulkan_lost.so", "");
}

// --- devices --------------------------------------------------------------------------------------------------------

TEST(Devices, TextAndJsonAgree) {
  const Outcome text = run({"devices"}), structured = run({"devices", "--json"});
  EXPECT_EQ(text.code, 0) << text.text();
  EXPECT_EQ(structured.code, 0);
  const json devices = json::parse(structured.out);
  ASSERT_FALSE(devices.empty());
  int chosen = 0;
  for (size_t i = 0; i < devices.size(); ++i) {
    const json& device = devices[i];
    EXPECT_EQ(device["index"], i);
    for (const char* key : {"name", "type", "vulkan", "driver", "uuid"})
      EXPECT_THAT(text.out, HasSubstr(device[key].get<std::string>())) << key;
    EXPECT_EQ(device["usable"], device["missing"].empty());
    EXPECT_EQ(device["uuid"].get<std::string>().size(), 32u);
    EXPECT_GT(device["memory_bytes"].get<uint64_t>(), 1u << 28);
    chosen += device["auto"].get<bool>();
  }
  EXPECT_EQ(chosen, 1);
}

// "cpu", the number, the UUID and a part of the name all mean the device.
TEST(Devices, AreChosenByWhatIsListed) {
  const json devices = json::parse(run({"devices", "--json"}).out);
  const auto cpu =
      std::find_if(devices.begin(), devices.end(), [](const json& device) { return device["type"] == "cpu"; });
  ASSERT_NE(cpu, devices.end()) << "mesa-vulkan-drivers is missing";
  Folder folder;
  for (const std::string& selector :
       {std::string("cpu"), std::to_string((*cpu)["index"].get<int>()), (*cpu)["uuid"].get<std::string>(),
        (*cpu)["name"].get<std::string>().substr(0, 8)}) {
    const Outcome outcome =
        run({"render", "builtin:boxes", "-o", folder.at("a.png"), "--size", "16x9", "--json", "--device", selector});
    ASSERT_EQ(outcome.code, 0) << selector << ": " << outcome.text();
    EXPECT_EQ(json::parse(outcome.out)["device"], (*cpu)["name"]) << selector;
  }
}

TEST(Devices, AreNoneWithoutDrivers) {
  const Outcome structured = run({"devices", "--json"}, {{"VK_DRIVER_FILES", "/nonexistent"}});
  EXPECT_EQ(structured.code, 4);
  EXPECT_TRUE(structured.out.empty() || json::parse(structured.out).empty()) << structured.out;
}

}  // namespace
}  // namespace latelight::app
