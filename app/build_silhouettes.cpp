// refine, before skins: samples beside silhouettes laid on the side at which the photographs agree.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/depth_tiff.h"
#include "scene/refine/silhouettes.h"

#include <set>

namespace app {

namespace {

using nlohmann::json;

constexpr int kSilhouetteVersion = 2;

/// Lays silhouettes anew, round after round; the images as they are after the last go into `part`. Returns what
/// changed, summed over the rounds.
std::vector<scene::SilhouetteFigures> settle(const std::vector<scene::StoredImage>& imported, const Overlaps& overlaps,
                                             const BuildOptions& options, const std::filesystem::path& part,
                                             const std::filesystem::path& spillFolder) {
    const scene::SilhouetteOptions& o = options.silhouettes;
    std::vector<scene::SilhouetteFigures> figures(imported.size());
    std::vector<scene::StoredImage> before = imported;
    // An image and those it asks are held together, with the new one and what is found on the way.
    const std::size_t imagesEach = static_cast<std::size_t>(o.maxPartners) + 6;
    Progress progress("silhouettes", static_cast<std::size_t>(o.rounds) * imported.size());
    for (int round = 0; round < o.rounds; ++round) {
        // Each round reads what the one before wrote, so none writes over it.
        const std::filesystem::path folder = round + 1 < o.rounds ? part / std::to_string(round) : part;
        std::filesystem::create_directories(folder);
        std::vector<scene::StoredImage> after = before;
        scene::ImageStore images(before, options.memoryBytes / 2, spillFolder);
        const auto settleOne = [&](std::size_t i) {
            scene::SilhouetteFigures f;
            const scene::DepthImage settled = scene::settleSilhouettes(images, i, overlaps.partners[i], o, f);
            if (f.areChanged() || figures[i].areChanged()) {
                after[i].file = folder / (settled.name + ".tiff");
                writeDepthTiff(settled, after[i].file);
            }
            figures[i].contested = f.contested, figures[i].moved += f.moved, figures[i].guessed += f.guessed;
            progress.advance();
        };
        scene::visitEach(images, imagesEach, settleOne);
        before = std::move(after);
    }
    std::error_code ignored;
    for (int round = 0; round + 1 < o.rounds; ++round)
        std::filesystem::remove_all(part / std::to_string(round), ignored);
    return figures;
}

json describe(const scene::SilhouetteVerdict& verdict, const std::vector<scene::StoredImage>& imported,
              const std::vector<scene::SilhouetteFigures>& figures) {
    json changed = json::array();
    scene::SilhouetteFigures all;
    for (std::size_t i = 0; i < figures.size(); ++i) {
        if (figures[i].areChanged()) changed.push_back(imported[i].name);
        all.contested += figures[i].contested, all.moved += figures[i].moved, all.guessed += figures[i].guessed;
    }
    return {{"samples_judged", verdict.samples},
            {"doubt", verdict.doubt()},
            {"seen_through", verdict.seenThroughShare()},
            {"changed", changed},
            {"contested", all.contested},
            {"moved", all.moved},
            {"guessed", all.guessed}};
}

} // namespace

json settleSilhouettes(ImportedImages& imported, const Overlaps& overlaps, const BuildOptions& options,
                       StageStore& store) {
    if (!options.settleSilhouettes) return nullptr;
    const scene::SilhouetteOptions& o = options.silhouettes;
    const std::string key =
        keyOf({kSilhouetteVersion, imported.key, o.radius, o.jump, o.maxPartners, o.leastParallax, o.mostParallax,
               o.patchRadius, o.step, o.colourStep, o.mostDifference, o.leastGain, o.rounds, o.rightShare,
               o.rightSeenThrough, o.judged, o.comparison.sameSurface, o.comparison.pixelError});
    const std::filesystem::path folder = store.find("silhouettes", key, [&](const std::filesystem::path& part) {
        scene::SilhouetteVerdict verdict;
        {
            scene::ImageStore images(imported.images, options.memoryBytes / 2, store.folder());
            verdict = scene::judgeSilhouettes(images, overlaps.partners, o);
        }
        std::vector<scene::SilhouetteFigures> figures;
        if (!verdict.areRight(o)) figures = settle(imported.images, overlaps, options, part, store.folder());
        writeWhole(part / "silhouettes.json", describe(verdict, imported.images, figures).dump());
    });
    const json report = readJson(folder / "silhouettes.json");
    const std::set<std::string> changed = report.at("changed");
    for (scene::StoredImage& image : imported.images)
        if (changed.contains(image.name)) image.file = folder / (image.name + ".tiff");
    if (!changed.empty()) imported.key = key; // what comes after is the same as without, else
    return report;
}

} // namespace app
