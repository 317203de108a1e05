#pragma once
// The spread of a figure over a run of any length, in memory that does not grow with it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

namespace app {

/// Exact up to kHeld values. Of more, as many are held, each value as likely as any other (algorithm R, Vitter 1985):
/// what is given as the 99th percentile then lies between the 98.5th and the 99.5th (three standard deviations of its
/// rank). The maximum is always exact.
class Spread {
  public:
    static constexpr std::size_t kHeld = 4096;

    void add(double value);

    /// {"median", "p95", "p99", "max"}; null if there were none.
    nlohmann::json toJson() const;

  private:
    std::vector<double> held_;
    double max_ = 0;
    std::uint64_t count_ = 0;
    std::uint64_t random_ = 1; ///< the same run gives the same figures
};

} // namespace app
