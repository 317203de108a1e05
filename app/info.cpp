#include "app/info.h"

#include "app/notes.h"
#include "scene/errors.h"
#include "scene/scene_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace app {

namespace {

using nlohmann::json;

/// Names of files and what people wrote, in one line.
std::string shown(const json& text) {
    return scene::onOneLine(text.get<std::string>());
}

std::uintmax_t bytesOnDisk(const std::filesystem::path& folder) {
    std::uintmax_t bytes = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) bytes += entry.file_size();
    return bytes;
}

std::string shareText(double part, double whole) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f %%", whole > 0 ? 100 * part / whole : 0.0);
    return text;
}

/// What was done to colours.
void printEvening(const char* of, const json& evening) {
    if (evening.is_null()) return;
    const double before = evening.at("seam_before"), after = evening.at("seam_after");
    if (evening.at("changed") == 0) {
        std::printf("  %-10s even as captured: they differ by %s across %lld overlaps\n", of,
                    shareText(before, 1).c_str(), evening.at("pairs").get<long long>());
        return;
    }
    std::printf("  %-10s made even: across %lld overlaps they differ by %s instead of %s; images changed by up to "
                "%.2f stops\n",
                of, evening.at("pairs").get<long long>(), shareText(after, 1).c_str(), shareText(before, 1).c_str(),
                evening.at("most_stops").get<double>());
    if (const auto limited = evening.at("limited").get<long long>(); limited > 0)
        std::printf("             %lld images are too dark to be brightened enough without noise\n", limited);
}

/// What was done beside silhouettes.
void printSilhouettes(const json& silhouettes) {
    if (silhouettes.is_null()) return;
    if (silhouettes.at("changed").empty())
        std::printf("  edges      as captured: of the near sides of silhouettes others saw through %s\n",
                    shareText(silhouettes.at("seen_through").get<double>(), 1).c_str());
    else
        std::printf("  edges      laid where the photographs have them: samples moved %lld times to the surface on the "
                    "other side of a silhouette, and range was guessed %lld times where none was measured; before, "
                    "others saw through %s of the near sides\n",
                    silhouettes.at("moved").get<long long>(), silhouettes.at("guessed").get<long long>(),
                    shareText(silhouettes.at("seen_through").get<double>(), 1).c_str());
}

/// Where scans stand, and how well that is known.
void printRegistration(const json& registration) {
    if (registration.is_null()) return;
    std::size_t registered = 0, leftOut = 0;
    std::set<std::string> groups;
    for (const json& scan : registration.at("scans")) {
        leftOut += scan.value("left_out", false);
        if (!scan.at("registered").get<bool>()) continue;
        ++registered;
        groups.insert(scan.at("group").get<std::string>());
    }
    const std::string apart =
        groups.size() > 1 ? ", in " + std::to_string(groups.size()) + " groups that nothing joins" : "";
    std::printf("  registered %zu of %zu scans%s", registered, registration.at("scans").size(), apart.c_str());
    if (registered > 0)
        std::printf("; surfaces lie on each other to %.1f mm", 1e3 * registration.at("rms_m").get<double>());
    if (leftOut > 0) std::printf("; %zu left out, since nothing says where they stand", leftOut);
    std::printf("\n");
    for (const json& pair : registration.at("pairs")) {
        if (!pair.at("used").get<bool>()) {
            std::printf("  pair       %s, %s: %s; overlap %s\n", shown(pair.at("a")).c_str(),
                        shown(pair.at("b")).c_str(), pair.at("verdict").get<std::string>().c_str(),
                        shareText(pair.at("overlap"), 1).c_str());
            continue;
        }
        std::printf("  pair       %s, %s: %s; overlap %s, %.2f %% against, residual %.1f mm, known to %.1f mm and "
                    "%.3f degrees\n",
                    shown(pair.at("a")).c_str(), shown(pair.at("b")).c_str(),
                    pair.at("verdict").get<std::string>().c_str(), shareText(pair.at("overlap"), 1).c_str(),
                    100 * pair.at("against_share").get<double>(), 1e3 * pair.at("rms_m").get<double>(),
                    1e3 * pair.at("deviation_m").get<double>(), pair.at("deviation_deg").get<double>());
    }
}

/// How far apart scans have what they both show.
void printScanAgreement(const json& agreement) {
    if (agreement.is_null() || agreement.at("pairs").empty()) return;
    std::vector<double> apart;
    for (const json& pair : agreement.at("pairs"))
        apart.push_back(pair.at("apart_m"));
    const auto middle = apart.begin() + std::ssize(apart) / 2;
    std::nth_element(apart.begin(), middle, apart.end());
    const json& pairs = agreement.at("pairs");
    const auto& worst = *std::max_element(pairs.begin(), pairs.end(), [](const json& a, const json& b) {
        return a.at("apart_m").get<double>() < b.at("apart_m").get<double>();
    });
    std::printf(
        "  scans      where two show the same surfaces they have them %.1f mm apart (median of %zu pairs, across "
        "surfaces); farthest apart %s and %s: %.1f mm\n",
        1e3 * *middle, apart.size(), shown(worst.at("a")).c_str(), shown(worst.at("b")).c_str(),
        1e3 * worst.at("apart_m").get<double>());
}

/// What became of the poses that photographs were given.
void printPoses(const json& poses) {
    if (poses.is_null()) return;
    const double before = poses.at("before").at("range_share"), after = poses.at("after").at("range_share");
    const int adjusted = poses.at("adjusted");
    if (poses.at("before").at("samples") == 0) {
        std::printf("  poses      as given: photographs have nothing in common to be laid on each other by\n");
        return;
    }
    if (adjusted == 0) {
        std::printf("  poses      as given%s: surfaces lie on each other to %.3f %% of their range\n",
                    poses.at("worse").get<bool>() ? ", nothing fits better" : "", 100 * before);
        return;
    }
    std::printf("  poses      of %d of %zu photographs adjusted, in the mean by %.1f mm and %.2f degrees, at most %.1f "
                "and %.2f: "
                "surfaces lie on each other to %.3f %% of their range and %.2f %% of them where another saw through, "
                "as given %.3f and %.2f\n",
                adjusted, poses.at("images").size(), 1e3 * poses.at("mean_m").get<double>(),
                poses.at("mean_deg").get<double>(), 1e3 * poses.at("most_m").get<double>(),
                poses.at("most_deg").get<double>(), 100 * after,
                100 * poses.at("after").at("against_share").get<double>(), 100 * before,
                100 * poses.at("before").at("against_share").get<double>());
}

/// How photographs were laid on their scans, and how sure that is.
void printPhotographs(const json& photographs) {
    if (photographs.is_null()) return;
    for (const json& photo : photographs) {
        std::printf("  photograph %s of %s: %s", shown(photo.at("name")).c_str(), shown(photo.at("scan")).c_str(),
                    photo.at("verdict").get<std::string>().c_str());
        if (photo.at("sure").get<bool>())
            std::printf("; %s by %.3f degrees, known to %.3f",
                        photo.at("verdict") == "as given" ? "fits best if turned" : "turned",
                        photo.at("turned_deg").get<double>(), photo.at("deviation_deg").get<double>());
        else
            std::printf(" (%s)", shown(photo.at("why")).c_str());
        std::printf("; the next best turn scores %s, %s of its parts agree\n",
                    shareText(photo.at("rival_share"), 1).c_str(), shareText(photo.at("agreeing"), 1).c_str());
    }
}

/// How large the place is: units that were mistaken show here at a glance.
struct Extent {
    glm::dvec3 placesMetres{0};                   ///< along the world's axes
    double medianMetres = 0, nearlyAllMetres = 0; ///< of all that images show, along their axes
};
json metresOrNothing(double metres) {
    return metres > 0 ? json(metres) : json();
}

Extent extentOf(const scene::Scene& scene, const json& figures) {
    Extent extent;
    // Scenes of before do not say.
    extent.medianMetres = figures.value("shown_median_m", 0.0);
    extent.nearlyAllMetres = figures.value("shown_nearly_all_m", 0.0);
    if (scene.images.empty()) return extent;
    glm::dvec3 low = scene.images.front().worldFromCamera.translation, high = low;
    for (const scene::SceneImage& image : scene.images) {
        low = glm::min(low, image.worldFromCamera.translation);
        high = glm::max(high, image.worldFromCamera.translation);
    }
    extent.placesMetres = high - low;
    return extent;
}

void printNotes(const Notes& notes) {
    for (const Note& note : notes.list) {
        const glm::dvec3 &a = note.from, &b = note.to;
        const json known = note.fields.value("known_to_m", json());
        std::array<char, 48> knownTo{};
        if (known.is_number())
            std::snprintf(knownTo.data(), knownTo.size(), ", known to %.1f mm%s", 1e3 * known.get<double>(),
                          note.kind == Note::Kind::point ? " within its set-up" : "");
        if (note.kind == Note::Kind::point)
            std::printf("  point      %s: %.3f %.3f %.3f%s\n", shown(note.label).c_str(), a.x, a.y, a.z,
                        knownTo.data());
        if (note.kind == Note::Kind::distance)
            std::printf("  distance   %s: from %.3f %.3f %.3f to %.3f %.3f %.3f, %.3f m%s\n", shown(note.label).c_str(),
                        a.x, a.y, a.z, b.x, b.y, b.z, glm::distance(a, b), knownTo.data());
    }
}

void printText(const scene::Scene& scene, const json& info, const Extent& extent, const Notes& notes) {
    const json& f = info.at("figures");
    const auto number = [&](const char* key) { return f.at(key).get<double>(); };
    std::printf("%s\n", scene.folder.string().c_str());
    for (const json& input : info.at("provenance").at("inputs"))
        std::printf("  from       %s\n", shown(input).c_str());
    std::printf("  images     %zu, %zu held out, %.0f overlapping pairs\n", scene.images.size(), scene.heldOut.size(),
                number("overlapping_pairs"));
    std::printf("  extent     they stand within %.2f x %.2f x %.2f m", extent.placesMetres.x, extent.placesMetres.y,
                extent.placesMetres.z);
    if (extent.medianMetres > 0)
        std::printf("; half of what they show is within %.2f m of them, 99 %% of it within %.2f m", extent.medianMetres,
                    extent.nearlyAllMetres);
    std::printf("\n");
    if (number("scan_points") > 0)
        std::printf("  scans      %.0f points, %.0f held, %.0f dropped\n", number("scan_points"),
                    number("scan_points_held"), number("scan_points_dropped"));
    printRegistration(info.value("registration", json()));
    printScanAgreement(info.value("scan_agreement", json()));
    printPoses(info.value("poses", json()));
    printEvening("photos", info.value("photograph_evening", json()));
    printEvening("colours", info.value("colour_evening", json()));
    printPhotographs(info.value("photographs", json()));
    printSilhouettes(info.value("silhouettes", json()));
    std::printf("  samples    %.0f; kept %s as base, %s for other directions; %.0f float in empty space\n",
                number("samples"), shareText(number("samples_base"), number("samples")).c_str(),
                shareText(number("samples_directional"), number("samples")).c_str(), number("samples_floating"));
    if (f.value("samples_closed", 0.0) > 0) // older scenes do not say
        std::printf("  closed     %.0f kept samples lie more than a pixel from what was measured, shown as filled\n",
                    number("samples_closed"));
    if (number("guesses_confirmed") + number("guesses_refuted") + number("guesses_open") > 0)
        std::printf(
            "  guesses    of range where none was measured: %.0f confirmed by other images, %.0f refuted; of the "
            "%.0f others %.0f kept, shown as filled\n",
            number("guesses_confirmed"), number("guesses_refuted"), number("guesses_open"), number("guesses_kept"));
    std::printf("  skins      %s of the triangles by planarity, %s more seen through by another image\n",
                shareText(number("triangles_skin_planarity"), number("triangles")).c_str(),
                shareText(number("triangles_skin_seen_through"), number("triangles")).c_str());
    if (scene.coverage)
        std::printf("  coverage   %.0f nodes, cells down to %.1f mm; in the box about all samples and cameras %.1f m3 "
                    "seen empty, %.1f m3 "
                    "never observed\n",
                    number("coverage_nodes"), 1e3 * number("coverage_finest_m"), number("coverage_empty_m3"),
                    number("coverage_unseen_m3"));
    std::printf("  tiles      %.0f, and %.0f of coarser levels, %.1f MB; scene %.1f MB on disk\n", number("tiles"),
                number("tiles_coarser"), static_cast<double>(scene.tilesFile.bytes().size()) / 1e6,
                info["bytes_on_disk"].get<double>() / 1e6);
    for (const json& reason : info.at("built"))
        std::printf("  built      %s\n", shown(reason).c_str());
    for (const json& remark : info.at("provenance").at("remarks"))
        std::printf("  note       %s\n", shown(remark).c_str());
    printNotes(notes);
}

} // namespace

void printInfo(const std::filesystem::path& folder, bool asJson) {
    const scene::Scene scene = scene::openScene(folder);
    json info = json::parse(scene.manifest);
    Notes notes;
    std::optional<scene::Failure> damage; // of the notes: the rest of the scene is as good as it was, and told
    info["notes"] = json::array();
    try {
        notes = NotesFile(folder).read();
        for (const Note& note : notes.list)
            info["notes"].push_back(note.fields);
    } catch (const scene::Failure& failure) {
        info["notes"] = nullptr;
        damage = failure;
    }
    info["bytes_on_disk"] = bytesOnDisk(folder);
    info["tiles_bytes"] = scene.tilesFile.bytes().size();
    const Extent extent = extentOf(scene, info.at("figures"));
    info["extent"] = {{"places_m", {extent.placesMetres.x, extent.placesMetres.y, extent.placesMetres.z}},
                      {"median_depth_m", metresOrNothing(extent.medianMetres)},
                      {"nearly_all_depth_m", metresOrNothing(extent.nearlyAllMetres)}};
    if (asJson)
        std::printf("%s\n", info.dump(1, ' ', false, json::error_handler_t::replace).c_str());
    else
        printText(scene, info, extent, notes);
    if (damage) throw *damage;
}

} // namespace app
