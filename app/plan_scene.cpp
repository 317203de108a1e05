#include "app/plan_scene.h"

#include "app/output_file.h"
#include "app/plan_picture.h"
#include "app/say.h"
#include "app/selection.h"
#include "app/stage_store.h"

#include "scene/errors.h"
#include "scene/scene_file.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace app {

namespace {

/// Six faces of a cube are one place.
std::vector<glm::dvec3> placesOf(const scene::Scene& scene) {
    constexpr double kSameMetres = 0.01;
    std::vector<glm::dvec3> places;
    for (const scene::SceneImage& image : scene.images)
        if (places.empty() || glm::distance(places.back(), image.worldFromCamera.translation) > kSameMetres)
            places.push_back(image.worldFromCamera.translation);
    return places;
}

/// Places from which images look all round; photographs beside a scan are no scanner.
std::ptrdiff_t scannersOf(const scene::Scene& scene) {
    const ReferencePositions positions = referencePositionsOf(scene.images);
    std::vector<std::size_t> images(positions.places.size());
    for (const std::uint32_t position : positions.positionOf)
        ++images[position];
    return std::ranges::count_if(images, [](std::size_t count) { return count >= kImagesPerPosition; });
}

/// Places are no better than the poses of what they are reckoned from.
void sayHowScansStand(const scene::Scene& scene) {
    const nlohmann::json manifest = nlohmann::json::parse(scene.manifest);
    const nlohmann::json registration = manifest.value("registration", nlohmann::json());
    if (registration.is_null()) {
        if (scannersOf(scene) > 1 && manifest.at("figures").at("scan_points") > 0)
            sayNote("scans are taken to stand where their files say: nobody has compared them ('revisit build "
                    "--register auto' does)");
        return;
    }
    const nlohmann::json& scans = registration.at("scans");
    std::size_t apart = 0, leftOut = 0;
    for (const nlohmann::json& scan : scans)
        if (scan.value("left_out", false))
            ++leftOut;
        else if (!scan.at("registered").get<bool>())
            ++apart;
    const std::string all = " of " + std::to_string(scans.size()) + " scans ";
    if (apart > 0)
        sayNote(std::to_string(apart) + all +
                "could not be registered to the others and are taken to stand where their files say");
    if (leftOut > 0)
        sayNote(std::to_string(leftOut) + all +
                "are not in the scene, since nothing says where they stand: what they saw counts as unseen");
}

/// Neither the plan nor the picture, whose name nobody gave, takes the place of anything but those of before.
void checkPlanAndPicture(const std::filesystem::path& out, const std::filesystem::path& picture) {
    std::error_code ignored;
    if (std::filesystem::is_other(out, ignored))
        throw scene::Failure("is no file, and a picture stands beside the plan", out, "name a file, as plan.json");
    bool hasPicture = false; // of the plan that stands there
    checkReplaceableFile(out, {}, [&](const nlohmann::json& plan) {
        const bool isPlan = plan.is_object() && plan.value("revisit", nlohmann::json()) == "plan";
        hasPicture = isPlan && plan.value("picture", nlohmann::json()) == picture.filename().string();
        return isPlan;
    });
    if (!hasPicture && std::filesystem::exists(std::filesystem::symlink_status(picture, ignored)))
        throw scene::Failure("would be replaced by the plan's picture, and no plan of that name speaks of it", picture,
                             "move it away, or give another name with --out");
}

nlohmann::json toJson(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

void print(const scene::NextScanPlan& plan, const PlanOptions& options) {
    std::printf("%.1f m3 of the %.1f m3 within the upright box about all surfaces were never seen\n",
                plan.unseenCubicMetres, plan.bounds.cubicMetres());
    if (plan.candidates == 0)
        std::printf("no place to stand was found: none with floor below it that was seen and is not raised above "
                    "the floor beside it, and with %.1f m of space about it that was seen empty\n",
                    options.next.clearanceMetres);
    else if (plan.scans.empty())
        std::printf(
            "nothing is left to reveal: no place would show a worthwhile part of the %.1f m3 that nobody has seen\n",
            plan.unseenCubicMetres);
    int number = 0;
    for (const scene::NextScan& scan : plan.scans) {
        const glm::dvec3 &world = scan.positionInWorld, &walk = scan.positionInWalk;
        std::printf("  %d  at %.2f %.2f %.2f (walk %.2f %.2f %.2f): should reveal %.1f m3, %.1f %% of what is unseen\n",
                    ++number, world.x, world.y, world.z, walk.x, walk.y, walk.z, scan.revealsCubicMetres,
                    100 * scan.revealsShare);
    }
    if (!plan.scans.empty() && plan.scans.size() < static_cast<std::size_t>(options.next.count))
        std::printf("  no further place would show a worthwhile part more\n");
}

} // namespace

void planScene(const PlanOptions& options) {
    std::filesystem::path picture = options.out;
    if (picture.extension() == ".json") picture.replace_extension();
    if (options.out.extension() != ".png") picture += ".png";
    std::error_code ignored;
    if (!options.out.has_filename() || std::filesystem::is_directory(options.out, ignored))
        throw scene::Failure("is a folder", options.out, "give the name of the JSON file to write, as plan.json");
    if (picture == options.out)
        throw scene::Failure("is the name of the picture", options.out,
                             "give the name of the JSON file, as plan.json; the picture stands beside it");
    const std::filesystem::path folder = std::filesystem::absolute(options.out).parent_path();
    if (!std::filesystem::is_directory(folder)) // said now, not when all is found out
        throw scene::Failure("no such folder", folder, "make it, or name a file elsewhere");
    checkPlanAndPicture(options.out, picture);
    const scene::Scene scene = scene::openScene(options.scene);
    if (!scene.coverage)
        throw scene::Failure("does not say what was never observed", options.scene,
                             "build it again with 'revisit build --coverage'");
    const std::vector<glm::dvec3> stood = placesOf(scene);
    const scene::NextScanPlan plan = scene::planNextScans(*scene.coverage, scene.walkFromWorld, stood, options.next);

    nlohmann::json positions = nlohmann::json::array(), before = nlohmann::json::array();
    for (const scene::NextScan& scan : plan.scans)
        positions.push_back({{"position", toJson(scan.positionInWorld)},
                             {"walk", toJson(scan.positionInWalk)},
                             {"reveals_m3", scan.revealsCubicMetres},
                             {"reveals_share", scan.revealsShare}});
    for (const glm::dvec3& place : stood)
        before.push_back(toJson(place));
    const nlohmann::json file{{"revisit", "plan"},
                              {"scene", options.scene.string()},
                              {"picture", picture.filename().string()},
                              {"tripod_m", options.next.tripodMetres},
                              {"candidates", plan.candidates},
                              {"box_m3", plan.bounds.cubicMetres()},
                              {"unseen_m3", plan.unseenCubicMetres},
                              {"stood", before},
                              {"positions", positions}};
    writeWhole(options.out, file.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    writeWhole(picture, drawPlan(scene, plan, stood));
    print(plan, options);
    sayHowScansStand(scene);
    std::printf("%s and %s\n", options.out.string().c_str(), picture.filename().string().c_str());
}

} // namespace app
