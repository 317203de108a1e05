#include "app/scan_agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace app {

namespace {

constexpr std::int64_t kLeastShared = 1000; ///< samples; of fewer a median says little
constexpr std::int64_t kLeastLoss = 100;    ///< samples within things; leaves have some, too
/// Scans with noise of 20 mm are 23 mm apart, those whose poses are 50 mm off 33 (docs/building.md).
constexpr double kFarApartMetres = 0.03;
constexpr std::size_t kNamed = 5;

constexpr std::size_t kNoScan = std::numeric_limits<std::size_t>::max();

std::vector<std::size_t> scanOfImages(std::span<const ScanFaces> scans, std::size_t images) {
    std::vector<std::size_t> scanOf(images, kNoScan);
    for (std::size_t s = 0; s < scans.size(); ++s)
        std::fill_n(scanOf.begin() + static_cast<std::ptrdiff_t>(scans[s].first), scans[s].count, s);
    return scanOf;
}

/// Of medians, each with how many samples it is of.
double weightedMedian(std::vector<std::pair<double, std::int64_t>> medians) {
    std::sort(medians.begin(), medians.end());
    std::int64_t all = 0, before = 0;
    for (const auto& [metres, samples] : medians)
        all += samples;
    for (const auto& [metres, samples] : medians)
        if (before += samples; 2 * before >= all) return metres;
    return 0;
}

std::string millimetres(double metres) {
    return std::to_string(std::lround(1e3 * metres)) + " mm";
}

} // namespace

ScanAgreement scanAgreement(std::span<const ScanFaces> scans, std::span<const scene::SkinFigures> ofImages) {
    const std::vector<std::size_t> scanOf = scanOfImages(scans, ofImages.size());
    std::map<std::pair<std::size_t, std::size_t>, std::vector<std::pair<double, std::int64_t>>> apart;
    std::vector<std::map<std::size_t, std::int64_t>> seenThroughBy(scans.size());
    std::vector<std::int64_t> inside(scans.size(), 0);
    for (std::size_t i = 0; i < ofImages.size(); ++i) {
        const std::size_t scan = scanOf[i];
        if (scan == kNoScan) continue;
        inside[scan] += ofImages[i].floatingInside;
        for (const scene::PartnerWord& word : ofImages[i].words) {
            const std::size_t other = scanOf[word.image];
            if (other == scan) continue;
            seenThroughBy[scan][other] += word.sawThrough;
            if (other != kNoScan && word.apartMetres > 0)
                apart[std::minmax(scan, other)].emplace_back(word.apartMetres, word.agrees);
        }
    }
    ScanAgreement agreement;
    for (const auto& [pair, medians] : apart) {
        std::int64_t samples = 0;
        for (const auto& [metres, count] : medians)
            samples += count;
        if (samples >= kLeastShared)
            agreement.pairs.push_back({pair.first, pair.second, samples, weightedMedian(medians)});
    }
    for (std::size_t s = 0; s < scans.size(); ++s) {
        if (inside[s] < kLeastLoss || seenThroughBy[s].empty()) continue;
        const auto most = std::max_element(seenThroughBy[s].begin(), seenThroughBy[s].end(),
                                           [](const auto& a, const auto& b) { return a.second < b.second; });
        agreement.losses.push_back({s, inside[s], most->first == kNoScan ? std::nullopt : std::optional(most->first)});
    }
    std::stable_sort(agreement.losses.begin(), agreement.losses.end(),
                     [](const ScanLoss& a, const ScanLoss& b) { return a.samples > b.samples; });
    return agreement;
}

nlohmann::json describe(const ScanAgreement& agreement, std::span<const ScanFaces> scans) {
    if (scans.size() < 2) return nullptr;
    nlohmann::json pairs = nlohmann::json::array(), losses = nlohmann::json::array();
    for (const ScanPair& pair : agreement.pairs)
        pairs.push_back({{"a", scans[pair.a].name},
                         {"b", scans[pair.b].name},
                         {"samples", pair.samples},
                         {"apart_m", pair.apartMetres}});
    for (const ScanLoss& loss : agreement.losses)
        losses.push_back({{"scan", scans[loss.scan].name},
                          {"samples_inside", loss.samples},
                          {"seen_through_by", loss.mostlyBy ? nlohmann::json(scans[*loss.mostlyBy].name) : nullptr}});
    return {{"pairs", pairs}, {"losses", losses}};
}

std::vector<std::string> remarksOn(const ScanAgreement& agreement, std::span<const ScanFaces> scans, bool areAsGiven) {
    std::vector<std::string> remarks;
    const auto worst =
        std::max_element(agreement.pairs.begin(), agreement.pairs.end(),
                         [](const ScanPair& a, const ScanPair& b) { return a.apartMetres < b.apartMetres; });
    if (worst != agreement.pairs.end() && worst->apartMetres > kFarApartMetres)
        remarks.push_back(
            "Where scans '" + scans[worst->a].name + "' and '" + scans[worst->b].name +
            "' show the same surfaces they have them " + millimetres(worst->apartMetres) +
            " apart (median, across them), and what is drawn lies between: their ranges are noisy or their samples "
            "sparse there, or " +
            (areAsGiven ? "their poses, which are as the files give them, are wrong: --register auto finds "
                          "better ones then."
                        : "their poses are wrong: revisit info says how they were registered."));
    if (!agreement.losses.empty()) {
        std::string some;
        for (std::size_t i = 0; i < std::min(kNamed, agreement.losses.size()); ++i) {
            const ScanLoss& loss = agreement.losses[i];
            some += (i > 0 ? ", '" : "'") + scans[loss.scan].name + "' (" + std::to_string(loss.samples) +
                    " samples; through most of it " +
                    (loss.mostlyBy ? "'" + scans[*loss.mostlyBy].name + "'" : std::string("photographs")) + " saw)";
        }
        if (agreement.losses.size() > kNamed)
            some += " and " + std::to_string(agreement.losses.size() - kNamed) + " more";
        remarks.push_back("Things that more scans saw through than saw are not drawn: something of " + some +
                          ". It moved from scan to scan, stands in glass or a mirror, or a pose is wrong; each scan "
                          "built alone shows all it saw.");
    }
    return remarks;
}

} // namespace app
