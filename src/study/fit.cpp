#include "study/fit.h"

#include <algorithm>
#include <cmath>

namespace latelight::study {

namespace {

using Matrix = std::vector<std::vector<double>>;

// Solves by Gaussian elimination with pivoting; columns must be scaled to 1. Returns nothing if the matrix is singular.
std::optional<std::vector<double>> solve(Matrix a, std::vector<double> b) {
  const size_t n = b.size();
  for (size_t i = 0; i < n; ++i) {
    size_t pivot = i;
    for (size_t k = i + 1; k < n; ++k)
      if (std::abs(a[k][i]) > std::abs(a[pivot][i])) pivot = k;
    if (std::abs(a[pivot][i]) < 1e-12) return std::nullopt;
    std::swap(a[i], a[pivot]);
    std::swap(b[i], b[pivot]);
    for (size_t k = i + 1; k < n; ++k) {
      const double factor = a[k][i] / a[i][i];
      for (size_t j = i; j < n; ++j) a[k][j] -= factor * a[i][j];
      b[k] -= factor * b[i];
    }
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t j = i + 1; j < n; ++j) b[i] -= a[i][j] * b[j];
    b[i] /= a[i][i];
  }
  return b;
}

double determination(std::span<const std::vector<double>> rows, std::span<const double> y,
                     const std::vector<double>& coefficients) {
  double mean = 0, residual = 0, total = 0;
  for (double value : y) mean += value / static_cast<double>(y.size());
  for (size_t k = 0; k < y.size(); ++k) {
    double model = 0;
    for (size_t i = 0; i < coefficients.size(); ++i) model += coefficients[i] * rows[k][i];
    residual += (y[k] - model) * (y[k] - model);
    total += (y[k] - mean) * (y[k] - mean);
  }
  if (total == 0) return residual == 0 ? 1 : 0;
  return 1 - residual / total;
}

}  // namespace

std::optional<LinearFit> fitLinear(std::span<const std::vector<double>> rows, std::span<const double> y) {
  if (rows.empty() || rows.size() < rows[0].size()) return std::nullopt;
  const size_t n = rows[0].size();
  std::vector<double> scale(n, 0);  // lights x triangles next to 1: normal equations square the magnitudes
  for (const std::vector<double>& row : rows)
    for (size_t i = 0; i < n; ++i) scale[i] = std::max(scale[i], std::abs(row[i]));
  if (std::find(scale.begin(), scale.end(), 0.0) != scale.end()) return std::nullopt;
  Matrix normal(n, std::vector<double>(n, 0));
  std::vector<double> right(n, 0);
  for (size_t k = 0; k < rows.size(); ++k) {
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j < n; ++j) normal[i][j] += rows[k][i] / scale[i] * (rows[k][j] / scale[j]);
      right[i] += rows[k][i] / scale[i] * y[k];
    }
  }
  std::optional<std::vector<double>> coefficients = solve(normal, right);
  if (!coefficients) return std::nullopt;
  for (size_t i = 0; i < n; ++i) (*coefficients)[i] /= scale[i];
  const double r2 = determination(rows, y, *coefficients);
  return LinearFit{std::move(*coefficients), r2};
}

std::vector<Sample> increasingPart(std::vector<Sample> sweep) {
  size_t first = 0;
  while (first < sweep.size() && sweep[first].y < 2 * sweep[0].y) ++first;
  if (sweep.size() - first < 2) first = sweep.size() - std::min<size_t>(sweep.size(), 3);
  sweep.erase(sweep.begin(), sweep.begin() + static_cast<std::ptrdiff_t>(first));
  return sweep;
}

std::optional<PowerFit> fitPower(std::span<const Sample> samples) {
  std::vector<std::vector<double>> rows;
  std::vector<double> y;
  for (const Sample& sample : samples) {
    if (!(sample.x > 0 && sample.y > 0)) continue;
    rows.push_back({1, std::log(sample.x)});
    y.push_back(std::log(sample.y));
  }
  const std::optional<LinearFit> fit = fitLinear(rows, y);
  if (!fit) return std::nullopt;
  return PowerFit{fit->coefficients[1], std::exp(fit->coefficients[0]), fit->r2};
}

}  // namespace latelight::study
