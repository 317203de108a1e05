#pragma once
// What skins found out about scans, scan by scan: how far apart two of them have the same surfaces, and what one saw
// and another saw through, which is not drawn. Poses that files give are right only if somebody has compared them.

#include "app/build_stages.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace app {

/// Two scans, and how far apart they have what both show: of the medians between their faces that of the most samples.
struct ScanPair {
    std::size_t a = 0, b = 0; ///< of ImportedImages::scans
    std::int64_t samples = 0; ///< that agree
    double apartMetres = 0;   ///< across surfaces
};

/// A scan of which whole things are not drawn, since others saw through them.
struct ScanLoss {
    std::size_t scan = 0;
    std::int64_t samples = 0;            ///< SkinFigures::floatingInside
    std::optional<std::size_t> mostlyBy; ///< the scan that saw through most of its samples; none: photographs
};

struct ScanAgreement {
    std::vector<ScanPair> pairs;  ///< those with enough in common
    std::vector<ScanLoss> losses; ///< the greatest first
};

/// ofImages: as many as images, as skins found them.
ScanAgreement scanAgreement(std::span<const ScanFaces> scans, std::span<const scene::SkinFigures> ofImages);

/// For scene.json: null where there are no two scans.
nlohmann::json describe(const ScanAgreement& agreement, std::span<const ScanFaces> scans);

/// What whoever builds the scene must know of it.
std::vector<std::string> remarksOn(const ScanAgreement& agreement, std::span<const ScanFaces> scans, bool areAsGiven);

} // namespace app
