// Pairwise covering arrays: instead of every combination of several choices, a small set in which each pair of values
// of any two choices still occurs. (R. Mandl 1985, Orthogonal Latin squares: an application of experiment design to
// compiler testing, CACM 28(10).)
#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <tuple>
#include <vector>

namespace latelight::test {

using Combination = std::vector<size_t>;  // one value per choice, in [0, its count)

// The valid combinations of `counts` values.
inline std::vector<Combination> combinations(const std::vector<size_t>& counts,
                                             const std::function<bool(const Combination&)>& valid) {
  std::vector<Combination> all;
  Combination c(counts.size(), 0);
  for (size_t i = 0; i < counts.size();) {
    if (valid(c)) all.push_back(c);
    for (i = 0; i < counts.size() && ++c[i] == counts[i]; ++i) c[i] = 0;
  }
  return all;
}

// a choice with its value, and another choice with its value
using ValuePair = std::tuple<size_t, size_t, size_t, size_t>;

inline std::vector<ValuePair> pairsOf(const Combination& c) {
  std::vector<ValuePair> pairs;
  for (size_t i = 0; i < c.size(); ++i)
    for (size_t k = i + 1; k < c.size(); ++k) pairs.emplace_back(i, c[i], k, c[k]);
  return pairs;
}

// Greedy: adds the first of the combinations that cover the most new pairs, until none is left.
inline std::vector<Combination> pairwise(const std::vector<size_t>& counts,
                                         const std::function<bool(const Combination&)>& valid) {
  const std::vector<Combination> all = combinations(counts, valid);
  std::set<ValuePair> missing;
  for (const Combination& c : all)
    for (const ValuePair& pair : pairsOf(c)) missing.insert(pair);
  std::vector<Combination> chosen;
  while (!missing.empty()) {
    size_t most = 0;
    const Combination* best = nullptr;
    for (const Combination& c : all) {
      size_t adds = 0;
      for (const ValuePair& pair : pairsOf(c)) adds += missing.count(pair);
      if (adds > most) most = adds, best = &c;
    }
    for (const ValuePair& pair : pairsOf(*best)) missing.erase(pair);
    chosen.push_back(*best);
  }
  return chosen;
}

}  // namespace latelight::test
