// `latelight study NAME --html`: a study's plots, pictures and tables on one page.
#pragma once

#include <span>
#include <string>

#include "study/study.h"

namespace latelight::report {

// `command`: its words that make the page.
std::string studyPage(const study::Study& study, const study::Options& options, const study::Result& result,
                      std::span<const std::string> command);

}  // namespace latelight::report
