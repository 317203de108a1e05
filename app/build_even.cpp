// refine, before all else of it: exposure and white balance of the images made even.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/camera_json.h"
#include "scene/depth_tiff.h"
#include "scene/refine/colour_evening.h"

#include <algorithm>
#include <cmath>

namespace app {

namespace {

using nlohmann::json;

constexpr int kEvenVersion = 2;

json describe(const ImportedImages& imported, const scene::ColourEvening& evening) {
    json images = json::object();
    double most = 0;
    for (std::size_t i = 0; i < evening.factors.size(); ++i) {
        const glm::dvec3& f = evening.factors[i];
        if (f == glm::dvec3(1)) continue;
        images[imported.images[i].name] = {f.x, f.y, f.z};
        for (int c = 0; c < 3; ++c)
            most = std::max(most, std::abs(std::log2(f[c])));
    }
    return {{"factors", images},
            {"pairs", evening.pairs},
            {"seam_before", evening.seamBefore},
            {"seam_after", evening.seamAfter},
            {"changed", evening.changed},
            {"limited", evening.limited},
            {"most_stops", most}};
}

} // namespace

json evenPhotographs(PhotographStage& photographs, const BuildOptions& options, StageStore& store) {
    if (!options.evenColour) return nullptr;
    ImportedImages all;
    std::vector<std::string> keys;
    for (const ScanPhotographs& some : photographs.ofScan) {
        all.images.insert(all.images.end(), some.images.begin(), some.images.end());
        keys.push_back(some.key);
    }
    if (all.images.empty()) return nullptr;
    all.key = keyOf(keys);
    const json report = evenImages(all, findOverlaps(all, options), options, store);
    auto image = all.images.begin();
    for (ScanPhotographs& some : photographs.ofScan) {
        if (!some.key.empty()) some.key = keyOf({some.key, all.key});
        for (scene::StoredImage& own : some.images)
            own = *image++;
    }
    return report;
}

json evenImages(ImportedImages& imported, const Overlaps& overlaps, const BuildOptions& options, StageStore& store,
                double spentStops) {
    if (!options.evenColour) return nullptr;
    scene::ColourEveningOptions o;
    o.mostStops = std::max(o.mostStops - spentStops, 0.0);
    const std::string key =
        keyOf({kEvenVersion, imported.key, o.maxPartners, o.samplesPerPair, o.leastSamples, o.priorStops, o.mostStops,
               o.leastChange, o.comparison.sameSurface, o.comparison.pixelError});
    const std::filesystem::path folder = store.find("evened", key, [&](const std::filesystem::path& part) {
        Progress progress("colours", 2 * imported.images.size());
        scene::ImageStore images(imported.images, options.memoryBytes / 2, store.folder());
        const scene::ColourEvening evening =
            scene::evenColours(images, overlaps.partners, o, [&] { progress.advance(); });
        scene::visitEach(images, 2, [&](std::size_t i) { // one that is lent, and its copy
            if (evening.factors[i] != glm::dvec3(1)) {
                scene::DepthImage image = *images.borrow(i);
                applyFactors(image.colour, evening.factors[i]);
                writeDepthTiff(image, part / (image.name + ".tiff"));
            }
            progress.advance();
        });
        writeWhole(part / "evening.json", describe(imported, evening).dump());
    });
    json report = readJson(folder / "evening.json");
    for (scene::StoredImage& image : imported.images)
        if (report.at("factors").contains(image.name)) image.file = folder / (image.name + ".tiff");
    imported.key = key;
    return report;
}

} // namespace app
