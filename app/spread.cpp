#include "app/spread.h"

#include <algorithm>
#include <cmath>

namespace app {

namespace {

/// Steele, Lea and Flood 2014 (splitmix64).
std::uint64_t nextRandom(std::uint64_t& state) {
    state += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

} // namespace

void Spread::add(double value) {
    max_ = count_ == 0 ? value : std::max(max_, value);
    ++count_;
    if (held_.empty()) held_.reserve(kHeld); // growing piece by piece would leave holes
    if (held_.size() < kHeld) {
        held_.push_back(value);
        return;
    }
    const std::uint64_t place = nextRandom(random_) % count_;
    if (place < kHeld) held_[place] = value;
}

nlohmann::json Spread::toJson() const {
    if (count_ == 0) return nullptr;
    std::vector<double> values = held_;
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double index = std::ceil(share * static_cast<double>(values.size())) - 1;
        return values[static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(values.size() - 1)))];
    };
    return {{"median", at(0.5)}, {"p95", at(0.95)}, {"p99", at(0.99)}, {"max", max_}};
}

} // namespace app
