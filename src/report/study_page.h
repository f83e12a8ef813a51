// `latelight study NAME --html`: the plots, images and tables of a study on one page.
#pragma once

#include <span>
#include <string>

#include "study/study.h"

namespace latelight::report {

// `command` holds the words of the command that creates the page.
std::string studyPage(const study::Study& study, const study::Options& options, const study::Result& result,
                      std::span<const std::string> command);

}  // namespace latelight::report
