// Error statistics over many samples. The order of summation is fixed, so the same samples produce the same digits with
// any number of threads.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace latelight::study {

struct Statistics {
  size_t count = 0;  // samples with a finite error
  size_t lost = 0;   // samples with an infinite one
  double sum = 0, sumOfSquares = 0;
  double maximum = 0;   // over the finite errors
  size_t worst = 0;     // the sample with the maximum
  double mean() const;  // 0 without samples
  double rms() const;
};

// Returns errorOf(i) for every sample, computed in parallel.
std::vector<double> errorsOf(size_t count, const std::function<double(size_t)>& errorOf);

// Summarizes the samples that `takes` accepts. Samples from `even` on affect only the maximum, because they are
// concentrated in difficult directions.
Statistics summarize(std::span<const double> errors, size_t even, const std::function<bool(size_t)>& takes);

// Counts how many of the first `even` samples fall into each of `bins` equal parts of [0, top). Larger values count in
// the last bin.
std::vector<size_t> histogramOf(std::span<const double> errors, size_t even, double top, size_t bins,
                                const std::function<bool(size_t)>& takes);

}  // namespace latelight::study
