#include "output/huffman.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace latelight::output {
namespace {

std::vector<HuffmanCode> codesOf(const std::vector<uint32_t>& counts) {
  std::vector<HuffmanCode> codes(counts.size());
  makeHuffmanCodes(counts, codes);
  return codes;
}

// 1 for codes that use all bit strings, greater for codes that cannot be decoded.
double kraftSum(const std::vector<HuffmanCode>& codes) {
  double sum = 0;
  for (const HuffmanCode& code : codes)
    if (code.bits > 0) sum += std::ldexp(1.0, -code.bits);
  return sum;
}

uint32_t firstBitHighest(HuffmanCode code) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < code.bits; ++i) bits = bits << 1 | (code.code >> i & 1);
  return bits;
}

// Section 3.2.2 of RFC 1951 has the codes for the lengths (3, 3, 3, 3, 3, 2, 4, 4), which these counts lead to.
TEST(Huffman, CodesAreThoseOfTheSpecification) {
  const auto codes = codesOf({10, 10, 10, 10, 10, 20, 4, 5});
  const uint32_t lengths[] = {3, 3, 3, 3, 3, 2, 4, 4}, expected[] = {2, 3, 4, 5, 6, 0, 14, 15};
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(codes[i].bits, lengths[i]) << i;
    EXPECT_EQ(firstBitHighest(codes[i]), expected[i]) << i;
  }
}

// Powers of two have codes as long as their logarithms.
TEST(Huffman, DyadicCountsReachTheEntropy) {
  const auto codes = codesOf({0, 1024, 512, 0, 256, 128, 64, 32, 32});
  const uint32_t lengths[] = {0, 1, 2, 0, 3, 4, 5, 6, 6};
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(codes[i].bits, lengths[i]) << i;
}

TEST(Huffman, ASingleSymbolHasOneBit) {
  const auto codes = codesOf({0, 0, 7});
  EXPECT_EQ(codes[2].bits, 1);
  EXPECT_EQ(codes[0].bits, 0);
}

// Counts of Fibonacci's sequence make the deepest tree.
TEST(Huffman, CodesAreLimited) {
  std::vector<uint32_t> counts{1, 1};
  while (counts.size() < 30) counts.push_back(counts[counts.size() - 1] + counts[counts.size() - 2]);
  const auto codes = codesOf(counts);
  for (const HuffmanCode& code : codes) {
    EXPECT_GE(code.bits, 1);
    EXPECT_LE(code.bits, kMaxCodeBits);
  }
  EXPECT_EQ(kraftSum(codes), 1);
}

TEST(Huffman, CodesOfAllCountsAreComplete) {
  std::mt19937 random(1);
  for (int repeat = 0; repeat < 1000; ++repeat) {
    std::vector<uint32_t> counts(2 + random() % 285);
    for (uint32_t& count : counts) count = random() >> (random() % 32);
    counts[0] = counts[1] = 1;
    EXPECT_EQ(kraftSum(codesOf(counts)), 1);
  }
}

}  // namespace
}  // namespace latelight::output
