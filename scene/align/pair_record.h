#pragma once
// What is known of two scans, as bytes: a registration of many scans takes hours, and what it found of a pair is worth
// keeping.

#include "scene/align/register_pair.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace scene {

std::vector<std::byte> packPair(const PairResult& result);

/// Nothing if they are damaged, or not a pair's.
std::optional<PairResult> unpackPair(std::span<const std::byte> bytes);

} // namespace scene
