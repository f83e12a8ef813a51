#include "study/statistics.h"

#include <cmath>

#include "base/parallel.h"

namespace latelight::study {

namespace {

constexpr size_t kChunk = 1 << 16;

void add(Statistics& s, double error, size_t index, bool even) {
  if (!std::isfinite(error)) {
    ++s.lost;
    return;
  }
  if (error > s.maximum) {
    s.maximum = error;
    s.worst = index;
  }
  if (!even) return;
  ++s.count;
  s.sum += error;
  s.sumOfSquares += error * error;
}

void merge(Statistics& to, const Statistics& from) {
  to.count += from.count;
  to.lost += from.lost;
  to.sum += from.sum;
  to.sumOfSquares += from.sumOfSquares;
  if (from.maximum > to.maximum) {
    to.maximum = from.maximum;
    to.worst = from.worst;
  }
}

}  // namespace

double Statistics::mean() const {
  return count ? sum / static_cast<double>(count) : 0.0;
}
double Statistics::rms() const {
  return count ? std::sqrt(sumOfSquares / static_cast<double>(count)) : 0.0;
}

std::vector<double> errorsOf(size_t count, const std::function<double(size_t)>& errorOf) {
  std::vector<double> errors(count);
  parallelFor(count, kChunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) errors[i] = errorOf(i);
  });
  return errors;
}

Statistics summarize(std::span<const double> errors, size_t even, const std::function<bool(size_t)>& takes) {
  std::vector<Statistics> parts((errors.size() + kChunk - 1) / kChunk);
  parallelFor(errors.size(), kChunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (takes(i)) add(parts[begin / kChunk], errors[i], i, i < even);
  });
  Statistics all;
  for (const Statistics& part : parts) merge(all, part);
  return all;
}

std::vector<size_t> histogramOf(std::span<const double> errors, size_t even, double top, size_t bins,
                                const std::function<bool(size_t)>& takes) {
  std::vector<size_t> counts(bins);
  for (size_t i = 0; i < even; ++i) {
    if (!takes(i)) continue;
    const double place = errors[i] / top * static_cast<double>(bins);
    ++counts[place < static_cast<double>(bins) ? static_cast<size_t>(place) : bins - 1];
  }
  return counts;
}

}  // namespace latelight::study
