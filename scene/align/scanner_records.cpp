#include "scene/align/scanner_records.h"

#include "scene/errors.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace scene {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kMostStep = kTurn / 8; ///< of the pan, from one half turn of the mirror to the next
constexpr double kSteady = 0.02;        ///< share of its range by which the pan may leave an even motion

Failure notOfOurs(const std::string& what, const std::string& where) {
    return {what, where,
            "only scans on a grid of half turns of the mirror, those before the pan unit first, hold the records that "
            "calibration needs"};
}

std::optional<ScannerRecord> recordAt(const Scan& scan, std::size_t i, const ScannerConstants<double>& believed,
                                      ScannerFace face) {
    const glm::vec3& p = scan.pointsInScanner[i];
    return recordOf(believed, {p.x, p.y, p.z}, face);
}

/// Mean direction of the pan for each column of one face, unwrapped from column to column; radians.
std::vector<double> pansOfColumns(const Scan& scan, const ScannerConstants<double>& believed, int first, int count,
                                  ScannerFace face, const std::string& where) {
    std::vector<double> sines(static_cast<std::size_t>(count)), cosines(sines.size());
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
        const int column = scan.column[i] - first;
        if (column < 0 || column >= count) continue;
        const auto record = recordAt(scan, i, believed, face);
        if (!record) continue;
        const double azimuth = record->pan * std::numbers::pi / believed.panStepsPerHalfTurn;
        sines[static_cast<std::size_t>(column)] += std::sin(azimuth);
        cosines[static_cast<std::size_t>(column)] += std::cos(azimuth);
    }
    std::vector<double> pans(sines.size());
    double last = 0;
    for (std::size_t c = 0; c < pans.size(); ++c) {
        double step = 0; // of a column without points nothing is known
        if (sines[c] != 0 || cosines[c] != 0) step = std::remainder(std::atan2(sines[c], cosines[c]) - last, kTurn);
        if (c > 0 && std::abs(step) > kMostStep)
            throw notOfOurs("has columns that do not follow each other about the pan axis", where);
        last += step;
        pans[c] = last;
    }
    return pans;
}

} // namespace

ScanRecords recordsOf(const Scan& scan, const ScannerConstants<double>& believed, const std::string& where) {
    if (scan.columns < 16 || scan.column.size() != scan.pointsInScanner.size()) throw notOfOurs("has no grid", where);
    const int fronts = scan.columns - scan.columns / 2;
    ScanRecords result;
    result.records.resize(scan.pointsInScanner.size());
    result.faces.resize(result.records.size(), ScannerFace::front);
    for (const ScannerFace face : {ScannerFace::front, ScannerFace::back}) {
        const int first = face == ScannerFace::front ? 0 : fronts,
                  count = face == ScannerFace::front ? fronts : scan.columns - fronts;
        const std::vector<double> pans = pansOfColumns(scan, believed, first, count, face, where);
        const double range = pans.back() - pans.front();
        for (std::size_t c = 0; c < pans.size(); ++c)
            if (!(std::abs(pans[c] - pans.front() - range * static_cast<double>(c) / (count - 1)) <
                  kSteady * std::abs(range)))
                throw notOfOurs("was not taken at an even pan", where);
        result.panTurns = std::abs(range) / kTurn;
        const double radiansPerStep = std::numbers::pi / believed.panStepsPerHalfTurn;
        for (std::size_t i = 0; i < result.records.size(); ++i) {
            const int column = scan.column[i] - first;
            if (column < 0 || column >= count) continue;
            result.faces[i] = face;
            const auto record = recordAt(scan, i, believed, face);
            if (!record) continue;
            result.records[i] = *record;
            // The column says in which turn, its points where in it.
            const double expected = pans[static_cast<std::size_t>(column)];
            result.records[i].pan =
                (expected + std::remainder(record->pan * radiansPerStep - expected, kTurn)) / radiansPerStep;
        }
    }
    return result;
}

void readAnew(Scan& scan, const ScanRecords& records, const ScannerConstants<double>& constants) {
    for (std::size_t i = 0; i < records.records.size(); ++i) {
        const ScannerRecord& record = records.records[i];
        if (!(record.rangeMetres > 0)) continue;
        const auto p = scannedPoint<double>(constants, record.encoder, record.pan, record.rangeMetres);
        scan.pointsInScanner[i] = glm::vec3(glm::dvec3(p[0], p[1], p[2]));
    }
}

} // namespace scene
