#include "base/error.h"

#include "base/log.h"

namespace latelight {

Error::Error(ExitCode code, const std::string& sentence) : std::runtime_error(printable(sentence)), code_(code) {}

Error::~Error() = default;  // here, so that the type has one home and can be caught across the library's border

}  // namespace latelight
