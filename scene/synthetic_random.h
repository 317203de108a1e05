#pragma once
// Seeded numbers that are the same on every machine and on any number of threads: each is a hash of where it
// is used.

#include <cmath>
#include <cstdint>

namespace scene {

/// Mixes all bits of a number (the finaliser of a 64 bit multiplicative hash).
inline std::uint64_t mixBits(std::uint64_t value) {
    value ^= value >> 32;
    value *= 0xd6e8feb86659fd93ULL;
    value ^= value >> 32;
    value *= 0xd6e8feb86659fd93ULL;
    return value ^ (value >> 32);
}

inline std::uint64_t mixBits(std::uint64_t a, std::uint64_t b) {
    return mixBits(a ^ (mixBits(b) + 0x9e3779b97f4a7c15ULL));
}

/// In [0, 1).
inline double unitOf(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// A sequence of numbers from one seed.
class SeededSequence {
  public:
    explicit SeededSequence(std::uint64_t seed) : seed_(mixBits(seed, 0x5eed)) {}

    std::uint64_t bits() { return mixBits(seed_, ++count_); }
    double unit() { return unitOf(bits()); }
    double between(double low, double high) { return low + (high - low) * unit(); }

    /// Mean 0, deviation 1.
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - unit()));
        return radius * std::cos(6.283185307179586 * unit());
    }

  private:
    std::uint64_t seed_ = 0, count_ = 0;
};

} // namespace scene
