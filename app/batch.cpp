// `latelight batch`: renders a data set from a job.
#include <fmt/core.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/commands.h"
#include "app/render_heap.h"
#include "app/render_options.h"
#include "base/journal.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "data/batch/devices.h"
#include "data/batch/run.h"
#include "data/batch/schema.h"
#include "data/batch/slurm.h"
#include "data/json_builder.h"
#include "data/stop.h"
#include "vk/cuda_devices.h"
#include "vk/driver_cache.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;

struct BatchArguments {
  std::string job, shard, devices = "auto", memory;
  bool resume = false, dryRun = false, schema = false, validate = false;
  uint32_t workers = 1, threads = 0, slurm = 0;
  Json given = Json::object();       // keys of the job that are given as options
  render::Settings scratch;          // target for checking image options
  std::string folder;                // for status, verify and merge
  std::vector<std::string> folders;  // `folder` and, for status and verify, the others
  bool allowMissing = false;
};

std::optional<std::string> environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? std::optional<std::string>(value) : std::nullopt;
}

// --- the job --------------------------------------------------------------------------------------------------------

bool takes(const Json& schema, const char* type) {
  if (!schema.contains("type")) return false;
  const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
  return std::ranges::find(types, type) != types.end();
}

// Numbers, and values that may be more than a name, are parsed as JSON.
Json valueOf(const std::string& key, const Json& schema, const std::string& text) {
  const bool isNumber = takes(schema, "integer");
  const bool mayBeMore = takes(schema, "object") || takes(schema.value("items", Json::object()), "object");
  if (!isNumber && !(mayBeMore && (text.starts_with('{') || text.starts_with('[')))) return text;
  try {
    return data::parseJson(text, "--" + key).json;
  } catch (const data::JsonError& error) {
    if (isNumber) badUsage("--{} takes a whole number, not \"{}\"", key, text);
    badUsage("--{} takes a name or JSON, not \"{}\": {}", key, text, error.what());
  }
}

// A list is given by repeating the option, each time with one element or with a list of them.
void addJobKey(CLI::App& command, BatchArguments& a, const std::string& key, const Json& schema) {
  const bool isList = takes(schema, "array") && schema.contains("items");
  const auto take = [&a, key, schema, isList](const std::vector<std::string>& texts) {
    Json values = Json::array();
    for (const std::string& text : texts) {
      const Json value = valueOf(key, schema, text);
      if (isList && value.is_array())
        values.insert(values.end(), value.begin(), value.end());
      else
        values.push_back(value);
    }
    a.given[key] = isList ? values : values.front();
  };
  const std::string names = key == "output" ? "-o,--output" : "--" + key;
  CLI::Option* option =
      command.add_option_function<std::vector<std::string>>(names, take, schema["description"].get<std::string>());
  option->expected(1)->group("Job")->type_name(takes(schema, "integer") ? "INTEGER" : "TEXT");
  if (isList) option->take_all();
}

void addJobOptions(CLI::App& command, BatchArguments& a) {
  for (const auto& [key, schema] : data::jobSchema()["properties"].items())
    if (key != "options") addJobKey(command, a, key, schema);
  for (const render::Option& option : render::options())
    addOption(command, option, [&a, &option](const std::string& text) {
      const std::string value = render::read(a.scratch, option, text);
      const bool isText = option.kind == render::OptionKind::Text || option.kind == render::OptionKind::Choice;
      Json& options = a.given["options"];
      if (options.is_null()) options = Json::object();
      options[std::string(render::keyOf(option))] = isText ? Json(value) : Json::parse(value);
    });
}

// Returns the job of the file, in which options replace keys.
data::Job readJob(const BatchArguments& a) {
  data::JobDocument document;
  if (!a.job.empty()) document = data::readJobFile(a.job);
  if (a.job.empty() && a.given.empty()) badUsage("no job is given: name a job file, or use --scenes and --output");
  // Another value than an object has no keys to replace; makeJob() rejects it. An empty file is a job without keys.
  if (!document.json.is_object() && !document.json.is_null()) return data::makeJob(document);
  for (const auto& [key, value] : a.given.items())
    if (key == "options" && document.json.contains(key) && document.json[key].is_object()) {
      document.json[key].update(value);
      for (const auto& [option, text] : value.items()) document.forgetLines("options." + option);
    } else {
      document.json[key] = value;
      document.forgetLines(key);
    }
  return data::makeJob(document);
}

// --- actions on the job ----------------------------------------------------------------------------------------------

void printPlan(const data::Job& job, const BatchArguments& a, const data::Shard& shard) {
  const data::SetFolder set(job.folder);
  data::checkSet(set, job, shard, a.resume);
  const data::Plan plan(job, set.plan());
  const data::Manifest finished = a.resume ? data::findFinished(set, job, plan, shard) : data::Manifest{};
  const auto [first, end] = shard.range(plan.frames());
  uint64_t frames = 0, bytes = 0;
  for (uint64_t index = first; index < end; ++index) {
    const auto place = plan.at(index);
    if (!place || finished.frames.contains(index)) continue;
    const data::PlannedCamera& camera = plan.camera(*place);
    fmt::print("{}  {}x{}  {}\n", plan.name(index), camera.width, camera.height,
               printable(plan.scenes()[place->scene].source));
    ++frames;
    bytes += uint64_t{camera.width} * camera.height * data::bytesOfPixel(job.settings);
  }
  for (const data::PlannedScene& scene : plan.scenes())
    if (!scene.error.empty()) warn("{}", scene.error);
  fmt::print("{} frames would be rendered; their outputs take {} bytes before they are compressed\n", frames, bytes);
}

std::string_view nameOfSignal(int signal) {
  return signal == SIGINT ? "SIGINT" : "SIGTERM";
}

// Returns the reason of a failure with the name of the frame or scene, which begins the reasons of most scenes.
std::string sentenceOf(const data::FailedFrame& failure) {
  const auto& [name, why] = failure;
  return why.starts_with(name + ": ") ? why : fmt::format("{}: {}", name, why);
}

void report(const data::BatchResult& result, const std::string& folder) {
  size_t warnings = 0;
  for (const auto& failure : result.failed)
    if (++warnings <= 20) warn("{}", sentenceOf(failure));
  if (warnings > 20) warn("{} more failed: see latelight batch status {}", warnings - 20, folder);
  const uint64_t missing = result.frames - result.finished;
  if (result.signal && missing == 0)
    fail(ExitCode::SomeFramesFailed, "stopped by {} before '{}' was merged; --resume merges it",
         nameOfSignal(result.signal), folder);
  if (result.signal)
    fail(ExitCode::SomeFramesFailed, "stopped by {} with {} of {} frames in '{}'; --resume makes the others",
         nameOfSignal(result.signal), result.finished, result.frames, folder);
  if (missing > 0)
    fail(ExitCode::SomeFramesFailed,
         "{} of {} frames were not made; the sentences before say why, and --resume tries again", missing,
         result.frames);
}

std::vector<std::string> workersOf(const BatchArguments& a) {
  const std::optional<std::string> visible = environment("CUDA_VISIBLE_DEVICES");
  const std::vector<std::string> devices =
      data::chooseDevices(vk::listDevices(), a.devices, visible, visible ? vk::cudaDevices() : std::nullopt);
  std::vector<std::string> workers;
  for (uint32_t i = 0; i < a.workers; ++i) workers.insert(workers.end(), devices.begin(), devices.end());
  return workers;
}

void printSlurm(const BatchArguments& a) {
  if (a.job.empty() || !a.given.empty())
    badUsage("--slurm requires a job file without further options: put the options into the file");
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  fmt::print("{}", data::slurmScript(data::quoted(program) + " batch " + data::quoted(a.job), a.slurm));
}

void runBatch(const BatchArguments& a) {
  if (a.schema) return fmt::print("{}\n", data::jobSchema().dump(2));
  if (a.slurm > 0) return printSlurm(a);
  keepFreedMemory();
  limitMemory(a.memory);
  const data::Job job = readJob(a);
  const data::SelectedShard part = data::chooseShard(a.shard, environment);
  if (!part.by.empty())
    record(fmt::format("part {}/{} of the frames, chosen by {}; --shard i/n chooses another", part.shard.index,
                       part.shard.count, part.by));
  data::BatchOptions options{.shard = part.shard, .shardBy = part.by, .resume = a.resume};
  if (a.dryRun) return printPlan(job, a, options.shard);
  options.validation = a.validate;
  options.writers = a.threads > 0 ? a.threads : threadCount();
  vk::avoidFullDriverCache();
  options.devices = workersOf(a);
  try {
    report(data::runBatch(job, options), job.folder.string());
  } catch (const data::Stopped& stopped) {
    fail(ExitCode::SomeFramesFailed, "stopped by {} before the first frame of '{}' was begun; --resume makes all",
         nameOfSignal(stopped.signal), job.folder.string());
  }
}

// --- actions on an existing set --------------------------------------------------------------------------------------

// Returns the beginning of a line about one of the folders, which a line about the only folder does not need.
std::string nameBefore(const std::string& folder, const BatchArguments& a) {
  return a.folders.size() > 1 ? printable(folder) + ": " : "";
}

// A merge may have failed, for example because the disk was full.
bool lacksMerge(const data::SetStatus& status) {
  return status.missing() == 0 && !status.isMerged;
}

[[noreturn]] void failUnmerged(const std::string& folders) {
  fail(ExitCode::BadInput, "all frames of {} are finished, but not merged: run latelight batch merge", folders);
}

void addQuoted(std::string& list, const std::string& folder) {
  list += fmt::format("{}'{}'", list.empty() ? "" : ", ", folder);
}

void printStatus(const BatchArguments& a) {
  bool isComplete = true;
  std::string unmerged;
  for (const std::string& folder : a.folders) {
    const data::SetStatus status = data::readStatus(data::SetFolder(folder));
    const std::string before = nameBefore(folder, a);
    for (const auto& failure : status.manifest.failed) fmt::print("{}{}\n", before, printable(sentenceOf(failure)));
    fmt::print("{}{} of {} frames are finished\n", before, status.manifest.frames.size(), status.frames);
    isComplete = isComplete && status.missing() == 0;
    if (lacksMerge(status)) addQuoted(unmerged, folder);
  }
  if (!unmerged.empty()) failUnmerged(unmerged);
  if (!isComplete) throw Exit{ExitCode::SomeFramesFailed};
}

// Checks every folder before it fails, so that one run lists all damaged files.
void verify(const BatchArguments& a) {
  size_t count = 0;
  std::string damaged, unmerged;
  for (const std::string& folder : a.folders) {
    const data::SetFolder set(folder);
    const data::SetStatus status = data::readStatus(set);
    const std::vector<std::string> wrong = data::verifySet(set, status);
    for (const std::string& sentence : wrong) warn("{}{}", nameBefore(folder, a), sentence);
    if (wrong.empty()) {
      fmt::print("{}the files of {} frames are as they were written\n", nameBefore(folder, a),
                 status.manifest.frames.size());
    } else {
      count += wrong.size();
      addQuoted(damaged, folder);
    }
    if (lacksMerge(status)) addQuoted(unmerged, folder);
  }
  if (count == 1)
    badInput("1 file of {} differs from what was written: remove it, and run the job with --resume", damaged);
  if (count > 1)
    badInput("{} files of {} differ from what was written: remove them, and run the job with --resume", count, damaged);
  if (!unmerged.empty()) failUnmerged(unmerged);
}

// Rejects a job and its options before the subcommand, because `batch` does not run then.
void rejectJob(const CLI::App& batch, const std::string& command) {
  for (const CLI::Option* option : batch.get_options())
    if (option->count() > 0)
      badUsage("batch {} accepts no job and no options of a job: omit {}", command,
               option->get_positional() ? option->results().front() : option->get_name());
}

// Returns the words after FOLDER. Throws the usual error if one of them is an option.
std::vector<std::string> moreFolders(const CLI::App& command) {
  std::vector<std::string> folders;
  for (const std::string& word : command.remaining())
    if (word == "--")
      continue;
    else if (word.starts_with('-'))
      throw CLI::ExtrasError({word});
    else
      folders.push_back(word);
  return folders;
}

CLI::App* addFolderCommand(CLI::App& batch, const std::shared_ptr<BatchArguments>& a, const char* name,
                           const char* help, const std::function<void(const BatchArguments&)>& run) {
  CLI::App* command = batch.add_subcommand(name, help);
  // Otherwise CLI11 passes unknown arguments to `batch`, which reads them as a job and its options.
  command->fallthrough(false);
  addQuietFlag(*command);
  command->add_option("FOLDER", a->folder, "Folder of the data set; status and verify accept several")->required();
  command->callback([a, run, &batch, command] {
    rejectJob(batch, command->get_name());
    a->folders = moreFolders(*command);
    a->folders.insert(a->folders.begin(), a->folder);
    run(*a);
  });
  return command;
}

void addRunOptions(CLI::App& command, BatchArguments& a) {
  const char* group = "Run";
  command.add_flag("--resume", a.resume, "Render frames that are missing or were rendered with other settings")
      ->group(group);
  command.add_flag("--dry-run", a.dryRun, "Print the frames that would be rendered")->group(group);
  command.add_option("--shard", a.shard, "Part i/n of the frames; default: from Slurm, Open MPI or PMI")->group(group);
  command.add_option("--devices", a.devices, "Devices: auto, all, or comma-separated cuda:N, numbers, names and UUIDs")
      ->capture_default_str()
      ->group(group);
  command.add_option("--workers", a.workers, "Number of renderers per device")
      ->check(CLI::Range(1, 64))
      ->capture_default_str()
      ->group(group);
  command.add_option("--threads", a.threads, "Number of threads that write files; default: one per core")
      ->check(CLI::Range(1, 1024))
      ->group(group);
  command
      .add_option("--memory", a.memory,
                  "Limit on host memory, for example 4G; default: three quarters of the free memory")
      ->group(group);
  command.add_flag("--validate", a.validate, "Enable the Vulkan validation layers; any message is an error")
      ->group(group);
  command.add_option("--slurm", a.slurm, "Print a job script for sbatch with this many shards")
      ->check(CLI::Range(1, 1'000'000))
      ->group(group);
  command.add_flag("--schema", a.schema, "Print the JSON schema of a job")->group(group);
}

}  // namespace

void addBatchCommand(CLI::App& app) {
  auto arguments = std::make_shared<BatchArguments>();
  CLI::App* batch = app.add_subcommand("batch", "Render a data set: scenes x variations x cameras, in many formats");
  batch->add_option("JOB", arguments->job, "Job file, .json or .yaml; may be omitted if options describe the job");
  addRunOptions(*batch, *arguments);
  addJobOptions(*batch, *arguments);
  batch->require_subcommand(0, 1);
  batch->callback([batch, arguments] {
    if (batch->get_subcommands().empty()) runBatch(*arguments);
  });
  // The further folders are extra words, because CLI11 splits the value "[a,b]" of a list.
  addFolderCommand(*batch, arguments, "status", "Print the number of finished frames and the failed ones", printStatus)
      ->allow_extras();
  addFolderCommand(*batch, arguments, "verify", "Check that all files are unmodified", verify)->allow_extras();
  CLI::App* merge =
      addFolderCommand(*batch, arguments, "merge", "Merge the shards' manifests and write the files of the whole set",
                       [](const BatchArguments& a) { data::mergeSet(data::SetFolder(a.folder), a.allowMissing); });
  merge->add_flag("--allow-missing", arguments->allowMissing, "Merge even if frames are missing");
}

}  // namespace latelight::app
