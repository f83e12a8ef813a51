// `latelight doctor` and `devices` in their own processes, with parts of the system hidden by environment variables.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "vk/drivers.h"

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

// With this hidden, the command exits with 4, reports a problem that contains `what`, and a remedy that contains `how`.
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

// --- drivers that Latelight adds
// --------------------------------------------------------------------------------------

// The library of the system's lavapipe, which stands in for other drivers.
std::string lavapipe() {
  for (const std::filesystem::path& file : vk::findDriverFiles().files)
    if (file.filename().string().starts_with("lvp_icd")) return vk::readDriverFile(file).library;
  ADD_FAILURE() << "mesa-vulkan-drivers is missing";
  return "";
}

std::string manifestOf(const std::string& library) {
  return json{{"file_format_version", "1.0.0"}, {"ICD", {{"library_path", library}, {"api_version", "1.3.0"}}}}.dump();
}

// A container into which the libraries of NVIDIA's driver are mounted, but no other driver.
struct Container {
  Container() {
    std::filesystem::create_directory(folder.at("lib"));
    std::filesystem::create_symlink(lavapipe(), folder.at("lib/libEGL_nvidia.so.0"));
  }
  Environment environment() const {
    return {{"LD_LIBRARY_PATH", folder.at("lib")},
            {"XDG_DATA_DIRS", folder.at("none")},
            {"XDG_CACHE_HOME", folder.at("cache")}};
  }
  Folder folder;
};

TEST(AddedDrivers, NvidiaNeedsNoDriverFile) {
  const Container container;
  const Outcome doctor = run({"doctor"}, container.environment());
  EXPECT_EQ(doctor.code, 0) << doctor.text();
  EXPECT_THAT(doctor.out, HasSubstr("NVIDIA's driver has no driver file, so Latelight has made one for "
                                    "libEGL_nvidia.so.0."));
  const Outcome devices = run({"devices"}, container.environment());
  EXPECT_THAT(devices.out, HasSubstr("llvmpipe"));
  EXPECT_THAT(devices.out, HasSubstr("Latelight has made one for libEGL_nvidia.so.0."));
}

// As where libX11 is missing, which libGLX_nvidia.so.0 requires and libEGL_nvidia.so.0 does not.
TEST(AddedDrivers, NvidiaMayHaveADriverFileThatDoesNotWork) {
  Container container;
  container.folder.write("nvidia_icd.json", manifestOf("libGLX_nvidia.so.0"));
  Environment environment = container.environment();
  environment["VK_ADD_DRIVER_FILES"] = container.folder.at("nvidia_icd.json");
  const Outcome devices = run({"devices"}, environment);
  EXPECT_EQ(devices.code, 0) << devices.text();
  EXPECT_THAT(devices.out, HasSubstr("no driver file that works, so Latelight has made one for libEGL_nvidia.so.0."));
  const Outcome doctor = run({"doctor"}, environment);
  EXPECT_EQ(doctor.code, 0);
  EXPECT_THAT(doctor.out, testing::Not(HasSubstr("problem")));
}

TEST(AddedDrivers, NothingIsAddedToDriversThatAVariableLists) {
  const Container container;
  Environment environment = container.environment();
  environment["VK_DRIVER_FILES"] = container.folder.at("none");
  EXPECT_EQ(run({"devices"}, environment).code, 4);
  EXPECT_FALSE(std::filesystem::exists(container.folder.at("cache/latelight/nvidia_icd.json")));
}

TEST(AddedDrivers, NvidiasLibraryMayLackWhatItNeeds) {
  expectProblem({{"LD_LIBRARY_PATH", LATELIGHT_FAKE_DRIVERS "/nvidia"}, {"XDG_DATA_DIRS", "/nonexistent"}},
                "NVIDIA's driver library libGLX_nvidia.so.0 is a Vulkan driver that cannot create an instance.",
                "libxext6 libegl1");
}

TEST(AddedDrivers, TheCpuDriverOfThePackageReplacesTheSystems) {
  Folder folder;
  folder.write("latelight_cpu_icd.json", manifestOf(lavapipe()));
  const Environment environment{{"LATELIGHT_CPU_DRIVER", folder.at("latelight_cpu_icd.json")}};
  const json devices = json::parse(run({"devices", "--json"}, environment).out);
  ASSERT_EQ(std::ranges::count_if(devices, [](const json& device) { return device["type"] == "cpu"; }), 1);
  EXPECT_THAT(run({"doctor"}, environment).out, HasSubstr("Latelight's own CPU driver replaces that of the system."));
  const Outcome outcome =
      run({"render", "builtin:boxes", "-o", folder.at("a.exr"), "--aov", "depth", "--size", "16x9", "--device", "cpu"},
          environment);
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  std::ifstream side(folder.at("a.json"));
  EXPECT_THAT(json::parse(side)["device"]["driver"].get<std::string>(), HasSubstr("(latelight-cpu)"));
}

// --- devices --------------------------------------------------------------------------------------------------------

std::string uuidOfTheCpu() {
  for (const json& device : json::parse(run({"devices", "--json"}).out))
    if (device["type"] == "cpu") return device["uuid"];
  return "";
}

// CUDA's device 1 is the CPU here, for want of a GPU.
TEST(Devices, AreChosenByCudasNumber) {
  Folder folder;
  const Environment cuda{{"LD_LIBRARY_PATH", LATELIGHT_FAKE_DRIVERS "/cuda"},
                         {"FAKE_CUDA_UUIDS", std::string(32, 'f') + "," + uuidOfTheCpu()}};
  const auto render = [&](const std::string& device, const Environment& environment) {
    return run({"render", "builtin:boxes", "-o", folder.at("a.png"), "--size", "16x9", "--device", device},
               environment);
  };
  const Outcome found = render("cuda:1", cuda);
  EXPECT_EQ(found.code, 0) << found.text();
  for (const auto& [device, sentence] :
       std::map<std::string, std::string>{{"cuda", "CUDA's device 0 is not among Vulkan's"},
                                          {"cuda:2", "CUDA has no device cuda:2: it lists 2"},
                                          {"cuda:-1", "CUDA has no device cuda:-1"},
                                          {"cuda:", "CUDA has no device cuda:"}}) {
    const Outcome refused = render(device, cuda);
    EXPECT_EQ(refused.code, 4) << device;
    EXPECT_THAT(refused.err, HasSubstr(sentence));
  }
  Environment empty = cuda;
  empty["FAKE_CUDA_UUIDS"] = "";
  EXPECT_THAT(render("cuda:0", empty).err,
              HasSubstr("CUDA has no device cuda:0: it lists 0 (see CUDA_VISIBLE_DEVICES)"));
  Environment broken = cuda;
  broken["FAKE_CUDA_UUIDS"] = "broken";
  EXPECT_THAT(render("cuda:1", broken).err, HasSubstr("CUDA's driver (libcuda.so.1) is missing or does not start"));
}

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

// "cpu", the number, the UUID and a part of the name all select the device.
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
