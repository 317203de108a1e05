#include "scene/align/lost_scans.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <utility>

namespace scene {

namespace {

constexpr int kLeastConfirmed = 2; ///< two scans of one tripod that was not moved stand as their files have them, too

bool isAtOrigin(const ScanView& scan) {
    return scan.givenWorldFromScanner.translation == glm::dvec3(0.0);
}

bool areInSiteCoordinates(std::span<const ScanView> scans, const std::vector<bool>& areSaid,
                          std::span<const FoundPlace> found) {
    std::map<std::size_t, int> confirmed; // by group
    int all = 0, refuted = 0, most = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        if (areSaid[i] || !found[i].isRegistered || found[i].group == i) continue;
        if (areElsewhere(found[i].worldFromScanner, scans[i].givenWorldFromScanner))
            ++refuted;
        else
            ++all, most = std::max(most, ++confirmed[found[i].group]);
    }
    return most >= kLeastConfirmed && all > refuted;
}

bool sawAnything(const ScanView& scan) {
    return std::ranges::any_of(scan.panorama.cells.pixels(), [](const PanoramaCell& cell) { return cell.samples > 0; });
}

} // namespace

std::vector<bool> arePosesSaid(std::span<const ScanView> scans) {
    const bool areSeveral = std::ranges::count_if(scans, isAtOrigin) > 1;
    std::vector<bool> areSaid;
    for (const ScanView& scan : scans)
        areSaid.push_back(!areSeveral || !isAtOrigin(scan));
    return areSaid;
}

std::vector<bool> findLost(std::span<const ScanView> scans, const std::vector<bool>& areSaid,
                           std::span<const FoundPlace> found) {
    assert(areSaid.size() == scans.size() && found.size() == scans.size());
    std::vector<bool> isLost(scans.size(), false);
    if (std::ranges::find(areSaid, false) == areSaid.end() || areInSiteCoordinates(scans, areSaid, found))
        return isLost;
    struct Group {
        std::vector<std::size_t> scans;
        bool isPlaced = false;
        bool sawAnything = false;
    };
    std::map<std::size_t, Group> groups;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        Group& group = groups[found[i].group];
        group.scans.push_back(i);
        group.isPlaced = group.isPlaced || areSaid[i];
        group.sawAnything = group.sawAnything || sawAnything(scans[i]);
    }
    std::size_t placed = 0;
    const Group* largest = nullptr; // of those that nobody placed
    for (const auto& [number, group] : groups) {
        if (group.isPlaced)
            placed += group.scans.size();
        else if (!largest || std::pair(group.sawAnything, group.scans.size()) >
                                 std::pair(largest->sawAnything, largest->scans.size()))
            largest = &group;
    }
    const bool keepsPlaced = !largest || placed >= largest->scans.size();
    for (const auto& [number, group] : groups)
        for (const std::size_t i : group.scans)
            isLost[i] = keepsPlaced ? !group.isPlaced : &group != largest;
    return isLost;
}

} // namespace scene
