// Job files of `latelight batch`, and their check against the schema. The first byte selects JSON or YAML.
#include "data/batch/job_file.h"
#include "data/batch/schema.h"
#include "fuzz/fuzz.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  if (size == 0) return 0;
  data::jobSchema();  // errors of the schema itself must not pass as errors of inputs
  const char* name = data[0] % 2 == 0 ? "job.json" : "job.yaml";
  const std::filesystem::path path = fuzz::writeInput(name, fuzz::bytesOf(data, size).subspan(1));
  fuzz::expectErrors({ExitCode::BadInput, ExitCode::Usage}, [&] { data::checkJob(data::readJobFile(path)); });
  return 0;
}
