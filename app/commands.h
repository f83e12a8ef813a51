// The subcommands: one file each. A callback prints its result; a failure throws latelight::Error.
#pragma once

#include <CLI/CLI.hpp>

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
void addViewCommand(CLI::App& app);
// Those that describe the others, which have been added by then.
void addCompletionsCommand(CLI::App& app);
void addManCommand(CLI::App& app);

// Thrown to end with an exit code and no message, which has been printed already.
struct Exit {
  ExitCode code;
};

}  // namespace latelight::app
