// The subcommands, with one file each. Their callbacks print results; failures throw latelight::Error.
#pragma once

#include <CLI/CLI.hpp>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace latelight::app {

void addRenderCommand(CLI::App& app);
void addListCommand(CLI::App& app);
void addDevicesCommand(CLI::App& app);
void addDoctorCommand(CLI::App& app);
void addCompareCommand(CLI::App& app);
void addStudyCommand(CLI::App& app);
void addBenchCommand(CLI::App& app);
void addBatchCommand(CLI::App& app);
void addReportCommand(CLI::App& app);
void addServeCommand(CLI::App& app);
void addExportCommand(CLI::App& app);
void addViewCommand(CLI::App& app);
// These describe the other commands, so they must be added last.
void addCompletionsCommand(CLI::App& app);
void addManCommand(CLI::App& app);

// Adds -q, which all commands accept, to the program or to a command that does not pass unknown options to it.
void addQuietFlag(CLI::App& command);

// Returns the names of the shells for which `latelight completions` prints scripts.
std::vector<std::string_view> completionShells();

// Ends the program with an exit code and without a message, which has been printed already.
struct Exit {
  ExitCode code;
};

}  // namespace latelight::app
