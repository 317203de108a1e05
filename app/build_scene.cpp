#include "app/build_scene.h"

#include "app/build_stages.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/scan_agreement.h"
#include "app/scene_folder.h"
#include "scene/align/scanner_file.h"
#include "scene/errors.h"
#include "scene/import/importer.h"
#include "scene/import/scan_photos.h"
#include "scene/unfinished_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <limits>

#include <unistd.h>

namespace app {

namespace {

/// What one asks for and the capture cannot give is not passed over.
void checkWishes(const BuildOptions& options, const scene::Capture& capture) {
    checkPositionsWish(options.positions, capture);
    if (options.mostPositions > 0 && !options.positions.isSearched)
        throw scene::Failure("is for positions that are searched for", std::string("--count"),
                             "leave it out, or ask for --positions auto");
    const std::string& how = options.registration;
    if (!how.empty() && how != "given" && capture.scans.empty() && capture.photos.empty())
        throw scene::Failure("is for laser scans and photographs, and there are none", std::string("--register"),
                             "leave it out");
    if (options.movesScans() && how != "auto" && capture.scans.empty())
        throw scene::Failure("is a file about laser scans, and there are none", std::string("--register"),
                             "leave it out");
    std::error_code error;
    if (options.movesScans() && how != "auto" && !std::filesystem::is_regular_file(how, error))
        throw scene::Failure("no such file", how, "say given, auto, or name a file of places on planes");
    if (!options.scanner.empty() && capture.scans.empty())
        throw scene::Failure("is for laser scans, and there are none", std::string("--scanner"), "leave it out");
    if (options.cubeFaces.opensSky && (!options.findUnseen || capture.scans.empty()))
        throw scene::Failure("says what scans saw to be empty, and that is not asked for", std::string("--open-sky"),
                             "give --coverage and laser scans, or leave it out");
    if (!capture.polygons.empty() && !options.holdOut.empty())
        throw scene::Failure("keeps photographs out, and polygons have none", std::string("--hold-out"),
                             "leave it out");
}

/// Who holds photographs out wants to compare with them.
void checkHeldOut(const scene::HeldOut& heldOut, const BuildOptions& options, const scene::Capture& capture) {
    if (options.holdOut.empty() || !heldOut.empty()) return;
    const std::size_t photographs = capture.photos.size() + capture.scanPhotos.size();
    const std::string where = "--hold-out " + options.holdOut;
    if (photographs == 0) throw scene::Failure("keeps photographs out, and there are none", where, "leave it out");
    throw scene::Failure("keeps none of " + std::to_string(photographs) + " photographs out", where,
                         "begin earlier, or leave it out");
}

/// Some photographs beside scans cannot be laid on them.
void checkLaid(const scene::HeldOut& heldOut, const PhotographStage& photographs, const BuildOptions& options) {
    if (heldOut.photos.empty() && !heldOut.scanPhotos.empty() && photographs.heldOut.empty())
        throw scene::Failure("keeps photographs out that cannot be laid on their scans",
                             "--hold-out " + options.holdOut,
                             "name others, or take them as the file has them with --register given");
}

/// The first few of many, in quotation marks.
std::string someOf(const std::vector<std::string>& names) {
    constexpr std::size_t kNamed = 5;
    std::string list;
    for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i)
        list += (i > 0 ? ", '" : "'") + names[i] + "'";
    return names.size() > kNamed ? list + " and " + std::to_string(names.size() - kNamed) + " more" : list;
}

/// Photographs that the others contradict, and those of which no other can say anything.
void sayWhichStandAlone(const Overlaps& overlaps, const SkinStage& skins, scene::Capture& capture) {
    if (!capture.isOfPhotographsAlone() || skins.images.size() < 2) return;
    std::vector<std::string> contradicted, unseen;
    for (const scene::Contradiction& contradiction : skins.contradictions)
        contradicted.push_back(skins.images[contradiction.image].name);
    for (std::size_t i = 0; i < skins.images.size(); ++i)
        if (overlaps.partners[i].empty()) unseen.push_back(skins.images[i].name);
    const auto pick = [](const std::vector<std::string>& names, const char* one, const char* several) {
        return names.size() == 1 ? std::string(one) : several;
    };
    if (!contradicted.empty())
        tell(capture,
             "The others contradict " + someOf(contradicted) + ": of what is said of each other's samples up to " +
                 std::to_string(std::lround(100 * skins.contradictions.front().share)) +
                 " % is that somebody saw through them. " +
                 pick(contradicted,
                      "Its pose, focal length or range is wrong: correct it, or leave the photograph out.",
                      "Pose, focal length or range of each is wrong: correct it, or leave these photographs out."));
    if (!unseen.empty())
        tell(capture, "No other photograph of the scene shows, even roughly, what " + someOf(unseen) +
                          pick(unseen, " shows: nothing tells whether it stands where it is said to.",
                               " show: nothing tells whether they stand where they are said to."));
}

/// Images whose poses are right see through few of each other's samples: at most 2.5 % of any capture that we have.
void sayIfContradictory(const scene::SkinFigures& figures, const BuildOptions& options, scene::Capture& capture) {
    constexpr double kContradictory = 0.1;
    const double share = static_cast<double>(figures.floating) / static_cast<double>(figures.samples);
    if (share < kContradictory) return;
    const std::string much =
        std::to_string(static_cast<int>(100 * share)) + " % of the samples stand where other images saw through";
    if (capture.scans.size() > 1)
        tell(capture, "Scans contradict each other: " + much + ", and are not drawn. " +
                          (!options.movesScans() ? "Their poses are wrong: --register auto finds others."
                                                 : "Some of their poses are wrong: revisit info says how "
                                                   "they were registered."));
    else
        tell(capture, "Images contradict each other: " + much +
                          ", and are not drawn. Poses, focal lengths or the unit of range may be wrong.");
}

/// Files of scans that nobody registered often have all of them at the origin.
void sayIfAtOnePlace(const BuildOptions& options, scene::Capture& capture) {
    if (options.movesScans()) return;
    const auto placeOf = [](const scene::ScanSource& scan) { return scan.worldFromScanner.translation; };
    for (auto scan = capture.scans.begin(); scan != capture.scans.end(); ++scan) {
        const auto other = std::find_if(std::next(scan), capture.scans.end(),
                                        [&](const scene::ScanSource& of) { return placeOf(of) == placeOf(*scan); });
        if (other == capture.scans.end()) continue;
        return tell(capture, "Scans '" + scan->name + "' and '" + other->name +
                                 "' stand at the same place in their files: if they were not taken from there, "
                                 "--register auto finds out how they stand.");
    }
}

/// Scanners and depth cameras of our day see neither so near nor so far; files in millimetres look as if they did.
void sayIfOtherUnits(double medianMetres, scene::Capture& capture) {
    constexpr double kNearest = 0.05, kFarthest = 300;
    if (medianMetres == 0 || (medianMetres >= kNearest && medianMetres <= kFarthest)) return;
    std::array<char, 32> metres{};
    if (medianMetres < kNearest) {
        std::snprintf(metres.data(), metres.size(), "%.1g", medianMetres);
        return tell(capture, std::string("What images and scans show is some ") + metres.data() +
                                 " m away: if that is not so, their unit is not the metre; export them in metres.");
    }
    const double step = std::pow(10, std::floor(std::log10(medianMetres)));
    std::snprintf(metres.data(), metres.size(), "%.0f", step * std::round(medianMetres / step));
    tell(capture, std::string("What images and scans show is some ") + metres.data() +
                      " m away: if that is not so, their unit is not the metre (millimetres?); export them in metres.");
}

/// The stages of a build, one after the other.
void runStages(scene::Capture& capture, scene::HeldOut heldOut, const BuildOptions& options, StageStore& store,
               const std::filesystem::path& output) {
    BuildReports reports;
    reports.registration = registerCapture(capture, heldOut, options, store);
    reports.poses = adjustPoses(capture, heldOut.photos, options, store);
    PhotographStage photographs = layPhotographs(capture, heldOut.scanPhotos, options, store);
    checkLaid(heldOut, photographs, options);
    reports.photographEvening = evenPhotographs(photographs, options, store);
    ImportedImages imported = capture.polygons.empty()
                                  ? importImages(capture, heldOut.photos, photographs, options, store)
                                  : capturePolygons(capture, options, store);
    const Overlaps overlaps = findOverlaps(imported, options);
    sayIfOtherUnits(overlaps.medianMetres, capture);
    const double spentStops =
        reports.photographEvening.is_null() ? 0 : reports.photographEvening.at("most_stops").get<double>();
    reports.evening = evenImages(imported, overlaps, options, store, spentStops);
    if (capture.isOfPhotographsAlone()) reports.silhouettes = settleSilhouettes(imported, overlaps, options, store);
    SkinStage skins = markSkins(imported, overlaps, options, store);
    // How scans stand is registration's to tell, and polygons stand where they stand.
    if (!capture.isOfPhotographsAlone()) skins.contradictions.clear();
    if (skins.figures.samples == 0) throw nothingToBuild(options);
    for (const std::string& scan : imported.emptyScans)
        tell(capture, "Scan '" + scan + "' holds no point with range: nothing of it is in the scene.");
    sayIfContradictory(skins.figures, options, capture);
    sayWhichStandAlone(overlaps, skins, capture);
    const ScanAgreement agreement = scanAgreement(imported.scans, skins.ofImages);
    for (const std::string& remark : remarksOn(agreement, imported.scans, !options.movesScans()))
        tell(capture, remark);
    reports.scanAgreement = describe(agreement, imported.scans);
    const KeepStage kept = keepBest(imported, overlaps, skins, options, store);
    const TileStage tiles = fuseAndCut(imported, overlaps, skins, kept, options, store);
    const CoverageStage coverage = coverSpace(skins, options, store);
    writeScene(output, capture, heldOut.photos, photographs.heldOut, imported, overlaps, skins, kept, tiles, coverage,
               reports, options);
}

/// Of the computer; without end where the system does not say.
std::uint64_t physicalMemoryBytes() {
    const long pages = sysconf(_SC_PHYS_PAGES), pageBytes = sysconf(_SC_PAGE_SIZE);
    if (pages <= 0 || pageBytes <= 0) return std::numeric_limits<std::uint64_t>::max();
    return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(pageBytes);
}

/// What to throw where a file of an earlier run cannot be read: whoever wrote that reader did not know whose file it
/// is.
scene::Failure damagedStage(const std::string& message, const std::filesystem::path& work) {
    return {"holds results of an earlier run that are damaged (" + message.substr(0, message.rfind("; ")) + ")", work,
            "remove this folder and build again"};
}

/// Who has no room on the disk may have it in results of other options.
scene::Failure withoutRoom(const std::string& message, const std::filesystem::path& work) {
    const std::size_t colon = message.find(": "), remedy = message.size() - std::strlen(scene::kWriteRemedy);
    return {message.substr(colon + 2, remedy - std::strlen("; ") - colon - 2), message.substr(0, colon),
            scene::kWriteRemedy + (" (results of earlier builds in " + work.string() + " may be removed)")};
}

} // namespace

void tell(scene::Capture& capture, const std::string& sentence) {
    sayNote(sentence);
    capture.remarks.push_back(sentence);
}

void buildScene(const BuildOptions& options) {
    scene::Capture capture = scene::openCapture(options.inputs);
    checkWishes(options, capture);
    checkScanSizes(capture.scans, physicalMemoryBytes());
    if (!options.scanner.empty()) {
        const scene::ScannerReading reading = scene::readScannerFile(options.scanner);
        for (scene::ScanSource& scan : capture.scans)
            scan.reading = reading;
    }
    if (!options.camera.empty()) useCameraFile(capture, options.camera);
    const scene::HeldOut heldOut = scene::findHeldOut(capture, options.holdOut);
    checkHeldOut(heldOut, options, capture);
    if (capture.isOfPhotographsAlone() && heldOut.photos.size() == capture.photos.size()) throw nothingToBuild(options);
    for (const std::string& remark : capture.remarks)
        sayNote(remark);
    sayIfAtOnePlace(options, capture);

    const std::filesystem::path output = placeOfScene(options.output);
    checkReplaceable(output, options.inputs);
    std::filesystem::path work = output;
    work += ".build";
    StageStore store(work);
    try {
        runStages(capture, heldOut, options, store, output);
    } catch (const scene::Failure& failure) {
        const std::string message = failure.what();
        const bool isAboutRoom = message.ends_with(scene::kWriteRemedy);
        if (isAboutRoom && store.hasOlder()) throw withoutRoom(message, work);
        if (message.starts_with(work.string() + "/") && !isAboutRoom) throw damagedStage(message, work);
        throw;
    }
}

} // namespace app
