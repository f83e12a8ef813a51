// The findings of the doctor when each part of the system is hidden in turn. A process loads Vulkan only once, so each
// case runs this program again, with variables that hide a part, as the single test DoctorInAProcess.DISABLED_Report.
#include "vk/doctor.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.h"
#include "own_process.h"
#include "vk/features.h"
#include "vk/loader.h"

namespace latelight::vk {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kReport = "LATELIGHT_TEST_REPORT";
constexpr const char* kHide = "LATELIGHT_TEST_HIDE";  // "version", or a feature's name

PFN_vkGetInstanceProcAddr realEntry;
PFN_vkGetPhysicalDeviceProperties2 realProperties;
PFN_vkGetPhysicalDeviceFeatures2 realFeatures;

VKAPI_ATTR void VKAPI_CALL olderProperties(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
  realProperties(device, properties);
  properties->properties.apiVersion = VK_MAKE_API_VERSION(0, 1, 2, 99);
}

VKAPI_ATTR void VKAPI_CALL fewerFeatures(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
  realFeatures(device, features);
  // The chain is always that of Features, which starts with its core part.
  for (const Feature& feature : requiredFeatures())
    if (std::string(feature.name) == std::getenv(kHide)) feature.of(*reinterpret_cast<Features*>(features)) = VK_FALSE;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL hidingEntry(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction real = realEntry(instance, name);
  const bool version = std::string(std::getenv(kHide)) == "version";
  if (version && std::string(name) == "vkGetPhysicalDeviceProperties2") {
    realProperties = reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(olderProperties);
  }
  if (!version && std::string(name) == "vkGetPhysicalDeviceFeatures2") {
    realFeatures = reinterpret_cast<PFN_vkGetPhysicalDeviceFeatures2>(real);
    return reinterpret_cast<PFN_vkVoidFunction>(fewerFeatures);
  }
  return real;
}

// Intercepts the program's calls to the loader and hides a part of each device.
void hide() {
  if (!std::getenv(kHide) || !loadVulkan().found()) return;
  realEntry = vkGetInstanceProcAddr;
  volkInitializeCustom(hidingEntry);
}

TEST(DoctorInAProcess, DISABLED_Report) {
  hide();
  const Diagnosis diagnosis = diagnose();
  nlohmann::json report{{"usable", diagnosis.usable}, {"problems", nlohmann::json::array()}};
  for (const Finding& finding : diagnosis.findings) {
    EXPECT_EQ(finding.ok, finding.remedy.empty()) << finding.sentence;
    report[finding.ok ? "good" : "problems"].push_back(finding.sentence);
  }
  try {
    Device device({.selector = "auto"});
    report["start"] = "works";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::NoDevice);
    report["start"] = error.what();
  }
  std::ofstream(std::getenv(kReport)) << report.dump();
}

using Variables = std::vector<std::pair<std::string, std::string>>;

class Doctor : public testing::Test {
 protected:
  Doctor() : folder_(fs::path(testing::TempDir()) / ("latelight-doctor-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~Doctor() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  std::string driverFile(const std::string& name, const std::string& library) {
    return write(name, nlohmann::json{{"file_format_version", "1.0.0"},
                                      {"ICD", {{"library_path", library}, {"api_version", "1.3.0"}}}}
                           .dump());
  }

  void run(const Variables& variables) {
    const fs::path report = folder_ / "report";
    const std::string self = fs::read_symlink("/proc/self/exe").string();
    const pid_t child = fork();
    if (child == 0) {
      for (const char* of : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_ADD_DRIVER_FILES"}) unsetenv(of);
      for (const auto& [name, value] : variables) setenv(name.c_str(), value.c_str(), 1);
      setenv(kReport, report.c_str(), 1);
      test::runAllShardsInChildren();
      if (!std::freopen("/dev/null", "w", stdout)) _exit(99);
      execl(self.c_str(), self.c_str(), "--gtest_filter=DoctorInAProcess.*", "--gtest_also_run_disabled_tests",
            nullptr);
      _exit(98);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    ASSERT_EQ(WEXITSTATUS(status), 0);
    report_ = nlohmann::json::parse(std::ifstream(report));
  }
  bool usable() const { return report_["usable"]; }
  std::vector<std::string> problems() const { return report_["problems"]; }
  std::vector<std::string> good() const { return report_.value("good", std::vector<std::string>{}); }
  std::string start() const { return report_["start"]; }

  fs::path folder_;
  nlohmann::json report_;
};

TEST_F(Doctor, FindsNoProblemsIfTheCpuDriverIsInstalled) {
  run({});
  EXPECT_TRUE(usable());
  EXPECT_EQ(start(), "works");
  EXPECT_THAT(good(), Contains(HasSubstr("--device auto` chooses device")));
}

TEST_F(Doctor, NoLoader) {
  run({{"LATELIGHT_VULKAN_LOADER", (folder_ / "none.so").string()}});
  EXPECT_FALSE(usable());
  EXPECT_THAT(problems(), Contains(HasSubstr("There is no Vulkan loader: ")));
  EXPECT_THAT(good(), Contains(HasSubstr("loads."))) << "the drivers are looked at all the same";
  EXPECT_THAT(start(), HasSubstr("There is no Vulkan loader"));
}

TEST_F(Doctor, ALibraryThatIsNoLoader) {
  run({{"LATELIGHT_VULKAN_LOADER", "libm.so.6"}});
  EXPECT_FALSE(usable());
  EXPECT_THAT(problems(), Contains(HasSubstr("libm.so.6 is not a Vulkan loader")));
}

TEST_F(Doctor, NoDriverFile) {
  const std::string nowhere = (folder_ / "nowhere").string();
  fs::create_directories(folder_ / "empty");
  run({{"VK_DRIVER_FILES", (folder_ / "empty").string()}});
  EXPECT_FALSE(usable());
  EXPECT_THAT(problems(), Contains(HasSubstr("No Vulkan driver is installed")));
  EXPECT_THAT(problems(), Contains(HasSubstr("VK_DRIVER_FILES")));
  EXPECT_THAT(start(), HasSubstr("latelight doctor"));
  run({{"VK_DRIVER_FILES", nowhere}});
  EXPECT_THAT(problems(), Contains(HasSubstr(nowhere + " is not there")));
}

TEST_F(Doctor, TheOlderVariableAndItsOrder) {
  run({{"VK_ICD_FILENAMES", write("old.json", "{")}});
  EXPECT_THAT(problems(), Contains(HasSubstr("old.json is not JSON")));
  run({{"VK_ICD_FILENAMES", write("old.json", "{")}, {"VK_DRIVER_FILES", write("new.json", "[")}});
  EXPECT_THAT(problems(), Contains(HasSubstr("new.json is not JSON")));
  EXPECT_THAT(problems(), Not(Contains(HasSubstr("old.json"))));
}

TEST_F(Doctor, DriverFilesWithOtherContents) {
  for (const char* text : {"", "nonsense", "[]", "3", "{\"ICD\": []}", "{\"ICD\": {\"library_path\": 7}}"}) {
    run({{"VK_DRIVER_FILES", write("bad.json", text)}});
    EXPECT_FALSE(usable()) << text;
    EXPECT_THAT(problems(), Contains(HasSubstr("bad.json is not"))) << text;
  }
}

TEST_F(Doctor, ADriverLibraryThatDoesNotLoad) {
  run({{"VK_DRIVER_FILES", driverFile("lost.json", "./lost_driver.so")}});
  EXPECT_FALSE(usable());
  EXPECT_THAT(problems(), Contains(HasSubstr("names the library ./lost_driver.so, which does not load (")));
  EXPECT_THAT(problems(), Contains(HasSubstr("cannot open shared object file"))) << "the linker's own words";
}

TEST_F(Doctor, ALibraryThatIsNoDriver) {
  run({{"VK_DRIVER_FILES", driverFile("wrong.json", "libm.so.6")}});
  EXPECT_FALSE(usable());
  EXPECT_THAT(problems(), Contains(HasSubstr("names the library libm.so.6, which is not a Vulkan driver")));
}

TEST_F(Doctor, ABrokenDriverNextToAGoodOneIsReportedAndHarmless) {
  run({{"VK_ADD_DRIVER_FILES", driverFile("lost.json", "./lost_driver.so")}});
  EXPECT_TRUE(usable());
  EXPECT_EQ(start(), "works");
  EXPECT_THAT(problems(), Contains(HasSubstr("lost.json")));
}

TEST_F(Doctor, NoDeviceWithVulkan13) {
  run({{kHide, "version"}});
  EXPECT_FALSE(usable());
  EXPECT_THAT(problems(), Contains(HasSubstr("it lacks Vulkan 1.3 (it has 1.2.99)")));
  EXPECT_THAT(problems(), Contains("No device has Vulkan 1.3 or newer."));
  EXPECT_THAT(start(), HasSubstr("Vulkan 1.3"));
}

TEST_F(Doctor, AMissingFeature) {
  for (const char* feature : {"scalarBlockLayout", "shaderInt64", "dynamicRendering"}) {
    run({{kHide, feature}});
    EXPECT_FALSE(usable());
    EXPECT_THAT(problems(), Contains(HasSubstr(std::string("(") + feature + ")")));
    EXPECT_THAT(problems(), Contains("No device has all that is needed of Vulkan 1.3."));
    EXPECT_THAT(start(), HasSubstr(feature));
  }
}

DeviceInfo fake(const char* version, std::vector<std::string> missing) {
  DeviceInfo info;
  info.name = "Some GPU";
  info.type = "discrete";
  info.apiVersion = version;
  info.missing = std::move(missing);
  return info;
}

TEST(DoctorOnDevices, NamesEachMissingFeature) {
  for (const Feature& required : requiredFeatures()) {
    Features offered;
    for (const Feature& feature : requiredFeatures()) feature.of(offered) = VK_TRUE;
    EXPECT_TRUE(missingFeatures(requiredFeatures(), offered).empty());
    required.of(offered) = VK_FALSE;
    const std::vector<Finding> findings = examineDevices({fake("1.3.0", missingFeatures(requiredFeatures(), offered))});
    ASSERT_EQ(findings.size(), 2u);
    EXPECT_FALSE(findings[0].ok);
    EXPECT_THAT(findings[0].sentence, HasSubstr(required.name));
    EXPECT_THAT(findings[0].sentence, HasSubstr(required.words));
    EXPECT_EQ(findings[1].sentence, "No device has all that is needed of Vulkan 1.3.");
  }
}

TEST(DoctorOnDevices, ReportsWhatAutoChoosesAndWhy) {
  std::vector<DeviceInfo> devices{fake("1.2.9", {"Vulkan 1.3 (it has 1.2.9)"}), fake("1.4.0", {})};
  devices[1].index = 1;
  devices[1].name = "Newer GPU";
  const std::vector<Finding> findings = examineDevices(devices);
  EXPECT_TRUE(findings.back().ok);
  EXPECT_THAT(findings.back().sentence, HasSubstr("chooses device 1: Newer GPU is the first usable device"));
  EXPECT_FALSE(findings[0].ok);
  EXPECT_THAT(examineDevices({}).at(0).sentence, HasSubstr("No driver finds a device"));
}

}  // namespace
}  // namespace latelight::vk
